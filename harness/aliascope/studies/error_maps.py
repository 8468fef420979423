"""`aliascope error`: two pictures as linear values, or why they can't be compared, and a map of their difference."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

from aliascope.errors import InvalidInput, NotWritable
from aliascope.image import decode_srgb, legible, opened, read_image, write_exr
from aliascope.metrics import check_finite
from aliascope.records import Pixels

LINEAR, SRGB = "linear", "srgb"
COLOUR_SPACES = (LINEAR, SRGB)
OPTIONS = ("--colour-space", "--reference-colour-space")

_TAGS = {
    **dict.fromkeys(["lin_rec709_scene", "lin_rec709", "lin_srgb", "linear", "Linear"], LINEAR),
    **dict.fromkeys(["srgb_rec709_scene", "srgb_rec709_display", "sRGB"], SRGB),
}
"""OpenImageIO's names of the two colour spaces; it gives PNG, JPEG and BMP the latter where the file says nothing."""


@dataclass(frozen=True)
class Stored:
    """What a file holds: its values' type ("uint8", "half"), the names of its channels, and its colour space.

    `colour_space` is "linear", "srgb", another's name as OpenImageIO gives it, or "" where nothing tells.
    """

    path: Path
    format: str
    colour_space: str
    channels: tuple[str, ...]
    alpha: bool
    size: tuple[int, int]
    offset: tuple[int, int]
    """Of the stored pixels' corner from that of the whole picture's window."""


@dataclass(frozen=True)
class Opened:
    """A picture as linear values, and what they were made from; `stated`: the user said what it is."""

    pixels: Pixels
    stored: Stored
    colour_space: str
    stated: bool

    def document(self) -> dict[str, str | bool]:
        """For --json."""
        return {"format": self.stored.format, "colour_space": self.colour_space, "stated": self.stated}


# --- reading ----------------------------------------------------------------------------------------------------------


def describe(path: Path) -> Stored:
    """Reads what a file says of itself. Raises InvalidInput."""
    with opened(path) as file:
        spec, kind = file.spec(), file.format_name()
    return Stored(
        path=path,
        format=str(spec.format),
        colour_space=_colour_space(spec, kind),
        channels=tuple(legible(str(name)) for name in spec.channelnames),
        alpha=spec.alpha_channel >= 0,
        size=(spec.width, spec.height),
        offset=(spec.x - spec.full_x, spec.y - spec.full_y),
    )


def _colour_space(spec: oiio.ImageSpec, kind: str) -> str:
    tag = legible(spec.get_string_attribute("oiio:ColorSpace"))
    profile = legible(spec.get_string_attribute("ICCProfile:profile_description"))
    if profile and "srgb" not in profile.lower():
        return profile
    # OpenImageIO calls all of Netpbm's files "Rec709"; a PFM holds light, and of a PPM's curve nobody can be sure.
    if not tag or (kind == "pnm" and tag == "Rec709"):
        return LINEAR if str(spec.format) in ("half", "float", "double") else ""
    return _TAGS.get(tag, tag)


def open_pair(
    image: Path, reference: Path, stated: str | None = None, reference_stated: str | None = None
) -> tuple[Opened, Opened]:
    """Two pictures as linear values, which metrics are defined on.

    `stated` and `reference_stated` say what the files hold, "linear" or "srgb", over what they say themselves. Two
    pictures that say they are sRGB are decoded, both. Raises InvalidInput where size, window or channels differ, where
    a picture's colour space is unknown or another, and where one is sRGB, one linear, and nobody has said that this is
    meant. Other bit depths are no hindrance once the colour space is known: `Stored.format` tells them.
    """
    for option, value in zip(OPTIONS, (stated, reference_stated), strict=True):
        if value is not None and value not in COLOUR_SPACES:
            raise InvalidInput(f'{option} "{value}" is neither linear nor srgb')
    a, r = describe(image), describe(reference)
    _check_shapes(a, r)
    spaces = stated or _known(a, OPTIONS[0]), reference_stated or _known(r, OPTIONS[1])
    if spaces[0] != spaces[1]:
        encoded, linear, option, said = (
            (a, r, OPTIONS[0], stated) if spaces[0] == SRGB else (r, a, OPTIONS[1], reference_stated)
        )
        if said is None:
            raise InvalidInput(
                f"{encoded.path} ({encoded.format}) is sRGB and {linear.path} ({linear.format}) is linear, and metrics "
                f"are of linear values: add {option} srgb to have it decoded, or {option} linear if its values are "
                "linear in truth"
            )
    return _open(a, spaces[0], stated is not None), _open(r, spaces[1], reference_stated is not None)


def _check_shapes(a: Stored, r: Stored) -> None:
    if a.size != r.size:
        raise InvalidInput(
            f"the picture has {a.size[0]} x {a.size[1]} pixels, the reference {r.size[0]} x {r.size[1]} pixels: "
            "they can't be compared"
        )
    names = [tuple(name.rpartition(".")[2].upper() for name in each.channels) for each in (a, r)]
    if names[0] != names[1]:
        first, second = (f"{len(each.channels)} channels ({', '.join(each.channels)})" for each in (a, r))
        hint = ""
        if a.alpha != r.alpha:
            more = a if a.alpha else r
            hint = f"; leave the alpha out with oiiotool {more.path} --ch R,G,B -o without-alpha{more.path.suffix}"
        raise InvalidInput(f"the picture has {first}, the reference {second}: they can't be compared{hint}")
    if a.offset != r.offset:
        raise InvalidInput(
            f"the pixels begin at {a.offset} in the picture's window, at {r.offset} in the reference's: "
            "they do not cover the same place"
        )


def _known(stored: Stored, option: str) -> str:
    if stored.colour_space in COLOUR_SPACES:
        return stored.colour_space
    if not stored.colour_space:
        raise InvalidInput(
            f"{stored.path} ({stored.format}) does not say whether its values are linear or sRGB: "
            f"say it with {option} srgb or {option} linear"
        )
    # Without --eraseattrib oiiotool leaves the old colour space's name in an EXR.
    raise InvalidInput(
        f'{stored.path} is in the colour space "{stored.colour_space}": make it linear Rec. 709 first, as with '
        f"oiiotool {stored.path} --tocolorspace lin_rec709_scene --eraseattrib colorInteropID -o linear.exr, or say "
        f"with {option} what its values are to be taken for, linear or srgb"
    )


def _open(stored: Stored, space: str, stated: bool) -> Opened:
    pixels = read_image(stored.path)
    if space == SRGB:
        if stored.alpha:
            raise InvalidInput(
                f"{stored.path}: sRGB values that alpha has multiplied can't be decoded; leave the alpha out with "
                f"oiiotool {stored.path} --ch R,G,B -o without-alpha{stored.path.suffix}"
            )
        pixels = decode_srgb(pixels)
    return Opened(pixels, stored, space, stated)


# --- drawing ----------------------------------------------------------------------------------------------------------


def check_map(path: Path | None, scale: float | None) -> None:
    """Raises InvalidInput for an ending that no map is written as, and a scale without a drawing or that is none."""
    ending = path.suffix.lower() if path else ""
    if path and ending not in (".png", ".exr"):
        raise InvalidInput(f'{path}: a map is written as .png (drawn) or .exr (values), not "{path.suffix}"')
    if scale is not None and ending != ".png":
        raise InvalidInput("a map's scale is that of a drawing: name one with --map OUT.png")
    if scale is not None and not (math.isfinite(scale) and scale > 0.0):
        raise InvalidInput(f"a map's scale is a positive number, not {scale}")


def write_map(path: Path, image: Opened, reference: Opened, scale: float | None = None) -> float | None:
    """Writes the signed error image - reference; gives the scale of a drawing.

    .exr: float32, of each channel. .png: the mean over channels from -scale (blue, too dark) over 0 (white) to scale
    (red, too bright), at whole-pixel zoom, with a legend; what lies beyond has the end's colour, and the legend says
    how many pixels. `scale`: the largest of the picture if not given. Raises InvalidInput, NotWritable.
    """
    check_map(path, scale)
    for each, what in ((image, "the picture"), (reference, "the reference")):
        check_finite(each.pixels, what)
    error = image.pixels.astype(np.float64) - reference.pixels
    if path.suffix.lower() == ".exr":
        header = {
            "image": str(image.stored.path),
            "reference": str(reference.stored.path),
            "error": "image - reference",
        }
        write_exr(path, error.astype(np.float32), header)
        return None
    mean = error.mean(axis=2)
    if scale is None:
        scale = float(np.abs(mean).max()) or 1.0
    title = f"{image.stored.path.name} − {reference.stored.path.name}"
    try:
        _draw(path, mean, scale, title)
    except OSError as problem:
        raise NotWritable(f"{path}: cannot be written: {problem.strerror}") from problem
    return scale


DPI = 100
LEAST_SIDE = 512
"""Pixels of a drawing's longer side at least: smaller pictures are enlarged by a whole factor."""
MARGIN, TITLE, LEGEND = 16, 30, 76
"""Pixels around the picture, above it, and below."""


def map_zoom(width: int, height: int) -> int:
    """How many pixels of the drawing a side of a picture's pixel has."""
    return math.ceil(LEAST_SIDE / max(width, height))


def _draw(path: Path, mean: NDArray[np.float64], scale: float, title: str) -> None:
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    zoom = map_zoom(mean.shape[1], mean.shape[0])
    colours = ScalarMappable(Normalize(-scale, scale), colormaps["RdBu_r"])
    pixels = colours.to_rgba(mean, bytes=True).repeat(zoom, axis=0).repeat(zoom, axis=1)
    height, width = pixels.shape[:2]
    full = max(width, LEAST_SIDE) + 2 * MARGIN, height + TITLE + LEGEND
    figure = Figure(figsize=(full[0] / DPI, full[1] / DPI), dpi=DPI)
    figure.figimage(pixels, MARGIN, LEGEND, origin="upper")  # pixel for pixel: an axes would resample
    figure.text(MARGIN / full[0], 1 - 20 / full[1], title, fontsize=9)

    beyond = int((np.abs(mean) > scale).sum())
    bar = figure.add_axes((4 * MARGIN / full[0], (LEGEND - 24) / full[1], 1 - 8 * MARGIN / full[0], 12 / full[1]))
    legend = figure.colorbar(
        colours, cax=bar, orientation="horizontal", ticks=[-scale, 0.0, scale], extend="both" if beyond else "neither"
    )
    legend.ax.set_xticklabels([f"−{scale:.3g}", "0", f"+{scale:.3g}"], fontsize=8)
    words = "blue too dark, red too bright; mean over channels"
    if not mean.any():
        words = "no error"
    elif beyond:
        words += f"; {beyond} pixel{'s' if beyond > 1 else ''} beyond the ends"
    legend.set_label(words, fontsize=8)
    figure.savefig(path, dpi=DPI, format="png")
