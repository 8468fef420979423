"""Draws the exact reference of each scene as scenes/pictures/NAME.png, in sRGB, three screen pixels a pixel.

Run: .venv/bin/python scenes/make_pictures.py
"""

from pathlib import Path

import numpy as np
import OpenImageIO as oiio

HERE = Path(__file__).parent
ZOOM = 3


def main() -> None:
    for scene in sorted(HERE.glob("*.toml")):
        (reference,) = (HERE.parent / "reference" / scene.stem).glob("*-box.exr")
        linear = np.clip(oiio.ImageBuf(str(reference)).get_pixels(oiio.FLOAT), 0.0, 1.0)
        # IEC 61966-2-1
        srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
        large = np.repeat(np.repeat(srgb, ZOOM, axis=0), ZOOM, axis=1).astype(np.float32)
        picture = oiio.ImageBuf(np.ascontiguousarray(large))
        picture.set_write_format(oiio.UINT8)
        target = HERE / "pictures" / f"{scene.stem}.png"
        target.parent.mkdir(exist_ok=True)
        if not picture.write(str(target)):
            raise SystemExit(picture.geterror())


if __name__ == "__main__":
    main()
