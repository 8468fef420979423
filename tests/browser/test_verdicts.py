"""The page of a regression run: verdicts first, and the p-values of each pixel."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from aliascope.records import ReportData
from aliascope.report import page as page_of
from browser.conftest import wait_ready
from browser.report_data import BRIGHT
from browser.run_data import run_data, with_p_values

Open = Callable[..., Page]


def written(folder: Path, data: ReportData, passed: bool) -> str:
    data = with_p_values(data)
    path = folder / "report.html"
    path.write_text(page_of(data, run_data(data, passed)), encoding="utf-8")
    return path.as_uri()


@pytest.fixture(scope="module")
def failing(data: ReportData, tmp_path_factory: pytest.TempPathFactory) -> str:
    return written(tmp_path_factory.mktemp("failing"), data, passed=False)


def opened(open_page: Open, address: str, width: int = 1400) -> Page:
    page = open_page("", width)
    page.goto(address)
    wait_ready(page)
    return page


def test_what_failed_comes_first_with_its_figures_and_commands(open_page: Open, failing: str) -> None:
    page = opened(open_page, failing)
    heads = page.locator("main > section > h2").all_inner_texts()
    assert heads[:2] == ["Failed: 2 of 4 cells", "What came out"]
    lost, moved = page.locator("#verdicts > ul > li").all()
    assert "no reference for" in lost.inner_text()
    text = moved.inner_text()
    for part in (
        "moved right, the worst of 8",
        "0.031 pixel",
        "at most 0.0042 pixel",
        "as if shifted",
        "(20, 11), green",
    ):
        assert part in text
    assert "blocks" not in text  # it passed
    assert [code.inner_text() for code in moved.locator("code").all()] == [
        "aliascope regress edge -r povray -m am2:depth=3",
        "aliascope regress --bless 'edge/povray/am2:depth=3' --reason '...'",
    ]
    assert page.locator("#verdicts td.bad", has_text="no outlier").count() == 1  # the control
    assert "CPU time 1.7 times" in page.locator(".warned-note").inner_text()
    assert page.evaluate("window.hacked") is None


def test_every_cell_has_its_head_room_the_least_first(open_page: Open, failing: str) -> None:
    page = opened(open_page, failing)
    page.locator(".all-cells summary").click()
    rows = page.locator(".cells tbody tr").all()
    assert len(rows) == 4
    assert rows[1].locator("td").all_inner_texts()[1:3] == ["\u2212638 %", "95 %"]
    assert rows[2].locator("td").all_inner_texts()[:2] == ["reference", "82 %"]
    assert rows[3].locator("td").all_inner_texts()[1] == "100 %"
    assert rows[3].locator("td.warned").inner_text() == "\u221213 %"


def test_a_failure_leads_to_its_picture_and_a_picture_to_its_p_values(open_page: Open, failing: str) -> None:
    page = opened(open_page, failing)
    page.locator("#verdicts .what a").click()
    expect(page.locator(".pane-name").first).to_contain_text("signed error, povray")
    expect(page.locator(".place")).to_have_text(f"pixel ({BRIGHT[0]}, {BRIGHT[1]})")
    # This one has no p-values, and says so; the other has.
    page.keyboard.press("p")
    expect(page.locator(".stage-column")).to_contain_text("judged by what was blessed")
    page.goto(f"{failing}#scene=edge&a=embree uniform:n=64&b=reference&view=p-values-a&x={BRIGHT[0]}&y={BRIGHT[1]}")
    page.locator('.pane canvas[data-shows="a p-values"]').wait_for()
    expect(page.locator('[data-read="p-value"] td')).to_have_text("3\u202f×\u202f10⁻⁷")
    expect(page.locator(".error-legend").first).to_contain_text("by chance")


def test_a_run_that_passed_says_so(open_page: Open, data: ReportData, tmp_path: Path) -> None:
    page = opened(open_page, written(tmp_path, data, passed=True))
    assert page.locator("#verdicts h2").inner_text() == "Passed: 2 cells"
    assert "12,480 statistical tests share a significance of 0.001" in page.locator("#verdicts").inner_text()
    assert page.locator("section.verdicts.failures").count() == 0


def test_nothing_is_wider_than_a_telephone(open_page: Open, failing: str) -> None:
    page = opened(open_page, failing, width=380)
    assert page.evaluate("document.documentElement.scrollWidth") <= 380
