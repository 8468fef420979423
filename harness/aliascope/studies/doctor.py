"""`aliascope doctor`: what is installed, and the conventions of each renderer, measured rather than believed."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from aliascope import landlock, places, renderers, seccomp
from aliascope.errors import AliascopeError, NotAvailable
from aliascope.native import plugin_fence
from aliascope.renderers import confinement
from aliascope.renderers.base import Renderer, Request
from aliascope.studies import doctor_embree, doctor_osmesa, doctor_povray
from aliascope.studies.doctor_charts import Edges, Star
from aliascope.studies.doctor_findings import Inquiry, Tell, answers
from aliascope.studies.doctor_general import centres, float32_step, levels, repeats
from aliascope.studies.probes import LIMITS, measure_named
from aliascope.workers import Workers

OWN: Mapping[str, Callable[[], list[Inquiry]]] = {
    each.NAME: each.inquiries for each in (doctor_embree, doctor_povray, doctor_osmesa)
}
"""The inquiries of the renderers that have some of their own."""

WIDTH = 100
"""Columns of the text."""


def inquiries_of(renderer: Renderer) -> list[Inquiry]:
    """What is asked of a renderer; of one that is not known by name, what its single and its probe mode can tell."""
    if renderer.name in OWN:
        return OWN[renderer.name]()
    modes = (renderer.single_mode, renderer.probe_mode)
    return [
        centres(renderer.name, dict.fromkeys(modes, Edges())),
        *levels(renderer.name, renderer.single_mode, {"float32": (1.0, float32_step(0.7))}),
        repeats(renderer.name, dict.fromkeys(modes, Star())),
    ]


def examine(
    names: Sequence[str] = (), quick: bool = False, tell: Tell = lambda what, done, total: None
) -> dict[str, Any]:
    """The document of `aliascope doctor --json`, of these renderers or all. quick: the one picture alone that `compare`
    takes. Raises InvalidInput for a name that there is not, and NotAvailable where one that was named is not there."""
    chosen = [renderers.find(name) for name in names] if names else list(renderers.RENDERERS.values())
    with Workers(len(os.sched_getaffinity(0))) as workers:
        found = [_first(renderer, workers) for renderer in chosen]
        for entry in found:
            if names and not entry["there"]:
                raise NotAvailable(entry["reason"])
        if not quick:
            _inquire(chosen, found, workers, tell)
    protection = confinement.protection()
    return {
        "aliascope": places.own_version(),
        "revision": places.revision(),
        "machine": places.machine(),
        "confinement": {"by": protection.by, "files": protection.files, "told": protection.told},
        "plugins": {"files": bool(landlock.abi()), "reach": seccomp.works(), "told": plugin_fence.told()},
        "renderers": found,
    }


def _inquire(chosen: Sequence[Renderer], found: Sequence[dict[str, Any]], workers: Workers, tell: Tell) -> None:
    """Adds the findings on those that rendered one picture."""
    asked = {
        index: inquiries_of(chosen[index]) for index, entry in enumerate(found) if entry["there"] and "centre" in entry
    }
    answered = iter(answers([each for several in asked.values() for each in several], workers, tell))
    for index, several in asked.items():
        findings = [next(answered) for _ in several]
        found[index]["findings"] = [finding.document for finding in findings]
        found[index]["holds"] = found[index]["holds"] and not any(finding.failed for finding in findings)


def _first(renderer: Renderer, workers: Workers) -> dict[str, Any]:
    """Whether it is there, its versions, and what one picture says."""
    entry: dict[str, Any] = {"name": renderer.name, "title": renderer.title, "there": True}
    try:
        entry["versions"] = dict(renderer.versions())
        probe = workers.begin(measure_named, [renderer.name], Request.time_limit).result()
    except NotAvailable as error:
        return entry | {"there": False, "reason": str(error)}
    except AliascopeError as error:
        return entry | {"holds": False, "reason": str(error)}
    return entry | {
        "mode": probe.mode,
        "centre": list(probe.centre or ()),
        "gain": probe.gain,
        "gamma": probe.gamma,
        "deviation": probe.deviation,
        "first_look": probe.holds,
        "holds": probe.holds,
    }


# --- for people -------------------------------------------------------------------------------------------------------


def lines_of(document: Mapping[str, Any]) -> list[str]:
    """The same for people."""
    lines = [
        f"aliascope {document['aliascope']} ({document['revision']})",
        ", ".join(f"{name} {value}" for name, value in document["machine"].items()),
        *textwrap.wrap(
            f"a .pov file of somebody's is held by {document['confinement']['told']}", WIDTH, subsequent_indent="  "
        ),
        *textwrap.wrap(f"a plugin of somebody's: {document['plugins']['told']}", WIDTH, subsequent_indent="  "),
    ]
    for entry in document["renderers"]:
        lines += ["", *_of_renderer(entry)] if entry.get("findings") else _of_renderer(entry)
    return lines


def _of_renderer(entry: Mapping[str, Any]) -> Iterator[str]:
    if not entry["there"]:
        yield f"{entry['title']}: not there: {entry['reason']}"
        return
    versions = ", ".join(f"{name} {version}" for name, version in entry.get("versions", {}).items())
    yield f"{entry['title']}: {versions}"
    if "centre" not in entry:
        yield f"  does not render: {entry['reason']}"
        return
    x, y = entry["centre"]
    yield f"  pixel centres: {x:+z.4f} right, {y:+z.4f} down, in pixels ({entry['mode']})"
    yield (f"  response: gain {entry['gain']:.5f}, gamma {entry['gamma']:.5f}; linear within {entry['deviation']:.1e}")
    for finding in entry.get("findings", ()):
        yield from _of_finding(finding)
    failed = [finding["name"] for finding in entry.get("findings", ()) if finding["needed"] and not finding["holds"]]
    if entry["holds"]:
        yield "  pictures can be compared"
    else:
        why = (
            []
            if entry["first_look"]
            else [f"centres must lie within {LIMITS.centre} pixel, the response within {LIMITS.response}"]
        )
        yield f"  PICTURES CANNOT BE COMPARED: {'; '.join([*why, *(f'{name} deviates' for name in failed)])}"


def _of_finding(finding: Mapping[str, Any]) -> Iterator[str]:
    """Its name and how it stands; what was measured, mode by mode; what was expected; what it means."""
    yield f"  {finding['name']}: {finding['status']}"
    figures = finding["figures"]
    labels = max((len(figure["label"]) for figure in figures), default=0)
    beside = all("\n" not in figure["text"] and 6 + labels + len(figure["text"]) <= WIDTH for figure in figures)
    for figure in figures:
        if beside:
            yield f"    {figure['label']:{labels}}  {figure['text']}"
        else:
            yield f"    {figure['label']}"
            for line in figure["text"].split("\n"):
                yield from textwrap.wrap(line, WIDTH, initial_indent=" " * 8, subsequent_indent=" " * 10)
    yield from textwrap.wrap(
        f"expected: {finding['expected']}", WIDTH, initial_indent="    ", subsequent_indent=" " * 6
    )
    yield from textwrap.wrap(finding["means"], WIDTH, initial_indent="    ", subsequent_indent="    ")
