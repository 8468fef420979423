"""Nanoseconds a dimension of the sequences of SciPy, in the units of bench_sampler: 2^20 points in four dimensions in
one call, one thread, the least of several rounds. SciPy has no random access."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import scipy
from scipy.stats import qmc

N, DIMENSIONS, ROUNDS = 1 << 20, 4, 5


def nanoseconds(make: Callable[[int], qmc.QMCEngine]) -> float:
    """Nanoseconds a value of the engine that `make` returns for a seed; making it is not counted."""
    spent = []
    for seed in range(ROUNDS):
        engine = make(seed)
        begun = time.thread_time_ns()
        points = engine.random(N)
        spent.append(time.thread_time_ns() - begun)
        assert points.shape == (N, DIMENSIONS)
    return min(spent) / (N * DIMENSIONS)


def main() -> None:
    engines: dict[str, Callable[[int], qmc.QMCEngine]] = {
        "Sobol, linear matrix scrambling": lambda seed: qmc.Sobol(DIMENSIONS, scramble=True, seed=seed),
        "Sobol": lambda seed: qmc.Sobol(DIMENSIONS, scramble=False),
        "Halton, permuted digits": lambda seed: qmc.Halton(DIMENSIONS, scramble=True, seed=seed),
        "Halton": lambda seed: qmc.Halton(DIMENSIONS, scramble=False),
        "Latin hypercube": lambda seed: qmc.LatinHypercube(DIMENSIONS, seed=seed),
    }
    print(f"the same of scipy.stats.qmc {scipy.__version__}, numpy {np.__version__}, all points in one call")
    for name, make in engines.items():
        print(f"  {name:<40} {N:8} {DIMENSIONS:4} {nanoseconds(make):9.2f}         -")


if __name__ == "__main__":
    main()
