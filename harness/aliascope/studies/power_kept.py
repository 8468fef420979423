"""What `make power` has rendered before, in a cache: a file for each key, the study's own alone."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aliascope import caches


@dataclass(frozen=True)
class Kept:
    """A folder of it. A key is a hash of all that the contents depend on, so what is there is right."""

    folder: Path

    def get(self, key: str) -> Any | None:
        """What is kept under a key, or None."""
        data = caches.read(self._path(key))
        try:
            return None if data is None else pickle.loads(data)
        except (pickle.UnpicklingError, EOFError):  # not what was written: it is made again
            return None

    def put(self, key: str, contents: Any) -> None:
        """Keeps it, whole or not at all. Raises NotWritable."""
        caches.write(self._path(key), pickle.dumps(contents))

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.pickle"
