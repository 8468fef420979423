"""What a sweep says: on the terminal, as JSON, as an ini file for POV-Ray, and as the data of a report."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from aliascope import metrics, places, renderers, sharing
from aliascope.errors import NotWritable
from aliascope.records import Estimate, ModeRow, ReportData, SceneSection
from aliascope.renderers import povray_file
from aliascope.report import write_report
from aliascope.report.files import write_text
from aliascope.specs import family, label, settings
from aliascope.studies.compare import with_reference
from aliascope.studies.sweep import Swept, machine, shown
from aliascope.studies.sweep_pov import duration, spec_of
from aliascope.studies.sweep_search import Answer, Candidate
from aliascope.trade.records import QUANTISATION

METRICS = ["bias", "mae", "rmse", "psnr", "max", "p99"]
"""Those that take no time."""

SETTINGS = ("fast", "balanced", "final")


def options(candidate: Candidate) -> str:
    """A setting in POV-Ray's options, or the mode of another renderer."""
    if candidate.renderer != "povray" or spec_of(candidate).name not in ("none", "am1", "am2"):
        return candidate.mode
    return " ".join(povray_file.options_of(spec_of(candidate)))


def command(swept: Swept, candidate: Candidate) -> str:
    """The command line that renders the scene so."""
    width, height = swept.size
    if swept.is_pov:
        name = swept.asked.path.name
        words = ["povray", f"+I{name}", f"+W{width}", f"+H{height}"]
        return " ".join([sharing.command_line(words), options(candidate)])
    words = ["aliascope", "render", str(swept.asked.path), "-r", candidate.renderer, "-m", candidate.mode]
    return sharing.command_line([*words, "--size", f"{width}x{height}", "-o", "out.exr"])


def ini(swept: Swept) -> str:
    """sweep.ini: a section for each setting. To be used in the scene's folder: `povray "DIR/sweep.ini[fast]"`."""
    width, height = swept.size
    here = sharing.shell_word((swept.asked.folder / "sweep.ini").absolute())
    lines = [
        f"; {swept.asked.path.name}: settings found by aliascope sweep, {width}x{height}",
        f'; In the folder of the scene: povray {here}"[balanced]"',
        f'Input_File_Name="{swept.asked.path.name}"',
        f"Width={width}",
        f"Height={height}",
    ]
    for name, candidate in _three(swept.answers[""]):
        seconds, error = swept.figures[candidate]
        lines += ["", f"[{name}]", f"; {_seconds(seconds)}, RMSE {_error(error)}", *_ini_lines(candidate)]
    return "\n".join(lines) + "\n"


def _ini_lines(candidate: Candidate) -> list[str]:
    spec = spec_of(candidate)
    if spec.name == "none":
        return ["Antialias=Off"]
    _, threshold, *_ = povray_file.options_of(spec)
    jitter = spec.real("jitter")
    return [
        "Antialias=On",
        f"Sampling_Method={spec.name[-1]}",
        f"Antialias_Threshold={threshold.removeprefix('+A')}",
        f"Antialias_Depth={spec.integer('depth')}",
        *(["Jitter=On", f"Jitter_Amount={jitter:g}"] if jitter > 0.0 else ["Jitter=Off"]),
    ]


def _three(answer: Answer) -> Iterator[tuple[str, Candidate]]:
    yield from zip(SETTINGS, (answer.fast, answer.balanced, answer.final), strict=True)


def _seconds(seconds: Estimate) -> str:
    value = f"{seconds.value:.3g}"
    if seconds.interval is None:
        return f"{value} s"
    return f"{value} s [{seconds.interval[0]:.3g}, {seconds.interval[1]:.3g}]"


def _error(error: Estimate) -> str:
    known = error.standard_error is not None
    return f"{error.value:.3g}" + (f" ± {error.standard_error:.1g}" if known else "")


def lines(swept: Swept, report: Path) -> list[str]:
    """For a person: the settings to use, the front, what is to be known, the report."""
    width, height = swept.size
    told = [f"{swept.title}, {width}x{height}; reference: {swept.reference_told}", ""]
    for name, own in swept.answers.items():
        told += [f"of {name}:"] if name else []
        if name and not swept.is_pov:
            told += [f"  {what:<9}{_figures(swept, c)}  {options(c)}" for what, c in _three(own)]
            continue
        for what, candidate in _three(own):
            told += [f"  {what:<9}{_figures(swept, candidate)}", f"           {command(swept, candidate)}"]
    told += ["", f"  {'CPU time':<28}{'RMSE':<20}{'timed runs':>10}  the front"]
    for candidate in swept.front:
        seconds, error = swept.figures[candidate]
        runs = len(swept.found.runs.get(candidate, []))
        name = "" if swept.is_pov else f"{candidate.renderer} "
        told.append(f"  {_seconds(seconds):<28}{_error(error):<20}{runs:>10}  {name}{options(candidate)}")
    told.append("")
    told += [f"note: {note}" for note in swept.notes]
    told += [f"failed {options(c)}: {why}" for c, why in swept.failed.items()]
    told += [f"skipped {name}: {why}" for name, why in swept.skipped.items()]
    told.append(
        f"{len(swept.found.whole)} settings in whole pictures, {len(swept.found.looked)} looked at before; "
        f"{swept.wall_seconds:.0f} s" + ("" if swept.asked.exhaustive else f" of {duration(swept.budget)}")
    )
    if swept.is_pov:
        told.append(f"{swept.asked.folder / 'sweep.ini'}: the settings as [fast], [balanced], [final]")
    return [*told, str(report)]


def _figures(swept: Swept, candidate: Candidate) -> str:
    seconds, error = swept.figures[candidate]
    return f"{_seconds(seconds):<28}RMSE {_error(error)}{_natural_end(swept, error)}"


def _in_one(swept: Swept, candidate: Candidate) -> str:
    """The figures of a setting in a sentence."""
    return ", RMSE ".join(" ".join(part.split()) for part in _figures(swept, candidate).split("RMSE"))


def _natural_end(swept: Swept, error: Estimate) -> str:
    assert error.value is not None
    if error.value <= QUANTISATION:
        return "  (that of 8 bits, or less)"
    return "  (as good as the reference can tell)" if error.value <= swept.limit else ""


def document(swept: Swept, report: Path) -> dict[str, Any]:
    """For --json."""
    reference = swept.reference
    return {
        "scene": str(swept.asked.path),
        "width": swept.size[0],
        "height": swept.size[1],
        "settings": {what: _entry(swept, c) for what, c in _three(swept.answers[""])},
        "renderers": {
            name: {what: _entry(swept, c) for what, c in _three(own)} for name, own in swept.answers.items() if name
        },
        "front": [_entry(swept, c) for c in swept.front],
        "all": [_entry(swept, c) for c in swept.figures],
        "reference": {
            "method": reference.method,
            "standard_error": reference.standard_error_rms,
            "error": reference.error,
            "text": swept.reference_told,
        },
        "quantisation": QUANTISATION,
        "notes": swept.notes,
        "failed": [{"mode": c.mode, "renderer": c.renderer, "reason": why} for c, why in swept.failed.items()],
        "skipped": swept.skipped,
        "budget_seconds": swept.budget,
        "wall_seconds": swept.wall_seconds,
        "measured": len(swept.found.whole),
        "looked": len(swept.found.looked),
        "not_finished": swept.found.dropped_for_time,
        "interrupted": swept.found.interrupted,
        "report": str(report),
    }


def _entry(swept: Swept, candidate: Candidate) -> dict[str, Any]:
    seconds, error = swept.figures[candidate]
    assert error.value is not None
    return {
        "renderer": candidate.renderer,
        "mode": candidate.mode,
        "options": options(candidate),
        "command": command(swept, candidate),
        "cpu_seconds": seconds.value,
        "cpu_seconds_interval": list(seconds.interval) if seconds.interval else None,
        "rmse": error.value,
        "rmse_standard_error": error.standard_error,
        "timed_runs": len(swept.found.runs.get(candidate, [])),
        "at_reference_limit": error.value <= swept.limit,
    }


def write(swept: Swept, started: datetime, said: str) -> Path:
    """Writes report.html, results.csv and plots/, and sweep.ini for a .pov file, to the folder. Raises NotWritable."""
    if swept.is_pov:
        write_text(swept.asked.folder / "sweep.ini", ini(swept))
    section = SceneSection(
        name=swept.asked.path.stem,
        title=swept.title,
        shows="",
        reference=swept.reference.pixels,
        reference_note=swept.reference_told,
        rows=tuple(_row(swept, c) for c in shown(swept, swept.rows)),
    )
    own = swept.answers[""]
    data = ReportData(
        title=f"aliascope sweep, {swept.asked.path.name}",
        started=started.astimezone(UTC).isoformat(timespec="seconds"),
        wall_seconds=swept.wall_seconds,
        pictures=len(section.rows),
        reused=0,
        headlines=(
            *(f"{what.capitalize()}: {_in_one(swept, c)}: {command(swept, c)}" for what, c in _three(own)),
            *(note[0].upper() + note[1:] + "." for note in swept.notes),
        ),
        scenes=(section,),
        failures=(),
        machine={**machine(), "command": said},
        versions={"aliascope": f"{places.own_version()} ({places.revision()})", **swept.versions},
        metrics=metrics.ABOUT,
        skipped=swept.skipped,
    )
    try:
        return write_report(swept.asked.folder, data)
    except OSError as error:
        raise NotWritable(f"{swept.asked.folder}: cannot be written: {error.strerror}") from error


def _row(swept: Swept, candidate: Candidate) -> ModeRow:
    spec, cost = spec_of(candidate), swept.costs[candidate]
    seconds, error = swept.figures[candidate]
    runs = swept.found.runs.get(candidate, [])
    seeded = renderers.find(candidate.renderer).seeded(spec)
    pixels = swept.pictures[candidate]
    measured = metrics.measure(pixels, swept.reference.pixels, METRICS)
    figures = {name: with_reference(name, Estimate(each.value), swept.reference) for name, each in measured.items()}
    return ModeRow(
        renderer=candidate.renderer,
        mode=candidate.mode,
        label=label(spec),
        family=family(spec),
        samples_per_pixel=cost.samples_per_pixel,
        cpu_seconds=seconds,
        metrics={**figures, "rmse": error},
        pictures=max(1, len(runs)) if seeded else 1,
        pixels=pixels,
        quantum=swept.quanta.get(candidate, 0.0),
        seconds=tuple(run.seconds for run in runs),
        draws={"rmse": tuple(run.rmse for run in runs) if seeded and runs else (error.value,)},
        deterministic=not seeded,
        samples=cost.samples,
        rays=dict(cost.rays),
        settings=settings(spec),
    )
