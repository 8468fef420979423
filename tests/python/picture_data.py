"""Pictures of all kinds that the report packs: lit materials, edges, steps, noise, any bits."""

from __future__ import annotations

import numpy as np

from aliascope.records import Pixels

HEIGHT, WIDTH = 40, 48
STEP = 1.0 / 65535.0


def lit(seed: int, noise: float = 0.02) -> Pixels:
    """Three materials under two lamps of different colours, on a flat background, each pixel with its own light. The
    second lamp does not shine on all."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    pixels = np.empty((HEIGHT, WIDTH, 3))
    pixels[:] = [0.0619, 0.0737, 0.0971]
    albedos = ([0.8419, 0.3173, 0.2347], [0.3391, 0.6217, 0.2873], [0.4337, 0.5119, 0.6871])
    lamps = np.array([[0.9, 0.8, 0.7], [0.1, 0.25, 0.5]])
    for i, albedo in enumerate(albedos):
        inside = np.hypot(x - 10 - 14 * i, y - 20) < 7.5
        shines = (x + y > 40) & (i > 0)
        first, second = rng.normal(0.0, noise, (2, HEIGHT, WIDTH))
        light = np.stack([0.2 + x / WIDTH + first, shines * (0.1 + y / HEIGHT + second)], axis=2)
        pixels[inside] = (0.02 + np.array(albedo) * (light @ lamps))[inside]
    return pixels.astype(np.float32)


def stepped(seed: int) -> Pixels:
    """The same in steps of 1 / 65535, as a renderer writes whole numbers."""
    whole = np.round(lit(seed).astype(np.float64) / STEP)
    return (whole * np.float64(np.float32(STEP))).astype(np.float32)


def odd() -> Pixels:
    """NaNs with payloads, infinities, both zeros, negative and very large values, in the midst of a picture."""
    pixels = lit(5)
    bits = pixels.view(np.uint32)
    bits[3, :8, 1] = [0x7FC00001, 0xFFC12345, 0x7F800000, 0xFF800000, 0x80000000, 0, 0x7F7FFFFF, 0x7F800001]
    bits[20, 5:9] = 0x7FC00000
    bits[21, 5:9, 0] = 0x00000001
    pixels[22, 5:9] = -0.25
    return pixels
