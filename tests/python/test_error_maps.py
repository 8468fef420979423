"""`aliascope error`: which pictures can be compared, what they are decoded to, and the map."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from aliascope import metrics
from aliascope.errors import InvalidInput, NotWritable
from aliascope.image import read_header, read_image, write_exr
from aliascope.studies import error_maps
from aliascope.studies.error_maps import LEAST_SIDE, LEGEND, MARGIN, TITLE, decode_srgb, map_zoom, open_pair, write_map

RAMP = np.random.default_rng(1).random((6, 8, 3), dtype=np.float32)


def write(
    path: Path,
    pixels: np.ndarray = RAMP,
    kind: str = "float",
    space: str | None = None,
    names: tuple[str, ...] | None = None,
    offset: int = 0,
    attributes: dict[str, str] | None = None,
) -> Path:
    """A picture as other programs write them."""
    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, kind)
    if names:
        spec.channelnames = names
    spec.x, spec.full_x = offset, 0
    spec.alpha_channel = 3 if channels == 4 else -1
    for key, value in {**(attributes or {}), **({"oiio:ColorSpace": space} if space else {})}.items():
        spec.attribute(key, value)
    out = oiio.ImageOutput.create(str(path))
    assert out is not None
    assert out.open(str(path), spec), out.geterror()
    assert out.write_image(np.ascontiguousarray(pixels, dtype=np.float32)), out.geterror()
    assert out.close()
    return path


def encode(linear: np.ndarray) -> np.ndarray:
    coded = oiio.ImageBufAlgo.colorconvert(oiio.ImageBuf(linear), "lin_rec709_scene", "srgb_rec709_scene")
    return np.asarray(coded.get_pixels())


def refusal(*arguments: object) -> str:
    with pytest.raises(InvalidInput) as problem:
        open_pair(*arguments)  # type: ignore[arg-type]
    return str(problem.value)


# --- what can be compared ---------------------------------------------------------------------------------------------


def test_linear_pictures_of_other_depths_are_as_stored(tmp_path: Path) -> None:
    exr = write(tmp_path / "float.exr")
    others = [
        write(tmp_path / "half.exr", kind="half"),
        write(tmp_path / "float.tif"),
        write(tmp_path / "linear.png", kind="uint8", space="lin_rec709_scene"),
        write(tmp_path / "light.hdr"),
        write(tmp_path / "light.pfm"),
    ]
    for path in others:
        a, r = open_pair(path, exr)
        assert (a.colour_space, r.colour_space) == ("linear", "linear")
        assert not a.stated
        assert np.array_equal(a.pixels, read_image(path))
        assert np.array_equal(r.pixels, RAMP)
    assert open_pair(others[0], exr)[0].document() == {"format": "half", "colour_space": "linear", "stated": False}
    assert open_pair(others[2], exr)[0].stored.format == "uint8"


@pytest.mark.parametrize(("name", "kind"), [("a.png", "uint8"), ("a.png", "uint16"), ("a.jpg", "uint8")])
def test_an_srgb_picture_against_a_linear_one_is_refused_until_it_is_said(tmp_path: Path, name: str, kind: str) -> None:
    coded, exr = write(tmp_path / name, encode(RAMP), kind), write(tmp_path / "r.exr")
    text = refusal(coded, exr)
    assert f"{coded} ({kind}) is sRGB and {exr} (float) is linear" in text
    assert "add --colour-space srgb to have it decoded" in text
    assert "add --reference-colour-space srgb" in refusal(exr, coded)
    a, r = open_pair(coded, exr, "srgb")
    assert (a.colour_space, a.stated, r.stated) == ("srgb", True, False)
    if name.endswith("png"):
        step = 1 / (255 if kind == "uint8" else 65535)
        assert np.abs(a.pixels - RAMP).max() < 2.3 * step  # half a step, by the curve's slope of at most 2.27 (+ float)
    assert np.array_equal(open_pair(exr, coded, None, "srgb")[1].pixels, a.pixels)
    # What the user says goes before what the file says.
    assert np.array_equal(open_pair(coded, exr, "linear")[0].pixels, read_image(coded))


def test_a_picture_tagged_srgb_is_srgb_whatever_its_depth(tmp_path: Path) -> None:
    coded, exr = write(tmp_path / "a.exr", encode(RAMP), space="sRGB"), write(tmp_path / "r.exr")
    assert "(float) is sRGB" in refusal(coded, exr)
    assert open_pair(coded, exr, "srgb")[0].pixels == pytest.approx(RAMP, abs=5e-5)  # OpenImageIO's encoding is rough


def test_two_srgb_pictures_are_decoded_both(tmp_path: Path) -> None:
    shallow = write(tmp_path / "a.png", encode(RAMP), "uint8")
    deep = write(tmp_path / "b.png", encode(RAMP), "uint16")
    a, b = open_pair(shallow, deep)
    assert (a.colour_space, b.colour_space) == ("srgb", "srgb")
    assert (a.stored.format, b.stored.format) == ("uint8", "uint16")
    assert b.pixels == pytest.approx(RAMP, abs=2.3 / 65535)
    assert 0 < np.abs(a.pixels - b.pixels).max() < 2.3 / 255


@pytest.mark.parametrize("name", ["a.tif", "a.tga", "a.ppm"])
def test_integers_that_say_nothing_are_refused_until_it_is_said(tmp_path: Path, name: str) -> None:
    path, exr = write(tmp_path / name, kind="uint8"), write(tmp_path / "r.exr")
    text = refusal(path, exr)
    assert f"{path} (uint8) does not say whether its values are linear or sRGB" in text
    assert "say it with --colour-space srgb or --colour-space linear" in text
    assert "with --reference-colour-space srgb" in refusal(exr, path)
    assert "with --reference-colour-space srgb" in refusal(path, path, "srgb")
    assert np.array_equal(open_pair(path, exr, "linear")[0].pixels, read_image(path))
    assert np.array_equal(open_pair(path, path, "srgb", "srgb")[1].pixels, decode_srgb(read_image(path)))


def test_other_colour_spaces_are_refused_with_the_way_out(tmp_path: Path) -> None:
    exr = write(tmp_path / "r.exr")
    wide = write(tmp_path / "a.exr", space="ACEScg")
    text = refusal(wide, exr)
    assert 'in the colour space "lin_ap1_scene"' in text
    assert f"oiiotool {wide} --tocolorspace lin_rec709_scene" in text
    gamma = write(tmp_path / "a.png", kind="uint8", space="Gamma2.2")
    assert 'in the colour space "g22_rec709_scene"' in refusal(gamma, exr)
    assert np.array_equal(open_pair(wide, exr, "linear")[0].pixels, RAMP)
    assert "neither linear nor srgb" in refusal(exr, exr, "sRGB")
    assert '--reference-colour-space "xyz"' in refusal(exr, exr, None, "xyz")


def test_a_profile_goes_before_the_tag(tmp_path: Path) -> None:
    from PIL import Image, ImageCms

    known = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    for profile, space in (
        (known, "srgb"),
        (known.replace("sRGB built-in".encode("utf-16-be"), "wide built-in".encode("utf-16-be")), "wide built-in"),
    ):
        path = tmp_path / "a.png"
        Image.fromarray((RAMP * 255).astype(np.uint8)).save(path, icc_profile=profile)
        assert error_maps.describe(path).colour_space == space


def test_the_way_out_of_the_message_is_one(tmp_path: Path) -> None:
    exr, wide = write(tmp_path / "r.exr"), write(tmp_path / "a.exr", space="ACEScg")
    words = refusal(wide, exr).partition("as with oiiotool ")[2].partition(", or say")[0].split()
    words[words.index("linear.exr")] = str(tmp_path / "linear.exr")
    subprocess.run([Path(sys.executable).with_name("oiiotool"), *words], check=True)
    assert open_pair(tmp_path / "linear.exr", exr)[0].colour_space == "linear"


def test_other_sizes_channels_and_windows_are_refused(tmp_path: Path) -> None:
    exr = write(tmp_path / "r.exr")
    small = write(tmp_path / "small.exr", RAMP[1:])
    assert "the picture has 8 x 5 pixels, the reference 8 x 6 pixels" in refusal(small, exr)
    grey = write(tmp_path / "grey.exr", RAMP[:, :, :1], names=("Y",))
    assert "the picture has 1 channels (Y), the reference 3 channels (R, G, B)" in refusal(grey, exr)
    other = write(tmp_path / "xyz.exr", names=("X", "Y", "Z"))
    assert "3 channels (X, Y, Z), the reference 3 channels (R, G, B)" in refusal(other, exr)
    layer = write(tmp_path / "layer.exr", names=("light.r", "light.g", "light.b"))
    assert np.array_equal(open_pair(layer, exr)[0].pixels, RAMP)
    moved = write(tmp_path / "moved.exr", offset=2)
    assert "begin at (2, 0) in the picture's window, at (0, 0) in the reference's" in refusal(moved, exr)


def test_alpha_is_said_and_the_way_to_be_rid_of_it_works(tmp_path: Path) -> None:
    exr = write(tmp_path / "r.exr")
    four = np.dstack([RAMP, np.full((6, 8), 0.5, np.float32)])
    alpha = write(tmp_path / "a.exr", four)
    for pair, option in (((alpha, exr), alpha), ((exr, alpha), alpha)):
        text = refusal(*pair)
        assert "4 channels (R, G, B, A)" in text
        assert f"leave the alpha out with oiiotool {option} --ch R,G,B" in text
    words = refusal(alpha, exr).partition("with oiiotool ")[2].split()
    words[-1] = str(tmp_path / words[-1])
    subprocess.run([Path(sys.executable).with_name("oiiotool"), *words], check=True)
    assert np.array_equal(open_pair(Path(words[-1]), exr)[0].pixels, RAMP)
    assert open_pair(alpha, alpha)[0].pixels.shape == (6, 8, 4)
    coded = write(tmp_path / "a.png", four, "uint8")
    assert "sRGB values that alpha has multiplied can't be decoded" in refusal(coded, coded)


def test_what_is_no_picture_is_said(tmp_path: Path) -> None:
    exr = write(tmp_path / "r.exr")
    assert "there is no such file" in refusal(tmp_path / "absent.exr", exr)
    (tmp_path / "text.png").write_text("words")
    assert "not a picture that can be read" in refusal(exr, tmp_path / "text.png")


def test_the_curve_is_that_of_openimageio() -> None:
    coded = np.linspace(0, 1, 4096, dtype=np.float32).reshape(1, -1, 1).repeat(3, axis=2)
    theirs = oiio.ImageBufAlgo.colorconvert(oiio.ImageBuf(coded), "srgb_rec709_scene", "lin_rec709_scene").get_pixels()
    assert decode_srgb(coded) == pytest.approx(theirs, rel=5e-5, abs=1e-6)  # its powers are fast and rough
    exact = {
        0.0: 0.0,
        1.0: 1.0,
        -1.0: -1.0,
        0.04: 0.04 / 12.92,
        0.5: (0.555 / 1.055) ** 2.4,
        2.0: (2.055 / 1.055) ** 2.4,
    }
    assert decode_srgb(np.float32(list(exact))) == pytest.approx(list(exact.values()), rel=2e-7)  # float32


# --- maps -------------------------------------------------------------------------------------------------------------


def drawn(path: Path, height: int, width: int) -> np.ndarray:
    """The part of a drawing that the picture fills."""
    picture = read_image(path)
    zoom = map_zoom(width, height)
    assert picture.shape[:2] == (height * zoom + TITLE + LEGEND, max(width * zoom, LEAST_SIDE) + 2 * MARGIN)
    return picture[TITLE : TITLE + height * zoom, MARGIN : MARGIN + width * zoom]


def test_a_map_is_drawn_pixel_by_pixel(tmp_path: Path) -> None:
    """Each pixel a square of its own colour: white where the mean error is 0, red for too bright, blue for too dark."""
    reference = np.full((6, 8, 3), 0.5, np.float32)
    image = reference.copy()
    image[1, 2] += [0.25, 0.0, 0.0]
    image[4, 7] -= [0.25, 0.5, 0.75]
    image[5, 0] += [0.25, -0.25, 0.0]
    pair = open_pair(write(tmp_path / "a.exr", image), write(tmp_path / "r.exr", reference))
    assert write_map(tmp_path / "map.png", *pair) == pytest.approx(0.5)
    zoom = map_zoom(8, 6)
    assert zoom == 64
    squares = drawn(tmp_path / "map.png", 6, 8).reshape(6, zoom, 8, zoom, -1)[..., :3]
    assert np.all(squares == squares[:, :1, :, :1])  # no smoothing
    colours = squares[:, 0, :, 0]
    neutral = colours[0, 0]
    assert np.ptp(neutral) < 0.01  # no hue
    assert neutral.min() > 0.96
    assert np.array_equal(colours[5, 0], neutral)
    red, green, blue = colours[1, 2]
    assert red > green > 0.5  # a sixth of the scale: pale
    assert red > blue
    red, green, blue = colours[4, 7]
    assert blue > green > red
    assert blue < 0.5  # the end: dark
    assert np.count_nonzero(np.any(colours != neutral, axis=2)) == 2


def test_a_map_has_its_legend(tmp_path: Path) -> None:
    """The strip below has both ends' colours, and ink; another scale is another drawing."""
    rng = np.random.default_rng(3)
    a, r = (write(tmp_path / name, rng.random((96, 128, 3), dtype=np.float32)) for name in ("a.exr", "r.exr"))
    pair = open_pair(a, r)
    scale = write_map(tmp_path / "own.png", *pair)
    assert scale == np.abs((pair[0].pixels.astype(float) - pair[1].pixels).mean(axis=2)).max()
    assert write_map(tmp_path / "fixed.png", *pair, 0.25) == 0.25
    own, fixed = (read_image(tmp_path / name)[..., :3] for name in ("own.png", "fixed.png"))
    strip = own[-LEGEND:].reshape(-1, 3)
    assert (strip.max(axis=1) < 0.3).sum() > 200  # letters
    picture = drawn(tmp_path / "own.png", 96, 128)[..., :3].reshape(-1, 3)
    darkest = picture[picture.sum(axis=1).argmin()]  # that of the largest error, an end of the scale
    assert np.any(np.all(np.abs(strip - darkest) < 0.01, axis=1))
    assert not np.array_equal(own[-LEGEND:], fixed[-LEGEND:])
    assert not np.array_equal(own[TITLE:-LEGEND], fixed[TITLE:-LEGEND])


def test_equal_pictures_have_a_white_map(tmp_path: Path) -> None:
    exr = write(tmp_path / "r.exr")
    assert write_map(tmp_path / "map.png", *open_pair(exr, exr)) == 1.0
    assert np.ptp(drawn(tmp_path / "map.png", 6, 8)[..., :3]) < 0.01


@pytest.mark.parametrize("shape", [(1, 1, 1), (1, 3000, 3), (3000, 1, 3), (5, 4, 4)])
def test_maps_of_any_shape(tmp_path: Path, shape: tuple[int, int, int]) -> None:
    pixels = np.random.default_rng(2).random(shape, dtype=np.float32)
    a, r = write(tmp_path / "a.exr", pixels), write(tmp_path / "r.exr", pixels[::-1])
    write_map(tmp_path / "map.png", *open_pair(a, r))
    drawn(tmp_path / "map.png", *shape[:2])


def test_an_exr_map_has_the_signed_error(tmp_path: Path) -> None:
    image, reference = RAMP * 3, RAMP[::-1] * 2
    pair = open_pair(write(tmp_path / "a.exr", image), write(tmp_path / "r.exr", reference))
    assert write_map(tmp_path / "map.exr", *pair) is None
    assert np.array_equal(read_image(tmp_path / "map.exr"), image - reference)
    assert read_header(tmp_path / "map.exr")["image"] == str(tmp_path / "a.exr")


def test_maps_that_cannot_be(tmp_path: Path) -> None:
    exr = write(tmp_path / "r.exr")
    pair = open_pair(exr, exr)
    with pytest.raises(InvalidInput, match=r'\.png \(drawn\) or \.exr \(values\), not "\.jpg"'):
        write_map(tmp_path / "map.jpg", *pair)
    for scale in (0.0, -1.0, math.inf, math.nan):
        with pytest.raises(InvalidInput, match="a positive number"):
            write_map(tmp_path / "map.png", *pair, scale)
    with pytest.raises(InvalidInput, match="name one with --map"):
        error_maps.check_map(None, 0.1)
    with pytest.raises(InvalidInput, match="that of a drawing"):
        write_map(tmp_path / "map.exr", *pair, 0.1)
    for ending in ("png", "exr"):
        with pytest.raises(NotWritable, match="cannot be written"):
            write_map(exr / f"map.{ending}", *pair)
    broken = RAMP.copy()
    broken[2, 3, 1] = np.inf
    with pytest.raises(InvalidInput, match="1 infinite values, the first at x=3, y=2"):
        write_map(tmp_path / "map.png", open_pair(write(tmp_path / "a.exr", broken), exr)[0], pair[1])
    assert not list(tmp_path.glob("map*"))


# --- the command ------------------------------------------------------------------------------------------------------


def run(*arguments: object, code: int = 0) -> subprocess.CompletedProcess[str]:
    command = [str(Path(sys.executable).with_name("aliascope")), "error", *map(str, arguments)]
    result = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert result.returncode == code, result.stderr
    return result


def test_the_command(tmp_path: Path) -> None:
    write_exr(tmp_path / "r.exr", RAMP, {})
    coded = write(tmp_path / "a.png", encode(RAMP), "uint8")
    said = run(coded, tmp_path / "r.exr", code=2).stderr
    assert said.count("\n") == 1
    assert "--colour-space srgb" in said
    arguments = (coded, tmp_path / "r.exr", "--colour-space", "srgb", "--map", tmp_path / "map.png")
    document = json.loads(run(*arguments, "--map-scale", "0.01", "--json").stdout)
    assert set(document["metrics"]) == set(metrics.METRICS)
    assert 0 < document["metrics"]["rmse"] < 1 / 255
    assert document["metrics"]["ssim"] is None
    assert "smaller" in document["details"]["ssim-reason"]
    assert document["details"]["map-scale"] == 0.01
    assert document["image"] == {"format": "uint8", "colour_space": "srgb", "stated": True}
    assert (tmp_path / "map.png").is_file()
    text = run(*arguments, "--metric", "p99,flip").stdout.splitlines()
    assert text[0] == f"{coded}: uint8, decoded from sRGB"
    assert [line.split()[0] for line in text[1:3]] == ["p99", "flip"]
    assert "(blue) to" in text[3]
    assert "name one with --map" in run(coded, coded, "--map-scale", "1", code=2).stderr
