"""`aliascope list`: what is registered, as it would stand in a spec."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from aliascope import integrands, metrics, renderers, scene_io
from aliascope.errors import NotAvailable
from aliascope.native import discrepancy, estimate, filters, samplers, uneven
from aliascope.specs import Key

Entries = list[dict[str, Any]]


def _scenes() -> Entries:
    return [scene_io.describe(scene_io.load(name)) for name in scene_io.names()]


def _renderers() -> Entries:
    found: Entries = []
    for name in (*renderers.RENDERERS, *(name for name in renderers.plugged_in() if name not in renderers.RENDERERS)):
        title = name
        try:
            renderer = renderers.find(name)
            title = renderer.title
            state = ", ".join(f"{what} {version}" for what, version in renderer.versions().items())
        except NotAvailable as error:
            state = f"not there: {error}"
        found.append({"name": name, "title": title, "version": state})
    return found


def _key(key: Key) -> str:
    values = "|".join(key.choices) if key.choices else "spec" if key.kind == "spec" else _interval(key)
    return f"{key.name}={values}: {key.text} (default {key.default})"


def _interval(key: Key) -> str:
    return f"{key.minimum:g}..{key.maximum:g}"


def _modes() -> Entries:
    return [
        {"renderer": renderer.name, "name": form.name, "text": form.text, "keys": [_key(key) for key in form.keys]}
        for renderer in renderers.RENDERERS.values()
        for form in renderer.modes.values()
    ]


class Registered(Protocol):
    """What the C library's registries say of each of theirs."""

    @property
    def name(self) -> str: ...
    @property
    def title(self) -> str: ...
    @property
    def source(self) -> str: ...
    @property
    def parameters(self) -> tuple[str, ...]: ...


def _of(registered: Callable[[], Sequence[Registered]]) -> Callable[[], Entries]:
    return lambda: [
        {"name": info.name, "title": info.title, "source": info.source, "keys": list(info.parameters)}
        for info in registered()
    ]


def _metrics() -> Entries:
    return [
        {"name": name, "text": (metric.__doc__ or "").strip().splitlines()[0]}
        for name, metric in metrics.METRICS.items()
    ]


def _integrands() -> Entries:
    found: Entries = []
    for kind in integrands.KINDS.values():
        least, most = kind.least_dimensions, kind.most_dimensions
        found.append(
            {
                "name": kind.name,
                "title": kind.title,
                "dimensions": f"d = {least}" if least == most else f"d = {least} to {most}",
                "smoothness": integrands.SMOOTHNESS[kind.smoothness],
                "source": kind.source,
                "keys": [_key(key) for key in kind.keys],
            }
        )
    return found


LISTS: Mapping[str, Callable[[], Entries]] = {
    "scenes": _scenes,
    "renderers": _renderers,
    "modes": _modes,
    "samplers": _of(samplers.registered),
    "measures": _of(discrepancy.registered),
    "filters": _of(filters.registered),
    "weightings": _of(uneven.registered),
    "metrics": _metrics,
    "integrands": _integrands,
    "estimators": _of(estimate.registered),
}
