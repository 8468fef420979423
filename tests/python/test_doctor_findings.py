"""What doctor finds where a convention is broken on purpose: by a povray that is a script about the real one, by a
rasteriser that lies, or in a picture that was made here."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import fake_povray
import numpy as np
import pytest
from commands import run

from aliascope import renderers
from aliascope.errors import JobFailed
from aliascope.geometry import Array
from aliascope.native import filters, raster, tracer
from aliascope.records import Rendering
from aliascope.renderers import povray_frames
from aliascope.renderers.base import Request
from aliascope.renderers.embree import Embree
from aliascope.renderers.osmesa import OSMesa
from aliascope.studies import doctor, doctor_embree, doctor_findings, doctor_osmesa, doctor_povray
from aliascope.studies.doctor_charts import PHASES, Edges, Levels, Star
from aliascope.studies.doctor_findings import Figure, Finding, Inquiry, Shot, Shown
from aliascope.studies.doctor_general import centres, float32_step, levels, placed, repeats
from aliascope.studies.doctor_patterns import Pattern, columns_of, grid_pattern, trapezoid_pattern, weighted

FIXED = doctor_povray.FIXED


class Threads:
    """Does tasks in threads of this process: POV-Ray sleeps for most of its run, and patches count here."""

    def __init__(self, count: int) -> None:
        self.pool = ThreadPoolExecutor(count)

    def begin(self, task: Callable[..., Any], arguments: Sequence[Any], time_limit: float) -> Future[Any]:
        return self.pool.submit(task, *arguments)


@pytest.fixture(scope="module")
def side_by_side() -> Iterator[Threads]:
    threads = Threads(6)
    yield threads
    threads.pool.shutdown()


@pytest.fixture(scope="module")
def one_by_one() -> Iterator[Threads]:
    """OSMesa's context and what patches stay in one thread."""
    threads = Threads(1)
    yield threads
    threads.pool.shutdown()


def ask(pool: Threads, *inquiries: Inquiry) -> list[Finding]:
    return doctor_findings.answers(inquiries, pool, lambda what, done, total: None)  # type: ignore[arg-type]


def by_name(inquiries: list[Inquiry], name: str) -> Inquiry:
    return next(inquiry for inquiry in inquiries if inquiry.name == name)


def labels(finding: Finding) -> dict[str, Figure]:
    return {figure.label: figure for figure in finding.figures}


# --- POV-Ray ----------------------------------------------------------------------------------------------------------


def asked_of_povray() -> list[Inquiry]:
    """A part of what doctor asks: each kind once."""
    modes = ("none", f"am1:depth=3,{FIXED}", f"am2:depth=3,{FIXED}")
    every = doctor_povray.inquiries()
    return [
        centres("povray", dict.fromkeys(modes, Edges())),
        *levels("povray", "none", doctor_povray.FORMATS),
        weighted("weights of am1", "povray", {modes[1]: grid_pattern(3, centre=True)}, "", ("good", "bad")),
        weighted("weights of am2", "povray", {modes[2]: trapezoid_pattern(4)}, "", ("good", "bad")),
        by_name(every, "tile size, where it must not count"),
        by_name(every, "tile size in am1"),
        repeats("povray", {"none": Star()}),
        by_name(every, "lens of focal-blur"),
    ]


def where(option: str, commands: str) -> str:
    """Shell commands for the runs that have such an option."""
    return f'case "$*" in *{option}*) {commands};; esac'


def moved_by(pixels: float) -> str:
    return f"sed -i '/^camera/ s/}}$/translate {pixels}*x }}/' scene.pov"


SPOILED = {
    # What a script does before it starts povray, with $@ for its arguments, and what is found.
    "nothing": (":", []),
    "the weights of AM1": (where("+AM1", 'set -- "$@" +R2'), ["weights of am1"]),
    "the place of AM2": (where("+AM2", moved_by(0.01)), ["pixel centre", "weights of am2"]),
    "the gamma of PNG": (where("+FN16", 'set -- "$@" File_Gamma=1.02'), ["pixel centre", "response"]),
    "tiles": (where("+BS4", moved_by(0.1)), ["tile size, where it must not count"]),
    "threads": (where("+WT4", moved_by(0.1)), ["repeatability"]),
    "8 bits": (where("+FN16", 'set -- "$@" +FN8'), ["response", "quantum of the output"]),
}


@pytest.mark.parametrize("what", SPOILED)
def test_what_is_spoiled_in_povray_is_found(
    what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, side_by_side: Threads
) -> None:
    before, expected = SPOILED[what]
    real = shutil.which("povray")
    folder = fake_povray.install(tmp_path / "bin", f'[ -f scene.pov ] && {{ {before}; }}\nexec {real} "$@"')
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")
    inquiries = asked_of_povray()
    if expected:  # what is not touched is asked of the real one alone
        inquiries = [each for each in inquiries if each.name in expected or each.name == "pixel centre"]
    found = {finding.name: finding for finding in ask(side_by_side, *inquiries)}
    assert [name for name, finding in found.items() if finding.failed] == expected
    if what == "nothing":
        return
    figures = {name: labels(found[name]) for name in expected}
    if what == "the weights of AM1":
        (figure,) = figures["weights of am1"].values()
        # Those of depth 2, though others are expected.
        assert figure.values["columns"] == pytest.approx([0.4, 0.2, 0.4], abs=1e-2)
        assert figure.values["column_places"] == pytest.approx([0.25, 0.5, 0.75], abs=2e-3)
    if what == "the place of AM2":
        assert figures["pixel centre"][f"am2:depth=3,{FIXED}"].values["right"] == pytest.approx(-0.01, abs=2e-3)
        assert figures["pixel centre"]["none"].values["right"] == pytest.approx(0.0, abs=2e-3)
        assert f"am2:depth=3,{FIXED} draw" in found["pixel centre"].means
    if what == "the gamma of PNG":
        assert figures["response"]["16-bit PNG"].values["gamma"] == pytest.approx(1 / 1.02, abs=1e-3)
        assert figures["response"]["half-float EXR"].values["gamma"] == pytest.approx(1.0, abs=1e-3)


def test_a_lens_that_the_compensation_does_not_fit_is_found(
    monkeypatch: pytest.MonkeyPatch, side_by_side: Threads
) -> None:
    monkeypatch.setattr(povray_frames, "APERTURE", 3.6)
    (finding,) = ask(side_by_side, by_name(doctor_povray.inquiries(), "lens of focal-blur"))
    assert finding.failed
    assert labels(finding)[doctor_povray.BLUR].values["lens"] == pytest.approx(0.9, abs=0.02)


# --- patterns ---------------------------------------------------------------------------------------------------------


def test_the_patterns_are_those_that_were_measured() -> None:
    """The columns of POV-Ray's AM1 as fractions of its d d + 1 rays, and the trapezoid rule's."""
    for depth, expected in {2: ("2/5", "1/5", "2/5"), 3: ("3/10", "4/10", "3/10")}.items():
        places, weights = grid_pattern(depth, centre=True).columns(0)
        assert weights.tolist() == pytest.approx([float(Fraction(each)) for each in expected])
        assert places[1] == 0.5
    for intervals in (1, 2, 4):
        pattern = trapezoid_pattern(intervals)
        assert len(pattern.samples) == (intervals + 1) ** 2
        x, y = pattern.samples[:, 0], pattern.samples[:, 1]
        # The rule's own: x y is integrated exactly, and x^2 too large by h^2 / 6.
        assert pattern.samples[:, 2] @ (x * y) == pytest.approx(1 / 4)
        assert pattern.samples[:, 2] @ x**2 == pytest.approx(1 / 3 + 1 / (6 * intervals**2))


def spread_of(places: Sequence[float], weights: Sequence[float]) -> tuple[Array, Array]:
    at = Edges().places()
    return at, sum((w * (at > x) for x, w in zip(places, weights, strict=True)), np.zeros(len(at)))


def test_columns_are_read_off_the_steps_of_an_edge() -> None:
    at, spread = spread_of([0.1253, 0.5011, 0.9], [0.2, 0.5, 0.3])
    found = columns_of(spread, at, np.array([0.125, 0.5, 0.9]))
    assert found.weights.tolist() == pytest.approx([0.2, 0.5, 0.3])
    assert found.places.tolist() == pytest.approx([0.1253, 0.5011, 0.9], abs=0.5 / PHASES)
    assert found.rest < 1e-12


def test_a_column_that_is_not_expected_shows_between_the_others() -> None:
    at, spread = spread_of([0.125, 0.3, 0.5], [0.2, 0.1, 0.7])
    assert columns_of(spread, at, np.array([0.125, 0.5])).rest > 0.04


# --- OSMesa -----------------------------------------------------------------------------------------------------------


def test_samples_that_lie_elsewhere_than_opengl_says_are_found(
    monkeypatch: pytest.MonkeyPatch, one_by_one: Threads
) -> None:
    at = raster.sample_positions()
    name = "samples of msaa"
    (good,) = ask(one_by_one, by_name(doctor_osmesa.inquiries(), name))
    assert not good.failed
    four = labels(good)["msaa:n=4"].values
    found = np.column_stack([four["x"], four["y"]])
    assert found[np.argsort(found[:, 0])] == pytest.approx(at[np.argsort(at[:, 0])], abs=1.0 / PHASES)
    # Rows and columns stay as they are when two samples change their rows: corners alone tell that.
    monkeypatch.setattr(raster, "sample_positions", lambda: np.column_stack([at[:, 0], at[[1, 0, 2, 3], 1]]))
    (bad,) = ask(one_by_one, by_name(doctor_osmesa.inquiries(), name))
    assert bad.failed
    assert labels(bad)["msaa:n=4"].values["weights_off"] == pytest.approx(0.25)


def test_other_limits_of_opengl_are_found(monkeypatch: pytest.MonkeyPatch, one_by_one: Threads) -> None:
    inquiry = by_name(doctor_osmesa.inquiries(), "what OpenGL says")
    assert not ask(one_by_one, inquiry)[0].failed
    monkeypatch.setattr(raster, "limits", lambda: raster.Limits(8, 8, 8))
    assert ask(one_by_one, inquiry)[0].failed
    monkeypatch.setattr(raster, "limits", lambda: raster.Limits(4, 4, 4))
    assert ask(one_by_one, inquiry)[0].failed


@pytest.mark.parametrize("bits", [5, 6, 8])
def test_the_grid_of_corners_is_measured(bits: int) -> None:
    """A staircase drawn here, its corners put on the grid: its lean, 1/16 pixel, is on any of at least 4 bits."""
    inquiry = by_name(doctor_osmesa.inquiries(), "grid of corners")
    ((mode, shot),) = inquiry.shots.items()
    width, height = shot.chart.size
    pixels = np.zeros((height, width, 3), np.float32)
    for i in range(width // 4):
        top = np.floor((0.5 - 64 / 1024 + i / 1024) * 2**bits) / 2**bits
        pixels[:, 4 * i + 2] = (top + (np.arange(height)[:, np.newaxis] + 0.5) / 1024 > 0.5).astype(np.float32)
    finding = inquiry.judge({mode: Shown(pixels, 0.0, 1.0)})
    assert finding.figures[0].values["bits"] == bits
    assert finding.holds is (bits == 8)


# --- Embree -----------------------------------------------------------------------------------------------------------


def test_a_filter_of_another_width_is_found() -> None:
    """Pictures made here: the integral of a box 1.1 pixel wide in place of a box."""
    inquiry = by_name(doctor_embree.inquiries(), "width of filters")
    chart = Edges(cell=12)

    def picture(name: str, width: float) -> Shown:
        at = chart.places()
        spread = np.array([filters.integral(name, -np.inf, (x - 0.5) / width) for x in at])
        by_pixel = spread.reshape(-1, chart_cells(), 64)[::-1]
        pixels = np.zeros((chart.size[1], chart.size[0], 3), np.float32)
        for top, turned in ((0, False), (chart.size[0], True)):
            panel = np.zeros((chart.size[0], chart.size[0]))
            for cell in range(chart_cells()):
                left = 5 + 12 * cell + 3
                panel[5:69, left : left + len(by_pixel)] = by_pixel[:, cell].T
            pixels[top : top + chart.size[0]] = (panel.T if turned else panel)[..., np.newaxis]
        return Shown(pixels, 0.0, 1.0)

    good = {name: picture(name, 1.0) for name in doctor_embree.FILTERS}
    assert not inquiry.judge(good).failed
    finding = inquiry.judge({**good, "box": picture("box", 1.1)})
    assert finding.failed
    assert labels(finding)["box"].values["x"] == pytest.approx(1.1**2 / 12, abs=1e-3)


def chart_cells() -> int:
    return PHASES // 64


def test_another_kernel_is_found(monkeypatch: pytest.MonkeyPatch, one_by_one: Threads) -> None:
    inquiry = by_name(doctor_embree.inquiries(), "kernel")
    chart = Levels((1.0,))
    kernel = tracer.Tracer(chart.scene(), chart.size).kernel
    (good,) = ask(one_by_one, inquiry)
    assert not good.failed
    assert kernel.version == tracer.embree_version()
    assert (kernel.packet, kernel.native in (4, 8, 16)) == (16, True)
    for wrong in ({"robust": False}, {"version": "3.0.0"}):
        monkeypatch.setattr(tracer.Tracer, "kernel", replace(kernel, **wrong))
        assert ask(one_by_one, inquiry)[0].failed


# --- any renderer -----------------------------------------------------------------------------------------------------


class Fourth(Embree):
    name = "fourth"
    probe_mode = "uniform:n=100,sampler=regular"


class Uneven(Fourth):
    """Its second picture is not its first."""

    made = 0

    def render(self, request: Request) -> Rendering:
        self.made += 1
        found = super().render(request)
        return replace(found, pixels=found.pixels + np.float32(1e-6 * self.made))


@pytest.mark.parametrize(("renderer", "failed"), [(Fourth(), False), (Uneven(), True)])
def test_a_new_renderer_is_asked_what_every_one_is(
    monkeypatch: pytest.MonkeyPatch, one_by_one: Threads, renderer: Fourth, failed: bool
) -> None:
    monkeypatch.setattr(renderers, "RENDERERS", {"fourth": renderer})
    found = ask(one_by_one, *doctor.inquiries_of(renderer))
    assert [each.name for each in found] == ["pixel centre", "response", "quantum of the output", "repeatability"]
    if not failed:
        assert not [each for each in found if each.failed]
        return
    assert found[-1].failed
    assert "a second run: rms" in found[-1].figures[0].text
    assert 0.0 < found[-1].figures[0].values["a second run, largest"] < 1e-5


def test_where_an_edge_is_found_has_its_sign(one_by_one: Threads) -> None:
    """By the picture, a pixel further right and one further up: along edges that lean by 1/PHASES."""
    chart = Edges()
    shown = doctor_findings.render(Shot("embree", "uniform:n=1,sampler=regular", chart))
    moved = placed(chart, replace(shown, pixels=np.roll(shown.pixels, (-1, 1), (0, 1))))
    assert (moved.right, moved.down) == (pytest.approx(1.0 + 1.0 / PHASES), pytest.approx(-1.0 - 1.0 / PHASES))


def test_a_step_of_float32_is_seen_and_a_coarser_one_too(one_by_one: Threads) -> None:
    formats = {"float32": (1.0, float32_step(0.7))}
    inquiries = levels("embree", "uniform:n=1,sampler=regular", formats)
    assert [finding.failed for finding in ask(one_by_one, *inquiries)] == [False, False]
    ((label, shot),) = inquiries[1].shots.items()
    shown = doctor_findings.render(shot)
    coarse = replace(shown, pixels=np.round(shown.pixels * 2**23) / np.float32(2**23))
    assert inquiries[1].judge({label: coarse}).failed
    clipped = replace(shown, pixels=np.minimum(shown.pixels, np.float32(0.99)))
    assert inquiries[0].judge({label: clipped}).failed


def test_a_picture_that_fails_fails_its_finding_alone(monkeypatch: pytest.MonkeyPatch, one_by_one: Threads) -> None:
    drawn = OSMesa.render

    def failing(self: OSMesa, request: Any) -> Any:
        if request.mode.name == "msaa":
            raise JobFailed("it hung")
        return drawn(self, request)

    monkeypatch.setattr(OSMesa, "render", failing)
    asked = [centres("osmesa", {mode: Edges()}) for mode in ("none", "msaa:n=4")]
    good, bad = ask(one_by_one, *asked)
    assert (good.failed, bad.failed) == (False, True)
    assert bad.means == "Not measured: msaa:n=4: it hung."
    assert bad.status == "DEVIATES"


def test_a_property_is_told_apart_from_a_deviation() -> None:
    finding = Finding("a", (), "b", False, "c", needed=False)
    assert (finding.failed, finding.status) == (False, "changed")
    assert (replace(finding, holds=True).status, replace(finding, needed=True).status) == ("property", "DEVIATES")


def test_what_is_no_number_is_null_in_json() -> None:
    document = Finding(
        "a", (Figure("l", "t", {"x": float("nan"), "y": [1.0, float("inf")]}),), "b", False, "c"
    ).document
    assert json.loads(json.dumps(document, allow_nan=False))["figures"][0]["values"] == {"x": None, "y": [1.0, None]}


def test_a_grid_that_is_too_coarse_for_the_staircase_is_said() -> None:
    inquiry = by_name(doctor_osmesa.inquiries(), "grid of corners")
    ((mode, shot),) = inquiry.shots.items()
    finding = inquiry.judge({mode: Shown(np.zeros((*shot.chart.size[::-1], 3), np.float32), 0.0, 1.0)})
    assert finding.failed
    assert finding.figures[0].text == "coarser than 1/16 pixel"


def test_a_pattern_beyond_its_pixel_is_read() -> None:
    """Samples outside of the pixel, as msaa:n=8 has two, fall between the corners of the chart."""
    pattern = Pattern(np.array([[0.3125, -0.0625, 0.5], [0.6875, 1.0625, 0.5]]))
    between = pattern.chart.between()
    assert between[0] < -0.0625 < 1.0625 < between[-1]


# --- the command ------------------------------------------------------------------------------------------------------


def test_the_command_measures_a_renderer(tmp_path: Path) -> None:
    """OSMesa's is the one that starts processes of its own, for llvmpipe's threads."""
    document = json.loads(run("doctor", "-r", "osmesa", "--json").stdout)
    (entry,) = document["renderers"]
    assert entry["holds"] is True
    names = [finding["name"] for finding in entry["findings"]]
    assert names == [inquiry.name for inquiry in doctor_osmesa.inquiries()]
    for finding in entry["findings"]:
        assert finding["holds"], finding
        assert finding["means"].endswith(".")
    lines = doctor.lines_of(document)
    assert max(map(len, lines)) <= doctor.WIDTH
    for finding in entry["findings"]:
        assert f"  {finding['name']}: {finding['status']}" in lines
        assert not [figure for figure in finding["figures"] if not any(figure["label"] in line for line in lines)]
