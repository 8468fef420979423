"""Files of points: text, or .npy. The first byte says which."""

from __future__ import annotations

import fuzzing

with fuzzing.counted(__name__):
    import numpy as np

    from aliascope.errors import AliascopeError
    from aliascope.studies import point_files


def one_input(data: bytes) -> None:
    path = fuzzing.written("p.npy" if data[:1] == b"n" else "p.txt", data[1:])
    try:
        points = point_files.read_points(str(path))
    except AliascopeError as error:
        fuzzing.refused(error, path.name)
        return
    assert points.ndim == 2
    assert points.size
    assert points.dtype == np.float64
    assert points.flags.c_contiguous
    assert bool(((points >= 0.0) & (points <= 1.0)).all())


if __name__ == "__main__":
    fuzzing.main(one_input)
