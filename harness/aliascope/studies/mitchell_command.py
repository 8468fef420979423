"""What `aliascope mitchell` was asked for, and what it answers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aliascope.errors import InvalidInput, near_misses
from aliascope.studies import mitchell, mitchell_search, mitchell_text, realisations
from aliascope.studies.mitchell import Options, Table
from aliascope.studies.mitchell_hardware import hardware_table
from aliascope.studies.mitchell_samplers import samplers_table
from aliascope.studies.mitchell_search import Combination
from aliascope.studies.progress import progress_bar

TABLES = ("lecture", "samplers", "hardware")


@dataclass(frozen=True)
class Asked:
    """The options of the command. None: not said."""

    table: str = "lecture"
    realisations: int | None = None
    half_count: bool = False
    columns: tuple[str, ...] = ()
    search: bool = False
    seed: int = 0
    threads: int | None = None
    out: Path | None = None

    def check(self) -> None:
        """Raises InvalidInput for options that are not there, or do not go together."""
        if self.table not in TABLES:
            raise InvalidInput(f'--table "{self.table}" is none{near_misses(self.table, TABLES)}')
        fixed = self.table == "hardware"
        for wrong, text in (
            (self.search and self.table != "lecture", "--search is about the lecture's table; leave --table out"),
            (self.search and self.half_count, "--search tries both; leave --half-count out"),
            (self.search and bool(self.columns), "--search has statistics of its own; leave --column out"),
            (fixed and self.realisations is not None, "--table hardware has fixed sets, of one realisation each"),
        ):
            if wrong:
                raise InvalidInput(text)


def answer(asked: Asked) -> TableAnswer | SearchAnswer:
    """Measures what was asked for. Raises InvalidInput, SpecError."""
    asked.check()
    threads = asked.threads or realisations.workers()
    columns = mitchell.columns_of(asked.columns)
    options = Options(asked.realisations, asked.half_count, columns, asked.seed, threads)
    with progress_bar() as tell:
        if asked.search:
            found = mitchell_search.search(asked.realisations, asked.seed, threads, tell)
            return SearchAnswer(tuple(found), asked)
        if asked.table == "hardware":
            return TableAnswer(hardware_table(options))
        make = mitchell.lecture_table if asked.table == "lecture" else samplers_table
        return TableAnswer(make(options, tell))


@dataclass(frozen=True)
class TableAnswer:
    """A table."""

    table: Table

    def document(self) -> dict[str, Any]:
        """What --json prints."""
        said = {name.lower(): text for name, text in mitchell_text.notes(self.table)}
        return {**mitchell.document(self.table), "notes": said}

    def lines(self) -> list[str]:
        """The table as text."""
        return mitchell_text.lines(self.table)

    def write(self, folder: Path) -> list[Path]:
        """Writes the page and what lies beside it; the paths, the page first. Raises NotWritable."""
        from aliascope.studies.mitchell_files import write_table  # draws, which takes a while to load

        return write_table(folder, self.table, self.document())


@dataclass(frozen=True)
class SearchAnswer:
    """What a search came to, the nearest first."""

    combinations: Sequence[Combination]
    asked: Asked

    def document(self) -> dict[str, Any]:
        """What --json prints."""
        return mitchell_search.document(self.combinations, self.asked.realisations, self.asked.seed)

    def lines(self) -> list[str]:
        """The search as text."""
        return mitchell_search.lines(self.combinations, self.asked.realisations)

    def write(self, folder: Path) -> list[Path]:
        """Writes search.json and search.csv, a row a combination. Raises NotWritable."""
        from aliascope.studies.mitchell_files import write_search

        return write_search(folder, self.combinations, self.document())
