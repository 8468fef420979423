"""Pictures that commands are given: EXR, PNG, PFM, TIFF, JPEG, HDR. The first byte says what the file is called; what
it is OpenImageIO looks for itself."""

from __future__ import annotations

import fuzzing

with fuzzing.counted(__name__):
    import numpy as np

    from aliascope import image
    from aliascope.errors import AliascopeError
    from aliascope.studies import error_maps

ENDINGS = ("exr", "png", "pfm", "tif", "jpg", "hdr")


def one_input(data: bytes) -> None:
    kind = data[0] % len(ENDINGS) if data else 0
    path = fuzzing.written(f"p.{ENDINGS[kind]}", data[1:])
    for read in (image.read_image, image.read_header, image.read_counts, error_maps.describe):
        try:
            found = read(path)
        except AliascopeError as error:
            fuzzing.refused(error, path.name)
            continue
        if isinstance(found, np.ndarray):
            assert found.ndim in (2, 3)
            assert found.size


if __name__ == "__main__":
    fuzzing.main(one_input)
