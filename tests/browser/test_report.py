"""The report as its reader meets it, in Chromium, from disk."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect

from aliascope.records import EmptyCell, Estimate, ReportData, SceneSection
from browser.conftest import wait_ready, written
from browser.report_data import BRIGHT, DARK, HEADLINE, HOSTILE, MARK, NOT_A_NUMBER

Open = Callable[..., Page]
EMBREE, POVRAY, OSMESA = "embree uniform:n=64", "povray am2:depth=3", "osmesa msaa:n=4"
AT_MARK = f"x={MARK[0]}&y={MARK[1]}"
BOTH = f"#scene=edge&a={POVRAY}&b={EMBREE}&{AT_MARK}"


def fragment(page: Page) -> dict[str, str]:
    # The address is written 120 ms after the last change, by the page's own clock, which may be late.
    page.evaluate("() => new Promise((done) => setTimeout(done, 200))")
    return {key: values[0] for key, values in parse_qs(urlsplit(page.url).fragment).items()}


def visible(page: Page, selector: str) -> list[str]:
    return page.locator(f"section.scene:not([hidden]) {selector}").all_inner_texts()


def number(text: str) -> float:
    return float(re.sub(r"[\s\u202f]", "", text).replace("\u2212", "-"))


def read_out(page: Page, key: str) -> list[str]:
    return page.locator(f'[data-read="{key}"] td').all_inner_texts()


def colour_at(page: Page, pixel: tuple[int, int], pane: int = 0) -> list[int]:
    return colour_in(page.locator(".pane canvas").nth(pane), pixel)


def colour_in(canvas: Locator, pixel: tuple[int, int]) -> list[int]:
    """The colour of a picture's pixel in a canvas that shows all of it, at the pixel's centre."""
    return canvas.evaluate(
        """(canvas, [x, y]) => {
            const copy = new OffscreenCanvas(canvas.width, canvas.height);  // to read from the page's own slows it down
            const context = copy.getContext("2d", { willReadFrequently: true });
            context.drawImage(canvas, 0, 0);
            const side = canvas.width / 40;
            return [...context.getImageData((x + 0.5) * side, (y + 0.5) * side, 1, 1).data].slice(0, 3);
        }""",
        list(pixel),
    )


def test_answers_come_in_the_order_of_the_questions(open_page: Open) -> None:
    page = open_page()
    heads = page.locator("main > section > h2").all_inner_texts()
    assert heads == ["1 job has failed", "What came out", "Let me see it", "Can I trust it?"]
    assert page.locator(".headlines p").first.inner_text() == HEADLINE
    facts = page.locator(".facts").inner_text()
    for fact in ("2026-12-01 14:03", "27 pictures", "3 reused", "1 failed", "3 min 41 s"):
        assert fact in facts
    failure = page.locator(".failures li").inner_text()
    assert "povray was killed" in failure
    assert "aliascope render edge" in failure


def test_the_head_says_what_was_compared(open_page: Open) -> None:
    page = open_page()
    assert page.locator("h1").inner_text() == "compare, quick profile, chosen scenes and modes"
    assert page.title() == "compare, quick profile, chosen scenes and modes · aliascope"


def test_probes_come_first_in_what_to_trust_with_what_does_not_hold(open_page: Open) -> None:
    page = open_page()
    assert page.locator("#trust h3").first.inner_text() == "Renderers, probed"
    rows = [
        [text.split("\n")[0].strip() for text in row.locator("th, td").all_inner_texts()]
        for row in page.locator(".probes tbody tr, .probes tfoot tr").all()
    ]
    assert rows == [
        ["cycles", "unknown", "not there: not installed"],
        ["povray", "unknown", f"its probe failed: {HOSTILE}"],
        ["osmesa", "no", "+0.0312", "0.0000", "1.00123", "0.99871", "1.2\u202f×\u202f10⁻³"],
        ["embree", "yes", "\u22120.0031", "0.0000", "1.00000", "1.00000", "1.8\u202f×\u202f10⁻⁸"],
        ["must be", "", "within ±0.01", "1, 1, and below 10⁻⁴"],
    ]
    bad = page.locator(".probes tr", has_text="osmesa").locator(".bad").all_inner_texts()
    assert bad == ["no", "+0.0312", "1.2\u202f×\u202f10⁻³"]
    assert page.locator(".probes tr", has_text="embree").locator(".bad").count() == 0
    units = page.locator(".probes thead th").all_inner_texts()
    assert {"right, pixels", "down, pixels", "gain", "gamma"} <= set(units)
    # Above all else, since every figure of it hangs on that.
    assert page.locator("main > *").nth(1).inner_text().startswith("osmesa: its pictures cannot be compared")
    assert page.locator("main > .notice").count() == 1


def test_what_cannot_be_told_from_the_best_is_bold_too(open_page: Open, data: ReportData, tmp_path: Path) -> None:
    """Two standard errors of a difference, sqrt(3^2 + 4^2) = 5 thousandths, are 10: 9 more is alike, 11 more is not."""
    scene = data.scenes[0]
    figures = [Estimate(0.111, 0.004), Estimate(0.100, 0.003), Estimate(0.109, 0.004), Estimate(0.107, None)]
    rows = tuple(
        replace(row, metrics={**row.metrics, "rmse": rmse}, cpu_seconds=Estimate(0.25, 0.01 * i))
        for i, (row, rmse) in enumerate(zip(scene.rows, figures, strict=True))
    )
    page = open_page()
    page.goto(written(tmp_path, replace(data, scenes=(replace(scene, rows=rows),))).as_uri() + "#error=0.12")
    wait_ready(page)
    # 7 more with an uncertainty that is not known is not alike: 6 is what the best's alone allows.
    assert [number(text) for text in visible(page, ".modes td.best:nth-child(2)")] == [0.1, 0.109]
    assert visible(page, ".modes td.best:nth-child(5)") == []  # all alike
    assert "what its uncertainty does not tell from it" in page.locator(".scene:not([hidden])").inner_text()
    # Each renderer's answer takes the same time.
    assert page.locator(".answer tr.best").count() == 3


def test_a_hostile_name_is_text(open_page: Open) -> None:
    page = open_page()
    page.locator("#scenes").get_by_role("tab").nth(2).click()
    assert page.locator(".scene:not([hidden]) h3").first.inner_text() == HOSTILE
    assert page.evaluate("window.hacked") is None
    assert page.locator("img").count() == 0
    assert fragment(page)["scene"] == HOSTILE
    page.reload()
    wait_ready(page)
    expect(page.locator("#scenes").get_by_role("tab").nth(2)).to_have_attribute("aria-selected", "true")
    assert page.evaluate("window.hacked") is None


def test_tables_sort_by_click_and_key(open_page: Open) -> None:
    page = open_page("#scene=edge")
    seconds = lambda: [number(text) for text in visible(page, ".modes td:nth-child(5)")]  # noqa: E731
    errors = [number(text) for text in visible(page, ".modes td:nth-child(2)")]
    assert errors == sorted(errors)
    head = page.locator("section.scene:not([hidden]) [data-sort=cpu]")
    head.click()
    assert seconds() == [0.001, 0.004, 0.05, 0.9]
    head.focus()
    page.keyboard.press("Enter")
    assert seconds() == [0.9, 0.05, 0.004, 0.001]
    sorted_head = page.locator("section.scene:not([hidden]) th[aria-sort=descending]")
    assert sorted_head.inner_text().split() == ["CPU", "time▼", "s"]
    assert fragment(page)["sort"] == "cpu-down"


def test_tables_are_tables(open_page: Open) -> None:
    page = open_page()
    unscoped = page.locator("th:not([scope])").count()
    assert unscoped == 0
    assert page.locator("table:not(:has(caption))").count() == 0
    best = visible(page, ".modes td.best")
    assert [text.strip() for text in best] == ["0.00500", "800", "0.00100"]


def test_a_and_b_are_chosen_in_table_list_and_sheet(open_page: Open) -> None:
    page = open_page("#scene=edge")
    scene = page.locator("section.scene:not([hidden])")
    row = scene.locator(f'tr[data-mode="{POVRAY}"]')
    row.locator("th").click()
    row.get_by_role("button", name="as B").click()
    names = page.locator(".pane-name")
    expect(names.nth(0)).to_have_text("povray am2, depth=3")
    expect(names.nth(1)).to_have_text("povray am2, depth=3")
    page.get_by_label("picture B").select_option(EMBREE)
    expect(names.nth(1)).to_have_text("embree uniform halton, n=64")
    scene.locator(f'.card[data-mode="{OSMESA}"]').click()
    expect(names.nth(0)).to_have_text("osmesa msaa, n=4")
    assert {key: value for key, value in fragment(page).items() if key in "ab"} == {"a": OSMESA, "b": EMBREE}
    assert scene.locator('[data-slot=a][aria-pressed="true"]').count() == 1


def test_the_read_out_is_the_linear_value(open_page: Open, data: ReportData) -> None:
    page = open_page(f"{BOTH}&exposure=3")
    scene = data.scenes[0]
    rows = {f"{row.renderer} {row.mode}": row.pixels for row in scene.rows}
    pictures = {"reference": scene.reference, "a": rows[POVRAY], "b": rows[EMBREE]}
    for key, pixels in pictures.items():
        expected = pixels[MARK[1], MARK[0]]
        assert [number(text) for text in read_out(page, key)] == [float(f"{v:.6g}") for v in expected.astype(float)]
    difference = rows[POVRAY][MARK[1], MARK[0]].astype(float) - scene.reference[MARK[1], MARK[0]]
    assert [number(text) for text in read_out(page, "a-error")] == [float(f"{v:.5g}") for v in difference]


def test_the_pixel_under_the_pointer_is_read_out(open_page: Open, data: ReportData) -> None:
    page = open_page(BOTH)
    canvas = page.locator(".pane canvas").nth(1)
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    assert box is not None
    x, y = 12, 17
    page.mouse.move(box["x"] + (x + 0.5) * box["width"] / 40, box["y"] + (y + 0.5) * box["height"] / 30)
    assert page.locator(".place").inner_text() == f"pixel ({x}, {y})"
    expected = [float(f"{v:.6g}") for v in data.scenes[0].reference[y, x].astype(float)]
    assert [number(text) for text in read_out(page, "reference")] == expected
    page.mouse.click(box["x"] + (x + 0.5) * box["width"] / 40, box["y"] + (y + 0.5) * box["height"] / 30)
    assert {key: fragment(page)[key] for key in "xy"} == {"x": "12", "y": "17"}


def test_a_value_that_is_no_number_is_said(open_page: Open) -> None:
    x, y = NOT_A_NUMBER
    page = open_page(f"#scene=edge&a={POVRAY}&b={EMBREE}&x={x}&y={y}")
    assert read_out(page, "a") == ["NaN", "NaN", "NaN"]
    assert colour_at(page, (x, y)) == [255, 0, 255]
    assert "1 pixel not finite" in page.locator(f'.scene:not([hidden]) tr[data-mode="{POVRAY}"]').inner_text()


def test_pictures_are_srgb_of_the_linear_values_times_the_exposure(open_page: Open, data: ReportData) -> None:
    def srgb(linear: float) -> int:  # IEC 61966-2-1
        v = min(max(linear, 0.0), 1.0)
        return round(255 * (12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055))

    pixel = (11, 20)
    values = data.scenes[0].reference[pixel[1], pixel[0]].astype(float)
    for stops in (0, 1):
        page = open_page(f"#scene=edge&a=reference&b={EMBREE}&exposure={stops}")
        assert colour_at(page, pixel) == [srgb(v * 2**stops) for v in values]


def test_the_error_map_is_neutral_at_zero_red_above_blue_below(open_page: Open) -> None:
    page = open_page(f"#scene=edge&a={POVRAY}&b=reference&view=errors")
    red, green, blue = colour_at(page, BRIGHT)
    assert red > 1.5 * max(green, blue)
    red, green, blue = colour_at(page, DARK)
    assert blue > 1.5 * red
    zero = colour_at(page, (11, 20), pane=1)
    assert min(zero) > 235
    assert max(zero) - min(zero) <= 1
    scale = page.locator(".stage-column .error-legend").inner_text()
    assert scale.split() == ["−0.1", "darker", "0", "+0.1", "brighter"]


def test_one_error_scale_for_every_map_of_a_scene(open_page: Open, data: ReportData) -> None:
    """The picture whose error is a fifth of another's is a fifth as far from neutral, not as bright."""
    page = open_page("#scene=edge")
    spread = """(canvas) => {
        const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
        let sum = 0;
        for (let i = 0; i < data.length; i += 4) sum += Math.abs(data[i] - data[i + 2]);
        return sum / data.length;
    }"""
    far = {
        mode: page.locator(f'.scene:not([hidden]) .card[data-mode="{mode}"] canvas').nth(1).evaluate(spread)
        for mode in (EMBREE, OSMESA)
    }
    noise = {row.mode: np.std(row.pixels - data.scenes[0].reference) for row in data.scenes[0].rows}
    assert noise["msaa:n=4"] > noise["uniform:n=64"]
    assert far[OSMESA] > 5 * far[EMBREE] > 0
    pixel = (11, 20)
    page = open_page(f"#scene=edge&a={OSMESA}&view=error-a")
    # thumbnails of 40 x 30 pixels are drawn three times larger by the style, not in the canvas
    thumbnail = page.locator(f'.scene:not([hidden]) .card[data-mode="{OSMESA}"] canvas').nth(1)
    assert colour_in(thumbnail, pixel) == colour_in(page.locator(".pane canvas").first, pixel)


def test_the_address_restores_what_was_seen(open_page: Open) -> None:
    page = open_page()
    page.get_by_role("tab", name="zone-plate", exact=True).click()
    page.get_by_label("picture A").select_option(OSMESA)
    page.get_by_label("slider").check()
    page.keyboard.press("+")
    page.get_by_label("exposure in stops").fill("1.5")
    page.get_by_label("Error as").select_option("psnr")
    before = fragment(page)
    assert before.items() >= {"scene": "zone-plate", "a": OSMESA, "view": "slider", "metric": "psnr"}.items()
    assert before["exposure"] == "1.5"
    shown = page.locator(".viewer").inner_text(), visible(page, ".modes")
    page.reload()
    wait_ready(page)
    assert fragment(page) == before
    assert (page.locator(".viewer").inner_text(), visible(page, ".modes")) == shown
    assert page.get_by_label("slider").is_checked()


@pytest.mark.parametrize("bad", ["#scene=nowhere&a=x&zoom=-3&x=1e99&metric=%00", "#=&&==", "#scene=%E0%A4%A"])
def test_an_address_that_makes_no_sense_shows_the_start(open_page: Open, bad: str) -> None:
    page = open_page(bad)
    expect(page.locator("#scenes").get_by_role("tab").nth(0)).to_have_attribute("aria-selected", "true")
    assert page.locator(".pane canvas").first.is_visible()


def test_keys(open_page: Open) -> None:
    page = open_page(BOTH)
    page.locator(".stage").focus()
    names = page.locator(".pane-name")
    page.keyboard.press("2")
    expect(names.nth(0)).to_have_text("povray am2, depth=3")  # second best by error
    page.keyboard.press("Shift+Digit4")
    expect(names.nth(1)).to_have_text("osmesa msaa, n=4")
    page.keyboard.press("r")
    expect(names.nth(0)).to_have_text("reference")
    page.keyboard.press("r")
    expect(names.nth(0)).to_have_text("povray am2, depth=3")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+ArrowDown")
    assert page.locator(".place").inner_text() == f"pixel ({MARK[0] + 1}, {MARK[1] + 10})"
    page.keyboard.press("e")
    expect(page.locator(".pane canvas").nth(0)).to_have_attribute("data-shows", "a error")
    page.keyboard.press("e")
    expect(page.locator(".pane canvas").nth(0)).to_have_attribute("data-shows", "b error")
    zoom = page.locator(".dial output").nth(1)
    fit = int(zoom.inner_text().removesuffix("×"))
    page.keyboard.press("+")
    assert int(zoom.inner_text().removesuffix("×")) > fit
    page.keyboard.press("0")
    assert int(zoom.inner_text().removesuffix("×")) == fit


def test_space_blinks(open_page: Open) -> None:
    page = open_page(BOTH)
    page.locator(".stage").focus()
    page.keyboard.press(" ")
    canvas = page.locator(".pane canvas").nth(0)
    assert fragment(page)["view"] == "blink"
    page.keyboard.press(" ")  # from here on by hand
    first = canvas.get_attribute("data-shows")
    page.keyboard.press(" ")
    second = canvas.get_attribute("data-shows")
    assert {first, second} == {"a picture", "b picture"}
    for _ in range(4):  # over two periods
        page.wait_for_timeout(350)
        assert canvas.get_attribute("data-shows") == second


def test_keys_leave_fields_alone(open_page: Open) -> None:
    page = open_page(BOTH)
    field = page.locator(".questions input[type=text]").first
    field.fill("")
    field.type("0.0123")
    assert field.input_value() == "0.0123"
    assert fragment(page)["a"] == POVRAY


def test_the_samples_of_each_pixel_are_a_view_of_a(open_page: Open, data: ReportData, tmp_path: Path) -> None:
    scene = data.scenes[0]
    counts = np.full(scene.reference.shape[:2], 4, np.uint32)
    counts[10, 20] = 64
    rows = (replace(scene.rows[0], counts=counts), *scene.rows[1:])
    path = written(tmp_path, replace(data, scenes=(replace(scene, rows=rows), *data.scenes[1:])))
    page = open_page()
    assert page.locator("input[name=view][value=samples-a]").count() == 0  # where no mode is adaptive
    row = scene.rows[0]
    page.goto(f"{path.as_uri()}#a={row.renderer} {row.mode}&view=samples-a&x=20&y=10")
    page.wait_for_selector("canvas[data-shows='a samples']")
    assert page.locator("[data-read=taken]").inner_text().split() == ["A", "took", "64", "samples"]
    assert re.sub(r"\s+", " ", page.locator(".viewer .error-legend").inner_text()) == "1 sample 8 64 samples"
    page.keyboard.press("s")
    page.wait_for_selector("canvas[data-shows='a picture']")
    page.wait_for_function("() => !location.hash.includes('samples-a')")
    page.keyboard.press("s")
    page.wait_for_selector("canvas[data-shows='a samples']")
    page.wait_for_url("**view=samples-a**")
    # A mode that takes as many everywhere has one colour, and the reference has none of its own.
    page.goto(f"{path.as_uri()}#a=reference&view=samples-a&x=20&y=10")
    page.reload()
    page.wait_for_selector("canvas[data-shows='a samples']")
    assert page.locator("[data-read=taken]").count() == 0


def test_the_slider_shows_a_left_and_b_right(open_page: Open) -> None:
    both = open_page(BOTH)
    left, right = (5, 20), (35, 20)
    expected = [colour_at(both, left, 0), colour_at(both, right, 1)]
    page = open_page(f"{BOTH}&view=slider&split=0.5")
    assert [colour_at(page, left), colour_at(page, right)] == expected


def test_the_plot_has_all_renderers_in_their_colours(open_page: Open) -> None:
    page = open_page()
    for place in ("#overview-plot", ".scene:not([hidden])"):
        for renderer, colour in (("embree", "#0072B2"), ("povray", "#D55E00"), ("osmesa", "#009E73")):
            points = page.locator(f"{place} .point[data-renderer={renderer}]")
            assert points.count() >= 1
            path = points.first.locator("path")
            assert colour in (path.get_attribute("fill"), path.get_attribute("stroke"))
    assert page.locator("#overview-plot .front").count() == 1
    assert page.locator("#overview-plot .bar").count() >= 2  # of embree: the others have no uncertainty of their time


def test_a_scene_counts_once(open_page: Open) -> None:
    page = open_page()
    assert page.locator(".figure-head h3").inner_text() == "Error against time, all 3 scenes"
    assert page.locator(".over option").first.inner_text() == "all 3 scenes"


def test_the_legend_is_that_of_the_plot(open_page: Open) -> None:
    page = open_page()
    listed = {text.strip() for text in page.locator("#legend li:not([hidden]) button").all_inner_texts()}
    assert listed == {"uniform halton", "am2", "msaa"}  # "uniform halton mitchell" has a plot of its own


def test_hidden_families_and_opened_tables_are_in_the_address(open_page: Open) -> None:
    page = open_page()
    page.locator("#legend button", has_text="am2").click()
    page.locator("#pooled summary").click()
    assert fragment(page)["opened"] == "pooled"
    again = open_page("#" + urlsplit(page.url).fragment)
    assert again.locator("#legend li button[aria-pressed=false]").all_inner_texts() == [" am2"]
    assert again.locator("#overview-plot .point.gone").count() == 1
    assert again.locator("#pooled table").is_visible()
    again.locator("#legend button", has_text="am2").click()
    again.locator("#pooled summary").click()
    assert not {"hidden", "opened"} & fragment(again).keys()
    assert again.locator(".point.gone").count() == 0


def test_a_mode_that_lacks_a_scene_is_hollow_and_said(open_page: Open) -> None:
    page = open_page("#scene=zone-plate")
    hollow = page.locator("#overview-plot .point.hollow")
    assert hollow.get_attribute("data-mode") == "uniform:n=4"
    assert "adaptive passes need a <lens>" in page.locator(".scene:not([hidden]) .lacking").inner_text()
    assert "adaptive passes need a <lens>" in page.locator("#trust").inner_text()


def test_a_point_is_hovered_and_chosen(open_page: Open) -> None:
    page = open_page("#scene=edge")
    point = page.locator('#overview-plot .point[data-mode="am2:depth=3"]')
    point.hover()
    assert "am2, depth=3" in page.locator("#overview-plot .tip").inner_text()
    point.click(modifiers=["Shift"])
    assert fragment(page)["b"] == POVRAY
    page.locator('#overview-plot .point[data-mode="msaa:n=4"]').click()
    assert fragment(page)["a"] == OSMESA
    point.focus()
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("Enter")
    assert fragment(page)["a"] == EMBREE


def test_which_one(open_page: Open) -> None:
    page = open_page()
    best = page.locator(".answer .best")
    page.locator(".questions input[type=text]").nth(0).fill("0.06")
    assert "uniform halton, n=64" in best.inner_text()
    page.locator(".questions input[type=text]").nth(0).fill("0.0015")
    assert "msaa, n=4" in best.inner_text()
    assert "fastest takes" in page.locator(".answer").inner_text()
    page.locator(".questions input[type=text]").nth(1).fill("0.03")
    assert "uniform halton, n=64" in best.inner_text()
    assert "best is 0.1" in page.locator(".answer tr", has_text="osmesa").inner_text()


def test_the_question_changes_by_typing_not_by_passing(open_page: Open) -> None:
    page = open_page("#scene=edge")
    time, error = page.locator(".questions input[type=text]").all()
    before = page.locator(".answer").inner_text()
    time.focus()
    page.keyboard.press("Tab")
    expect(error).to_be_focused()
    page.keyboard.press("Tab")
    assert page.locator(".answer").inner_text() == before
    assert page.get_by_role("radio", name="I have").is_checked()
    assert not {"time", "error"} & fragment(page).keys()
    error.fill("0,03")
    assert fragment(page)["error"] == "0.03"
    assert page.get_by_role("radio", name="I need").is_checked()


def test_an_error_asked_for_goes_with_its_metric(open_page: Open) -> None:
    page = open_page()
    error = page.locator(".questions input[type=text]").nth(1)
    error.fill("0.09")
    page.get_by_label("Error as").select_option("psnr")
    decibels = float(fragment(page)["error"])
    assert 15.0 < decibels < 50.0  # RMSE is 0.005 to 0.12
    assert float(error.input_value()) == decibels
    linked = open_page("#metric=psnr&error=31")
    assert linked.locator(".questions input[type=text]").nth(1).input_value() == "31"


def test_a_metric_says_which_values_are_better(open_page: Open) -> None:
    page = open_page("#scene=edge&metric=sharpness")
    first, *_, last = page.locator(".scene:not([hidden]) .modes tbody tr").all_inner_texts()
    assert "uniform halton, n=64" in first  # the least noise
    assert "msaa, n=4" in last
    assert visible(page, ".modes td.best:nth-child(2)")[0].strip().startswith("3.00")  # 3 - 0.005
    assert "sharpness ≥" in page.locator(".questions").inner_text()


def test_metrics_without_a_value(open_page: Open) -> None:
    page = open_page("#scene=edge&metric=max")
    assert set(visible(page, ".modes td:nth-child(2)")) == {"–"}
    assert "Nothing to plot" in page.locator("#overview-plot svg").text_content()
    page.get_by_label("Error as").select_option("bias")
    assert {text.strip() for text in visible(page, ".modes td:nth-child(2)")} == {"−0.00100"}


def test_a_time_too_short_to_be_told_is_not_the_best(open_page: Open, data: ReportData, tmp_path: Path) -> None:
    scene = data.scenes[0]
    rows = tuple(replace(r, cpu_seconds=Estimate(0.0, 0.0)) if r.renderer == "povray" else r for r in scene.rows)
    page = open_page()
    page.goto(written(tmp_path, replace(data, scenes=(replace(scene, rows=rows),))).as_uri())
    wait_ready(page)
    table = page.locator(".scene .modes")
    povray = table.locator("tbody tr", has_text="povray").locator("td").all_inner_texts()
    assert [text.strip() for text in povray[3:7]] == ["too short", "", "–", ""]
    assert table.locator("td:nth-child(5).best").count() == 1
    assert "best" in (table.locator("tbody tr", has_text="osmesa").locator("td").nth(3).get_attribute("class") or "")
    assert "too short a time" in page.locator(".answer").inner_text()
    assert "povray am2, depth=3" in page.locator("#overview-plot .note").inner_text()


def test_dark_and_light(open_page: Open) -> None:
    background = "getComputedStyle(document.documentElement).backgroundColor"
    light, dark = (open_page(scheme=scheme).evaluate(background) for scheme in ("light", "dark"))
    assert min(int(c) for c in re.findall(r"\d+", light)) > 230
    assert max(int(c) for c in re.findall(r"\d+", dark)) < 40


def test_a_figure_has_no_digits_below_its_uncertainty(open_page: Open, data: ReportData, tmp_path: Path) -> None:
    scene = data.scenes[0]
    given = {"uniform:n=4": Estimate(0.0000935, 0.0012), "uniform:n=64": Estimate(-0.00002, 0.0012)}
    rows = [
        replace(row, metrics={**row.metrics, "structure": given.get(row.mode, Estimate(0.3031, 0.0012))})
        for row in scene.rows
    ]
    page = open_page()
    path = written(tmp_path, replace(data, scenes=(replace(scene, rows=tuple(rows)),)))
    page.goto(path.as_uri() + "#metric=structure&sort=spp-up")
    wait_ready(page)
    found = [text.strip("\u2007\u2008 ") for text in visible(page, ".modes td:nth-child(2)")]
    assert sorted(found) == ["0.0000", "0.0001", "0.303", "0.303"]


def test_a_narrow_table_is_for_fingers(open_page: Open) -> None:
    page = open_page(width=380)
    box = page.locator(".slots .slot").first.bounding_box()
    assert box is not None
    assert min(box["width"], box["height"]) >= 32


@pytest.mark.parametrize("scene", [0, 2])
def test_a_narrow_page_does_not_scroll_sideways(open_page: Open, scene: int) -> None:
    page = open_page(width=380)
    page.locator("#scenes").get_by_role("tab").nth(scene).click()
    for details in page.locator("details").all():
        details.evaluate("node => node.open = true")
    assert page.evaluate("document.documentElement.scrollWidth") <= 380
    canvas = page.locator(".pane canvas").first.bounding_box()
    assert canvas is not None
    assert canvas["width"] <= 380


@pytest.mark.parametrize("scenes", [0, 1, 2])
def test_a_report_of_nothing(open_page: Open, data: ReportData, tmp_path: Path, scenes: int) -> None:
    """No scene, one without a picture, and one beside a scene that has some."""
    empty = (EmptyCell("bare", "povray", "none", "why"),)
    bare = SceneSection("bare", "Bare", "", data.scenes[0].reference, "", (), empty)
    path = written(tmp_path, replace(data, scenes=(bare, data.scenes[0])[:scenes], headlines=()))
    page = open_page()
    page.goto(path.as_uri())
    if scenes == 0:
        assert "No picture was measured" in page.locator("#answer").inner_text()
        return
    wait_ready(page)
    assert "No picture of this scene" in page.locator(".scene").first.inner_text()
    assert "povray cannot draw it: why" in page.locator(".scene").first.inner_text()
    page.keyboard.press("1")
    if scenes == 2:
        page.get_by_role("tab", name="edge").click()
        assert page.locator(".pane canvas").first.is_visible()
        page.get_by_role("tab", name="bare").click()
        page.keyboard.press("1")


def test_paper_has_every_scene(open_page: Open) -> None:
    page = open_page(scheme="dark")
    page.emulate_media(media="print")
    assert page.locator(".scene").count() == 4
    for scene in page.locator(".scene").all():
        assert scene.is_visible()
        assert scene.locator(".sheet").get_attribute("data-ready") == "true"
    assert page.evaluate("getComputedStyle(document.documentElement).color") == "rgb(22, 24, 27)"
