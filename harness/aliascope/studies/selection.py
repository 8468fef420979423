"""From the words of the command line to a plan: which scenes, renderers and modes."""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from aliascope import jobs, plan, renderers, scene_io
from aliascope.errors import InvalidInput, SpecError, near_misses
from aliascope.jobs import Plan
from aliascope.model import Scene
from aliascope.native import samplers
from aliascope.renderers.base import DIMENSIONS
from aliascope.scene_io import SceneFile
from aliascope.specs import Spec, join, label, spelled_out, split

WILDCARDS = frozenset("*?[")


def plan_of(
    scenes: Sequence[str],
    chosen: Sequence[str],
    modes: Sequence[str],
    profile: str,
    size: tuple[int, int] | None,
    arrangements: Sequence[str] = (),
) -> Plan:
    """The plan of `aliascope compare`. Nothing named means all; renderers named must be there. Modes that take an
    arrangement of dimensions and say none have each of these."""
    plugged_in = [info.name for info in samplers.registered() if info.plugged_in]
    own = plan.with_samplers(plan.profile(profile), plugged_in)
    chosen = renderers.named(chosen)
    names = plan.matching(chosen, renderers.RENDERERS, "renderer") if chosen else list(own)
    wanted = {name: list(own[name] if name in own else _own_modes(name, profile)) for name in names}
    if modes:
        wanted = _modes(wanted, modes)
    if arrangements:
        wanted = {name: _arranged(name, found, arrangements) for name, found in wanted.items()}
    files = [scene_io.load(name) for name in scenes_of(scenes)]
    check_names(files)
    # Modes that were named are for all scenes: a cell that one of them cannot fill says why.
    suits = None if modes else _suits(profile)
    made = jobs.make_plan(files, wanted, plan.SEEDS[profile], size, required=chosen, suits=suits)
    return replace(made, about=_about(profile, [file.name for file in files], own, wanted))


def _own_modes(name: str, profile: str) -> tuple[str, ...]:
    return renderers.of_profile(renderers.find(name), profile)


def _suits(profile: str) -> Callable[[str, Spec, Scene], bool]:
    """Whether a mode of a profile, however its dimensions are arranged, is one for a kind of scene."""
    canonical = {
        name: {
            kind: {renderers.mode_of(renderers.find(name), mode).text for mode in modes}
            for kind, modes in kinds.items()
        }
        for name, kinds in plan.KINDS[profile].items()
    }

    def suits(renderer: str, spec: Spec, scene: Scene) -> bool:
        kinds = canonical.get(renderer, {})
        name, pairs = split(spec.text)
        pairs.pop(DIMENSIONS.name, None)
        text = join(name, pairs)
        return text in kinds.get(plan.kind_of(scene), ()) or not any(text in modes for modes in kinds.values())

    return suits


def check_names(files: Sequence[SceneFile]) -> None:
    """Raises InvalidInput where two scenes would stand under one name."""
    twice = {file.name for file in files if sum(other.name == file.name for other in files) > 1}
    if twice:
        raise InvalidInput(f"two scenes are named {', '.join(sorted(twice))}: rename one of the files")


def _about(
    profile: str, scenes: Sequence[str], own: Mapping[str, Sequence[str]], wanted: Mapping[str, Sequence[str]]
) -> str:
    """What was taken of a profile: "quick profile" for all of it, else what was chosen too."""

    def canonical(modes: Mapping[str, Sequence[str]]) -> set[tuple[str, str]]:
        return {(name, renderers.mode_of(renderers.find(name), mode).text) for name in modes for mode in modes[name]}

    chosen = [] if sorted(scenes) == scene_io.names() else ["scenes"]
    chosen += [] if canonical(wanted) == canonical(own) else ["modes"]
    return f"{profile} profile" + (f", chosen {' and '.join(chosen)}" if chosen else "")


def scenes_of(patterns: Sequence[str]) -> list[str]:
    """The scenes that patterns name, and paths as they are; all of ours for nothing. Raises InvalidInput."""
    paths = [pattern for pattern in patterns if scene_io.is_path(pattern)]
    named = [pattern for pattern in patterns if pattern not in paths]
    own = plan.matching(named, scene_io.names(), "scene") if named else [] if paths else scene_io.names()
    return [*own, *paths]


def _modes(profile: dict[str, list[str]], modes: Sequence[str]) -> dict[str, list[str]]:
    """Modes with a wildcard choose among the profile's; others are specs of those renderers that have their name.

    A mode of the profile is chosen by each way to write it: the profile's, the canonical one, with its defaults, for
    people.
    """
    wanted: dict[str, list[str]] = {name: [] for name in profile}
    for mode in modes:
        hits = {name: _hits(name, mode, own) for name, own in profile.items()}
        if not any(hits.values()):
            known = [form for name in profile for form in renderers.find(name).modes]
            raise SpecError(f'no mode "{mode}" of {", ".join(profile)}{near_misses(mode.partition(":")[0], known)}')
        for name, found in hits.items():
            wanted[name] += found
    return {name: found for name, found in wanted.items() if found}


def _arranged(renderer: str, modes: Sequence[str], arrangements: Sequence[str]) -> list[str]:
    found = renderers.find(renderer)
    made = (renderers.arranged(found, mode, arrangement) for arrangement in arrangements for mode in modes)
    return list(dict.fromkeys(made))


def _hits(renderer: str, mode: str, own: Sequence[str]) -> list[str]:
    found = renderers.find(renderer)
    if WILDCARDS & set(mode):
        specs = {each: renderers.mode_of(found, each) for each in own}
        return [
            spec.text
            for each, spec in specs.items()
            if fnmatch.filter([each, spec.text, spelled_out(spec), label(spec)], mode)
        ]
    return [mode] if split(mode)[0] in found.modes else []
