"""The report: one page that needs nothing but itself, and its figures as SVG and CSV.

`page.html` is the skeleton, in the order of a reader's questions: what came out, let me see it, can I trust it. What is
interactive is drawn by the scripts from the JSON of `document.py` and the pictures of `encode.py`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path

from markupsafe import Markup

from aliascope.records import ReportData, SceneSection
from aliascope.regression.records import Run
from aliascope.report.document import document, json_text
from aliascope.report.encode import PictureStore
from aliascope.report.files import digest, environment, source, write_text
from aliascope.report.filters import FREQUENCIES, Response, filter_responses, filters_csv, filters_json
from aliascope.report.plots import Plot, colours, plot_csv, plot_svg, plots_of, spectrum_name
from aliascope.report.signal_plots import filters_svg, spectrum_svg
from aliascope.report.spectra import SceneSpectra, spectra_csv, spectra_of
from aliascope.report.tables import results_csv
from aliascope.report.trade import TITLES, trade_csv, trade_of
from aliascope.report.verdicts import verdicts_html
from aliascope.sharing import records_shared
from aliascope.trade import Trade
from aliascope.trade.records import Knob

SCRIPTS = (
    "unpack.js",
    "packed_data.js",
    "core.js",
    "metrics.js",
    "costs.js",
    "state.js",
    "pictures.js",
    "plot.js",
    "spectrum.js",
    "filters.js",
    "choose.js",
    "tables.js",
    "trade.js",
    "knobs.js",
    "sheet.js",
    "controls.js",
    "viewer.js",
    "page.js",
)
"""In the order of their use of each other; they become one function, which waits for its data to be inflated."""


def write_report(folder: Path, data: ReportData, run: Run | None = None, measures: Sequence[Knob] = ()) -> Path:
    """Writes report.html, results.csv and plots/ to a folder, which is made; each file whole or not at all. The
    verdicts of a regression run come before everything else. `measures` are knobs beside those of the modes.

    Returns the path of report.html. Raises NotWritable, and InvalidInput where a picture has not its reference's size.
    """
    data, run = records_shared(data), records_shared(run)
    spectra, filters = spectra_of(data), filter_responses()
    trade = trade_of(data)
    trade = replace(trade, knobs=(*trade.knobs, *measures))
    text = _page(data, spectra, filters, run, trade)
    palette = colours([row.renderer for scene in data.scenes for row in scene.rows])
    plots = plots_of(data)
    for plot in plots:
        _write_figure(folder, plot.name, plot_svg(plot, palette), plot_csv(plot))
    for plot, scene, found in _of_scenes(plots, data, spectra):
        svg = spectrum_svg(plot.title, found, scene.rows, palette)
        _write_figure(folder, spectrum_name(plot.name), svg, spectra_csv(found, scene.rows))
    if filters:
        _write_figure(folder, "filters", filters_svg(filters), filters_csv(filters))
    for name, text_ in trade_csv(trade).items():
        write_text(folder / "plots" / f"{name}.csv", text_)
    write_text(folder / "results.csv", results_csv(data))
    return write_text(folder / "report.html", text)


def page(data: ReportData, run: Run | None = None) -> str:
    """The text of report.html."""
    return _page(data, spectra_of(data), filter_responses(), run, trade_of(data))


def _page(
    data: ReportData, spectra: Sequence[SceneSpectra], filters: Sequence[Response], run: Run | None, trade: Trade
) -> str:
    pictures = PictureStore()
    values = document(data, pictures, spectra, trade)
    values["colours"] = colours(values["renderers"])
    values["filters"] = {"frequencies": FREQUENCIES, "responses": filters_json(filters)}
    style = source("page.css") + source("trade.css") + (source("verdicts.css") if run else "")
    body = "\n".join(source(name) for name in SCRIPTS)
    script = f'(async () => {{\n"use strict";\n{body}\n}})();\n'
    pages = environment()
    pages.filters |= {
        "figures": _figures,
        "signed": _signed,
        "power_of_ten": _power_of_ten,
        "signed_percent": _signed_percent,
    }
    return pages.from_string(source("page.html")).render(
        data=data,
        started=_date(data.started),
        wall=_duration(data.wall_seconds),
        figures=_figure_names(data, spectra, filters),
        filters=filters,
        trade=trade,
        tables=[(name, TITLES[name]) for name in trade_csv(trade)],
        quanta=_quanta(data),
        undrawn=_undrawn(data),
        policy=f"default-src 'none'; script-src '{digest(script)}'; style-src '{digest(style)}'",
        style=Markup(style),  # ours
        script=Markup(script),  # ours
        json=Markup(json_text(values)),  # of characters that mean nothing to HTML
        pictures=[Markup(text) for text in pictures.texts],  # of characters that mean nothing to HTML
        verdicts=verdicts_html(run, pages),
    )


def _of_scenes(
    plots: Sequence[Plot], data: ReportData, spectra: Sequence[SceneSpectra]
) -> list[tuple[Plot, SceneSection, SceneSpectra]]:
    """The plots of scenes, which come last, with what they are of."""
    own = plots[len(plots) - len(data.scenes) :]
    return list(zip(own, data.scenes, spectra, strict=True))


def _figure_names(
    data: ReportData, spectra: Sequence[SceneSpectra], filters: Sequence[Response]
) -> dict[str, list[tuple[str, str]]]:
    """(name of the files, title) of the figures beside the page, by what they show."""
    plots = plots_of(data)
    found = {
        "Error against CPU time": [(plot.name, plot.title) for plot in plots],
        "Spectrum of the error": [
            (spectrum_name(plot.name), plot.title) for plot, _, _ in _of_scenes(plots, data, spectra)
        ],
        "Filters": [("filters", "Frequency responses")] if filters else [],
    }
    return {kind: entries for kind, entries in found.items() if entries}


def _write_figure(folder: Path, name: str, svg: str, csv: str) -> None:
    write_text(folder / "plots" / f"{name}.svg", svg)
    write_text(folder / "plots" / f"{name}.csv", csv)


def _date(text: str) -> str:
    """A date of ISO 8601 as a person reads it; anything else as it is."""
    try:
        return datetime.fromisoformat(text).strftime("%Y-%m-%d %H:%M %Z").strip()
    except ValueError:
        return text


def _duration(seconds: float) -> str:
    if not math.isfinite(seconds):
        return "an unknown time"
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {rest} s"


def _figures(value: float) -> str:
    """Three significant digits."""
    return f"{value:.3g}"


def _signed(value: float) -> str:
    """Four decimals and the sign; of what rounds to 0 neither."""
    text = f"{value:+.4f}".replace("-", "\u2212")
    return text if text.strip("+\u22120.") else "0.0000"


def _signed_percent(value: float) -> str:
    return f"{value:+.1f} %".replace("-", "\u2212")


def _power_of_ten(value: float) -> str:
    """Two significant digits, "6.1 × 10⁻⁶"; one where the other is 0, and a power alone where that is 1."""
    if value == 0.0:
        return "0"
    mantissa, power = f"{value:.1e}".split("e")
    digits = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    short = mantissa.removesuffix(".0")
    return f"10{digits}" if short == "1" else f"{short}\u202f×\u202f10{digits}"


def _quanta(data: ReportData) -> list[tuple[str, list[float]]]:
    """The steps of each renderer's output, coarsest first; 0 is float."""
    found: dict[str, set[float]] = {}
    for scene in data.scenes:
        for row in scene.rows:
            found.setdefault(row.renderer, set()).add(row.quantum)
    return [(renderer, sorted(steps, reverse=True)) for renderer, steps in found.items()]


def _undrawn(data: ReportData) -> list[tuple[str, str, list[tuple[str, int]]]]:
    """(renderer, reason, [(scene, number of modes)]) of the empty cells."""
    found: dict[tuple[str, str], dict[str, int]] = {}
    for cell in (*(cell for scene in data.scenes for cell in scene.empty), *data.undrawn):
        scenes = found.setdefault((cell.renderer, cell.reason), {})
        scenes[cell.scene] = scenes.get(cell.scene, 0) + 1
    return [(renderer, reason, list(scenes.items())) for (renderer, reason), scenes in found.items()]
