"""The renderers there are. Each is one file, and one line here; its library is loaded only when it renders."""

from __future__ import annotations

from collections.abc import Mapping

from aliascope.errors import InvalidInput, near_misses
from aliascope.renderers import embree, osmesa, povray
from aliascope.renderers.base import DIMENSIONS, Renderer
from aliascope.specs import Spec, join, parse, split

RENDERERS: Mapping[str, Renderer] = {
    renderer.name: renderer for renderer in (embree.RENDERER, povray.RENDERER, osmesa.RENDERER)
}


def find(name: str) -> Renderer:
    """The renderer of a name. Raises InvalidInput with the near misses."""
    if name not in RENDERERS:
        raise InvalidInput(f'unknown renderer "{name}"{near_misses(name, RENDERERS)}')
    return RENDERERS[name]


def mode_of(renderer: Renderer, text: str) -> Spec:
    """The parsed mode of a renderer. Raises SpecError."""
    return parse(text, renderer.modes, f"mode of {renderer.name}")


def arranged(renderer: Renderer, text: str, arrangement: str) -> str:
    """The mode with this arrangement of its dimensions, where it says none of its own; as it is where it takes none.

    Raises SpecError.
    """
    name, pairs = split(text)
    key = DIMENSIONS.name
    if key in pairs or key not in mode_of(renderer, text).values:
        return text
    return mode_of(renderer, join(name, {**pairs, key: arrangement})).text
