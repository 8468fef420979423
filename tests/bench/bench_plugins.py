"""What it costs that a plugin runs in a process of its own: time of a picture by --plugin over that by --trust-plugin,
in turn, on two scenes. Of the plugin that is named, a sampler called kronecker."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

SIZE = "320x240"
SCENES = ("edge", "spheres")
SAMPLES = (1, 4, 16, 64, 256)
ROUNDS = 5


def seconds(option: str, plugin: str, scene: str, n: int) -> float:
    """On the wall, of one picture, without what comes before it."""
    mode = f"uniform:n={n},sampler=kronecker"
    with tempfile.TemporaryDirectory() as folder:
        words = [
            "render",
            scene,
            "-r",
            "embree",
            "-m",
            mode,
            "--size",
            SIZE,
            "-o",
            str(Path(folder, "o.exr")),
            "--json",
        ]
        command = [sys.executable, "-m", "aliascope.cli", option, plugin, *words]
        said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return float(json.loads(said)["wall_seconds"])


def main() -> None:
    plugin = sys.argv[1]
    print(f"a plugin in a process of its own: time over that of one that is trusted, median of {ROUNDS} pairs; {SIZE}")
    for scene in SCENES:
        for n in SAMPLES:
            pairs = [
                [seconds(each, plugin, scene, n) for each in ("--plugin", "--trust-plugin")] for _ in range(ROUNDS)
            ]
            ratios = sorted(apart / inside for apart, inside in pairs)
            more = statistics.median(apart - inside for apart, inside in pairs)
            ratio = f"{statistics.median(ratios):5.2f} [{ratios[0]:.2f}, {ratios[-1]:.2f}]"
            print(f"  {scene:10}{n:4} samples a pixel  {ratio}  {1e3 * more:6.1f} ms more")


if __name__ == "__main__":
    main()
