"""The files of a report: pictures to the bit, figures that parse, names that stay names."""

from __future__ import annotations

import csv
import html
import json
import math
import os
import re
import subprocess
import sys
import zlib
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure
from page_data import shown

from aliascope import metrics
from aliascope.errors import InvalidInput, NotAvailable, NotWritable
from aliascope.records import EmptyCell, Estimate, Failure, MetricInfo, ModeRow, Pixels, ReportData, SceneSection
from aliascope.report import _power_of_ten, _signed, page, write_report
from aliascope.report.document import document, script_json
from aliascope.report.encode import (
    PictureStore,
    decode_picture,
    encode_picture,
    error_map,
    error_scale,
    from_text,
    round_up,
)
from aliascope.report.filters import FREQUENCIES, filter_responses, filters_csv
from aliascope.report.plots import Plot, colours, limits, plot_svg, plots_of, svg_of
from aliascope.report.pool import curve_of, efficiency, in_common, pareto_front, pool
from aliascope.report.signal_plots import MOST_LINES, telling
from aliascope.report.spectra import (
    CONSTANT,
    EQUAL,
    MOST_RINGS,
    NOT_FINITE,
    SMALL,
    joined,
    scene_spectra,
    spectra_csv,
    spectra_of,
)
from aliascope.spectrum import radial_spectrum
from aliascope.trade import analyse

HOSTILE = "</script><!--<script>alert('$x^{$')\u2028&\"\n,=1"
METRICS = {name: MetricInfo(name, "less") for name in ("rmse", "psnr", "max", "bias", "structure")}
NAN, INF = math.nan, math.inf


def row_of(
    renderer: str, mode: str, rmse: float, seconds: float, pixels: Pixels, error: float | None = None
) -> ModeRow:
    metrics = {"rmse": Estimate(rmse, error), "psnr": Estimate(NAN), "max": Estimate(INF), "bias": Estimate(None)}
    return ModeRow(renderer, mode, mode, "family", 4.0, Estimate(seconds, error), metrics, 2, pixels, 1 / 255)


def data_of(*scenes: SceneSection) -> ReportData:
    failure = Failure("one", "povray", "am2", HOSTILE, f"aliascope {HOSTILE}")
    named = {HOSTILE: HOSTILE}
    return ReportData("t", "2026-12-01", 1.0, 2, 0, (HOSTILE,), scenes, (failure,), named, named, METRICS, named)


def scene_of(name: str, *rows: ModeRow) -> SceneSection:
    empty = (EmptyCell(name, "osmesa", HOSTILE, HOSTILE),)
    return SceneSection(name, name, name, np.zeros((3, 4, 3), np.float32), HOSTILE, rows, empty)


def usual() -> ReportData:
    black, grey = np.zeros((3, 4, 3), np.float32), np.full((3, 4, 3), 0.5, np.float32)
    grey[1, 2, 0] = NAN
    grey[2, 1, 1] = INF
    rows = row_of("embree", HOSTILE, 0.1, 0.5, grey, 0.01), row_of("povray", "b", 0.0, 0.25, black)
    return data_of(scene_of("one", *rows), scene_of(HOSTILE, *rows), scene_of("ONE", rows[0]))


# Pictures.


@pytest.mark.parametrize("kinds", ["few", "some", "all different", "any bits"])
def test_pictures_come_back_to_the_bit(kinds: str) -> None:
    rng = np.random.default_rng(11)
    shape = (90, 41, 3)
    words = {
        "few": rng.integers(0, 2, shape, np.uint32) * np.uint32(0x3F800001),
        "some": np.repeat(rng.integers(0, 1 << 30, (90, 41, 1), np.uint32) % 700, 3, axis=2),  # two bytes an index
        "all different": rng.random(shape, np.float32).view(np.uint32),
        "any bits": rng.integers(0, 1 << 32, shape, np.uint32),  # NaNs with payloads, subnormals, both zeros
    }[kinds]
    pixels = words.astype(np.uint32).view(np.float32)
    back = decode_picture(encode_picture(pixels), 41, 90)
    assert np.array_equal(back.view(np.uint32), pixels.view(np.uint32))


def test_more_colours_than_a_palette_holds() -> None:
    pixels = np.random.default_rng(12).random((300, 300, 3), np.float32)
    text = encode_picture(pixels)
    assert zlib.decompress(from_text(text))[0] == 0
    assert np.array_equal(decode_picture(text, 300, 300), pixels)


def test_views_and_single_pixels_are_encoded_too() -> None:
    pixels = np.arange(60, dtype=np.float32).reshape(4, 5, 3)[::-1, ::2]
    assert np.array_equal(decode_picture(encode_picture(pixels), 3, 4), pixels)
    one = np.full((1, 1, 3), 0.1, np.float32)
    assert np.array_equal(decode_picture(encode_picture(one), 1, 1), one)


def test_a_picture_of_another_size_is_refused() -> None:
    with pytest.raises(ValueError, match="5 x 4 pixels"):
        decode_picture(encode_picture(np.zeros((4, 4, 3), np.float32)), 5, 4)


def test_flat_pictures_are_small() -> None:
    """17 grey levels, as 16 samples a pixel leave them along edges: what most scenes are made of."""
    y, x = np.mgrid[0:96, 0:128]
    levels = np.clip((x - 0.6 * y) % 40 - 12, 0, 16) // 1 / 16
    pixels = np.repeat(levels[..., np.newaxis], 3, axis=2).astype(np.float32)
    assert len(encode_picture(pixels)) < pixels.nbytes / 30


def test_equal_pictures_are_stored_once() -> None:
    store = PictureStore()
    zero, one = np.zeros((2, 6, 3), np.float32), np.ones((2, 6, 3), np.float32)
    assert [store.add(zero), store.add(one), store.add(zero.copy())] == [0, 1, 0]
    assert store.add(zero.reshape(6, 2, 3)) == 2
    assert store.add(-zero) == 3  # -0.0 has other bits
    assert len(store.texts) == 4


@given(st.floats(1e-300, 1e300))
@settings(max_examples=300)
def test_round_up_is_the_next_of_1_2_5(value: float) -> None:
    rounded = round_up(value)
    mantissa = f"{rounded:e}".split("e")[0].rstrip("0").rstrip(".")
    assert mantissa in {"1", "2", "5"}
    assert value * (1 - 1e-11) <= rounded <= value * 2.5 * (1 + 1e-11)


def test_the_error_scale_is_one_number_for_a_scene() -> None:
    reference = np.zeros((10, 10, 3), np.float32)
    errors = [error_map(np.full_like(reference, value), reference) for value in (0.5, 0.03, -0.04, 0.0)]
    assert error_scale(errors) == 0.05  # the median of the three that have an error is 0.04
    assert error_scale([]) == error_scale([np.full((2, 2), NAN)]) == 0.01
    assert round_up(0.1) == 0.1


# Figures over scenes.


def test_pooled_figures() -> None:
    pixels = np.zeros((3, 4, 3), np.float32)
    scenes = [
        scene_of("one", row_of("embree", "a", 0.3, 1.0, pixels, 0.01), row_of("embree", "b", 0.1, 1.0, pixels)),
        scene_of("two", row_of("embree", "a", 0.4, 3.0, pixels, 0.02)),
    ]
    first, second = pool(scenes)
    assert first.metrics["rmse"].value == pytest.approx(math.sqrt((0.09 + 0.16) / 2))
    # d sqrt((a^2 + b^2) / 2) = (a da + b db) / (2 sqrt((a^2 + b^2) / 2)), da and db independent
    expected = math.hypot(0.3 * 0.01, 0.4 * 0.02) / (2 * math.sqrt(0.125))
    assert first.metrics["rmse"].standard_error == pytest.approx(expected)
    assert first.metrics["psnr"].value == pytest.approx(-10 * math.log10(0.125))
    assert first.metrics["max"].value is None  # infinite is no figure
    assert first.cpu_seconds.value == 2.0
    assert (first.missing, second.missing) == ((), ("two",))
    assert second.metrics["rmse"].standard_error is None
    assert efficiency(first) == pytest.approx(1 / (0.125 * 2.0))
    assert efficiency(curve_of(row_of("a", "b", 0.0, 1.0, pixels))) is None


def test_scenes_in_common() -> None:
    pixels = np.zeros((3, 4, 3), np.float32)
    a, b = row_of("embree", "a", 0.3, 1.0, pixels), row_of("povray", "b", 0.1, 1.0, pixels)
    scenes = scene_of("one", a, b), scene_of("two", a), scene_of("three")
    assert [scene.name for scene in in_common(scenes)] == ["one"]
    # none in common: all that have a row
    assert [scene.name for scene in in_common((scene_of("x", b), *scenes[1:]))] == ["x", "two"]


def test_scenes_that_a_renderer_drew_in_other_modes_are_not_pooled() -> None:
    """Over them, none of its modes would have every scene, and it would have no answer."""
    pixels = np.zeros((3, 4, 3), np.float32)
    one = [row_of("embree", mode, 0.3, 1.0, pixels) for mode in "abc"]
    others = {mode: row_of("povray", mode, 0.1, 1.0, pixels) for mode in "xyz"}
    lens = scene_of("lens", *one, others["z"])
    flat, failed = scene_of("flat", *one, others["x"], others["y"]), scene_of("one failed", *one[:2], others["x"])
    assert [scene.name for scene in in_common((lens, flat, failed))] == ["flat", "one failed"]
    assert [scene.name for scene in in_common((flat, lens))] == ["flat"]
    little = scene_of("little", *one, others["x"], others["z"], row_of("povray", "w", 0.1, 1.0, pixels))
    assert [scene.name for scene in in_common((flat, little))] == ["flat"]  # one of povray's four modes in both
    assert [scene.name for scene in in_common((lens,))] == ["lens"]


def test_a_scene_under_another_filter_is_not_pooled() -> None:
    """Its modes are of no other scene: over both, every mode would lack one, and none be on the front."""
    pixels = np.zeros((3, 4, 3), np.float32)
    box, filtered = row_of("embree", "a", 0.3, 1.0, pixels), row_of("embree", "a:filter=mitchell", 0.1, 1.0, pixels)
    scenes = scene_of("one", box), scene_of("two", box), replace(scene_of("one, mitchell", filtered), filter="mitchell")
    assert next(plot.title for plot in plots_of(data_of(*scenes))) == "All 2 scenes"
    assert next(plot.title for plot in plots_of(data_of(scenes[0], scenes[2]))) == "The scene one"
    assert [scene.name for scene in in_common(scenes)] == ["one", "two"]
    assert all(curve.missing == () for curve in pool(in_common(scenes)))


@given(st.lists(st.tuples(st.integers(1, 9), st.integers(1, 9)), max_size=12))
def test_the_front_is_what_nothing_beats(points: list[tuple[int, int]]) -> None:
    found = {points[i] for i in pareto_front(points)}
    expected = {p for p in points if not any(q != p and q[0] <= p[0] and q[1] <= p[1] for q in points)}
    assert found == expected


def test_metrics_say_which_values_are_better() -> None:
    """Of two pictures with the same error, one of them 10 times as large, and structured."""
    rng = np.random.default_rng(4)
    reference = np.full((48, 64, 3), 0.5, np.float32)
    noise = rng.normal(0.0, 0.01, reference.shape).astype(np.float32)
    wave = np.cos(2.0 * np.pi * 0.25 * np.arange(64))[np.newaxis, :, np.newaxis].astype(np.float32)
    good, bad = metrics.measure(reference + noise, reference), metrics.measure(reference + 0.1 * wave - 0.05, reference)
    for name, about in metrics.ABOUT.items():
        better, worse = good[name].value, bad[name].value
        assert better is not None
        assert worse is not None
        if about.better == "zero":
            assert abs(better) < abs(worse), name
        else:
            assert (better < worse) == (about.better == "less"), name
        assert about.best in (None, metrics.measure(reference, reference, [name])[name].value), name


# Signals.


def noisy_scene(height: int = 96, width: int = 128) -> SceneSection:
    rng = np.random.default_rng(5)
    reference = np.full((height, width, 3), 0.5, np.float32)
    noise = rng.normal(0.0, 0.1, reference.shape).astype(np.float32)
    wave = np.cos(2.0 * np.pi * 0.25 * np.arange(width))[np.newaxis, :, np.newaxis] * np.float32(0.1)
    pictures = {"noise": reference + noise, "wave": reference + wave, "same": reference, "off": reference + 0.25}
    rows = [row_of("embree", mode, 0.1, 1.0, pixels.astype(np.float32)) for mode, pixels in pictures.items()]
    return replace(scene_of("noisy", *rows), reference=reference)


def test_spectra_tell_noise_from_a_wave() -> None:
    spectra = scene_spectra(noisy_scene())
    noise, wave, same, off = spectra.rows
    assert (same, off) == (EQUAL, CONSTANT)
    assert not isinstance(noise, str)
    assert not isinstance(wave, str)
    # The mean of 3 channels' powers, of variance 0.01: a relative standard error of 2 / sqrt(3 bins), four of them.
    # The first ring lacks what the mean takes.
    for power, bins in list(zip(noise, spectra.bins, strict=True))[2:]:
        assert power == pytest.approx(0.01, rel=8.0 / math.sqrt(3 * bins))
    assert spectra.frequencies[int(np.argmax(wave))] == pytest.approx(0.25, abs=0.01)  # rings are 1/96 wide
    # cos of amplitude 0.1 has a mean power of 0.1^2 / 2, but for the 4 digits that are kept
    assert np.average(wave, weights=spectra.bins) == pytest.approx(0.005, rel=1e-3)
    assert all(float(f"{power:.4g}") == power for power in (*noise, *wave))


@pytest.mark.parametrize("size", [(96, 128), (128, 128), (601, 400), (40, 300), (2, 9), (1, 1)])
def test_joined_rings_keep_the_power(size: tuple[int, int]) -> None:
    spectrum = radial_spectrum(np.random.default_rng(6).normal(size=size))
    rings = joined(spectrum)
    assert len(rings.bins) <= MOST_RINGS
    alone = max(size) <= 2 * min(size)  # frequency 0 has a ring of its own, which is left out
    assert rings.bins.sum() == size[0] * size[1] - (1 if alone else 0)
    total = (spectrum.bins * spectrum.power).sum()
    assert (rings.bins * rings.power).sum() == pytest.approx(total, rel=1e-12, abs=1e-12)
    assert (np.diff(rings.frequencies) > 0).all()
    if size == (96, 128):
        assert np.array_equal(rings.power, spectrum.power[1:])  # few enough: as they are


def test_a_pixel_has_no_spectrum() -> None:
    reference = np.zeros((1, 1, 3), np.float32)
    scene = replace(scene_of("dot", row_of("embree", "a", 1.0, 1.0, reference + np.float32(1))), reference=reference)
    assert scene_spectra(scene).rows == (SMALL,)
    assert shown(page(data_of(scene)))["scenes"][0]["spectra"]["rows"] == [SMALL]


def test_the_csv_of_spectra_has_a_column_a_mode() -> None:
    scene = noisy_scene()
    spectra = scene_spectra(scene)
    rows = list(csv.DictReader(spectra_csv(spectra, scene.rows).splitlines()))
    assert [float(row["cycles_per_pixel"]) for row in rows] == list(spectra.frequencies)
    assert [float(row["embree noise"]) for row in rows] == list(spectra.rows[0])
    assert {row["embree same"] for row in rows} == {""}


def test_the_figure_has_the_least_and_the_most_structured() -> None:
    scene = noisy_scene()
    rows = []
    for renderer in ("embree", "povray"):
        for i in range(MOST_LINES):
            for spp in (1.0, 16.0, 256.0):
                metrics = {"structure": Estimate((i * 5 % MOST_LINES) / 10)}
                found = replace(scene.rows[0], renderer=renderer, mode=f"{i} {spp}", family=f"{i}", metrics=metrics)
                rows.append(replace(found, samples_per_pixel=spp))
    lines = telling(scene_spectra(replace(scene, rows=tuple(rows))), rows)
    assert [(line.row.renderer, line.structure) for line in lines] == [
        (renderer, structure) for renderer in ("embree", "povray") for structure in (0.0, 0.5)
    ]
    assert {line.row.samples_per_pixel for line in lines} == {16.0}


def test_the_csv_of_filters() -> None:
    rows = list(csv.DictReader(filters_csv(filter_responses()).splitlines()))
    assert [float(row["cycles_per_pixel"]) for row in rows] == list(FREQUENCIES)
    for row in rows:
        f = float(row["cycles_per_pixel"])
        # box and tent: sinc and its square; 6 decimals are kept
        assert float(row["box"]) == pytest.approx(np.sinc(f), abs=6e-7)
        assert float(row["tent"]) == pytest.approx(np.sinc(f) ** 2, abs=6e-7)


def test_without_the_library_a_report_has_no_filters(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("aliascope.native.filters.registered", missing)
    data = usual()
    text = write_report(tmp_path, replace(data, scenes=data.scenes[2:])).read_text(encoding="utf-8")
    assert 'id="filter-panels"' not in text
    assert not (tmp_path / "plots" / "filters.svg").exists()


def missing() -> None:
    raise NotAvailable("the library is not there")


@pytest.mark.parametrize("names", [("edge", "edge-spectrum"), ("edge-spectrum", "edge"), ("a, b", "a-b", "filters")])
def test_figures_of_like_names_do_not_share_a_file(
    names: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("plot_svg", "spectrum_svg", "filters_svg"):
        monkeypatch.setattr(f"aliascope.report.{name}", lambda *_: "")  # the names count, not what is drawn
    data = data_of(*(scene_of(name) for name in names))
    write_report(tmp_path, data)
    # all scenes, filters, and two a scene
    assert len(list((tmp_path / "plots").glob("*.svg"))) == 2 + 2 * len(names)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the usual report."""
    path = write_report(tmp_path_factory.mktemp("written") / "new", usual())
    assert path.name == "report.html"
    return path.parent


# Files.


def test_all_files_are_written_and_parse(written: Path) -> None:
    names = ["all-scenes", "one", "one-2", "script-script-alert-x-1"]
    found = sorted(p.name for p in (written / "plots").iterdir())
    signals = ["filters", *(f"{name}-spectrum" for name in names[1:])]
    figures = {f"{name}.{kind}" for name in names + signals for kind in ("svg", "csv")}
    assert set(found) - figures == {f"trade-{name}.csv" for name in ("equal-error", "front", "ratios")}
    assert figures <= set(found)
    for name in signals:
        ElementTree.parse(written / "plots" / f"{name}.svg")
    for name in names:
        ElementTree.parse(written / "plots" / f"{name}.svg")
        with (written / "plots" / f"{name}.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        assert {row["renderer"] for row in rows} >= {"embree"}
        assert all(math.isfinite(float(row["rmse"])) for row in rows)
    assert not list(written.glob(".*"))


def test_the_csv_has_every_figure_and_reason(written: Path) -> None:
    with (written / "results.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["status"] for row in rows] == ["measured"] * 2 + ["empty"] + ["measured"] * 2 + ["empty"] + [
        "measured",
        "empty",
        "failed",
    ]
    first, second = rows[:2]
    assert first["mode"] == HOSTILE
    assert float(first["rmse"]) == 0.1
    assert float(first["rmse_standard_error"]) == 0.01
    assert float(first["cpu_seconds"]) == 0.5
    assert float(first["efficiency"]) == pytest.approx(200.0)
    assert first["psnr"] == first["max"] == first["bias"] == ""  # NaN, infinite, none
    assert second["rmse"] == "0.0"
    assert second["efficiency"] == second["rmse_standard_error"] == ""
    assert all(row["reason"] for row in rows if row["status"] != "measured")


def test_there_is_no_nan_in_the_json() -> None:
    values = document(usual(), PictureStore(), spectra_of(usual()), analyse(usual().scenes))

    def refuse(name: str) -> None:
        raise AssertionError(name)

    assert json.loads(script_json(values), parse_constant=refuse) == values
    assert values["scenes"][0]["rows"][0]["metrics"]["max"] == [None, None]
    assert values["scenes"][0]["rows"][0]["notFinite"] == 2
    assert values["scenes"][0]["rows"][0]["worst"] == [2, 1]  # the first that is not finite
    assert values["scenes"][0]["spectra"]["rows"] == [NOT_FINITE, EQUAL]
    with pytest.raises(ValueError, match="Out of range float"):
        script_json(NAN)


def test_nothing_in_the_json_ends_its_script() -> None:
    text = script_json({"name": HOSTILE})
    assert not re.search(r"[<>&\u2028\u2029]", text)
    assert json.loads(text) == {"name": HOSTILE}


def tags_of(markup: str) -> str:
    """The tags of a page without what stands between them."""
    return "".join(re.findall(r"<[^>]*>", markup))


def test_the_page_asks_for_nothing() -> None:
    text = page(usual())
    found = set(re.findall(r"https?://[^\s\"'<>)]+", text))
    assert found <= {"http://www.w3.org/2000/svg"}  # a namespace is a name
    assert not re.search(r"<(link|img|iframe|object|embed|base)\b|@import|url\(", text)
    markup = re.sub(r"(?s)<(script|style)\b.*?</\1>", "", text).replace("http-equiv=", "")
    assert not re.search(r"\b(src|srcset|action|style|on[a-z]+)=", tags_of(markup))
    assert "default-src 'none'" in html.unescape(text)


def test_the_page_escapes_what_it_is_given() -> None:
    text = page(usual())
    assert "<script>alert" not in text
    assert text.count("<!--") == 0
    scripts = re.findall(r"<script\b([^>]*)>", text)
    assert [attributes for attributes in scripts if "type=" not in attributes] == [""]  # one that runs: ours


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (1e-4, "10⁻⁴"), (1.8e-8, "1.8\u202f×\u202f10⁻⁸"), (9.96e-5, "10⁻⁴"), (0.5, "5\u202f×\u202f10⁻¹")],
)
def test_small_figures_of_probes(value: float, text: str) -> None:
    assert _power_of_ten(value) == text


@pytest.mark.parametrize(
    ("value", "text"), [(0.00123, "+0.0012"), (-0.00126, "\u22120.0013"), (-0.00004, "0.0000"), (0.0, "0.0000")]
)
def test_places_of_probes_have_their_sign(value: float, text: str) -> None:
    assert _signed(value) == text


def test_the_same_data_gives_the_same_files(tmp_path: Path, written: Path) -> None:
    write_report(tmp_path, usual())
    files = sorted(path.relative_to(written) for path in written.rglob("*.*"))
    assert len(files) == 21
    for file in files:
        assert (written / file).read_bytes() == (tmp_path / file).read_bytes(), file


FIGURES = """
import sys
from dataclasses import replace
from pathlib import Path
from aliascope.report import write_report
from browser.report_data import report_data
data = report_data()
write_report(Path(sys.argv[1]), replace(data, scenes=data.scenes[:1]))
"""


def test_two_processes_draw_the_same_figures(tmp_path: Path) -> None:
    """Addresses and hashes differ between them, and with these the last digits of matplotlib's layout."""
    paths = os.pathsep.join([str(Path(__file__).parents[1]), *sys.path])
    for name in ("one", "two"):
        environment = {**os.environ, "PYTHONPATH": paths, "PYTHONHASHSEED": str(len(name))}
        subprocess.run([sys.executable, "-c", FIGURES, str(tmp_path / name)], check=True, env=environment)
    figures = sorted(path.name for path in (tmp_path / "one" / "plots").glob("*.svg"))
    assert len(figures) == 3  # a scene's plot and spectrum, the filters
    for figure in figures:
        texts = {(tmp_path / name / "plots" / figure).read_bytes() for name in ("one", "two")}
        assert len(texts) == 1, figure


def test_the_last_digits_of_a_layout_are_not_drawn() -> None:
    """Two processes seldom differ in them; that they are rounded off is seen in one."""
    figures = []

    def draw(figure: Figure) -> None:
        figures.append(figure)
        figure.add_subplot().set_ylabel("y")

    svg_of(draw, (3.0, 2.0))
    bounds = figures[0].axes[0].get_position().bounds
    assert bounds == pytest.approx([round(value, 6) for value in bounds], rel=1e-14)


@pytest.mark.parametrize("seconds", [(0.001,), (0.0,), (0.001, 0.001), (0.001, 0.0)])
def test_few_times_are_plotted_without_a_warning(seconds: tuple[float, ...], recwarn: pytest.WarningsRecorder) -> None:
    pixels = np.zeros((3, 4, 3), np.float32)
    curves = tuple(curve_of(row_of("povray", "none", 0.1, t, pixels, 0.0)) for t in seconds)
    svg = plot_svg(Plot("one", "One", curves), colours(["povray"]))
    assert ElementTree.fromstring(svg).tag.endswith("svg")
    assert [str(warning.message) for warning in recwarn] == []


def test_limits_have_room_for_points_and_bars() -> None:
    low, high = limits([0.01, 0.1], [None, 0.05])
    assert low < 0.01 < 0.15 < high < 0.2
    low, high = limits([0.01], [0.02])  # a bar that would reach 0 has its end out of sight
    assert 0.0 < low < 0.01 < 0.03 < high


def test_colours_are_those_of_the_renderers() -> None:
    found = colours(["mine", "osmesa", "yours"])
    assert found["osmesa"] == "#009E73"
    assert (found["mine"], found["yours"]) == ("#CC79A7", "#E69F00")


def test_one_scene_has_one_plot() -> None:
    data = usual()
    assert [plot.name for plot in plots_of(replace(data, scenes=data.scenes[:1]))] == ["one"]
    assert plots_of(replace(data, scenes=())) == []


def test_an_empty_report_is_written(tmp_path: Path) -> None:
    text = write_report(tmp_path, replace(usual(), scenes=(), failures=(), headlines=())).read_text()
    assert "No picture was measured" in text


def test_pictures_of_other_sizes_are_refused() -> None:
    odd = scene_of("one", row_of("embree", "a", 0.1, 1.0, np.zeros((4, 3, 3), np.float32)))
    with pytest.raises(InvalidInput, match="one: embree a: the picture is 3 x 4 x 3, its reference 4 x 3 x 3"):
        page(data_of(odd))


def test_a_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(NotWritable, match="cannot be written"):
        write_report(tmp_path / "file", usual())
