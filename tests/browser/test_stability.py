"""The page of `aliascope stability` in a browser: it fits, asks for nothing, is walked by keys, and can be read."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from aliascope.studies.stability_page import html
from browser import stability_data

Open = Callable[..., Page]


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("stability")
    found = {}
    for name, data in (("large", stability_data.large()), ("small", stability_data.small())):
        found[name] = folder / f"{name}.html"
        found[name].write_text(html(data), encoding="utf-8")
    return found


@pytest.fixture
def opened(browser: Browser, pages: dict[str, Path]) -> Iterator[Open]:
    contexts, noises, requests = [], [], []

    def open_(name: str = "large", fragment: str = "", width: int = 1280, scheme: str = "light") -> Page:
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


@pytest.mark.parametrize("name", ["large", "small"])
@pytest.mark.parametrize(("width", "scheme"), [(380, "light"), (1280, "dark")])
def test_it_fits_and_asks_for_nothing(opened: Open, name: str, width: int, scheme: str) -> None:
    page = opened(name, width=width, scheme=scheme)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    cells = stability_data.cells() if name == "large" else [None]
    expect(page.locator(".map button")).to_have_count(len(cells))
    expect(page.locator(".map")).to_have_count(6 if name == "large" else 1)


CONTRASTS = """() => {
  const parts = (colour) => (colour.match(/[\\d.]+/g) ?? []).map(Number);
  const light = ([r, g, b]) => [r, g, b].map((v) => v / 255)
    .map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const ratio = (a, b) => (Math.max(light(a), light(b)) + 0.05) / (Math.min(light(a), light(b)) + 0.05);
  const behind = (node) => {
    for (let each = node; each; each = each.parentElement) {
      const found = parts(getComputedStyle(each).backgroundColor);
      if (found.length === 3) return found;
    }
    return null;
  };
  const over = ([r, g, b, a], under) => [r, g, b].map((v, i) => a * v + (1 - a) * under[i]);
  const hatch = parts(getComputedStyle(document.body).getPropertyValue("--hatch"));
  const read = ".map td b, .map td small, .map th, .map th small, .legend-lost li, .said li span, .lead";
  const nodes = document.querySelectorAll(read);
  let least = [Infinity, ""];
  for (const node of nodes) {
    const ink = parts(getComputedStyle(node).color);
    const ground = behind(node);
    const grounds = node.closest(".refused") ? [ground, over(hatch, ground)] : [ground];
    for (const each of grounds) {
      const found = ratio(ink, each);
      if (found < least[0]) least = [found, `${node.textContent} in ${node.closest("td, th, li, p").className}`];
    }
  }
  return [...least, hatch.length];
}"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_all_can_be_read(opened: Open, scheme: str) -> None:
    least, where, hatched = opened(scheme=scheme).evaluate(CONTRASTS)
    assert hatched == 4  # red, green, blue, and how much of it
    assert least >= 4.5, where  # WCAG 2.1, 1.4.3


def test_cells_are_told_apart_without_colours(opened: Open) -> None:
    page = opened()
    for mark, words in (("refused", "refuses at "), ("failed", "fails at "), ("absent", "not there")):
        cell = page.locator(
            f".map td.{mark}:not(.ours):not(.excused)" if mark == "refused" else f".map td.{mark}"
        ).first
        expect(cell).to_contain_text(words)
    expect(page.locator(".map td.lost-0:not(.refused):not(.failed)").first).to_contain_text("keeps")
    expect(page.locator(".map td.ours button").first).to_have_attribute("aria-label", re.compile(", ours"))
    expect(page.locator(".map td.excused button").first).to_have_attribute(
        "aria-label", re.compile("by others or|failed")
    )


def test_heads_stay_in_sight(opened: Open) -> None:
    page = opened()
    box = page.locator("#counts .map-box")
    box.scroll_into_view_if_needed()
    box.evaluate("(node) => node.scrollTo(0, 700)")
    top = box.evaluate("(node) => node.getBoundingClientRect().top")
    head = page.locator("#counts thead th").first.evaluate("(node) => node.getBoundingClientRect().top")
    assert head - top == pytest.approx(1.0, abs=1.0)  # below its border
    narrow = opened(width=380)
    box = narrow.locator("#geometry .map-box")
    box.evaluate("(node) => node.scrollTo(600, 0)")
    left = box.evaluate("(node) => node.getBoundingClientRect().left")
    row = narrow.locator("#geometry th.spec").first.evaluate("(node) => node.getBoundingClientRect().left")
    assert row - left == pytest.approx(1.0, abs=1.0)


def test_shadows_stand_where_there_is_more_and_row_names_break_between_words(opened: Open) -> None:
    narrow = opened(width=380)
    frame, box = narrow.locator("#geometry .map-frame"), narrow.locator("#geometry .map-box")
    expect(frame).to_have_class(re.compile("more-right"))
    box.evaluate("(node) => node.scrollTo(node.scrollWidth, node.scrollHeight)")
    expect(frame).not_to_have_class(re.compile("more-right|more-below"))
    # The pieces between places where a name may break, each of which has one box while it is in one line.
    words = """(head) => [...head.childNodes].filter((node) => node.nodeType === Node.TEXT_NODE).every((node) => {
      const range = document.createRange();
      range.selectNodeContents(node);
      return range.getClientRects().length === 1;
    })"""
    heads = narrow.locator("#geometry th.spec, #counts th.spec")
    assert all(heads.nth(place).evaluate(words) for place in range(heads.count()))


def test_keys_walk_the_map_and_open_a_cell(opened: Open) -> None:
    page = opened()
    page.locator("nav a").last.focus()
    page.keyboard.press("Tab")  # one stop a table
    focused = "document.activeElement.getAttribute('aria-label')"
    assert page.evaluate(focused).startswith("embree, far: ")
    page.keyboard.press("End")
    page.keyboard.press("Home")
    assert page.evaluate(focused).startswith("embree, far: ")
    page.keyboard.press("ArrowDown")
    assert page.evaluate(focused).startswith("embree:relative=0, ")
    page.keyboard.press("ArrowRight")
    name = page.evaluate(focused).split(": ")[0]
    page.keyboard.press("Tab")
    page.keyboard.press("Shift+Tab")
    assert page.evaluate(focused).startswith(name)
    page.keyboard.press("Enter")
    dialog = page.locator("dialog[open]")
    expect(dialog.locator("h2")).to_contain_text(name)
    assert "#cell=" in page.url
    page.keyboard.press("Escape")
    expect(dialog).to_have_count(0)
    assert page.evaluate(focused).startswith(name)
    assert "#" not in page.url
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.closest('.group').id") == "radiance"
    page.keyboard.press("Shift+Tab")  # back to where it was
    assert page.evaluate(focused).startswith(name)
    page.keyboard.press("Enter")
    page.locator("[aria-label='Next cell']").click()
    beside = dialog.locator("h2").inner_text()
    assert beside != name
    page.keyboard.press("Escape")
    assert page.evaluate(focused).startswith(beside)


def test_a_cell_shows_its_readings(opened: Open) -> None:
    cells = stability_data.large().cells
    broken = next(each for each in cells if each.breaks and not each.excused and each.refused_from is None)
    page = opened(fragment=f"#cell={broken.component}/{broken.extreme}")
    dialog = page.locator("dialog[open]")
    expect(dialog.locator("h2")).to_have_text(f"{broken.component}, {broken.extreme}")
    for words in (broken.against, broken.unit, "digits lost", "Breaks at"):
        expect(dialog).to_contain_text(words)
    expect(dialog.locator(".readings-table tbody tr")).to_have_count(len(broken.readings))
    plot = dialog.locator("svg.readings-plot")
    expect(plot.locator("path.kept, path.over")).to_have_count(len(broken.readings))
    expect(plot.locator("line.bound")).to_have_count(1)
    expect(plot.locator("line.precision")).to_have_count(1)
    bound = float(plot.locator("line.bound").get_attribute("y1") or "nan")
    heights = plot.locator("path.over").evaluate_all(
        "(nodes) => nodes.map((node) => Number(node.getAttribute('transform').match(/ ([\\d.]+)\\)/)[1]))"
    )
    assert heights
    assert all(height < bound for height in heights)  # above it


def test_what_has_no_error_is_marked(opened: Open) -> None:
    page = opened()
    cells = stability_data.large().cells
    for mark, css in (("refused", "declined"), ("failed", "crossed")):
        one = next(each for each in cells if getattr(each, f"{mark}_from") is not None)
        page.goto(page.url.split("#")[0] + f"#cell={one.component}/{one.extreme}")
        marked = [each for each in one.readings if getattr(each, mark)]
        expect(page.locator(f"dialog[open] svg.readings-plot path.{css}")).to_have_count(len(marked))
        expect(page.locator("dialog[open] .readings-table")).to_contain_text(getattr(marked[0], mark))
        page.keyboard.press("Escape")
    page.locator(".map td.absent button").click()
    expect(page.locator("dialog[open]")).to_contain_text("libOSMesa.so.8")
    expect(page.locator("dialog[open] svg.readings-plot")).to_have_count(0)


def test_every_cell_opens(opened: Open) -> None:
    """No complaint, and nothing in a plot that is no number."""
    page = opened(width=700)
    page.locator(".map button").first.click()
    for _ in range(len(stability_data.cells()) - 1):
        page.evaluate("document.querySelector('[aria-label=\"Next cell\"]').click()")
        assert not page.evaluate("document.getElementById('readings').innerHTML.includes('NaN')")
    expect(page.locator("[aria-label='Next cell']")).to_be_disabled()
    assert page.evaluate("document.querySelector('dialog').scrollWidth <= document.querySelector('dialog').clientWidth")


def test_what_is_said_leads_to_its_cell(opened: Open) -> None:
    page = opened()
    link = page.locator(".said .link").first
    link.click()
    expect(page.locator("dialog[open] h2")).to_have_text(link.inner_text())
    page.locator("dialog button", has_text="Close").click()
    expect(link).to_be_focused()


def test_names_and_notes_are_text(opened: Open) -> None:
    page = opened()
    expect(page.locator("#made")).to_contain_text("<script>alert('no')</script>")
    noted = next(each for each in stability_data.large().cells if each.note)
    page.goto(page.url.split("#")[0] + f"#cell={noted.component}/{noted.extreme}")
    expect(page.locator("dialog[open]")).to_contain_text("<b>beyond</b>")
