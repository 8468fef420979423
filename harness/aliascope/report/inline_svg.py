"""Plots as part of a page: in the colours of its theme, without names that another plot has."""

from __future__ import annotations

import re
from collections.abc import Mapping

INK, SOFT, RULE, PAPER = "#16181b", "#5a6067", "#d9d9d3", "#ffffff"
"""Of text, ticks, grid and ground. In a page they change with its theme."""
_THEMED: Mapping[str, str] = {INK: "var(--ink)", SOFT: "var(--soft)", RULE: "var(--rule)", PAPER: "var(--paper)"}


def inline(svg: str, name: str) -> str:
    """The <svg> element of a plot; `name` begins its ids. The element with the id NAME-title says what it shows."""
    body = svg[svg.index("<svg") :]
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    body = re.sub(r'\b(id="|xlink:href="#|url\(#)', rf"\g<1>{name}-", body)
    for colour, variable in _THEMED.items():
        body = body.replace(colour, variable)
    opening = rf'<svg xmlns:xlink="http://www.w3.org/1999/xlink" \1 role="img" aria-labelledby="{name}-title">'
    return re.sub(r'<svg [^>]*?(viewBox="[^"]*")[^>]*>', opening, body, count=1)
