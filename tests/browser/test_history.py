"""The page of `aliascope history` in a browser: it fits, asks for nothing, and is walked by pointer and keys."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from aliascope.history import KeptCell, KeptRun
from aliascope.records import Estimate
from aliascope.regression.records import CellName
from aliascope.studies.history import answer
from aliascope.studies.history_page import write
from aliascope.studies.history_series import Asked

Open = Callable[..., Page]
RUNS = 30
MODES = tuple(f"uniform:n={n},sampler={sampler}" for n in (4, 16, 64) for sampler in ("random", "sobol"))
NAMES = [CellName(scene, "embree", mode) for scene in ("edge", "discs") for mode in MODES]
CHANGED = CellName("edge", "embree", MODES[3])
SCRIPT = CellName("edge", "povray", '<script>alert("no")</script>')


def cell(name: CellName, index: int) -> KeptCell:
    late = name == CHANGED and index >= 12
    return KeptCell(
        name,
        passed=not (late and index == 12),
        rmse=Estimate(0.011 if late else 0.01, 0.0005),
        rmse_of_each=(0.011, 0.0109) if late else (0.01, 0.01),
        pictures=2,
        samples=200.0,
        rays={"primary": 200.0, "shadow": 400.0 if index < 20 else 500.0},
        cpu_seconds=0.5 + 0.01 * ((index * 7 + len(name.mode)) % 5) + (0.3 if index >= 15 else 0.0),
        cpu_seconds_of_each=(0.5,),
    )


def runs() -> list[KeptRun]:
    made = []
    for i in range(RUNS):
        machine = {"processor": "One", "cores": "2", "system": "Linux"}
        versions = {"embree": "3.13.5" if i < 12 else "4.0.0"}
        cells = tuple(cell(name, i) for name in (*NAMES, SCRIPT))
        made.append(
            KeptRun(f"2026-01-{i + 1:02}T10:00:00+00:00", 9.0, f"{i:02x}" * 6, machine, versions, "x", i != 12, cells)
        )
    return made


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Of 30 runs, and of the first alone."""
    folder = tmp_path_factory.mktemp("history")
    return {
        "many": write(folder / "many", answer(runs(), Asked())),
        "one": write(folder / "one", answer(runs()[:1], Asked())),
    }


@pytest.fixture
def opened(browser: Browser, pages: dict[str, Path]) -> Iterator[Open]:
    contexts, noises, requests = [], [], []

    def open_(name: str = "many", fragment: str = "", width: int = 1280, scheme: str = "light") -> Page:
        context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: noises.append(message.text))
        page.on("pageerror", lambda error: noises.append(str(error)))
        page.on("dialog", lambda dialog: noises.append(dialog.message))
        page.on("request", lambda request: requests.append(request.url))
        page.goto(pages[name].as_uri() + fragment)
        page.wait_for_selector("html[data-ready]", state="attached")
        return page

    yield open_
    for context in contexts:
        context.close()
    assert noises == []
    assert all(url.split("#")[0] in {path.as_uri() for path in pages.values()} for url in requests)


@pytest.mark.parametrize("name", ["many", "one"])
@pytest.mark.parametrize(("width", "scheme"), [(380, "light"), (1280, "dark")])
def test_it_fits_and_asks_for_nothing(opened: Open, name: str, width: int, scheme: str) -> None:
    page = opened(name, width=width, scheme=scheme)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    red = int(page.evaluate("getComputedStyle(document.documentElement).backgroundColor").split("(")[1].split(",")[0])
    assert (red < 64) == (scheme == "dark")
    expect(page.locator("svg.runs")).to_have_count(2)
    expect(page.locator("svg.runs").first.locator(".point")).to_have_count(RUNS if name == "many" else 1)


def test_a_step_leads_to_its_mode(opened: Open) -> None:
    page = opened()
    step = page.locator(".step", has_text="rmse")
    expect(step).to_have_count(1)
    expect(step).to_contain_text("+10.0 %")
    expect(page.locator(".place", has=step)).to_contain_text("embree 3.13.5 → 4.0.0")
    step.click()
    expect(page.locator("#detail h3")).to_have_text(f"embree {CHANGED.mode}")
    expect(page.locator("#scene")).to_have_value("edge")
    expect(page.locator(".row[aria-pressed=true]")).to_contain_text("embree")
    expect(page.locator("svg.runs").first.locator(".step-mark.up")).to_have_count(1)
    expect(page.locator("svg.runs").first.locator(".failed")).to_have_count(1)
    page.wait_for_function("(mode) => decodeURIComponent(location.hash).includes(mode)", arg=CHANGED.mode)


def test_keys_walk_the_runs_and_say_them(opened: Open) -> None:
    page = opened(fragment=f"#scene=edge&mode=embree+{CHANGED.mode.replace('=', '%3D')}")
    expect(page.locator("#detail h3")).to_have_text(f"embree {CHANGED.mode}")
    page.locator("#stepped").focus()
    for _ in range(30):  # past the rows of the list, to the plot
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.classList.contains('runs')"):
            break
    page.keyboard.press("Home")
    for _ in range(12):
        page.keyboard.press("ArrowRight")
    tip = page.locator(".tip:not([hidden])")
    for text in (
        "0c0c0c0c0c0c",
        "did not pass",
        "2026-01-13 10:00",
        "0.01100 ± 0.0005",
        "One, 2 cores",
        "embree, new",
        "4.0.0",
    ):
        expect(tip).to_contain_text(text)
    expect(page.locator("#live")).to_contain_text("0c0c0c0c0c0c")
    page.keyboard.press("Escape")
    expect(tip).to_have_count(0)


def test_the_pointer_shows_a_run(opened: Open) -> None:
    page = opened(fragment="#scene=discs")
    plot = page.locator("svg.runs").first
    box = plot.bounding_box()
    assert box is not None
    plot.hover(position={"x": box["width"] - 20, "y": 90})
    expect(page.locator(".tip:not([hidden])")).to_contain_text(f"{RUNS - 1:02x}" * 6)
    expect(page.locator("svg.runs .cursor[visibility=visible]")).to_have_count(2)


def test_one_finds_modes_and_costs(opened: Open) -> None:
    page = opened()
    page.locator("#scene").select_option("edge")
    expect(page.locator(".row")).to_have_count(len(MODES) + 1)
    page.locator("#find").fill("sobol n=16")
    expect(page.locator(".row")).to_have_count(1)
    page.locator("#find").fill("nothing of that kind")
    expect(page.locator("#list")).to_contain_text("No mode of this scene is so named.")
    page.locator("#find").fill("")
    page.locator("#cost").select_option("rays-shadow")
    expect(page.locator("svg.runs").nth(1)).to_contain_text("shadow rays a picture")
    expect(page.locator("svg.runs").nth(1)).to_contain_text("+25.0 %")
    page.locator(".row").first.focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    expect(page.locator(".row").nth(1)).to_have_attribute("aria-pressed", "true")


def test_history_of_nothing_but_times_has_one_plot(opened: Open, pages: dict[str, Path], tmp_path: Path) -> None:
    only = answer([dataclasses.replace(run) for run in runs()], Asked(metrics=("cpu-seconds",)))
    pages["times"] = write(tmp_path, only)
    page = opened("times", "#scene=edge")
    expect(page.locator("svg.runs")).to_have_count(1)
    page.locator("#scene").select_option("all scenes")
    expect(page.locator("svg.runs .step-mark")).to_have_count(1)
