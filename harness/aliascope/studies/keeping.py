"""`aliascope cache`: what there is on disk that can be made again, and what of a folder of results nobody needs."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from aliascope import caches, scratch
from aliascope.caches import Usage
from aliascope.errors import InvalidInput
from aliascope.folder_lock import locked
from aliascope.pipeline import counts_path
from aliascope.store import Store

FONTS, SCRATCH, ALL = "fonts", "scratch", "all"
NAMES = (*caches.KNOWN, FONTS, SCRATCH)


@dataclass(frozen=True)
class Entry:
    """A cache: where, what there is, what it is for, and how large it may grow, in words."""

    name: str
    path: str
    usage: Usage
    about: str
    limit: str


@dataclass(frozen=True)
class Results:
    """The pictures of a folder of results, and what of them can go: those that no row of the database names, and those
    of rows that a later run has made anew, by other code or of another version of the scene."""

    folder: Path
    pictures: Usage
    unnamed: Usage
    outdated: Usage
    rows: int
    pruned: bool


def entries() -> list[Entry]:
    """All caches."""
    whole = f"{caches.told(caches.limit())} for all, out with what was used longest ago"
    own = [
        Entry(name, str(caches.folder(name)), caches.usage(name), about, whole) for name, about in caches.KNOWN.items()
    ]
    fonts = _fonts()
    where = str(Path(tempfile.gettempdir()) / f"{scratch.PREFIX}*")
    return [
        *own,
        Entry(FONTS, str(_font_folder()), _usage(fonts), "matplotlib's list of fonts, for plots", "a file a version"),
        Entry(
            SCRATCH, where, _usage(_scratch()), "of renderers that run", "goes with the next run, once it is no one's"
        ),
    ]


def empty(names: Sequence[str]) -> Usage:
    """Removes what is in these caches, in all of them for "all". Raises InvalidInput for a name that is none."""
    chosen = list(dict.fromkeys(NAMES if ALL in names else names))
    for name in chosen:
        if name not in NAMES:
            raise InvalidInput(f'there is no cache "{name}"; known: {", ".join((*NAMES, ALL))}')
    removed = caches.empty([name for name in chosen if name in caches.KNOWN])
    for name, files in ((FONTS, _fonts), (SCRATCH, _scratch)):
        if name in chosen:
            before = _usage(files())
            if name == SCRATCH:
                scratch.remove_abandoned()
            else:
                for path in files():
                    path.unlink(missing_ok=True)
            after = _usage(files())
            removed = Usage(removed.files + before.files - after.files, removed.size + before.size - after.size)
    return removed


def results(folder: Path, prune: bool) -> Results:
    """What of a folder of results can go; with `prune` it is removed, when nobody else writes there.

    Raises InvalidInput for a folder without results of compare or knobs, NotWritable where another process has it.
    """
    if not (folder / "results.sqlite").is_file():
        raise InvalidInput(f"{folder}: has no results.sqlite, as compare and knobs write it: there is nothing to prune")
    with locked(folder), Store(folder / "results.sqlite") as store:
        there = {path.relative_to(folder).as_posix() for path in (folder / "images").glob("**/*.exr")}
        outdated_rows = store.outdated()
        kept = _files_of(store.images(but=outdated_rows))
        outdated = _files_of(outdated_rows.values()) & there - kept
        unnamed = there - kept - outdated
        found = Results(
            folder,
            _usage([folder / path for path in sorted(there)]),
            _usage([folder / path for path in sorted(unnamed)]),
            _usage([folder / path for path in sorted(outdated)]),
            len(outdated_rows),
            prune,
        )
        if prune:
            # The rows first: what is killed in between leaves pictures without one, which the next time goes.
            store.remove(outdated_rows, unnamed | outdated)
            for path in sorted(unnamed | outdated):
                (folder / path).unlink(missing_ok=True)
    return found


def lines(found: Sequence[Entry]) -> list[str]:
    """For people."""
    told = [f"all of aliascope's own in {caches.root()} (set {caches.VARIABLE} for another folder)"]
    for each in found:
        told.append(f"{each.name}: {_amount(each.usage)}; {each.about}")
        told += [f"  {each.path}", f"  limit: {each.limit}"]
    told.append(
        "results of commands (-o DIR) are yours, and nothing removes them: aliascope cache DIR says what could go"
    )
    return told


def result_lines(found: Results) -> list[str]:
    """For people."""
    verb = "removed" if found.pruned else "could go"
    rows = f"{found.rows} row{'' if found.rows == 1 else 's'}"
    told = [
        f"{found.folder}: {_amount(found.pictures)} of pictures",
        f"  {verb}: {_amount(found.unnamed)} that no row of results.sqlite names",
        f"  {verb}: {_amount(found.outdated)} of {rows} that a later run has made anew",
    ]
    more = found.unnamed.files or found.rows
    return told if found.pruned or not more else [*told, "  with --prune they go"]


def removed_line(removed: Usage) -> str:
    """For people."""
    return f"removed {_amount(removed)}"


def document(found: Sequence[Entry], of: Results | None, removed: Usage | None) -> dict[str, Any]:
    """For --json."""
    return {
        "folder": str(caches.root()),
        "limit": caches.limit(),
        "caches": [{**asdict(each), "usage": asdict(each.usage)} for each in found],
        "removed": None if removed is None else asdict(removed),
        "results": None if of is None else {**asdict(of), "folder": str(of.folder)},
    }


def _amount(usage: Usage) -> str:
    return f"{usage.files} file{'' if usage.files == 1 else 's'}, {caches.told(usage.size)}"


def _files_of(images: Any) -> set[str]:
    """Pictures, each with its counts, whether there are any or not."""
    return {path for each in images if each for path in (each, counts_path(each))}


def _usage(paths: Sequence[Path]) -> Usage:
    sizes = []
    for path in paths:
        try:
            sizes.append(path.lstat().st_size)
        except OSError:  # gone in between
            continue
    return Usage(len(sizes), sum(sizes))


def _font_folder() -> Path:
    import matplotlib

    return Path(matplotlib.get_cachedir())


def _fonts() -> list[Path]:
    return sorted(_font_folder().glob("fontlist-*.json"))


def _scratch() -> list[Path]:
    folders = Path(tempfile.gettempdir()).glob(f"{scratch.PREFIX}*")
    return sorted(path for folder in folders for path in folder.rglob("*") if path.is_file())
