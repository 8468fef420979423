"""Scenes of somebody else whose names are scripts: no page that shows them runs one, asks for anything, or has an
element that they made."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from commands import run
from playwright.sync_api import Page

from aliascope.regression.records import CellName
from aliascope.report import charts
from aliascope.report import page as report_page
from aliascope.report.teaching import PageTable, Panel, Section, TeachingPage, Value, teaching_page
from aliascope.studies import history_page, stability_page
from aliascope.studies.history import answer
from aliascope.studies.history_series import Asked
from browser import stability_data, test_history
from browser.hostile_names import NAMES, WATCH, check, scene_file
from browser.report_data import report_data
from browser.run_data import run_data, with_p_values


def hostile_report() -> str:
    """The page of compare, sweep and regress, with a run's verdicts, all of whose scenes are hostile."""
    data = with_p_values(report_data())
    verdicts = run_data(data)
    names = dict(zip([scene.name for scene in data.scenes], NAMES, strict=False))
    scenes = tuple(
        replace(
            scene,
            name=names[scene.name],
            title=NAMES[(i + 1) % 5],
            shows=NAMES[(i + 2) % 5],
            reference_note=NAMES[(i + 3) % 5],
            rows=tuple(replace(row, mode=f"{row.mode}{NAMES[3]}", label=NAMES[3] + row.label) for row in scene.rows),
        )
        for i, scene in enumerate(data.scenes)
    )
    return report_page(replace(data, title=NAMES[1], headlines=NAMES, scenes=scenes, failures=()), verdicts)


def taught() -> TeachingPage:
    """As the page of `agree` is made, and those of other studies."""
    table = PageTable(NAMES[0], NAMES[:3], ((NAMES[2], tuple(Value(name) for name in NAMES[3:])),))
    panel = Panel(f"<svg>{charts.words(NAMES[1], x=1, y=1)}</svg>", title=NAMES[2], note=NAMES[3])
    section = Section("a", NAMES[0], NAMES, (table,), (panel,), definitions=((NAMES[1], NAMES[2]),))
    return TeachingPage(NAMES[1], NAMES[2], NAMES, (section,))


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """By name. Those of `compare` and `agree` are the commands' own, of a scene's file."""
    folder = tmp_path_factory.mktemp("hostile")
    scene = scene_file(folder)
    run("compare", scene, "-r", "embree", "-m", "uniform:n=4", "-m", "uniform:n=16", "-o", folder / "compare")
    small = ("--size", "16x12", "--samples", "2", "--replicates", "4")
    run("agree", scene, "-r", "embree", "-r", "osmesa", *small, "-o", folder / "agree")
    found = {name: folder / name / "report.html" for name in ("compare", "agree")}
    runs = [
        replace(
            each,
            cells=tuple(
                replace(c, name=CellName(NAMES[i % 5], c.name.renderer, f"uniform:n={i}"))
                for i, c in enumerate(each.cells)
            ),
            versions={NAMES[1]: NAMES[4]},
            machine={**each.machine, "processor": NAMES[2]},
        )
        for each in test_history.runs()
    ]
    found["history"] = history_page.write(folder / "history", answer(runs, Asked()))
    cells = tuple(
        replace(each, component=each.component + NAMES[i % 5]) for i, each in enumerate(stability_data.cells())
    )
    made = {
        "report": hostile_report(),
        "teaching": teaching_page(taught()),
        "stability": stability_page.html(replace(stability_data.large(), cells=cells[:40], lost={NAMES[1]: NAMES[2]})),
    }
    for name, html in made.items():
        found[name] = folder / f"{name}.html"
        found[name].write_text(html, encoding="utf-8")
    return found


@pytest.mark.parametrize("name", ["compare", "agree", "teaching", "report", "history", "stability"])
def test_names_are_words(page: Page, pages: dict[str, Path], name: str) -> None:
    assert "hit(" in check(page, pages[name]), "the names are there, as words"


def test_what_the_names_would_do(page: Page, tmp_path: Path) -> None:
    """Without escaping each of these is seen: else the test above would hold of any page."""
    path = tmp_path / "open.html"
    for name in (NAMES[0], NAMES[1], NAMES[2]):
        path.write_text(f"<!doctype html><script>{WATCH}</script><body><title>{name}", encoding="utf-8")
        page.goto(path.as_uri())
        path.write_text(f"<!doctype html><script>{WATCH}</script><body>{name}", encoding="utf-8")
        page.goto(path.as_uri())
        page.wait_for_function("window.hits.length > 0")


def test_a_figure_has_names_as_words(page: Page, pages: dict[str, Path]) -> None:
    """The SVG files beside a report, which are opened by themselves."""
    figures = sorted((pages["compare"].parent / "plots").glob("*.svg"))
    assert figures
    for path in figures:
        page.add_init_script(WATCH)
        page.goto(path.as_uri())
        assert page.evaluate("window.hits") == []
        assert page.evaluate("document.querySelectorAll('script, foreignObject, [onload], [onerror]').length") == 0
