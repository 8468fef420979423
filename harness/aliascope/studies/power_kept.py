"""What `make power` has rendered before, on disk: a file for each key, the study's own alone."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aliascope.errors import NotWritable


@dataclass(frozen=True)
class Kept:
    """A folder of it. A key is a hash of all that the contents depend on, so what is there is right."""

    folder: Path

    def has(self, key: str) -> bool:
        return self._path(key).is_file()

    def get(self, key: str) -> Any | None:
        """What is kept under a key, or None."""
        if not self.has(key):
            return None
        with self._path(key).open("rb") as file:
            return pickle.load(file)

    def put(self, key: str, contents: Any) -> None:
        """Keeps it, whole or not at all. Raises NotWritable."""
        path = self._path(key)
        part = path.with_suffix(".part")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with part.open("wb") as file:
                pickle.dump(contents, file)
            part.replace(path)
        except OSError as error:
            raise NotWritable(f"{path}: cannot be written: {error.strerror}") from error

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.pickle"
