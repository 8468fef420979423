"""The commands that a regression run tells its user: to run a cell again alone, to bless it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from aliascope import places, sharing
from aliascope.regression.records import CellName

REASON = "why this is right"
"""What stands in a command where the user is to say it."""


@dataclass(frozen=True)
class Setting:
    """What the commands of a run have in common: the folder of references, where it is not the project's; options as
    they were given (`--trust-plugin F.so`, `--time-limit S`), words for the shell; what names a renderer there, where
    that is not its name but its file."""

    references: Path = places.REFERENCES
    options: tuple[str, ...] = ()
    renderers: Mapping[str, str] = field(default_factory=dict)


def again(name: CellName, scene: str = "", setting: Setting | None = None) -> str:
    """Runs a cell alone. `scene`: what the command line calls it, the path of a file, where that is not its name."""
    return sharing.command_line(_words(name, scene, setting or Setting()))


def bless(name: CellName, scene: str = "", setting: Setting | None = None, pattern: str = "") -> str:
    """Blesses a cell as it renders now, or all of its scene that a pattern matches."""
    setting = setting or Setting()
    word = setting.renderers.get(name.renderer, name.renderer)
    known = [] if word == name.renderer else ["-r", word]  # of a file that is not named nothing matches
    words = [*_of_scene(name, scene, setting), *known] if pattern else _words(name, scene, setting)
    return sharing.command_line([*words, "--bless", pattern or name.text, "--reason", REASON])


def reference(scene: str, filter_: str, setting: Setting | None = None) -> str:
    """Makes the reference that cells are compared with. `scene` as the command line calls it."""
    folder = (setting or Setting()).references
    words = ["aliascope", "reference", scene, *([] if filter_ == "box" else ["--filter", filter_])]
    return sharing.command_line([*words, *([] if folder == places.REFERENCES else ["-o", str(folder)])])


def _words(name: CellName, scene: str, setting: Setting) -> Sequence[str]:
    return [
        *_of_scene(name, scene, setting),
        "-r",
        setting.renderers.get(name.renderer, name.renderer),
        "-m",
        name.mode,
    ]


def _of_scene(name: CellName, scene: str, setting: Setting) -> Sequence[str]:
    elsewhere = [] if setting.references == places.REFERENCES else ["--references", str(setting.references)]
    return ["aliascope", "regress", scene or name.scene, *elsewhere, *setting.options]
