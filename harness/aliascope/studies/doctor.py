"""`aliascope doctor`: what is installed, and the conventions of each renderer, measured rather than believed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from aliascope import places, renderers
from aliascope.errors import AliascopeError, NotAvailable
from aliascope.studies.probes import LIMITS, measure


def examine() -> dict[str, Any]:
    """The document of `aliascope doctor --json`."""
    found = []
    for renderer in renderers.RENDERERS.values():
        entry: dict[str, Any] = {"name": renderer.name, "title": renderer.title, "there": True}
        try:
            entry["versions"] = dict(renderer.versions())
            probe = measure(renderer)
        except NotAvailable as error:
            entry |= {"there": False, "reason": str(error)}
        except AliascopeError as error:
            entry |= {"holds": False, "reason": str(error)}
        else:
            entry |= {
                "mode": probe.mode,
                "centre": list(probe.centre or ()),
                "gain": probe.gain,
                "gamma": probe.gamma,
                "deviation": probe.deviation,
                "holds": probe.holds,
            }
        found.append(entry)
    return {
        "aliascope": places.own_version(),
        "revision": places.revision(),
        "machine": places.machine(),
        "renderers": found,
    }


def lines_of(document: Mapping[str, Any]) -> list[str]:
    """The same for people."""
    lines = [
        f"aliascope {document['aliascope']} ({document['revision']})",
        ", ".join(f"{name} {value}" for name, value in document["machine"].items()),
    ]
    for entry in document["renderers"]:
        if not entry["there"]:
            lines.append(f"{entry['title']}: not there: {entry['reason']}")
            continue
        versions = ", ".join(f"{name} {version}" for name, version in entry.get("versions", {}).items())
        lines.append(f"{entry['title']}: {versions}")
        if "centre" not in entry:
            lines.append(f"  does not render: {entry['reason']}")
            continue
        x, y = entry["centre"]
        lines += [
            f"  pixel centres ({entry['mode']}): {x:+.4f} right, {y:+.4f} down of where they should be, in pixels",
            f"  response: gain {entry['gain']:.5f}, gamma {entry['gamma']:.5f}; linear within {entry['deviation']:.1e}",
            "  pictures can be compared"
            if entry["holds"]
            else f"  PICTURES CANNOT BE COMPARED: centres must lie within {LIMITS.centre} pixel, "
            f"the response within {LIMITS.response}",
        ]
    return lines
