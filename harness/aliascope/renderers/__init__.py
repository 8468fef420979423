"""The renderers there are. Each of ours is one file, and one line here; its library is loaded only when it renders.

Others come from TOML files (`external`), by their path, and from packages that have an entry point of the group GROUP,
by its name: an object that is a `base.Renderer`, or a function without arguments that makes one. They are loaded when
they are first asked for, and stand in RENDERERS from then on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import EntryPoint, entry_points

from aliascope import at_start
from aliascope.errors import InvalidInput, NotAvailable, near_misses
from aliascope.renderers import embree, external, osmesa, povray
from aliascope.renderers.base import DIMENSIONS, Renderer
from aliascope.specs import Spec, join, parse, split

GROUP = "aliascope.renderers"

BUILT_IN: Mapping[str, Renderer] = {
    renderer.name: renderer for renderer in (embree.RENDERER, povray.RENDERER, osmesa.RENDERER)
}
MEMBERS = (
    *("name", "title", "modes", "draws", "native", "probe_mode", "single_mode", "shifts", "absent"),
    *("versions", "unable", "seeded", "render"),
)
"""What a renderer has: see `base.Renderer`."""

RENDERERS: dict[str, Renderer] = dict(BUILT_IN)
"""By name: ours, and those of others that were asked for."""


def find(name: str) -> Renderer:
    """The renderer of a name, or of a TOML file's path. Raises InvalidInput with the near misses, and NotAvailable for
    one of another package that does not load."""
    if is_path(name):
        return add(name)
    if name in RENDERERS:
        return RENDERERS[name]
    others = plugged_in()
    if name not in others:
        raise InvalidInput(f'unknown renderer "{name}"{near_misses(name, [*RENDERERS, *others])}')
    RENDERERS[name] = _loaded(others[name])
    return RENDERERS[name]


def is_path(name: str) -> bool:
    """Whether a word for a renderer is the path of a TOML file: it has a slash, or the ending."""
    return "/" in name or name.endswith(".toml")


def add(path: str) -> Renderer:
    """Adds the renderer that a TOML file describes, here and in workers that start from now on. Raises InvalidInput,
    also where another has its name."""
    made = external.load(path)
    known = RENDERERS.get(made.name)
    if isinstance(known, external.External) and known.path.resolve() == made.path.resolve():
        return known
    if known is not None or made.name in plugged_in():
        raise InvalidInput(f'{path}: a renderer is named "{made.name}" already: choose another name')
    RENDERERS[made.name] = made
    at_start.add(f"renderer {made.name}", add, str(made.path.absolute()))
    return made


def word_of(name: str) -> str:
    """What names a renderer on a command line: its file, where it has one."""
    found = RENDERERS.get(name)
    return str(found.path) if isinstance(found, external.External) else name


def named(words: Sequence[str]) -> list[str]:
    """Words for renderers, as on a command line, with those of others made known: a path by its renderer's name."""
    return [find(word).name if is_path(word) or word in plugged_in() else word for word in words]


def plugged_in() -> dict[str, EntryPoint]:
    """The entry points of other packages by name; of two with one name, or of ours, the first."""
    found: dict[str, EntryPoint] = {}
    for point in entry_points(group=GROUP):
        if point.name not in BUILT_IN:
            found.setdefault(point.name, point)
    return found


def _loaded(point: EntryPoint) -> Renderer:
    """Whatever its package does, the reason why it does not load is a sentence."""
    where = f'the renderer "{point.name}" ({point.value})'
    try:
        made = point.load()
        if callable(made) and not hasattr(made, "modes"):
            made = made()
    except Exception as error:  # what a package raises when it is loaded is anything
        reason = " ".join(str(error).split())[:200] or "no reason given"
        raise NotAvailable(f"{where} does not load: {type(error).__name__}: {reason}") from error
    missing = [member for member in MEMBERS if not hasattr(made, member)]
    if missing:
        raise NotAvailable(f"{where} is no renderer: it has no {', '.join(missing)}")
    if made.name != point.name:
        raise NotAvailable(f'{where} calls itself "{made.name}": it is known by its entry point\'s name')
    renderer: Renderer = made
    return renderer


def of_profile(renderer: Renderer, profile: str) -> tuple[str, ...]:
    """The modes of a profile that a renderer which is none of ours has itself; its probe's where it has none."""
    own: Mapping[str, tuple[str, ...]] = getattr(renderer, "profiles", {})
    return tuple(own.get(profile, (renderer.probe_mode,)))


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
