"""What the page makes of packed pictures: the same bits as Python, in Chromium."""

from __future__ import annotations

import numpy as np
from picture_data import HEIGHT, STEP, WIDTH, lit, odd, stepped
from playwright.sync_api import Browser

from aliascope.records import Pixels
from aliascope.report.encode import encode_picture
from aliascope.report.files import source
from aliascope.report.packing import Known
from aliascope.report.relations import find_relations

DECODE = """async ([text, width, height, reference, relations]) => {
    document.body.innerHTML = "<script type='text/plain' id='picture-0'></script>";
    document.getElementById("picture-0").textContent = text;
    const values = reference && new Float32Array(new Uint32Array(reference).buffer);
    return [...new Uint32Array((await decodePicture(0, width, height, { relations, reference: values })).buffer)];
}"""


def test_the_page_unpacks_the_same_bits(browser: Browser) -> None:
    known = Known(lit(0, noise=0.0), find_relations([lit(seed) for seed in range(4)]))
    near = Known(lit(0, noise=1e-5), known.relations)
    cases: list[tuple[Pixels, Known, float]] = [
        (lit(9), known, 0.0),
        (lit(0, noise=2e-5), near, 0.0),
        (stepped(9), known, STEP),
        (odd(), known, 0.0),
        (np.random.default_rng(3).integers(0, 1 << 32, (HEIGHT, WIDTH, 3), np.uint32).view(np.float32), known, 0.0),
        (lit(9), Known(None, known.relations), 0.0),
        (np.round(lit(9) * 8) / np.float32(8), known, 0.0),
        (lit(0, noise=0.0), Known(None, known.relations), 0.0),
    ]
    half = np.where(np.arange(WIDTH)[:, np.newaxis] < WIDTH // 2, lit(0), lit(9))
    cases.append((half, Known(lit(0), known.relations), 0.0))  # the reference's own pixels
    kinds = set()
    page = browser.new_page()
    page.add_script_tag(
        content="const same = (v) => v, clamp = (v, a, b) => Math.min(Math.max(v, a), b);\n"
        + source("unpack.js")
        + "\nwindow.decodePicture = decode; window.inflated = inflate;"
    )
    for pixels, told, step in cases:
        text = encode_picture(pixels, told, step)
        relations = {"lines": told.relations.lines.tolist(), "planes": told.relations.planes.tolist()}
        reference = told.reference.view(np.uint32).reshape(-1).tolist() if told.reference is not None else None
        bits = page.evaluate(DECODE, [text, WIDTH, HEIGHT, reference, relations])
        assert np.array_equal(np.array(bits, np.uint32), pixels.view(np.uint32).reshape(-1))
        kinds.add(page.evaluate("async (text) => (await inflated(text))[0]", text))
    page.close()
    assert kinds >= {0, 1, 2, 6}  # labels, a palette, told from the reference, and that in steps
