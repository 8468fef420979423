"""Meshes: OBJ, PLY, STL, OFF and GLB. The first byte says which."""

from __future__ import annotations

import fuzzing

with fuzzing.counted(__name__):
    import numpy as np
    import trimesh  # noqa: F401  (else it would be loaded by the first input)

    from aliascope import meshes
    from aliascope.errors import AliascopeError


def one_input(data: bytes) -> None:
    kind = data[0] % len(meshes.ENDINGS) if data else 0
    path = fuzzing.written(f"m{meshes.ENDINGS[kind]}", data[1:])
    try:
        _, triangles = meshes.load(path)
    except AliascopeError as error:
        fuzzing.refused(error, path.name)
        return
    assert triangles.shape[1:] == (3, 3)
    assert len(triangles)
    assert bool(np.isfinite(triangles).all())


if __name__ == "__main__":
    fuzzing.main(one_input)
