"""`aliascope integrate`: which samplers are asked for, and the results as a table, a document and files."""

from __future__ import annotations

import csv
import fnmatch
import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from aliascope.errors import SpecError, Unsupported, near_misses
from aliascope.integration import LEAST_N, MOST_N, Convergence, Integration
from aliascope.native import samplers
from aliascope.report.files import write_text
from aliascope.studies.integrate_plots import Line, convergence_svg

COLUMNS = (
    *("integrand", "d", "sampler", "n", "rmse", "standard_error", "realisations", "at_floor"),
    *("star_discrepancy", "koksma_hlawka_bound", "koksma_hlawka_ratio"),
)


def expand(texts: Iterable[str]) -> list[str]:
    """Samplers from specs and patterns of names ("halton*", "*"). Raises SpecError for a pattern without a match."""
    names = [info.name for info in samplers.registered()]
    found: list[str] = []
    for text in texts:
        if not _is_glob(text):
            found.append(text)
            continue
        matching = fnmatch.filter(names, text)
        if not matching:
            raise SpecError(f'no sampler is called "{text}"{near_misses(text.strip("*?"), names)}')
        found += matching
    return list(dict.fromkeys(found))


def span(least_n: int | None, most_n: int | None) -> dict[str, int]:
    """The range of N; one end that is given moves the other's default, where that would lie beyond it."""
    least = min(LEAST_N, most_n or LEAST_N) if least_n is None else least_n
    most = max(MOST_N, least) if most_n is None else most_n
    return {"least_n": least, "most_n": most}


def _is_glob(text: str) -> bool:
    return ":" not in text and any(sign in text for sign in "*?[")


def check_all_there(found: Integration, named: Sequence[str]) -> None:
    """A sampler that was asked for by its name is to be among the results. Raises Unsupported."""
    for spec, reason in found.refused:
        if spec in named and not _is_glob(spec):
            raise Unsupported(reason)
    if not found.results:
        raise Unsupported(f"no sampler has these numbers of points in {found.d} dimensions")


def document(found: Integration) -> dict[str, Any]:
    """What --json prints."""
    variation = found.integrand.variation(found.d)
    return {
        "integrand": found.integrand.spec,
        "title": found.integrand.title,
        "d": found.d,
        "exact": found.integrand.exact(found.d),
        "variation": variation,
        "variation_reason": found.integrand.no_variation(found.d),
        "seed": found.seed,
        "realisations": found.realisations,
        "results": [_result(result) for result in found.results],
        "refused": [{"sampler": spec, "reason": reason} for spec, reason in found.refused],
    }


def _result(result: Convergence) -> dict[str, Any]:
    rate, known = result.rate, result.theory
    return {
        "sampler": result.sampler,
        "shifted": result.shifted,
        "rate": rate.exponent if rate else None,
        "rate_interval": list(rate.interval) if rate else None,
        "rate_reason": result.reason,
        "rate_range": [rate.least_n, rate.most_n] if rate else None,
        "curved": rate.curved if rate else None,
        "local_rate": rate.local if rate else None,
        "theory": {
            "text": known.text,
            "kind": known.kind,
            "rate": float(known.exponent) if known.exponent is not None else None,
            "logarithms": float(known.logarithms),
            "rate_over_range": known.rate_over([error.n for error in result.errors]),
            "source": known.source,
        }
        if known
        else None,
        "points": [
            {
                "n": error.n,
                "rmse": error.rmse,
                "standard_error": error.standard_error,
                "realisations": error.realisations,
                "at_floor": error.at_floor,
            }
            for error in result.errors
        ],
        "koksma_hlawka": [
            {"n": k.n, "error": k.error, "star_discrepancy": k.star_discrepancy, "bound": k.bound, "ratio": k.ratio}
            for k in result.variation
        ],
        "koksma_hlawka_reason": result.no_variation,
    }


def lines(found: Integration, with_variation: bool) -> list[str]:
    """The results for a person: a line about the integrand, a table, what could not be had."""
    variation = found.integrand.variation(found.d)
    said = (
        f"variation {variation:.6g}" if variation is not None else f"variation {found.integrand.no_variation(found.d)}"
    )
    head = f"{found.integrand.spec}, d = {found.d}: integral {found.integrand.exact(found.d):.10g}; {said}"
    rows = [("sampler", "N", "rate", "95 % interval", "theory", "error at the largest N"), *map(_row, found.results)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    table = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    tail = [f"no {spec}: {reason}" for spec, reason in found.refused]
    return [head, "", *table, *(_variation_lines(found) if with_variation else []), *([""] if tail else []), *tail]


def name_of(result: Convergence) -> str:
    return f"{result.sampler} + shift" if result.shifted else result.sampler


def _row(result: Convergence) -> tuple[str, ...]:
    rate, last = result.rate, result.errors[-1]
    span = f"{result.errors[0].n} to {last.n}"
    if rate:
        span = f"{rate.least_n} to {rate.most_n}"
    error = f"{last.rmse:.3g}" + (f" +- {last.standard_error:.2g}" if last.realisations > 1 else "")
    if last.at_floor:
        error += ", rounding"
    interval = f"[{rate.interval[0]:.2f}, {rate.interval[1]:.2f}]{' bent' if rate.curved else ''}" if rate else ""
    shown = f"{rate.exponent:.2f}" if rate else f"none: {result.reason}"
    return name_of(result), span, shown, interval, result.theory.text if result.theory else "", error


def _variation_lines(found: Integration) -> list[str]:
    if found.integrand.variation(found.d) is None:
        return []  # the first line says why
    rows: list[tuple[str, ...]] = [("sampler", "N", "|error|", "D*_N", "V D*_N", "ratio")]
    for result in found.results:
        if result.no_variation:
            rows.append((name_of(result), "", f"none: {result.no_variation}", "", "", ""))
        for one in result.variation:
            figures = (f"{value:.4g}" for value in (one.error, one.star_discrepancy, one.bound, one.ratio))
            rows.append((name_of(result), str(one.n), *figures))
    widths = [max(len(row[column]) for row in rows) for column in (0, 1)] + [11] * 4
    table = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    return ["", "Koksma and Hlawka: |error| <= V D*_N", *table]


def table_csv(found: Iterable[Integration]) -> str:
    """Every error, one row a sampler and N; empty where there is none."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for one in found:
        for result in one.results:
            bounds = {k.n: k for k in result.variation}
            for error in result.errors:
                bound = bounds.get(error.n)
                bounds_of = [bound.star_discrepancy, bound.bound, bound.ratio] if bound else [None] * 3
                errors = [error.rmse, error.standard_error, error.realisations, int(error.at_floor)]
                writer.writerow([one.integrand.spec, one.d, name_of(result), error.n, *errors, *bounds_of])
    return out.getvalue()


def write(folder: Path, found: Integration) -> list[Path]:
    """Writes convergence.svg and convergence.csv to a folder, which is made. Raises NotWritable."""
    title = f"{found.integrand.spec}, d = {found.d}"
    svg = convergence_svg(title, [Line.of(result, name_of(result)) for result in found.results])
    return [
        write_text(folder / "convergence.svg", svg),
        write_text(folder / "convergence.csv", table_csv([found])),
    ]
