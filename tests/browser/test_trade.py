"""What time buys, on the report's page: the plot, the tables, the knobs, and how sure all of it is."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest
from playwright.sync_api import Locator, Page, expect

from aliascope.records import Estimate, ReportData
from aliascope.trade import QUANTISATION, Trade, analyse
from browser.conftest import wait_ready, written
from browser.trade_data import NOISE, trade_data

Open = Callable[..., Page]


@pytest.fixture(scope="module")
def data() -> ReportData:
    return trade_data()


@pytest.fixture(scope="module")
def told(data: ReportData) -> Trade:
    return analyse(data.scenes)


@pytest.fixture(scope="module")
def report(data: ReportData, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("trade"), data)


def fragment(page: Page) -> dict[str, str]:
    page.evaluate("() => new Promise((done) => setTimeout(done, 200))")
    return {key: values[0] for key, values in parse_qs(urlsplit(page.url).fragment).items()}


def number(text: str) -> float:
    return float(re.sub(r"[\s\u2007\u2008\u202f]", "", text).replace("\u2212", "-"))


def cells(row: Locator) -> list[str]:
    return [text.strip(" \u2007\u2008") for text in row.locator("th, td").all_inner_texts()]


def panel(page: Page, tab: str) -> Locator:
    return page.locator(f"#trade-panel-{tab}")


def in_sight(page: Page, selector: str) -> bool:
    return page.locator(selector).first.evaluate(
        "node => { const box = node.getBoundingClientRect(); return box.top >= -1 && box.top < innerHeight; }"
    )


def test_the_plot_is_of_all_scenes_or_of_one(open_page: Open) -> None:
    page = open_page()
    points = page.locator("#overview-plot .point")
    heading = page.locator(".figure-head h3")
    assert heading.inner_text() == "Error against time, both scenes"
    assert points.count() == 15
    over_both = page.locator("#overview-plot .chance").count()
    assert over_both > 0
    first = points.first.get_attribute("aria-label")
    page.get_by_label("scenes of the plot").select_option(label="disc")
    assert heading.inner_text() == "Error against time, disc"
    assert points.count() == 15
    assert points.first.get_attribute("aria-label") != first
    assert fragment(page).items() >= {"over": "scene", "scene": "disc"}.items()
    again = open_page("#over=scene&scene=disc")
    assert again.locator(".figure-head h3").inner_text() == "Error against time, disc"
    page.get_by_label("scenes of the plot").select_option(label="both scenes")
    assert heading.inner_text() == "Error against time, both scenes"


def test_costs_that_no_machine_changes(open_page: Open) -> None:
    page = open_page("#cost=rays")
    plot = page.locator("#overview-plot")
    assert plot.locator(".axis-title").last.text_content() == "rays a pixel"
    assert plot.locator(".point").count() == 13
    assert "a number of rays" in plot.locator(".note").inner_text()  # osmesa's
    names = page.get_by_label("Cost as").locator("option").all_inner_texts()
    assert names == ["CPU time", "samples", "rays"]  # nobody counted instructions
    page.get_by_label("Cost as").select_option("samples")
    assert plot.locator(".axis-title").last.text_content() == "samples a pixel"
    assert plot.locator(".point").count() == 15
    assert page.locator(".figure-head h3").inner_text() == "Error against samples, both scenes"
    label = plot.locator('.point[data-mode="uniform:n=64,sampler=sobol"]').get_attribute("aria-label")
    assert (label or "").endswith("64.0 samples a pixel")
    assert fragment(page)["cost"] == "samples"


def test_a_renderer_is_hidden_as_a_whole(open_page: Open) -> None:
    page = open_page("#scene=edge")
    whole = page.locator("#legend .whole", has_text="embree")
    whole.click()
    gone = page.locator("#overview-plot .point.gone")
    assert gone.count() == 10
    assert set(gone.evaluate_all("nodes => nodes.map((node) => node.dataset.renderer)")) == {"embree"}
    again = open_page("#" + urlsplit(page.url).fragment if "hidden" in fragment(page) else "")
    assert again.locator("#overview-plot .point.gone").count() == 10
    again.locator("#legend button", has_text="uniform sobol").click()
    expect(again.locator("#legend .whole", has_text="embree")).to_have_attribute("aria-pressed", "true")
    assert again.locator("#overview-plot .point.gone").count() == 5
    whole.focus()
    page.keyboard.press("Enter")
    assert gone.count() == 0


def test_a_click_opens_a_mode_beside_the_reference(open_page: Open) -> None:
    page = open_page("#scene=disc")
    page.evaluate("scrollTo(0, 0)")
    page.locator('#overview-plot .point[data-mode="am2:depth=3"]').click()
    expect(page.locator(".pane-name").nth(0)).to_have_text("povray am2, n=9")
    expect(page.locator(".pane-name").nth(1)).to_have_text("reference")
    assert in_sight(page, ".viewer")
    assert page.evaluate("document.activeElement.className") == "stage"
    given = fragment(page)
    assert (given["scene"], given["a"], given["b"]) == ("disc", "povray am2:depth=3", "reference")


def test_hovering_says_how_sure_a_point_is(open_page: Open, told: Trade) -> None:
    page = open_page("#over=scene&scene=edge")
    mode = "uniform:n=16,sampler=sobol"
    page.locator(f'#overview-plot .point[data-mode="{mode}"]').hover()
    tip = page.locator("#overview-plot .tip")
    lines = dict(zip(tip.locator("dt").all_inner_texts(), tip.locator("dd").all_inner_texts(), strict=True))
    assert lines["RMSE"] == "0.0500 ± 0.0006"
    assert lines["CPU seconds"] == "0.00166"
    assert lines[""] == "0.00163 to 0.00170"
    chance = next(one.probability for one in told.scenes[0].front if one.mode == mode)
    assert chance > 0.9
    assert "%" in lines["on the front"]
    ring = page.locator(f'#overview-plot .point[data-mode="{mode}"] .chance')
    assert float(ring.get_attribute("stroke-opacity") or 0) == pytest.approx(chance, abs=1e-3)


def test_the_rounding_to_8_bits_is_a_line(open_page: Open) -> None:
    page = open_page("#over=scene&scene=edge")
    line = page.locator("#overview-plot .quantisation")
    low = 0.4 * 256**-0.75
    assert low > QUANTISATION
    assert line.count() == 0  # out of sight
    page = open_page("#metric=psnr")
    assert page.locator("#overview-plot .quantisation").count() == 0


def test_the_rounding_is_shown_where_errors_come_near(open_page: Open, data: ReportData, tmp_path: Path) -> None:
    scene = data.scenes[0]
    rows = tuple(replace(row, metrics={"rmse": Estimate(row.metrics["rmse"].value / 20.0, None)}) for row in scene.rows)
    page = open_page()
    page.goto(written(tmp_path, replace(data, scenes=(replace(scene, rows=rows),))).as_uri())
    wait_ready(page)
    assert "rounding to 8 bits, 0.00113" in (page.locator("#overview-plot .quantisation").text_content() or "")


def test_the_time_to_an_error(open_page: Open, told: Trade) -> None:
    page = open_page("#scene=edge")
    radios = panel(page, "error").locator("input[type=radio]")
    errors = sorted({one.error for one in told.scenes[0].equal_error} | {QUANTISATION}, reverse=True)
    assert radios.count() == len(errors)
    for error in errors:
        radios.nth(errors.index(error)).check()
        answers = [one for one in told.scenes[0].equal_error if one.error == error] or told.scenes[0].quantisation
        shown = [cells(row) for row in panel(page, "error").locator("tbody tr").all()]
        able = sorted((one.seconds.value, one) for one in answers if one.seconds)
        assert [number(row[1]) for row in shown[: len(able)]] == [pytest.approx(t, rel=6e-3) for t, _ in able]
        assert [row[0] for row in shown[: len(able)]] == [f"{one.renderer} {one.family}" for _, one in able]
        for row in shown[len(able) :]:
            assert row[1] == "–"
            assert row[3].startswith("cannot: its best is ")
        assert len(shown) == len(answers) == 4
    assert float(fragment(page)["reach"]) == pytest.approx(QUANTISATION)


def test_a_mode_of_a_table_is_opened(open_page: Open) -> None:
    page = open_page("#scene=disc&trade=time")
    assert panel(page, "time").is_visible()
    assert not panel(page, "error").is_visible()
    button = panel(page, "time").locator("button.link").first
    label = button.get_attribute("aria-label") or ""
    button.focus()
    page.keyboard.press("Enter")
    assert label.startswith(page.locator(".pane-name").nth(0).inner_text().strip())
    expect(page.locator(".pane-name").nth(1)).to_have_text("reference")
    assert in_sight(page, ".viewer")


def test_tabs_go_by_keys_and_are_in_the_address(open_page: Open) -> None:
    page = open_page()
    page.get_by_role("tab", name="To reach an error").focus()
    page.keyboard.press("ArrowRight")
    assert panel(page, "time").is_visible()
    page.keyboard.press("End")
    expect(page.get_by_role("tab", name="Knobs")).to_be_focused()
    assert fragment(page)["trade"] == "knobs"
    page.keyboard.press("ArrowRight")
    assert "trade" not in fragment(page)
    again = open_page("#trade=knobs")
    assert panel(again, "knobs").is_visible()


def test_convergence(open_page: Open) -> None:
    page = open_page("#scene=edge&trade=rate")
    shown = {row[0]: row for row in map(cells, panel(page, "rate").locator("tbody tr").all())}
    assert shown["embree uniform sobol"][1] == "\u22120.75"
    assert shown["embree uniform random"][1] == "\u22120.50"


def test_ratios_over_scenes(open_page: Open, told: Trade) -> None:
    page = open_page("#trade=scenes")
    shown = {row[0]: row for row in map(cells, panel(page, "scenes").locator("tbody tr").all())}
    for ratio in told.ratios:
        row = shown[f"{ratio.renderer} {ratio.family}"]
        for text, interval in ((row[1], ratio.time), (row[3], ratio.error)):
            assert (number(text) if interval else text) == (
                pytest.approx(interval.value, rel=6e-3) if interval else "–"
            )
    assert " ".join(told.base or ()) in panel(page, "scenes").locator("p").first.inner_text()


def test_knobs_say_what_they_do(open_page: Open, told: Trade) -> None:
    page = open_page("#trade=knobs")
    rows = panel(page, "knobs").locator("tbody tr:not(.group)")
    assert rows.count() == len(told.knobs) > 3
    shown = {row[0]: row for row in map(cells, rows.all())}
    by_sampler = next(name for name in shown if name.startswith("sampler"))
    assert shown[by_sampler][6] in ("faster, but worse", "slower, but better")
    for knob in told.knobs:
        row = shown.get(f"{knob.knob} {knob.setting} against {knob.baseline}")
        assert row is not None
        words = row[6]
        if knob.time.high is not None and knob.time.high < 1.0:
            assert "faster" in words
        if knob.error.low is not None and knob.error.low > 1.0:
            assert "worse" in words
    assert panel(page, "knobs").locator("tbody").count() == len({(k.renderer, k.form) for k in told.knobs})


def test_which_one_says_how_sure_it_is(open_page: Open, data: ReportData, tmp_path: Path) -> None:
    page = open_page("#over=scene&scene=edge&error=0.06")
    best = page.locator(".answer .best").first.inner_text()
    assert "uniform sobol, n=16" in best
    assert "±\u00a00.0006" in best
    assert "0.00163 to 0.00170" in best
    sure = page.locator(".answer .sure").inner_text()
    assert "No other mode is as good" in sure
    assert "on the front" in sure
    # A twin that takes as long cannot be told from it.
    scene = data.scenes[0]
    twin = next(row for row in scene.rows if row.mode == "uniform:n=16,sampler=sobol")
    twin = replace(twin, mode="uniform:n=16,sampler=twin", family="uniform twin", label="uniform twin, n=16")
    path = written(tmp_path, replace(data, scenes=(replace(scene, rows=(*scene.rows, twin)),)))
    page.goto(path.as_uri() + "#error=0.06")
    wait_ready(page)
    assert "Cannot be told from it: embree uniform" in page.locator(".answer .sure").inner_text()


def test_a_loaded_machine_is_said_first(open_page: Open, data: ReportData, tmp_path: Path) -> None:
    page = open_page()
    assert NOISE.told in page.locator("#loaded").inner_text()
    steady = page.locator("#noise").inner_text()
    for text in ("40 runs", "0.0312 CPU s", "8.1 %", "+3.4 %", "1.9 × the median"):
        assert text in steady
    quiet = replace(NOISE, loaded=False, told="It was quiet.")
    page.goto(written(tmp_path, replace(data, noise=quiet)).as_uri())
    wait_ready(page)
    assert page.locator("#loaded").count() == 0
    assert "It was quiet." in page.locator("#noise").inner_text()


@pytest.mark.parametrize("tab", ["error", "time", "rate", "scenes", "knobs"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_narrow_page_has_its_tables_in_boxes(open_page: Open, tab: str, scheme: str) -> None:
    page = open_page(f"#trade={tab}&over=scene", width=380, scheme=scheme)
    assert page.evaluate("document.documentElement.scrollWidth") <= 380
    box = panel(page, tab).locator(".scroll")
    assert box.evaluate("node => node.scrollWidth > node.clientWidth && getComputedStyle(node).overflowX === 'auto'")
    assert box.get_attribute("tabindex") == "0"


def test_tables_are_tables_and_all_of_them_are_printed(open_page: Open) -> None:
    page = open_page()
    tables = page.locator(".trade-section table")
    assert tables.count() == 5
    assert page.locator(".trade-section th:not([scope])").count() == 0
    assert page.locator(".trade-section table:not(:has(caption))").count() == 0
    page.emulate_media(media="print")
    assert all(table.is_visible() for table in tables.all())


def test_what_has_no_data_is_left_out(open_page: Open, data: ReportData, tmp_path: Path) -> None:
    scene = data.scenes[0]
    rows = tuple(replace(row, cpu_seconds=Estimate(0.0), seconds=(), draws={}, settings={}) for row in scene.rows)
    bare = replace(data, scenes=(replace(scene, rows=rows),), noise=None)
    page = open_page()
    page.goto(written(tmp_path, bare).as_uri())
    wait_ready(page)
    assert page.locator(".trade-section, #loaded, #noise").count() == 0
    one = replace(data, scenes=(replace(scene, rows=scene.rows[:1]),))
    (tmp_path / "one").mkdir()
    page.goto(written(tmp_path / "one", one).as_uri())
    wait_ready(page)
    assert page.locator(".trade-section").count() == 0


def test_an_address_of_what_is_not_there_shows_the_start(open_page: Open) -> None:
    page = open_page("#trade=nonsense&cost=money&reach=-1&afford=x&over=none")
    assert panel(page, "error").is_visible()
    assert page.locator("#overview-plot .axis-title").last.text_content() == "CPU seconds a picture"
