"""What was blessed, on disk: `<scene>/blessed-<renderer>.json` below a folder, and `blessings.jsonl`, the log of it.

A file has an entry for each mode: all that is kept of its pictures, one a line, and where they came from. Each entry
carries a digest of itself, so that one that was edited by hand, or merged wrongly, is refused. Figures have so many
digits as tell more than the limits that are set on them (`_DIGITS`); an entry that is loaded and saved again is the
same to the bit. Nothing is written but by `save`.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from statistics import fmean, median
from typing import Any

from aliascope import places
from aliascope.errors import CheckFailed
from aliascope.records import Estimate
from aliascope.regression import commands
from aliascope.regression.commands import Setting
from aliascope.regression.records import Blessed, CellName, Draw, Observed, Replicate
from aliascope.text_files import append_lines, write_text

FORMAT = 1
LOG = "blessings.jsonl"

_DIGITS = 9
"""Significant digits of a figure: float32 has them."""
_SQUARES_DIGITS = 5
"""Of a block's mean square: their sum is right to 1e-5, and an accuracy is held to 2 in 100."""
_SECONDS_DIGITS = 4
_TOLD_DIGITS = 6
"""Of the means that people compare: fewer than a file keeps, so that its rounding is no change."""
_BLOCK_STEP = 1e-7
"""The step of a block's mean, which stands as a whole number: a 4,000th of what is granted to a block, 1/2550."""


def path_of(folder: Path, scene: str, renderer: str) -> Path:
    """Where the blessed figures of a renderer on a scene lie, whether they are there or not."""
    return folder / scene / f"blessed-{renderer}.json"


def fingerprint(replicates: Iterable[Replicate]) -> str:
    """SHA-256 of the digests of all pictures, in their order."""
    return hashlib.sha256("".join(replicate.sha256 for replicate in replicates).encode()).hexdigest()


def bless(observed: Observed, reason: str, command: str) -> Blessed:
    """What was observed, here and now, as it is to be blessed. Raises CheckFailed where a picture is none."""
    broken = sum(replicate.not_finite for replicate in observed.replicates)
    if broken:
        raise CheckFailed(f"{observed.name.text}: cannot be blessed: {broken} of its pixels are infinite or no numbers")
    return Blessed(
        observed=observed,
        sha256=fingerprint(observed.replicates),
        revision=places.revision(),
        machine=places.machine(),
        command=command,
        reason=reason,
        blessed_on=datetime.now(UTC).isoformat(timespec="seconds"),
    )


# --- files ------------------------------------------------------------------------------------------------------------


def load(
    folder: Path, scene: str, renderer: str, called: str = "", setting: Setting | None = None
) -> Mapping[str, Blessed]:
    """What was blessed of a renderer on a scene, by mode; empty where there is no file.

    `called`, `setting`: for the command in the message, as `commands.bless` has them. Raises CheckFailed where the file
    cannot be read, or an entry was edited.
    """
    path = path_of(folder, scene, renderer)
    setting = setting or Setting(folder)
    found: dict[str, Blessed] = {}
    for mode, entry in _read(path, scene, renderer, called, setting).items():
        name = CellName(scene, renderer, mode)
        try:
            if entry.get("digest") != _digest(name, entry):
                raise ValueError("digest")
            found[mode] = _decoded(name, entry)
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise CheckFailed(
                f'{path}: the figures of "{mode}" were changed since they were blessed; take the file back from '
                f"version control, or bless them anew: {commands.bless(name, called, setting)}"
            ) from error
    return found


def save(folder: Path, blessed: Sequence[Blessed]) -> list[Path]:
    """Puts these into their files, in place of what stood there for the same modes; all else stays as it is, also what
    `load` refuses. Returns the files. Raises NotWritable; CheckFailed for a file that cannot be read, which would be
    lost."""
    groups: dict[tuple[str, str], list[Blessed]] = {}
    for each in blessed:
        groups.setdefault((each.observed.name.scene, each.observed.name.renderer), []).append(each)
    # All are read before one is written.
    entries = {
        key: {**_read(path_of(folder, *key), *key, "", Setting(folder)), **{_mode(one): _encoded(one) for one in each}}
        for key, each in groups.items()
    }
    return [write_text(path_of(folder, *key), _text(*key, modes)) for key, modes in entries.items()]


def log(folder: Path, blessed: Blessed, before: Blessed | None) -> Path:
    """Adds a line to the log: what was blessed, when, why, and what changed by it. Raises NotWritable."""
    now = figures(blessed.observed)
    then = figures(before.observed) if before else {}
    line = {
        "when": blessed.blessed_on,
        "cell": blessed.observed.name.text,
        "reason": blessed.reason,
        "old": before.sha256 if before else None,
        "new": blessed.sha256,
        "changes": {name: [then.get(name), now.get(name)] for name in {**then, **now}},
        "revision": blessed.revision,
    }
    return append_lines(folder / LOG, [json.dumps(line, allow_nan=False)])


def figures(observed: Observed) -> dict[str, float]:
    """Of a cell what a person compares: its metrics, the mean of each template, and what it costs."""
    replicates = observed.replicates
    made = {name: metric.value for name, metric in observed.metrics.items()}
    errors = [replicate.rmse for replicate in replicates if replicate.rmse is not None]
    if errors:
        made.setdefault("rmse", fmean(errors))
    for place, name in enumerate(observed.names):
        made[name] = fmean(replicate.coefficients[place] for replicate in replicates)
    made["least"] = min(replicate.least for replicate in replicates)
    made["largest"] = max(replicate.largest for replicate in replicates)
    made["outlier"] = max(replicate.outlier for replicate in replicates)
    made["scatter"] = observed.scatter
    made["samples"] = fmean(replicate.samples for replicate in replicates)
    for kind in dict.fromkeys(kind for replicate in replicates for kind in replicate.rays):
        made[f"{kind} rays"] = fmean(replicate.rays.get(kind, 0) for replicate in replicates)
    made["cpu seconds"] = median(replicate.cpu_seconds for replicate in replicates)
    return {
        name: _rounded(value, _TOLD_DIGITS)
        for name, value in made.items()
        if value is not None and math.isfinite(value)
    }


def _mode(blessed: Blessed) -> str:
    return blessed.observed.name.mode


def _read(path: Path, scene: str, renderer: str, called: str, setting: Setting) -> Mapping[str, dict[str, Any]]:
    """The entries of a file by mode, as they stand there."""
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError) as error:
        raise CheckFailed(_unreadable(path, scene, renderer, called, setting)) from error
    try:
        document = json.loads(text, object_pairs_hook=_unique)
        version, modes = document["format"], document["modes"]
        if (document["scene"], document["renderer"]) != (scene, renderer):
            raise ValueError("another cell's")
        if not all(isinstance(entry, dict) for entry in modes.values()):
            raise TypeError("no entries")
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise CheckFailed(_unreadable(path, scene, renderer, called, setting)) from error
    if version != FORMAT:
        raise CheckFailed(f"{path}: has format {version}, this version reads {FORMAT}: use the version that wrote it")
    return {str(mode): entry for mode, entry in modes.items()}


def _unreadable(path: Path, scene: str, renderer: str, called: str, setting: Setting) -> str:
    everything = commands.bless(CellName(scene, renderer, "*"), called, setting, f"{scene}/{renderer}/*")
    return (
        f"{path}: cannot be read as the blessed figures of {renderer} on {scene}; take it back from version control, "
        f"or remove it and bless all of them anew: {everything}"
    )


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) < len(pairs):  # as two branches that are merged can leave it
        raise ValueError("a name twice")
    return made


# --- an entry ---------------------------------------------------------------------------------------------------------


def _rounded(value: float, digits: int = _DIGITS) -> float:
    if not math.isfinite(value):
        raise CheckFailed(f"a figure that is {value} cannot be blessed")
    return float(f"{value:.{digits}g}") + 0.0  # no -0


def _figures(values: Iterable[float], digits: int = _DIGITS) -> list[float]:
    return [_rounded(value, digits) for value in values]


def _encoded(blessed: Blessed) -> dict[str, Any]:
    observed = blessed.observed
    entry: dict[str, Any] = {
        "reason": blessed.reason,
        "blessed_on": blessed.blessed_on,
        "revision": blessed.revision,
        "command": blessed.command,
        "machine": dict(blessed.machine),
        "versions": dict(observed.versions),
        "judged": observed.judged,
        "scene_digest": observed.scene_digest,
        "size": list(observed.size),
        "filter": observed.filter,
        "quantum": observed.quantum,
        "metrics": {
            name: [None if figure is None else _rounded(figure) for figure in (each.value, each.standard_error)]
            for name, each in observed.metrics.items()
        },
        "names": list(observed.names),
        "known": _figures(observed.known),
        "known_blocks": _figures(observed.known_blocks, _SQUARES_DIGITS),
        "scatter": _rounded(observed.scatter),
        "sha256": blessed.sha256,
        "replicates": [_replicate(replicate) for replicate in observed.replicates],
    }
    return {"digest": _digest(observed.name, entry), **entry}


def _replicate(replicate: Replicate) -> dict[str, Any]:
    return {
        "seed": replicate.draw.seed,
        "shift": list(replicate.draw.shift),
        "sha256": replicate.sha256,
        "coefficients": _figures(replicate.coefficients),
        "blocks": [round(_rounded(value) / _BLOCK_STEP) for value in replicate.blocks],
        "rmse": None if replicate.rmse is None else _rounded(replicate.rmse),
        "block_squares": _figures(replicate.block_squares, _SQUARES_DIGITS),
        "least": _rounded(replicate.least),
        "largest": _rounded(replicate.largest),
        "outlier": _rounded(replicate.outlier),
        "samples": replicate.samples,
        "rays": dict(replicate.rays),
        "cpu_seconds": _rounded(replicate.cpu_seconds, _SECONDS_DIGITS),
    }


def _decoded(name: CellName, entry: Mapping[str, Any]) -> Blessed:
    width, height = entry["size"]
    observed = Observed(
        name=name,
        judged=entry["judged"],
        scene_digest=entry["scene_digest"],
        size=(width, height),
        filter=entry["filter"],
        names=tuple(entry["names"]),
        replicates=tuple(_replicate_of(each) for each in entry["replicates"]),
        known=tuple(entry["known"]),
        known_blocks=tuple(entry["known_blocks"]),
        scatter=entry["scatter"],
        versions=entry["versions"],
        metrics={key: Estimate(*figures) for key, figures in entry["metrics"].items()},
        quantum=entry["quantum"],
    )
    provenance = {key: entry[key] for key in ("sha256", "revision", "machine", "command", "reason", "blessed_on")}
    return Blessed(observed, **provenance)


def _replicate_of(line: Mapping[str, Any]) -> Replicate:
    right, down = line["shift"]
    same = ("sha256", "rmse", "least", "largest", "outlier", "samples", "rays", "cpu_seconds")
    return Replicate(
        draw=Draw(line["seed"], (right, down)),
        coefficients=tuple(line["coefficients"]),
        blocks=tuple(value * _BLOCK_STEP for value in line["blocks"]),
        block_squares=tuple(line["block_squares"]),
        not_finite=0,  # what has such pixels is not blessed
        **{key: line[key] for key in same},
    )


def _digest(name: CellName, entry: Mapping[str, Any]) -> str:
    """Of all that an entry says, and of which cell."""
    said = {key: value for key, value in entry.items() if key != "digest"}
    text = json.dumps([name.scene, name.renderer, name.mode, said], sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _text(scene: str, renderer: str, modes: Mapping[str, Mapping[str, Any]]) -> str:
    """The file, in an order that does not hang on what was blessed first, a picture a line: so a difference between
    two versions is readable."""
    parts = [f"{json.dumps(mode)}: {_entry_text(modes[mode])}" for mode in sorted(modes)]
    head = f'{{\n"format": {FORMAT},\n"scene": {json.dumps(scene)},\n"renderer": {json.dumps(renderer)},\n"modes": {{\n'
    return head + ",\n".join(parts) + "\n}\n}\n"


def _entry_text(entry: Mapping[str, Any]) -> str:
    lines = []
    for key, value in entry.items():
        if key == "replicates" and isinstance(value, list):
            each = ",\n  ".join(json.dumps(one, separators=(",", ":")) for one in value)
            lines.append(f' "replicates": [\n  {each}\n ]')
        else:
            lines.append(f" {json.dumps(key)}: {json.dumps(value)}")
    return "{\n" + ",\n".join(lines) + "\n}"
