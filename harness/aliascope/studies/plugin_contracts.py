"""The contracts of a sampler, each a function that raises Broken: creation, memory, weights, traits, uniformity.

Those of its values are in plugin_values. They run in processes of their own: plugin_probe.
"""

from __future__ import annotations

import itertools
import math
import resource
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aliascope.native.probing import Buffer, Memory, Probe
from aliascope.studies.plugin_subject import COUNTS, DIMENSIONS, Broken, Finding, NothingToCheck, Subject, same
from aliascope.studies.plugin_values import in_range, order, purity, threads

# --- creation ---------------------------------------------------------------------------------------------------------


def refusals(subject: Subject) -> Finding:
    """Creation gives a sampler, or ASC_UNSUPPORTED and the reason; past all memory also ASC_OUT_OF_MEMORY."""
    counts = sorted({*range(1, 34), *itertools.chain.from_iterable(COUNTS)})
    sizes = list(itertools.product(counts, DIMENSIONS))
    refused = sum(not _answer(subject, n, d) for n, d in sizes)
    if refused == len(sizes):
        raise Broken(f"none of {len(sizes)} sizes is there: {subject.probe(16, 2).message}")
    _limit_memory(4 << 30)
    for n, d in ((16, 1024), (16, 65536), (2**32 + 1, 2), (2**53, 2)):
        _answer(subject, n, d, scarce=True)
    return Finding(f"{len(sizes) - refused} of {len(sizes)} sizes are there, {refused} are refused with a reason")


def _answer(subject: Subject, samples: int, dimensions: int, scarce: bool = False) -> bool:
    """Whether a size is there. Raises Broken for an answer that is none."""
    probe = subject.probe(samples, dimensions)
    probe.destroy()
    size = f"N = {samples}, D = {dimensions}"
    if probe.made or (scarce and probe.status == "ASC_OUT_OF_MEMORY"):
        return probe.made
    if probe.status != "ASC_UNSUPPORTED":
        raise Broken(f"create for {size} gave {probe.status}; a size that is not there is ASC_UNSUPPORTED")
    if not probe.message.strip():
        raise Broken(f"create for {size} gave ASC_UNSUPPORTED and no message: say in `error` which sizes there are")
    if not probe.message.isprintable():
        raise Broken(f"create for {size} gave a message that is not one printable line: {probe.message!r}")
    subject.note(f"in create for {size} without an asc_error: `error` may be NULL")
    silent = Probe(subject.spec, samples, dimensions, error=False)
    if silent.status != probe.status:
        raise Broken(f"create for {size} gave {probe.status}, and {silent.status} where `error` is NULL")
    return False


def _limit_memory(more: int) -> None:
    """So that what asks for too much is refused, and does not take the machine down."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    wanted = pages * resource.getpagesize() + more
    resource.setrlimit(resource.RLIMIT_AS, (wanted if hard == resource.RLIM_INFINITY else min(wanted, hard), hard))


def index_end(subject: Subject) -> Finding:
    """Ends at N, for a sequence at N or later; the last index that there is can be had."""
    count = 0
    for n, d in subject.sizes():
        probe = subject.made(n, d)
        subject.note(f"looking for index_end, N = {n}, D = {d}")
        end = probe.index_end()
        if probe.sequence and end < n:
            raise Broken(f"N = {n}, D = {d}: index_end is {end}, before the last of {n} points")
        if not probe.sequence and end != n:
            raise Broken(f"N = {n}, D = {d}: index_end is {end}; for a pattern that is no sequence it is N")
        subject.fill(probe, (0, 0), end - 1, 1)
        count += 1
    return Finding(f"{count} sizes, to the last index")


# --- memory -----------------------------------------------------------------------------------------------------------


def past_end(subject: Subject) -> Finding:
    """Nothing is written or read past the end of a buffer."""
    return _edges(subject, Memory.at_the_end, Buffer.stray_after, "past the end")


def before_start(subject: Subject) -> Finding:
    """Nothing is written or read before the start of a buffer."""
    return _edges(subject, Memory.at_the_start, Buffer.stray_before, "before the start")


def _edges(
    subject: Subject, at_the_edge: Callable[[Memory, int], Buffer], stray: Callable[[Buffer], int], words: str
) -> Finding:
    """First among canaries, which tell how far it went; then beside a page that no process may touch."""
    calls = 0
    sizes = list(subject.sizes())
    for guarded, (n, d) in itertools.product((False, True), sizes):
        probe = subject.made(n, d, 1)
        place = at_the_edge if guarded else Memory.in_the_middle
        after = f" {words} of which nothing may be touched" if guarded else ""
        for first, count, first_dimension, columns in _ranges(n, d):
            where = subject.place(probe, (0, 0), first, count, first_dimension, columns)
            subject.note(f"in fill of {where}, into a buffer{after}")
            buffer = place(subject.memory, count * columns)
            probe.fill(buffer, (0, 0), first, count, first_dimension, columns)
            _look(stray(buffer), f"fill of {where}", words)
            calls += 1
            if (first_dimension, columns) != (0, d):
                continue
            where = f"N = {n}, samples {first} to {first + count - 1}"
            subject.note(f"in weights of {where}, into a buffer{after}")
            buffer = place(subject.memory, count)
            probe.weights(buffer, first, count)
            _look(stray(buffer), f"weights of {where}", words)
    return Finding(f"{calls // 2} ranges, with canaries and beside a guard page")


def _look(distance: int, call: str, words: str) -> None:
    if distance:
        raise Broken(f"{call} wrote up to {distance} bytes {words} of its buffer")


def _ranges(n: int, d: int) -> list[tuple[int, int, int, int]]:
    """(first, count, first dimension, dimensions): all, one point, the last ones, parts of the dimensions."""
    ranges = {(0, n, 0, d), (n - 1, 1, 0, d), (n // 3, n - n // 3, 0, d), (0, n, d - 1, 1), (n // 2, 1, 0, 1)}
    if d > 2:
        ranges.add((n // 3, n - n // 3, 1, d - 2))
    return sorted(ranges)


# --- weights and traits -----------------------------------------------------------------------------------------------

WEIGHT_TOLERANCE = 1e-12
"""Of the sum of up to 1,024 weights: each has some 2^-53 of its own, the sum rounds as often."""


def weights(subject: Subject) -> Finding:
    """Finite and of sum 1; 1/N without the trait; any piece has the bits of all at once."""
    differ, said = False, False
    count = 0
    for n, d in subject.sizes():
        probe = subject.made(n, d)
        whole = subject.weights(probe, 0, n)
        size = f"N = {n}, D = {d}"
        if not np.isfinite(whole).all():
            index = int(np.flatnonzero(~np.isfinite(whole))[0])
            raise Broken(f"{size}: weight {index} is {whole[index]:g}")
        if abs(math.fsum(whole) - 1) > WEIGHT_TOLERANCE:
            raise Broken(f"{size}: weights add up to {math.fsum(whole):.15g}, not 1")
        uneven = bool((whole != 1 / n).any())
        if uneven and not probe.weighted:
            raise Broken(f"{size}: weights other than 1/N, without ASC_TRAIT_WEIGHTED")
        differ, said = differ or uneven, said or probe.weighted
        for first in {0, n // 2, n - 1}:
            if not same(subject.weights(probe, first, 1), whole[first : first + 1]):
                raise Broken(f"{size}: weight {first} has other bits alone than where all are asked for")
        count += 1
    if said and not differ:
        raise Broken("all weights are 1/N, with ASC_TRAIT_WEIGHTED")
    return Finding(f"{count} sizes: of sum 1{'' if differ else ', 1/N each'}")


def traits(subject: Subject) -> Finding:
    """No unknown traits; of an ASC_TRAIT_SEQUENCE the first points do not depend on N."""
    sequences = 0
    for d, group in itertools.groupby(subject.sizes(), key=lambda size: size[1]):
        probes = [subject.made(n, d, 21) for n, _ in group]
        for probe in probes:
            if probe.unknown_traits:
                raise Broken(f"N = {probe.samples}, D = {d}: unknown traits {probe.unknown_traits:#x}")
        found = [probe for probe in probes if probe.sequence]
        if not found:
            continue
        longest = subject.fill(found[-1], (1, 2), 0, found[-1].samples)
        for probe in found[:-1]:
            points = subject.fill(probe, (1, 2), 0, probe.samples)
            if not same(points, longest[: probe.samples]):
                raise Broken(
                    f"ASC_TRAIT_SEQUENCE, but with D = {d} the points of N = {probe.samples} are not the first ones of "
                    f"N = {found[-1].samples}"
                )
            sequences += 1
    return Finding(f"the first points do not depend on N, {sequences} sizes" if sequences else "no sequence")


OTHER_PIXELS = ((1, 0), (0, 1), (256, 0), (0, 65536), (-1, 0))
OTHER_SEEDS = (2, 1 << 32 | 1, 2**64 - 1)


def seeds(subject: Subject) -> Finding:
    """Seeds and pixels give other points with ASC_TRAIT_RANDOMISED, and never without."""
    n, d = _typical(subject)
    probe = subject.made(n, d, 1)
    base = subject.fill(probe, (0, 0), 0, n)
    others = {f"pixel {x},{y}": subject.fill(probe, (x, y), 0, n) for x, y in OTHER_PIXELS}
    others |= {f"seed {seed}": subject.fill(subject.made(n, d, seed), (0, 0), 0, n) for seed in OTHER_SEEDS}
    for name, points in others.items():
        if same(points, base) and probe.randomised:
            raise Broken(f"ASC_TRAIT_RANDOMISED, but {name} has the points of pixel 0,0 and seed 1 (N = {n}, D = {d})")
        if not same(points, base) and not probe.randomised:
            raise Broken(
                f"no ASC_TRAIT_RANDOMISED, but {name} has other points than pixel 0,0 and seed 1 (N = {n}, D = {d})"
            )
    return Finding("seeds and pixels differ" if probe.randomised else "not randomised: seeds and pixels do not matter")


def _typical(subject: Subject) -> tuple[int, int]:
    """The size for what is asked of one alone: in up to 5 dimensions, of 64 points or about as many."""
    return min(subject.sizes(), key=lambda size: (size[1] > 5, abs(math.log(size[0] / 64)), -size[1]))


# --- uniformity -------------------------------------------------------------------------------------------------------

REALISATIONS = 1 << 13
MARGIN_BINS = 16
PAIR_BINS = 8
SIGNIFICANCE = 1e-6
"""How often a sampler that is uniform would fail, all tests together."""


def uniformity(subject: Subject) -> Finding:
    """One point of each of many realisations, its index by turns: independent whatever the pattern, so that counts in
    equal cells of each dimension and each pair are multinomial, and chi-squared says whether they are even."""
    from scipy.special import gammaincc  # late: it takes as long to load as all else, in each check's process

    n, d = _typical(subject)
    probe = subject.made(n, d)
    if not probe.randomised:
        raise NothingToCheck("not randomised")
    if probe.weighted:
        raise NothingToCheck("its points have weights")
    drawn = _realisations(subject, n, d)
    inside = ~np.isnan(drawn).any(axis=1) & (drawn >= 0).all(axis=1) & (drawn < 1).all(axis=1)
    drawn = drawn[inside]  # what lies outside is found by another check
    columns = [(a,) for a in range(d)] + list(itertools.combinations(range(d), 2))
    for chosen in columns:
        bins = MARGIN_BINS if len(chosen) == 1 else PAIR_BINS
        cells = np.ravel_multi_index(tuple((drawn[:, c] * bins).astype(int) for c in chosen), (bins,) * len(chosen))
        counts = np.bincount(cells, minlength=bins ** len(chosen))
        expected = len(drawn) / len(counts)
        statistic = float(((counts - expected) ** 2).sum() / expected)
        # The upper tail of chi-squared with k degrees of freedom at x is Q(k/2, x/2).
        if gammaincc((len(counts) - 1) / 2, statistic / 2) < SIGNIFICANCE / len(columns):
            which = f"dimension {chosen[0]} is" if len(chosen) == 1 else f"dimensions {chosen[0]} and {chosen[1]} are"
            raise Broken(
                f"{which} not uniform over seeds and pixels, N = {n}, D = {d}: chi-squared {statistic:.1f} with "
                f"{len(counts) - 1} degrees of freedom in {len(drawn)} realisations"
            )
    return Finding(
        f"{d} dimensions and {len(columns) - d} pairs over {len(drawn)} realisations, N = {n}, chi-squared at a "
        f"significance of {SIGNIFICANCE:g}"
    )


def _realisations(subject: Subject, n: int, d: int) -> NDArray[np.float64]:
    drawn = np.empty((REALISATIONS, d))
    probe = subject.made(n, d)
    for number in range(REALISATIONS):
        seed, place = divmod(number, 256)
        if place == 0:
            probe = subject.made(n, d, 7 + seed)
        drawn[number] = subject.fill(probe, (place % 16, place // 16), (number + seed) % n, 1)[0]
    return drawn


CONTRACTS: Mapping[str, Callable[[Subject], Finding]] = {
    "refusals": refusals,
    "past-end": past_end,
    "before-start": before_start,
    "range": in_range,
    "purity": purity,
    "order": order,
    "threads": threads,
    "weights": weights,
    "seeds": seeds,
    "traits": traits,
    "index-end": index_end,
    "uniformity": uniformity,
}
"""After `table`, each in a process of its own."""
