"""Pictures on disk, through OpenImageIO: EXR float32 with provenance in the header, written whole or not at all."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # the name that its own documentation uses

from aliascope.errors import InvalidInput, NotFinite, NotWritable
from aliascope.model import LARGEST_AREA
from aliascope.records import Counts, Pixels

HEADER_PREFIX = "aliascope:"

LARGEST_PICTURE = 4 * LARGEST_AREA
"""Values of a picture that is read whole: 1 GiB as float32."""
LARGEST_ROW = 1 << 24
MOST_CHANNELS = 256


def write_exr(path: Path, pixels: Pixels, header: Mapping[str, str], *, finite: bool = True) -> None:
    """Writes (height, width, channels) float32 as EXR; the header's entries get the prefix `aliascope:`.

    The file appears under its name only when it is complete. Raises NotWritable; where values are to be `finite`,
    NotFinite for one that is not: it names the file and the first pixel.
    """
    height, width, channels = pixels.shape
    broken = ~np.isfinite(pixels)
    if finite and broken.any():
        y, x, channel = (int(i) for i in np.argwhere(broken)[0])
        raise NotFinite(
            f"{path}: not written: {int(broken.sum())} values are no finite numbers, the first at x={x}, y={y}, "
            f"channel {channel} ({pixels[y, x, channel]:g})"
        )
    spec = oiio.ImageSpec(width, height, channels, "float")
    spec.attribute("compression", "zip")
    spec.attribute("oiio:ColorSpace", "lin_rec709_scene")
    spec.attribute("DateTime", "1970:01:01 00:00:00")  # instead of now: the same picture is the same file
    for key, value in header.items():
        spec.attribute(HEADER_PREFIX + key, value)
    temporary = path.with_name(f".{path.stem}.{os.getpid()}.exr")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        out = oiio.ImageOutput.create(str(temporary))
        if out is None:
            raise NotWritable(f"{path}: {oiio.geterror()}")
        if not (out.open(str(temporary), spec) and out.write_image(np.ascontiguousarray(pixels)) and out.close()):
            raise NotWritable(f"{path}: cannot be written: {_first_line(out.geterror())}")
        _sync(temporary)  # else the name can outlive a loss of power and the contents not
        temporary.replace(path)
    except OSError as error:
        raise NotWritable(f"{path}: cannot be written: {error.strerror}") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def write_counts(path: Path, counts: Counts, header: Mapping[str, str]) -> None:
    """Writes the samples of each pixel, (height, width), as an EXR of one channel; float is exact up to 2^24."""
    write_exr(path, counts.astype(np.float32)[..., np.newaxis], header)


def read_counts(path: Path) -> Counts:
    """What `write_counts` wrote. Raises InvalidInput, also for a picture of values that are no counts."""
    stored = read_image(path)[..., 0]
    if not bool(((stored >= 0.0) & (stored < 2.0**32) & (stored == np.floor(stored))).all()):
        raise InvalidInput(f"{path}: holds values that are no counts of samples: whole numbers from 0 to 2^32 - 1")
    return stored.astype(np.uint32)


def _sync(path: Path) -> None:
    with path.open("rb+") as file:
        os.fsync(file.fileno())


def remove_unfinished(folder: Path) -> None:
    """Removes what a process that was killed while it wrote a picture left below this folder."""
    for path in folder.glob("**/.*.exr"):
        path.unlink(missing_ok=True)


@contextlib.contextmanager
def opened(path: Path) -> Iterator[oiio.ImageInput]:
    """A picture's file, open. Raises InvalidInput where it is not there or no picture."""
    if not path.is_file():
        pipe = "it is no file, but a pipe, a device or a folder" if path.exists() else "there is no such file"
        raise InvalidInput(f"{path}: {pipe}")
    # By its definition the rows of a PFM go from the bottom to the top, which OpenImageIO only heeds if asked to.
    config = oiio.ImageSpec()
    config.attribute("pnm:pfmflip", 1)
    with _libpng_silent(path):
        try:
            image = oiio.ImageInput.open(str(path), config)
            if image is None:
                raise InvalidInput(f"{path}: not a picture that can be read: {_first_line(oiio.geterror())}")
            try:
                _check_size(path, image.spec())
                yield image
            finally:
                image.close()
        except UnicodeDecodeError as error:  # of what OpenImageIO quotes from the file, and gives as it is there
            quoted = error.object.decode(errors="backslashreplace")
            raise InvalidInput(f"{path}: a name in it is no text: {_first_line(quoted)}") from error


def _check_size(path: Path, spec: oiio.ImageSpec) -> None:
    """Raises InvalidInput for a header that claims more than is taken, before any of it is made."""
    if spec.nchannels > MOST_CHANNELS or spec.width * spec.nchannels > LARGEST_ROW or spec.depth > 1:
        raise InvalidInput(
            f"{path}: says that it has {spec.nchannels} channels, {spec.width} pixels in a row, {spec.depth} layers: "
            f"at most {MOST_CHANNELS} channels, {LARGEST_ROW} values in a row and one layer are read"
        )


def read_image(path: Path) -> Pixels:
    """Any picture that OpenImageIO reads, as float32 (height, width, channels), as stored: no colour conversion.

    Raises InvalidInput where the file is not there, no picture, or not whole.
    """
    with opened(path) as image:
        spec = image.spec()
        values = int(spec.width) * int(spec.height) * int(spec.nchannels)  # of one layer, as `opened` saw to
        if values > LARGEST_PICTURE:
            raise InvalidInput(f"{path}: says that it has {values} values, and at most {LARGEST_PICTURE} are read")
        pixels = image.read_image(oiio.FLOAT)
        problem = image.geterror()  # a JPEG that ends too soon has pixels all the same
        if pixels is None or problem:
            raise InvalidInput(f"{path}: the picture is broken: {_first_line(problem)}")
        return np.asarray(pixels, dtype=np.float32)


def read_header(path: Path) -> dict[str, str]:
    """The provenance in a picture's header, without the prefix; empty where there is none. Raises InvalidInput."""
    with opened(path) as image:
        return {
            legible(attribute.name.removeprefix(HEADER_PREFIX)): legible(str(attribute.value))
            for attribute in image.spec().extra_attribs
            if attribute.name.startswith(HEADER_PREFIX)
        }


def decode_srgb(encoded: Pixels) -> Pixels:
    """Linear values of sRGB ones, in float32; IEC 61966-2-1:1999, negative ones by the curve's mirror image."""
    size = np.abs(encoded.astype(np.float64))
    linear = np.where(size <= 0.04045, size / 12.92, ((size + 0.055) / 1.055) ** 2.4)
    return np.copysign(linear, encoded).astype(np.float32)


def read_rows(image: oiio.ImageInput, path: Path, first: int, count: int) -> Pixels:
    """Some rows of a picture that is `opened`, as `read_image` has them; `path` is for errors. Raises InvalidInput."""
    pixels = image.read_scanlines(first, first + count, 0, 0, image.spec().nchannels, oiio.FLOAT)
    if pixels is None:
        raise InvalidInput(f"{path}: the picture is broken: {_first_line(image.geterror())}")
    return np.asarray(pixels, dtype=np.float32)


_standard_error = threading.Lock()


@contextlib.contextmanager
def _libpng_silent(path: Path) -> Iterator[None]:
    """Keeps from standard error what libpng prints there of a broken PNG, and OpenImageIO reports as well."""
    try:
        with path.open("rb") as file:
            is_png = file.read(8) == b"\x89PNG\r\n\x1a\n"
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read: {error.strerror}") from error
    if not is_png:
        yield
        return
    with _standard_error, Path(os.devnull).open("wb") as nowhere:
        kept = os.dup(2)
        os.dup2(nowhere.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)


def legible(text: str) -> str:
    """A text of a picture's header; bytes that are no UTF-8, which OpenImageIO hands on as they are, escaped."""
    return text.encode(errors="surrogateescape").decode(errors="backslashreplace")


def _first_line(text: str) -> str:
    return text.strip().splitlines()[0] if text.strip() else "no reason given"
