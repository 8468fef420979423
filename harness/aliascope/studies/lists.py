"""`aliascope list`: what is registered, as it would stand in a spec."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from aliascope import integrands, metrics, scene_io
from aliascope.errors import NotAvailable
from aliascope.native import discrepancy, estimate, filters, samplers
from aliascope.renderers import RENDERERS
from aliascope.specs import Key

Entries = list[dict[str, Any]]


def _scenes() -> Entries:
    return [scene_io.describe(scene_io.load(name)) for name in scene_io.names()]


def _renderers() -> Entries:
    found: Entries = []
    for renderer in RENDERERS.values():
        try:
            state = ", ".join(f"{name} {version}" for name, version in renderer.versions().items())
        except NotAvailable as error:
            state = f"not there: {error}"
        found.append({"name": renderer.name, "title": renderer.title, "version": state})
    return found


def _key(key: Key) -> str:
    values = "|".join(key.choices) if key.choices else "spec" if key.kind == "spec" else _interval(key)
    return f"{key.name}={values}: {key.text} (default {key.default})"


def _interval(key: Key) -> str:
    return f"{key.minimum:g}..{key.maximum:g}"


def _modes() -> Entries:
    return [
        {"renderer": renderer.name, "name": form.name, "text": form.text, "keys": [_key(key) for key in form.keys]}
        for renderer in RENDERERS.values()
        for form in renderer.modes.values()
    ]


def _samplers() -> Entries:
    return [
        {"name": info.name, "title": info.title, "source": info.source, "keys": list(info.parameters)}
        for info in samplers.registered()
    ]


def _measures() -> Entries:
    return [
        {"name": info.name, "title": info.title, "source": info.source, "keys": list(info.parameters)}
        for info in discrepancy.registered()
    ]


def _metrics() -> Entries:
    return [
        {"name": name, "text": (metric.__doc__ or "").strip().splitlines()[0]}
        for name, metric in metrics.METRICS.items()
    ]


def _filters() -> Entries:
    return [
        {"name": info.name, "title": info.title, "source": info.source, "keys": list(info.parameters)}
        for info in filters.registered()
    ]


def _estimators() -> Entries:
    return [
        {"name": info.name, "title": info.title, "source": info.source, "keys": list(info.parameters)}
        for info in estimate.registered()
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
    "samplers": _samplers,
    "measures": _measures,
    "filters": _filters,
    "metrics": _metrics,
    "integrands": _integrands,
    "estimators": _estimators,
}
