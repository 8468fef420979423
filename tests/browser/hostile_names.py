"""Names that are scripts, a scene that has them, and how a page is found to show them as words."""

from __future__ import annotations

import json
from pathlib import Path

from playwright.sync_api import Page

FILE_NAME = "<img src=x onerror=hit(1)>\"'`$(id)${hit(2)}{{7*7}}&lt;b&gt;"
"""Of a file, which has no slash; and of a mode, which has no colon and no comma."""
NAMES = (
    FILE_NAME,
    '</script><script>hit(3)</script><!--<script>"\\u003cimg src=x onerror=hit(4)>',
    '"></style></title></textarea><svg/onload=hit(5)><a href=javascript:hit(6)>x</a>',
    "'];hit(7);//\u2028hit(8)\\",
    "]]></svg><image href=x onerror=hit(9) /><foreignObject><iframe srcdoc='<script>parent.hit(10)</script>'>",
)
WATCH = "window.hits = []; window.hit = (n) => { window.hits.push(n); };"
MADE = "[onerror], [onload], [onclick], [src='x'], [href='x'], a[href^='javascript:'], iframe, object, embed"
"""What the names above would make, were one of them taken for markup."""

SCENE = f"""\
title = {json.dumps(NAMES[1])}
shows = {json.dumps(NAMES[2])}

[view]
size = [16, 16]

[camera]
type = "orthographic"
eye = [0.0, 0.0, 4.0]
look_at = [0.0, 0.0, 0.0]
height = 2.0

[materials.{json.dumps(NAMES[4])}]
emission = [1.0, 1.0, 1.0]

[[surfaces]]
type = "polygon"
material = {json.dumps(NAMES[4])}
points = [[-0.31, -0.57, 0.0], [0.93, 0.07, 0.0], [0.13, 0.83, 0.0]]
"""
"""As small as a sweep takes it. What JSON quotes, TOML reads."""


def scene_file(folder: Path) -> Path:
    path = folder / f"{FILE_NAME}.toml"
    path.write_text(SCENE)
    return path


WALK = """() => {
  for (const each of document.querySelectorAll("details")) each.open = true;
  for (const each of document.querySelectorAll("select")) {
    for (let i = 0; i < each.options.length; i++) {
      each.selectedIndex = i;
      each.dispatchEvent(new Event("input", { bubbles: true }));
      each.dispatchEvent(new Event("change", { bubbles: true }));
    }
  }
  const live = "button, summary, [tabindex], svg circle, svg path, td, th, canvas, label";
  for (const each of [...document.querySelectorAll(live)].slice(0, 1500)) {
    for (const kind of ["pointerenter", "pointerover", "pointermove", "mouseover", "focus", "click"]) {
      each.dispatchEvent(new MouseEvent(kind, { bubbles: true, clientX: 5, clientY: 5 }));
    }
  }
}"""
MARKUP = "(found) => found.map((each) => each.outerHTML.slice(0, 200))"
SHOWN = """() => {
  const words = document.body.cloneNode(true);
  for (const each of words.querySelectorAll("script, style, noscript")) each.remove();
  return words.textContent;
}"""


def check(page: Page, path: Path) -> str:
    """Opens a file, uses all that is there to be used, and holds it to be silent, alone and without an element that the
    names made. Returns its words."""
    noises: list[str] = []
    requests: list[str] = []
    page.on("dialog", lambda dialog: (noises.append(dialog.message), dialog.dismiss()))
    page.on("pageerror", lambda error: noises.append(str(error)))
    page.on("console", lambda message: noises.append(message.text))
    page.on("request", lambda request: requests.append(request.url))
    page.add_init_script(WATCH)
    page.goto(path.as_uri())
    if "data-ready" in path.read_text(encoding="utf-8"):
        page.wait_for_selector("html[data-ready]", state="attached")
    page.evaluate(WALK)
    page.wait_for_timeout(200)
    found = {
        "ran": page.evaluate("window.hits"),
        "made": page.locator(MADE).evaluate_all(MARKUP),
        "complained": noises,
        "asked for": [
            url for url in requests if url.split("#")[0] != path.as_uri() and not url.startswith(("blob:", "data:"))
        ],
    }
    assert not any(found.values()), found
    shown: str = page.evaluate(SHOWN)
    return shown
