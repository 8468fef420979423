"""Scenes in TOML, beside a mesh that they may name."""

from __future__ import annotations

import fuzzing

with fuzzing.counted(__name__):
    from aliascope import scene_io
    from aliascope.errors import AliascopeError

MESH = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def one_input(data: bytes) -> None:
    fuzzing.written("m.obj", MESH)
    path = fuzzing.written("s.toml", data)
    try:
        file = scene_io.load_file(path)
    except AliascopeError as error:
        fuzzing.refused(error, path.name)
        return
    assert file.name == "s"
    scene_io.describe(file)


if __name__ == "__main__":
    fuzzing.main(one_input)
