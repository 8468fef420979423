"""`aliascope sweep`: on small scenes of POV-Ray and of ours; what is measured of a scene; and bad input."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from commands import complaint, run

from aliascope import places
from aliascope.errors import InvalidInput, JobFailed
from aliascope.renderers import povray_file
from aliascope.renderers.povray_file import SRGB, Colours
from aliascope.studies import sweep, sweep_pov, sweep_scene, sweep_search, sweep_text
from aliascope.studies.sweep_search import Candidate
from aliascope.trade.records import QUANTISATION

SCENE = """#version {version};
{settings}
camera {{ orthographic location <1, 1, -10> direction <0, 0, 1> right 2*x up 2*y }}
plane {{ z, 1 pigment {{ checker rgb 0.9 rgb 0.1 scale 0.237 rotate 17*z }} finish {{ ambient 1 diffuse 0 }} }}
sphere {{ <0.8, 1.1, 0>, 0.413 pigment {{ rgb 2.5 }} finish {{ ambient 1 diffuse 0 }} }}
{more}
"""
LIMIT = 60.0


def written(folder: Path, more: str = "", settings: str = "global_settings { assumed_gamma 1 }") -> Path:
    path = folder / "scene.pov"
    path.write_text(SCENE.format(version="3.7", settings=settings, more=more))
    return path


@pytest.fixture(autouse=True, scope="module")
def quick() -> Iterator[None]:
    """Two timed runs of one picture each, and a coarser grid: the figures are not what is tested here."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sweep_search, "MOST_REPEATS", 2)
        patch.setattr(sweep_pov, "LEAST_TIMED", 0.0)
        patch.setattr(sweep_pov, "THRESHOLDS", (0.0, 0.03, 0.3, 0.6))
        patch.setattr(sweep_pov, "DEPTHS", {"am1": (2, 3, 5, 9), "am2": (1, 2, 3, 4)})
        patch.setattr(sweep_scene, "SAMPLERS", {name: sweep_scene.SAMPLERS[name] for name in ("halton", "regular")})
        patch.setattr(sweep_scene, "ADAPTIVE_COUNTS", (16, 64))
        yield


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    """A sweep of a small scene, with an include beside it, and its document."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "more.inc").write_text("disc { <1.4, 0.5, 0>, z, 0.211 pigment { rgb <0.2, 0.7, 0.4> } }\n")
    scene = written(folder, '#include "more.inc"\n#include "colors.inc"\nlight_source { <0, 5, -9> White }')
    words = ["sweep", scene, "--budget", "4m", "--size", "48x36", "-o", folder / "out", "--json"]
    return folder, json.loads(run(*words).stdout)


def test_the_document_has_the_three_settings_the_front_and_the_reference(swept: tuple[Path, dict]) -> None:
    folder, found = swept
    assert found["wall_seconds"] < found["budget_seconds"] == 240.0
    assert set(found["settings"]) == {"fast", "balanced", "final"}
    times = [found["settings"][name]["cpu_seconds"] for name in ("fast", "balanced", "final")]
    errors = [found["settings"][name]["rmse"] for name in ("fast", "balanced", "final")]
    assert times == sorted(times)
    assert errors == sorted(errors, reverse=True)
    front = [(each["cpu_seconds"], each["rmse"]) for each in found["front"]]
    assert front == sorted(front)
    assert [rmse for _, rmse in front] == sorted((rmse for _, rmse in front), reverse=True)
    assert found["measured"] == len(found["all"]) >= len(front) > 3
    assert 0.0 < found["reference"]["standard_error"] < errors[0]
    assert (folder / "out" / "report.html").is_file()
    # Antialiasing pays on such a scene: at most a fifth of the error of none is left.
    none = next(each for each in found["all"] if each["mode"] == "none")
    assert errors[2] < none["rmse"] / 5.0


def test_its_errors_are_those_against_a_grid_of_many_more_rays(swept: tuple[Path, dict]) -> None:
    folder, found = swept
    file = povray_file.open_file(folder / "scene.pov")
    truth = povray_file.grid(file, (48, 36), 31, (), Colours(), LIMIT, 2)[0][31]
    truth = np.clip(truth, 0.0, 1.0)
    for name in ("fast", "final"):
        own = found["settings"][name]
        options = own["options"].split()
        drawn = povray_file.draw(file, (48, 36), options, LIMIT)
        # The stated error has its reference's in it, at most that of two standard errors.
        off = math.sqrt(((drawn.pixels - truth) ** 2).mean())
        assert off == pytest.approx(own["rmse"], abs=2.0 * found["reference"]["standard_error"])
    # The reference's own error is no smaller than stated.
    own = povray_file.grid(file, (48, 36), 15, (5, 3), Colours(), LIMIT, 2)[0]
    pictures = {side: np.clip(mean, 0.0, 1.0) for side, mean in own.items()}
    stated, slope = sweep_pov.grid_error(pictures, 15)
    real = math.sqrt(((pictures[15] - truth) ** 2).mean())
    assert 0.5 * real < stated < 3.0 * real  # a factor 2 either way: the rows of an edge are few in so small a picture
    assert 1.0 <= slope <= 1.5


def test_povray_takes_the_ini_file_and_the_command_line(swept: tuple[Path, dict]) -> None:
    folder, found = swept
    file = povray_file.open_file(folder / "scene.pov")
    for name in ("fast", "balanced", "final"):
        own = found["settings"][name]
        by_command = own["command"].split()
        assert by_command[:4] == ["povray", "+Iscene.pov", "+W48", "+H36"]
        by_options = povray_file.draw(file, (48, 36), by_command[4:], LIMIT)
        by_ini = povray_file.draw(file, (48, 36), [f"{folder / 'out' / 'sweep.ini'}[{name}]"], LIMIT)
        np.testing.assert_array_equal(by_ini.pixels, by_options.pixels)
        assert by_ini.statistics.samples == by_options.statistics.samples


def test_the_grid_in_a_grid_is_the_grid(tmp_path: Path) -> None:
    file = povray_file.open_file(written(tmp_path))
    colours = Colours()
    means, centres, rounding = povray_file.grid(file, (24, 18), 15, (5, 3), colours, LIMIT, 1)
    for side in (3, 5):
        own = povray_file.grid(file, (24, 18), side, (), colours, LIMIT, 1)[0][side]
        # Two canvases place a ray within a rounding of each other: none of these meets an edge.
        np.testing.assert_allclose(means[side], own, atol=1e-12)
    plain = povray_file.draw(file, (24, 18), ("-A",), LIMIT).pixels
    np.testing.assert_allclose(np.clip(centres, 0.0, 1.0), plain, atol=2.0**-12)  # half of a half float's step
    assert 0.0 < rounding < 2.0**-12
    # A mode at the threshold 0 is that grid and, once more, its centre.
    am1 = povray_file.draw(file, (24, 18), ("+AM1", "+A0.0", "+R5", "-J"), LIMIT, unclipped=True).pixels
    np.testing.assert_allclose(am1, (25.0 * means[5] + centres) / 26.0, atol=2.5 * 2.0**-11)


@pytest.mark.parametrize(
    ("settings", "version", "gamma", "as_written"),
    [
        ("global_settings { assumed_gamma 1 }", "3.7", 1.0, False),
        ("global_settings { assumed_gamma 2.2 }", "3.7", 2.2, False),
        ("global_settings { assumed_gamma 1.6 }", "3.7", 1.6, False),
        ("global_settings { assumed_gamma srgb }", "3.7", SRGB, False),
        ("", "3.6", SRGB, True),
        ("", "3.7", 1.0, False),
    ],
)
def test_the_gamma_of_a_scene_is_measured(
    tmp_path: Path, settings: str, version: str, gamma: float | str, as_written: bool
) -> None:
    path = tmp_path / "scene.pov"
    path.write_text(SCENE.format(version=version, settings=settings, more=""))
    found = povray_file.character_of(povray_file.open_file(path), (32, 24), LIMIT, 2)
    assert (found.colours.gamma, found.colours.as_written) == (gamma, as_written)
    assert found.colours.residual < 2e-4  # what half floats round
    assert found.differs_by_run == 0.0
    assert bool(found.colours.told()) == (gamma != 1.0)
    light = np.array([-0.3, 0.0, 0.001, 0.4, 3.0])
    np.testing.assert_allclose(found.colours.light(found.colours.averaged(light)), light, rtol=1e-9, atol=1e-12)


def test_a_scene_that_depends_on_its_canvas_is_found_out() -> None:
    generator = np.random.default_rng(7)
    noise = generator.normal(0.0, 0.01, (96, 128, 3))
    assert sweep_pov.lasting(noise) < 1e-3  # averages out
    assert sweep_pov.lasting(noise + 0.005) == pytest.approx(0.005, rel=0.1)


def test_the_error_of_a_grid_is_found_from_the_grids_within() -> None:
    """Pictures with independent errors C k^-p; the bounds of p hold."""
    generator = np.random.default_rng(3)

    def pictures(power: float) -> dict[int, np.ndarray]:
        return {k: generator.normal(0.0, 0.2 * k**-power, (120, 160, 3)) for k in (15, 5, 3)}

    for power, held in ((1.25, 1.25), (0.8, 1.0), (2.0, 1.5)):
        error, slope = sweep_pov.grid_error(pictures(power), 15)
        assert slope == pytest.approx(held, abs=0.02)  # the standard error of either difference is 0.2 %
        if power == held:
            assert error == pytest.approx(0.2 * 15**-power, rel=0.03)
        # Without the slope, the least.
    one, slope = sweep_pov.grid_error({12: np.zeros((4, 4, 3)), 4: np.full((4, 4, 3), 0.1)}, 12)
    assert (one, slope) == (pytest.approx(0.1 / math.sqrt(10.0)), 1.0)


def test_an_error_has_its_spread_over_the_picture() -> None:
    # The jackknife over blocks: of noise, rmse / sqrt(2 values), here within a third (30 blocks).
    squares = np.random.default_rng(5).normal(0.0, 0.1, (80, 96)) ** 2
    assert sweep.over_blocks(squares) == pytest.approx(0.1 / math.sqrt(2.0 * squares.size), rel=0.33)
    assert sweep.over_blocks(np.ones((8, 8))) is None


def test_a_scene_of_ours_has_settings_of_every_renderer(tmp_path: Path) -> None:
    words = ["sweep", places.SCENES / "discs.toml", "--budget", "4m", "--size", "32x24", "-o", tmp_path, "--json"]
    found = json.loads(run(*words).stdout)
    assert set(found["renderers"]) == {"embree", "osmesa", "povray"}
    assert {each["renderer"] for each in found["all"]} == {"embree", "osmesa", "povray"}
    assert found["settings"]["final"]["rmse"] <= max(QUANTISATION, 1.05 * min(e["rmse"] for e in found["all"]))
    command = found["settings"]["balanced"]["command"].split()
    assert command[:2] == ["aliascope", "render"]
    assert "--size" in command
    assert found["reference"]["method"] != "converged"


def test_what_the_text_of_a_scene_tells(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"scene\.pov:6: the scene writes files \(#fopen F"):
        povray_file.open_file(written(tmp_path, '#fopen F "out.txt" write\n'))
    povray_file.open_file(written(tmp_path, '// #fopen F "out.txt" write\n#fopen F "in.txt" read\n'))
    (tmp_path / "beside.inc").write_text('\n#fopen F concat("a", "b") append\n')
    with pytest.raises(InvalidInput, match=r"beside\.inc:2: the scene writes files"):
        povray_file.open_file(written(tmp_path, '#include "beside.inc"\n'))
    assert "clock 0" in povray_file.open_file(written(tmp_path, "sphere { <clock, 0, 0>, 0.1 }")).notes[0]
    (tmp_path / "blind.pov").write_text("#version 3.7;\nsphere { 0, 1 }\n")
    with pytest.raises(InvalidInput, match=r"blind\.pov: the scene has no camera"):
        povray_file.open_file(tmp_path / "blind.pov")


def test_complaints_are_one_line_each(tmp_path: Path) -> None:
    out = ["-o", tmp_path / "out", "--budget", "20s", "--size", "32x24"]
    scene = written(tmp_path)
    assert "no such file" in complaint("sweep", tmp_path / "none.pov", *out, code=2)
    assert "a scene to sweep ends in" in complaint("sweep", tmp_path / "none.ini", *out, code=2)
    assert "is no time" in complaint("sweep", scene, "--budget", "5", code=2)
    assert "5s at least" in complaint("sweep", scene, *out[:2], "--budget", "2s", code=2)
    assert "16x16 pixels or more" in complaint("sweep", scene, *out[:2], "--size", "15x20", code=2)
    assert "can be done" in complaint("sweep", scene, *out[:2], "--size", "4000x3000", code=2)
    broken = written(tmp_path, "sphere { 0, 1 pigmnt { rgb 1 } }")
    assert "scene.pov:6: Parse Error: No matching } in 'sphere', undeclared identifier 'pigmnt'" in complaint(
        "sweep", broken, *out, code=2
    )
    endless = written(tmp_path, "#while (1) #end")
    assert "larger --budget; or the scene has no end" in complaint("sweep", endless, *out, "--budget", "5s", code=2)
    file = tmp_path / "file"
    file.write_text("")
    assert "choose another folder" in complaint("sweep", written(tmp_path), "-o", file / "sub", code=4)


def slow(folder: Path) -> Path:
    """A scene whose pixels take long."""
    lights = "light_source { <0, 5, -9> rgb 1 area_light 9*x, 9*y, 65, 65 }\n" * 4
    return written(folder, lights + "sphere { <1.5, 0.3, 0>, 0.3 pigment { rgb 1 } }")


def test_a_scene_out_of_reach_is_refused_with_what_would_do() -> None:
    with pytest.raises(InvalidInput, match=r"--budget 23m, or --size \d+x\d+$") as refused:
        sweep_pov._check((320, 240), 60.0, 600.0)
    width, height = (int(n) for n in str(refused.value).rpartition(" ")[2].split("x"))
    assert 600.0 * width * height / (320 * 240) <= 0.55 * 60.0
    sweep_pov._check((320, 240), 60.0, 30.0)


@pytest.mark.parametrize("look", ["a small picture", "the picture without antialiasing"])
def test_each_look_at_a_scene_may_find_it_out_of_reach(
    tmp_path: Path, look: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From that look on, any reference takes more than its share of the budget."""
    told: list[str] = []

    def tell(what: str) -> None:
        told.append(what)
        if what == look:
            monkeypatch.setattr(sweep_pov, "LARGEST_REFERENCE_SHARE", 1e-9)

    monkeypatch.setattr(sweep_pov, "REFERENCE_SHARE", 0.0)
    with pytest.raises(InvalidInput, match="the reference alone"):
        sweep_pov.prepare(povray_file.open_file(written(tmp_path)), (32, 24), 60.0, lambda: 60.0, tell, told.clear)
    assert told[-1] == look


def test_options_are_those_of_the_setting() -> None:
    assert sweep_text.options(Candidate("povray", "am1:depth=4,jitter=0,threshold=0.003")) == "+AM1 +A0.003 +R4 -J"
    assert sweep_text.options(Candidate("povray", "none")) == "-A"


def test_a_failure_of_povray_keeps_its_words(tmp_path: Path) -> None:
    with pytest.raises(JobFailed, match="time limit"):
        povray_file.draw(povray_file.open_file(slow(tmp_path)), (320, 240), ("-A",), 0.3)
