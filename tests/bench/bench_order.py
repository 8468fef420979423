"""Whether a comparison that is done again finds the same order of times: two runs from nothing, and of all pairs of
modes of a scene those whose 95 % intervals of time do not overlap.

    bench_order.py [SCENE...] [-o FOLDER] [--profile quick]

Without scenes all of them. Takes twice what the comparison takes, on a machine that does nothing else.
"""

from __future__ import annotations

import argparse
import itertools
import json
import shutil
import subprocess
import sys
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Intervals = dict[tuple[str, str, str], tuple[float, float]]
"""By scene, renderer and mode."""


@dataclass(frozen=True)
class Orders:
    """Pairs of modes of a scene: all; those that the first run tells apart; those that both do; and of these how many
    have the other order in the second run, by the middle of its interval or by the intervals themselves."""

    pairs: int
    told: int
    told_twice: int
    turned: tuple[str, ...]
    turned_twice: tuple[str, ...]


def intervals(document: dict[str, Any]) -> Intervals:
    """Of the document of `aliascope compare --json`."""
    return {
        (row["scene"], row["renderer"], row["mode"]): tuple(row["cpu_seconds_interval"])
        for row in document["rows"]
        if row["cpu_seconds_interval"] is not None
    }


def orders(first: Intervals, second: Intervals) -> Orders:
    """What the second run says of the order that the first found."""
    scenes: dict[str, list[tuple[str, str, str]]] = defaultdict(list)
    for key in first:
        if key in second:
            scenes[key[0]].append(key)
    pairs = told = told_twice = 0
    turned: list[str] = []
    turned_twice: list[str] = []
    for keys in scenes.values():
        for one, other in itertools.combinations(keys, 2):
            pairs += 1
            faster, slower = sorted((one, other), key=lambda key: first[key])
            if first[faster][1] >= first[slower][0]:
                continue
            told += 1
            name = f"{faster[0]}: {' '.join(faster[1:])} before {' '.join(slower[1:])}"
            # On a logarithmic scale, as the intervals are made.
            (low, high), (slow_low, slow_high) = second[faster], second[slower]
            if low * high > slow_low * slow_high:
                turned.append(name)
            apart = high < slow_low or slow_high < low
            told_twice += apart
            if slow_high < low:
                turned_twice.append(name)
    return Orders(pairs, told, told_twice, tuple(turned), tuple(turned_twice))


def compared(scenes: list[str], profile: str, folder: Path) -> dict[str, Any]:
    """The document of a comparison that begins with nothing."""
    shutil.rmtree(folder, ignore_errors=True)
    command = [sys.executable, "-m", "aliascope.cli", "compare", *scenes, "--profile", profile, "-o", str(folder)]
    done = subprocess.run([*command, "--json"], stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode not in (0, 4):  # 4: some pictures failed, which are told beside the others
        sys.exit(f"the comparison ended with exit code {done.returncode}")
    document: dict[str, Any] = json.loads(done.stdout)
    return document


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("-o", dest="folder", type=Path, default=Path(".results/order"))
    parser.add_argument("--profile", default="quick")
    asked = parser.parse_args()
    documents = [compared(asked.scenes, asked.profile, asked.folder / name) for name in ("first", "second")]
    for name, document in zip(("first", "second"), documents, strict=True):
        noise = document["noise"]
        told = noise["told"] if noise else "nothing is known of the machine's noise"
        print(f"{name} run, {document['wall_seconds']:.0f} s: {told}")
    found = orders(*map(intervals, documents))
    print(f"{found.pairs} pairs of modes of a scene, {found.told} with intervals of time that do not overlap")
    print(f"  {len(found.turned)} of these have the other order in the second run")
    print(f"  {found.told_twice} do not overlap there either, of which {len(found.turned_twice)} have the other order")
    for name in found.turned[:20]:
        print(f"  turned: {name}")


if __name__ == "__main__":
    main()
