"""One Chromium for all tests; each gets a page of its own, which must neither complain nor ask for anything."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from aliascope.records import ReportData
from aliascope.report import page as page_of
from browser.report_data import report_data

ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
Open = Callable[..., Page]


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    executable = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if executable is None:
        pytest.fail("no Chromium on the path: make installs it")
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=executable, args=ARGUMENTS)
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """An empty one."""
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    yield context.new_page()
    context.close()


@pytest.fixture(scope="session")
def data() -> ReportData:
    return report_data()


@pytest.fixture(scope="session")
def report(data: ReportData, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("report"), data)


def written(folder: Path, data: ReportData) -> Path:
    """The page alone, without the figures beside it, which no test here looks at."""
    path = folder / "report.html"
    path.write_text(page_of(data), encoding="utf-8")
    return path


@pytest.fixture
def open_page(browser: Browser, report: Path) -> Iterator[Open]:
    """Opens the report at a fragment; at the end there may be no complaint and no request but for the file itself."""
    contexts, noises, requests = [], [], []

    def open_(fragment: str = "", width: int = 1400, scheme: str = "light") -> Page:
        context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: noises.append(message.text))
        page.on("pageerror", lambda error: noises.append(str(error)))
        page.on("request", lambda request: requests.append(request.url))
        page.goto(report.as_uri() + fragment)
        wait_ready(page)
        return page

    yield open_
    for context in contexts:
        context.close()
    assert noises == []
    assert all(url.startswith("file://") and url.split("#")[0].endswith("/report.html") for url in requests), requests


def wait_ready(page: Page) -> None:
    """Until the contact sheets, which come last, are drawn."""
    page.wait_for_selector("html[data-ready]", state="attached")
