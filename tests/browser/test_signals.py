"""The signal-processing view: spectra of the errors, the number that tells noise from a pattern, filters."""

from __future__ import annotations

import re

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from aliascope.records import ReportData
from aliascope.report.spectra import scene_spectra
from browser.conftest import wait_ready
from browser.report_data import FILTERED, STRUCTURES
from browser.test_report import EMBREE, OSMESA, POVRAY, Open, fragment, number

SHOWN = ".scene:not([hidden])"
COLOURS = {EMBREE: "#0072B2", POVRAY: "#D55E00", OSMESA: "#009E73"}


def heights(page: Page, slot: str) -> list[float]:
    """Where a curve runs, in the plot's units: down is less power."""
    path = page.locator(f"{SHOWN} .curve[data-slot={slot}] .line").get_attribute("d")
    assert path is not None
    return [float(y) for y in re.findall(r" (-?[\d.]+)", path)]


def test_the_spectra_of_a_and_b_change_with_them(open_page: Open) -> None:
    page = open_page(f"#scene=edge&a={OSMESA}&b={EMBREE}")
    curves = page.locator(f"{SHOWN} .curve")
    for i, mode in enumerate((OSMESA, EMBREE)):
        expect(curves.nth(i)).to_have_attribute("data-mode", mode)
        expect(curves.nth(i)).to_have_attribute("stroke", COLOURS[mode])
    before = heights(page, "a"), heights(page, "b")
    page.get_by_label("picture B").select_option("embree uniform:n=4")
    expect(curves.nth(1)).to_have_attribute("data-mode", "embree uniform:n=4")
    assert heights(page, "a") == before[0]  # one scale for all pictures of the scene
    assert np.mean(heights(page, "b")) < np.mean(before[1])  # more noise: higher up
    page.get_by_label("picture B").select_option("reference")
    expect(curves).to_have_count(1)
    assert "B is the reference: no error" in page.locator(f"{SHOWN} .spectrum figcaption").inner_text()


def test_the_curve_is_the_spectrum(open_page: Open, data: ReportData) -> None:
    """Heights go with the logarithm of the power, and the dotted line lies at that of the mean."""
    page = open_page(f"#scene=edge&a={OSMESA}&b={EMBREE}")
    spectra = scene_spectra(data.scenes[0])
    powers = spectra.rows[[f"{row.renderer} {row.mode}" for row in data.scenes[0].rows].index(OSMESA)]
    assert not isinstance(powers, str)
    found = heights(page, "a")
    assert len(found) == len(powers) == len(spectra.frequencies)
    slope, offset = np.polyfit(np.log10(powers), found, 1)
    assert slope < 0
    # heights are rounded to 0.1, so off by 0.05 at most; the fitted line may be off by as much again
    assert np.abs(slope * np.log10(powers) + offset - found).max() < 0.1
    level = page.locator(f"{SHOWN} .curve[data-slot=a] .level").get_attribute("y1")
    assert level is not None
    mean = np.average(powers, weights=spectra.bins)
    assert float(level) == pytest.approx(slope * np.log10(mean) + offset, abs=0.1)


def test_the_number_is_the_metric(open_page: Open) -> None:
    page = open_page(f"#scene=edge&a={POVRAY}&b={EMBREE}")

    def shown(slot: str) -> list[str]:
        return page.locator(f"{SHOWN} [data-structure={slot}] td").all_inner_texts()

    assert (number(shown("a")[0]), shown("a")[1]) == (STRUCTURES["povray"], "")
    assert (number(shown("b")[0]), shown("b")[1]) == (STRUCTURES["embree"], "± 0.010")
    page.get_by_label("picture A").select_option(OSMESA)
    assert number(shown("a")[0]) == STRUCTURES["osmesa"]
    page.get_by_label("picture A").select_option("reference")
    assert shown("a") == ["–", ""]
    assert "near 0, noise; toward ½, a pattern" in page.locator(f"{SHOWN} .structure").inner_text()


def test_a_frequency_is_read_out_by_pointer_and_key(open_page: Open, data: ReportData) -> None:
    page = open_page(f"#scene=edge&a={OSMESA}&b={EMBREE}")
    plot = page.locator(f"{SHOWN} .spectrum-plot")
    tip = page.locator(f"{SHOWN} .spectrum .tip")
    plot.hover()
    assert "cycles per pixel" in tip.inner_text()
    page.mouse.move(0, 0)
    expect(tip).to_be_hidden()
    spectra = scene_spectra(data.scenes[0])
    plot.focus()
    page.keyboard.press("End")
    page.keyboard.press("ArrowLeft")
    said = plot.get_attribute("aria-valuetext")
    assert said is not None
    assert said.startswith(f"{spectra.frequencies[-2]:.3g} cycles per pixel: power A ")
    assert plot.get_attribute("aria-valuenow") == str(len(spectra.frequencies) - 2)
    values = [float(text) for text in tip.locator("dd").all_inner_texts()]
    rows = [f"{row.renderer} {row.mode}" for row in data.scenes[0].rows]
    for value, mode in zip(values, (OSMESA, EMBREE), strict=True):
        assert value == pytest.approx(float(spectra.rows[rows.index(mode)][-2]), rel=5e-3)  # three digits


def test_errors_without_a_spectrum_say_why(open_page: Open) -> None:
    page = open_page(f"#scene=edge&a={POVRAY}&b={EMBREE}")
    caption = page.locator(f"{SHOWN} .spectrum figcaption")
    assert "A has values that are no numbers" in caption.inner_text()
    expect(page.locator(f"{SHOWN} .curve")).to_have_count(1)
    page.get_by_role("tab", name=FILTERED).click()
    page.get_by_label("picture A").select_option("embree uniform:filter=mitchell,n=4")
    page.get_by_label("picture B").select_option("embree uniform:filter=mitchell,n=64")
    assert "A equals the reference" in caption.inner_text()
    assert "B is off by the same everywhere" in caption.inner_text()
    expect(page.locator(f"{SHOWN} .spectrum-plot")).to_be_hidden()  # nothing to plot at all


def test_a_scene_whose_name_has_a_comma(open_page: Open) -> None:
    page = open_page()
    page.get_by_role("tab", name=FILTERED).click()
    assert fragment(page)["scene"] == FILTERED
    page.reload()
    wait_ready(page)
    expect(page.get_by_role("tab", name=FILTERED)).to_have_attribute("aria-selected", "true")
    assert "filtered with mitchell" in page.locator(f"{SHOWN} h3").inner_text()
    assert FILTERED in page.locator("#overview-plot .note").last.inner_text()  # why it is not pooled
    assert page.locator("#overview-plot .point").count() == 4


def test_the_filters(open_page: Open) -> None:
    page = open_page()
    panels = page.locator("[data-filter]")
    assert {"box", "tent", "mitchell"} <= {panel.get_attribute("data-filter") for panel in panels.all()}
    assert page.locator(".response > .line").count() == panels.count()
    page.locator(".filters summary").click()
    box = page.locator(".filters tr", has_text="box").locator("td").all_inner_texts()
    # the box's is sin(pi f) / (pi f)
    assert [number(text) for text in box[1:]] == [round(float(np.sinc(f)), 3) + 0.0 for f in (0.25, 0.5, 0.75, 1, 1.5)]
    page.locator('[data-filter="tent"] svg').hover()
    assert re.fullmatch(r"−?\d\.\d{3} at \d\.\d{3}", page.locator('[data-filter="box"] .value').inner_text())


def test_paper_has_the_spectra_of_every_scene(open_page: Open) -> None:
    page = open_page("#scene=edge")
    drawn = page.locator(".scene[hidden] .curve").count()  # before printing, which need not wait for a drawing
    assert drawn == 4
    page.emulate_media(media="print")
    for scene in page.locator(".scene").all()[:3]:
        assert scene.locator(".curve").count() >= 1
        assert scene.locator(".spectrum-plot").is_visible()
        assert scene.locator("[data-structure]").count() == 2
