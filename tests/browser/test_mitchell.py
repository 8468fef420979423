"""The pages of `aliascope mitchell` in a browser: tables that are tables, no overflow, no request, either scheme."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

NAMES = ("mitchell", "hardware")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("mitchell")
    for options in (["--realisations", "4", "--column", "star"], ["--table", "hardware"]):
        command = [sys.executable, "-W", "error", "-m", "aliascope.cli", "mitchell", *options, "-o", str(made)]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
    return made


def opened(browser: Browser, path: Path, width: int, scheme: str = "light") -> tuple[Page, list[str], list[str]]:
    """The page, what it complains of, and what it asks for."""
    page = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme).new_page()
    noises: list[str] = []
    requests: list[str] = []
    page.on("console", lambda message: noises.append(message.text))
    page.on("pageerror", lambda error: noises.append(str(error)))
    page.on("request", lambda request: requests.append(request.url))
    page.goto(path.as_uri())
    return page, noises, requests


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [380, 1400])
def test_it_fits_and_asks_for_nothing(browser: Browser, folder: Path, name: str, scheme: str, width: int) -> None:
    page, noises, requests = opened(browser, folder / f"{name}.html", width, scheme)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    red = int(page.evaluate("getComputedStyle(document.documentElement).backgroundColor").split("(")[1].split(",")[0])
    assert (red < 64) == (scheme == "dark")
    assert noises == []
    assert [url for url in requests if not url.startswith("data:")] == [(folder / f"{name}.html").as_uri()]
    page.context.close()


def test_the_table_is_a_table_with_the_figures(browser: Browser, folder: Path) -> None:
    document: dict[str, Any] = json.loads((folder / "mitchell.json").read_text())
    page, _, _ = opened(browser, folder / "mitchell.html", 1400)
    table = page.locator("table").first
    assert table.locator("caption").inner_text() == "Discrepancy of random edges"
    assert table.locator("th[scope=colgroup]").all_inner_texts() == ["16 points", "256 points", "1,600 points"]
    rows = table.locator("tbody tr")
    for i, process in enumerate(dict.fromkeys(cell["process"] for cell in document["cells"])):
        assert rows.nth(i).locator("th[scope=row]").inner_text() == process
        shown = rows.nth(i).locator("td").all_inner_texts()
        cells = [cell for cell in document["cells"] if cell["process"] == process]
        for j, cell in enumerate(cells):
            assert float(shown[3 * j].split()[0]) == pytest.approx(cell["mean"], rel=0.05)  # two digits of a wide error
            assert float(shown[3 * j + 1]) == cell["published"]
            assert shown[3 * j + 2] == f"{cell['ratio']:.3f}"
    headings = page.locator("h2").all_inner_texts()
    assert {"The table", "With half a count added", "What this shows", "Other measures"} <= set(headings)
    for name in ("Reproduced", "Fitted", "Unknown", "Searched"):
        assert len(page.locator(f"dl.notes div:has(dt:text-is('{name}')) dd").inner_text()) > 100
    page.context.close()


def test_pictures_are_there_and_named(browser: Browser, folder: Path) -> None:
    page, _, _ = opened(browser, folder / "mitchell.html", 1400)
    assert page.locator("#sets figure svg[aria-label]").count() == 15
    assert page.locator("#spectra figure img[alt]").count() == 10
    assert page.evaluate("[...document.images].every(image => image.complete && image.naturalWidth > 60)")
    for link in page.locator("#files a").all():
        assert (folder / (link.get_attribute("href") or "")).is_file()
    page.goto((folder / "hardware.html").as_uri())
    assert page.locator("#patterns figure svg[aria-label]").count() == 18  # an ordered grid has 1, 4 or 16 points
    page.context.close()
