"""What doctor says of a renderer that it does not know by name, and what a comparison keeps of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from inline_workers import Inline

from aliascope import renderers
from aliascope.errors import JobFailed
from aliascope.pipeline import Options
from aliascope.records import Job, Outcome, Probe, Rendering
from aliascope.renderers.base import Request
from aliascope.renderers.embree import Embree
from aliascope.store import Store
from aliascope.studies import doctor, probes


class Fourth(Embree):
    name = "fourth"
    title = "A fourth"
    probe_mode = "uniform:n=400,sampler=regular"


class Random(Fourth):
    """Random samples place an edge 0.03 pixel off, and more."""

    probe_mode = "uniform:n=1,sampler=random"


@pytest.mark.parametrize(("renderer", "holds"), [(Fourth(), True), (Random(), False)])
def test_a_new_renderer_is_probed_in_the_mode_that_it_names(
    monkeypatch: pytest.MonkeyPatch, renderer: Fourth, holds: bool
) -> None:
    monkeypatch.setattr(renderers, "RENDERERS", {renderer.name: renderer})
    monkeypatch.setattr(doctor, "Workers", Inline)
    document = doctor.examine(quick=True)
    (entry,) = document["renderers"]
    assert entry["mode"] == renderer.probe_mode
    assert entry["holds"] is holds
    assert any(renderer.probe_mode in line for line in doctor.lines_of(document))


class Bent(Fourth):
    """Output = 0.9 input^1.1."""

    def render(self, request: Request) -> Rendering:
        found = super().render(request)
        return replace(found, pixels=(0.9 * found.pixels.astype(np.float64) ** 1.1).astype(np.float32))


def test_a_gain_and_a_gamma_are_measured() -> None:
    probe = probes.measure(Bent())
    assert (probe.gain, probe.gamma) == (pytest.approx(0.9, rel=1e-5), pytest.approx(1.1, rel=1e-5))
    assert probe.deviation == pytest.approx(1.0 - 0.9, rel=1e-5)  # at the brightest strip
    assert not probe.holds


class Moved(Fourth):
    """Half a pixel off, to the right and up: each pixel the mean of two neighbours."""

    def render(self, request: Request) -> Rendering:
        found = super().render(request)
        right = (found.pixels + np.pad(found.pixels, ((0, 0), (1, 0), (0, 0)), "edge")[:, :-1]) / 2
        up = (right + np.pad(right, ((0, 1), (0, 0), (0, 0)), "edge")[1:]) / 2
        return replace(found, pixels=up.astype(np.float32))


def test_where_the_pixels_are_has_its_sign() -> None:
    probe = probes.measure(Moved())
    # The mode's 20 samples a side find an edge to 1/40 pixel; the mean over 48 columns, each in another phase, to less.
    assert probe.centre == (pytest.approx(0.5, abs=2e-3), pytest.approx(-0.5, abs=2e-3))
    assert not probe.holds


# --- in a comparison --------------------------------------------------------------------------------------------------


class Done:
    """A task that is done when its result is asked for."""

    def __init__(self, result: Callable[[], Any]) -> None:
        self.result = result


class Here:
    """Does the tasks in this process, and counts them."""

    begun = 0

    def begin(self, task: Callable[..., Any], arguments: list[Any], time_limit: float, about: object = None) -> Done:
        self.begun += 1
        return Done(lambda: task(*arguments))


def outcome_of(renderer: str, status: str) -> Outcome:
    return Outcome(Job(renderer + status, "s", "s.toml", renderer, "m", 4, 3, 0), status)


def test_those_that_drew_are_probed_once_and_what_does_not_hold_is_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Broken(Fourth):
        name = "broken"

        def render(self, request: Request) -> Rendering:
            raise JobFailed("it hung")

    class Off(Random):
        name = "off"

    class Idle(Fourth):
        name = "idle"

    class Away(Fourth):
        name = "away"

    every = {each.name: each for each in (Fourth(), Off(), Broken(), Idle(), Away())}
    monkeypatch.setattr(renderers, "RENDERERS", every)
    monkeypatch.setattr(renderers, "find", every.__getitem__)
    digest = ["1"]
    monkeypatch.setattr(probes.jobs, "code_digest", lambda name, mode: digest[0])
    done = [outcome_of(name, "done") for name in ("fourth", "broken", "off")]
    outcomes = [*done, outcome_of("fourth", "failed"), outcome_of("idle", "failed")]
    told: list[object] = []

    def probed() -> tuple[dict[str, Probe], int]:
        workers = Here()
        with Store(tmp_path / "results.sqlite") as store:
            store.begin_run("", "", "", {}, {})
            found = probes.of_those_that_drew(
                outcomes,
                {"away": "not installed"},
                store,
                Options(),
                lambda *what: told.append(what[0]),
                workers,  # type: ignore[arg-type]
            )
        return {probe.renderer: probe for probe in found}, workers.begun

    first, begun = probed()
    assert list(first) == ["away", "idle", "broken", "off", "fourth"]
    assert [probe.holds for probe in first.values()] == [False, False, False, False, True]
    assert first["away"].reason == "not there: not installed"
    assert first["idle"].reason == "none of its pictures was made"
    assert first["broken"].reason == "its probe failed: it hung"
    assert "off: PICTURES CANNOT BE COMPARED" in probes.warning_of(first["off"])
    assert [probes.warning_of(first[name]) for name in ("away", "fourth")] == ["", ""]
    assert (begun, told) == (3, ["probing fourth", "probing off", "probing broken"])
    again, begun = probed()
    assert (again, begun) == (first, 1)  # what failed is tried again
    digest[0] = "2"
    assert probed()[1] == 3  # and all of it with other code
