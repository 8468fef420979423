"""References on disk: `<scene>/<W>x<H>-<filter>.exr` below a folder, each with where it came from in its header.

One of a picture that is moved on the film is `<W>x<H>-<filter>@<right>,<down>.exr`, its shift in pixels.
A converged reference has its standard error beside it, in `<W>x<H>-<filter>.standard-error.exr`. Nothing is replaced or
made in passing: a file that is missing, that was made for another version of its scene, or that was changed since, is
an error that says what to do.
"""

from __future__ import annotations

import hashlib
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy
import shapely

from aliascope import agreement
from aliascope.agreement import Estimate
from aliascope.draws import UNMOVED, text_of
from aliascope.errors import CheckFailed, InvalidInput
from aliascope.geometry import Array
from aliascope.image import read_header, read_image, write_exr
from aliascope.model import Scene
from aliascope.records import Pixels
from aliascope.references import converged, make
from aliascope.references.converged import Plan
from aliascope.references.result import Reference

Shift = tuple[float, float]
"""Pixels to the right and down by which all that is seen is moved on the film."""
CHECK = Plan(samples=576, replicates=32, sampler="jittered", first_seed=1 << 41)
"""How a converged reference is checked: another pattern and other seeds, at an eighth of the cost."""
PROVENANCE = ("samples_per_pixel", "replicates", "sampler", "seeds", "embree")
"""What the header of a converged reference has besides."""
HALF_ULP = 2.0**-24
"""float32 rounds to nearest: within this, relative to the value."""
SMALLEST = 2.0**-149
"""And within this where the value is too small for that."""


@dataclass(frozen=True)
class Verification:
    """A stored reference against the same, made again.

    An exact one holds when no value differs by more than its tolerance (what float32 rounds there, and both error
    bounds) and the file is as it was written; a converged one when it agrees with an independent estimate as far as
    the standard errors of both can tell (`agreement`). Otherwise `reason` says what is wrong. `max_difference` is the
    largest absolute difference, NaN where the file has a NaN. The value that comes nearest to its tolerance, or is
    beyond it the most, is at pixel `x`, `y` and `channel`, with its `difference` and `tolerance`.
    """

    holds: bool
    reason: str
    max_difference: float
    difference: float
    tolerance: float
    x: int
    y: int
    channel: int
    method: str
    error: float


def path_of(folder: Path, name: str, size: tuple[int, int], filter_: str, shift: Shift = UNMOVED) -> Path:
    """Where the reference of a scene lies, whether it is there or not."""
    moved = "" if shift == UNMOVED else f"@{text_of(shift)}"
    return folder / name / f"{size[0]}x{size[1]}-{filter_}{moved}.exr"


def files_of(path: Path) -> list[Path]:
    """The file of a reference and that of its standard error, if it has one."""
    return [path, *(each for each in (_spread_path(path),) if each.is_file())]


def command_for(
    name: str, scene: Scene, size: tuple[int, int], filter_: str, samples: str = "", shift: Shift = UNMOVED
) -> str:
    """The command that makes a reference, `samples` in it where they are not the usual ones."""
    command = f"aliascope reference {shlex.quote(name)}"
    if size != scene.view.size:
        command += f" --size {size[0]}x{size[1]}"
    if filter_ != "box":
        command += f" --filter {filter_}"
    if shift != UNMOVED:
        command += f" --shift {text_of(shift)}"
    return f"{command} --samples {samples}" if samples not in ("", str(Plan.samples)) else command


def save(
    folder: Path,
    name: str,
    scene: Scene,
    size: tuple[int, int],
    filter_: str,
    reference: Reference,
    shift: Shift = UNMOVED,
) -> Path:
    """Writes a reference and returns its path. Raises NotWritable."""
    path = path_of(folder, name, size, filter_, shift)
    samples = reference.provenance.get("samples_per_pixel", "")
    header = {
        "scene": name,
        "scene_hash": scene.digest(),
        "size": f"{size[0]}x{size[1]}",
        "filter": filter_,
        **({} if shift == UNMOVED else {"shift": text_of(shift)}),
        "method": reference.method,
        "error": repr(reference.error),
        "command": command_for(name, scene, size, filter_, samples, shift),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "shapely": f"{shapely.__version__}, GEOS {shapely.geos_version_string}",
        "pixels": _digest(reference.pixels),
        **reference.provenance,
    }
    if reference.standard_error is not None:
        spread = _three_digits(reference.standard_error)
        header["standard_error"] = _digest(spread)
        write_exr(_spread_path(path), spread, header)
    write_exr(path, reference.pixels, header)
    return path


def load(
    folder: Path, name: str, scene: Scene, size: tuple[int, int], filter_: str, shift: Shift = UNMOVED
) -> Reference:
    """The stored reference of a scene. Its `exact` is the stored float32, which its `error` allows for.

    Raises CheckFailed when it is missing, was made for another version of the scene, or was changed since.
    """
    path = path_of(folder, name, size, filter_, shift)
    pixels, header = _read(path, name, scene, size, filter_, shift)
    advice = f"make it again with: {command_for(name, scene, size, filter_, shift=shift)}"
    error = _recorded_error(header)
    if not np.isfinite(pixels).all():
        raise CheckFailed(f"{path}: the reference has values that are not finite; {advice}")
    if header.get("pixels") != _digest(pixels):
        raise CheckFailed(f"{path}: the reference was changed since it was made; {advice}")
    if error is None:
        raise CheckFailed(f"{path}: the reference does not state its error; {advice}")
    return Reference(
        pixels=pixels,
        exact=pixels.astype(np.float64),
        error=error + HALF_ULP * float(np.abs(pixels).max()),
        method=header.get("method", ""),
        standard_error=_read_spread(path, header, pixels, advice),
        provenance={key: header[key] for key in PROVENANCE if key in header},
    )


def verify(
    folder: Path,
    name: str,
    scene: Scene,
    size: tuple[int, int],
    filter_: str,
    check: Plan = CHECK,
    shift: Shift = UNMOVED,
) -> Verification:
    """Makes a reference again and compares, a converged one by `check`. What differs is in the result, never raised.

    Raises CheckFailed when there is nothing to compare: the file is missing, or of another version of the scene.
    """
    path = path_of(folder, name, size, filter_, shift)
    stored, header = _read(path, name, scene, size, filter_, shift)
    if "standard_error" in header:
        drawn = converged.renderer(scene, size, filter_, check, shift)
        return _verify_converged(path, (stored, header), drawn, filter_, check)
    again = make(scene, size, filter_, shift=shift)
    recorded = _recorded_error(header)
    error = again.error + (recorded if recorded is not None else 0.0)
    difference = np.abs(stored.astype(np.float64) - again.exact)
    tolerance = error + HALF_ULP * np.abs(again.exact) + SMALLEST
    ratio = np.where(np.isnan(difference), np.inf, difference / tolerance)
    row, column, channel = (int(i) for i in np.unravel_index(int(np.argmax(ratio)), ratio.shape))
    worst = float(difference[row, column, channel])
    reason = ""
    if not bool((difference <= tolerance).all()):  # so that a NaN, which compares as false, never passes
        reason = f"pixel ({column}, {row}) channel {channel} differs by {worst:.3g}"
    elif header.get("pixels") != _digest(stored):
        reason = "the file was changed since it was made, if by no more than its error"
    elif recorded is None:
        reason = "the file does not state its error"
    elif header.get("method") != again.method:
        reason = f'the file was made by "{header.get("method")}", not "{again.method}"'
    return Verification(
        holds=not reason,
        reason=reason,
        max_difference=float(difference.max()),
        difference=worst,
        tolerance=float(tolerance[row, column, channel]),
        x=column,
        y=row,
        channel=channel,
        method=again.method,
        error=again.error,
    )


def _verify_converged(
    path: Path, file: tuple[Pixels, Mapping[str, str]], drawn: converged.Render, filter_: str, check: Plan
) -> Verification:
    stored, header = file
    spread = _read_spread(path, header, stored, "make it again")
    assert spread is not None  # the header says so
    again, pictures = converged.estimate(drawn, check)
    factor = 1.0 if filter_ == "box" else agreement.correlation(pictures)
    error = converged.ROUNDING * float(np.abs(pictures).max())
    counts = [header.get(key, "") for key in ("replicates", "samples_per_pixel")]
    usable = all(count.isdecimal() for count in counts) and int(counts[0]) >= 2
    replicates, samples = (int(count) for count in counts) if usable else (2, check.samples)
    recorded = Estimate(stored.astype(np.float64), spread, replicates, replicates * samples)
    found = agreement.agreement(recorded, again, 2 * error, factor)
    reason = found.reason
    if not reason and header.get("pixels") != _digest(stored):
        reason = "the file was changed since it was made, if by no more than its standard errors can tell"
    elif not reason and not usable:
        reason = "the file does not state how many samples it has"
    elif not reason and _recorded_error(header) is None:
        reason = "the file does not state its error"
    row, column, channel = found.place
    return Verification(
        holds=not reason,
        reason=reason,
        max_difference=float(np.abs(recorded.mean - again.mean).max()),
        difference=found.difference,
        tolerance=found.tolerance,
        x=column,
        y=row,
        channel=channel,
        method=header.get("method", ""),
        error=error,
    )


def _read(
    path: Path, name: str, scene: Scene, size: tuple[int, int], filter_: str, shift: Shift
) -> tuple[Pixels, Mapping[str, str]]:
    """The pixels and the header of a stored reference of this very scene, size, filter and shift."""
    command = command_for(name, scene, size, filter_, shift=shift)
    if not path.is_file():
        what = f"{name} at {size[0]}x{size[1]} with the filter {filter_}"
        if shift != UNMOVED:
            what += f", shifted by {text_of(shift)} pixels"
        raise CheckFailed(f"no reference for {what} ({path}): make it with: {command}")
    try:
        header, pixels = read_header(path), read_image(path)
    except InvalidInput as error:
        raise CheckFailed(f"{error}; make the reference again with: {command}") from error
    if header.get("scene_hash") != scene.digest():
        raise CheckFailed(f"{path}: was made for another version of the scene; make it again with: {command}")
    stated = (header.get("size"), header.get("filter"))
    if stated != (f"{size[0]}x{size[1]}", filter_) or pixels.shape != (size[1], size[0], 3):
        raise CheckFailed(
            f"{path}: holds {pixels.shape[1]} x {pixels.shape[0]} pixels of {pixels.shape[2]} channels and says "
            f"{stated[0]}, filter {stated[1]}; make it again with: {command}"
        )
    moved, wanted = header.get("shift", text_of(UNMOVED)), text_of(shift)
    if moved != wanted:
        raise CheckFailed(f"{path}: is shifted by {moved} pixels, not {wanted}; make it again with: {command}")
    return pixels, header


def _read_spread(path: Path, header: Mapping[str, str], pixels: Pixels, advice: str) -> Array | None:
    if "standard_error" not in header:
        return None
    beside = _spread_path(path)
    if not beside.is_file():
        raise CheckFailed(f"{beside}: the standard error of the reference is missing; {advice}")
    try:
        spread = read_image(beside)
    except InvalidInput as error:
        raise CheckFailed(f"{error}; {advice}") from error
    if spread.shape != pixels.shape or header["standard_error"] != _digest(spread):
        raise CheckFailed(f"{beside}: the standard error was changed since it was made; {advice}")
    return spread.astype(np.float64)


def _three_digits(standard_error: Array) -> Pixels:
    """Standard errors rounded up to 8 bits, which is more than they are known to and a quarter of the file."""
    mantissa, exponent = np.frexp(standard_error)
    return np.ldexp(np.ceil(mantissa * 256.0) / 256.0, exponent).astype(np.float32)


def _spread_path(path: Path) -> Path:
    return path.with_suffix(".standard-error.exr")


def _recorded_error(header: Mapping[str, str]) -> float | None:
    """The error bound that a header states: finite and not negative, else None."""
    try:
        error = float(header.get("error", "nan"))
    except ValueError:
        return None
    return error if 0.0 <= error < float("inf") else None


def _digest(pixels: Pixels) -> str:
    """SHA-256 of the pixels as little-endian float32, row by row."""
    return hashlib.sha256(np.ascontiguousarray(pixels, dtype="<f4").tobytes()).hexdigest()
