"""Whether `aliascope sweep` recommends what the whole grid would: of each scene, the time of its settings over the best
time of the grid for an error no larger. At most 1.10 is held to be as good.

Takes .pov files, and --size WxH and --budget TIME of the sweep; the grid takes some minutes a scene at 320x240, and
both times that are compared are then taken again, in turn. For a quiet machine, with Debian's povray-examples:

    X=/usr/share/doc/povray/examples
    PYTHONPATH=$PWD/harness .venv/bin/python tests/bench/bench_sweep.py --size 320x240 --budget 5m \\
        $X/objects/torus1.pov $X/animations/vect1/vect1.pov $X/lights/spotlite.pov $X/advanced/teapot/teapot.pov \\
        $X/lights/arealit1.pov
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from pathlib import Path
from unittest.mock import patch

from aliascope.cli.shared import size_of
from aliascope.cli.sweeping import seconds_of
from aliascope.renderers import povray_file
from aliascope.studies import sweep_search
from aliascope.studies.sweep import Asked, Swept, sweep
from aliascope.studies.sweep_pov import LEAST_TIMED, spec_of
from aliascope.studies.sweep_search import Candidate
from aliascope.studies.sweep_text import options

HELD = 1.10
ROUNDS = 5
LIMIT = 600.0


def swept(path: Path, size: tuple[int, int], budget: float | None, exhaustive: bool) -> Swept:
    with tempfile.TemporaryDirectory() as folder:
        return sweep(Asked(path, budget, size, None, Path(folder), exhaustive), lambda what, done, total: None)


def timed(path: Path, size: tuple[int, int], candidates: list[Candidate]) -> dict[Candidate, float]:
    """CPU seconds of these settings, the medians of runs in turn, of LEAST_TIMED or more each."""
    file = povray_file.open_file(path)
    runs: dict[Candidate, list[float]] = {c: [] for c in candidates}
    for _ in range(ROUNDS):
        for candidate, found in runs.items():
            seconds: list[float] = []
            while sum(seconds) < LEAST_TIMED and len(seconds) < 10:
                drawn = povray_file.draw(file, size, povray_file.options_of(spec_of(candidate)), LIMIT)
                seconds.append(drawn.statistics.cpu_seconds)
            found.append(statistics.mean(seconds))
    return {candidate: statistics.median(found) for candidate, found in runs.items()}


def ratios(path: Path, size: tuple[int, int], budget: float | None) -> list[float]:
    """Prints and returns the ratios of a scene's three settings."""
    ours = swept(path, size, budget, exhaustive=False)
    with patch.object(sweep_search, "MOST_REPEATS", 1):  # those that matter are timed again below
        grid = swept(path, size, None, exhaustive=True)
    known = grid.found.best_known()
    print(
        f"{path.name}: {len(ours.found.whole)} whole pictures and {len(ours.found.looked)} looks in "
        f"{ours.wall_seconds:.0f} s; the grid: {len(known)} in {grid.wall_seconds:.0f} s",
        flush=True,
    )
    own = ours.answers[""]
    found = []
    for name, chosen in (("fast", own.fast), ("balanced", own.balanced), ("final", own.final)):
        error = ours.found.best_known()[chosen].rmse * (1.0 + 1e-9)
        rivals = sorted((c for c, m in known.items() if m.rmse <= error), key=lambda c: known[c].seconds)[:3]
        again = timed(path, size, list(dict.fromkeys([chosen, *rivals])))
        best = min(rivals, key=lambda c: again[c], default=chosen)
        found.append(again[chosen] / again[best])
        print(
            f"  {name:<9}{options(chosen):<28}{again[chosen]:.3f} s, RMSE {error:.3g}; best of the grid "
            f"{options(best):<28}{again[best]:.3f} s: ratio {found[-1]:.3f}",
            flush=True,
        )
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", type=Path)
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--budget", default="5m")
    asked = parser.parse_args()
    size = size_of(asked.size)
    assert size is not None
    worst = {path.name: max(ratios(path, size, seconds_of(asked.budget))) for path in asked.scenes}
    for name, ratio in worst.items():
        print(f"{name}: {ratio:.3f} at worst of three settings, {'held' if ratio <= HELD else 'NOT held'}")
    held = sum(ratio <= HELD for ratio in worst.values())
    print(f"{held} of {len(worst)} scenes within {HELD:.2f}")


if __name__ == "__main__":
    main()
