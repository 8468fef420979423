"""How steady the machine is on which pictures are timed: a fixed job, run between them again and again in the process
that renders, and what the processors did meanwhile."""

from __future__ import annotations

import os
import resource
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from aliascope.native import plugin_process
from aliascope.native.samplers import Sampler
from aliascope.records import Noise

EVERY = 10
"""Timed runs between two of the fixed job."""

SAMPLER, POINTS, FILLS = "sobol:scramble=owen", 4096, 2500
"""The fixed job: the points of this pattern, 64 kB of them so that they stay near the processor, so many times; some
20 ms."""

MOST_OTHERS = 0.1
"""Of a processor that others may use, in the mean, before the machine counts as loaded."""
MOST_WAITED = 0.05
"""Share of its time on the wall that a run may have waited for a processor."""
MOST_SPREAD = 0.1
"""Standard deviation of the fixed job's times, over their median, of a steady machine. One that shares its processors
with others unseen, as virtual ones do, is not: that is no load of its own, and every interval of times has it in."""
LEAST_WATCHED = 1.0
"""Seconds on the wall from which on it is told what others used: it is counted in hundredths."""


@dataclass(frozen=True)
class Beat:
    """One run of the fixed job, in seconds."""

    cpu: float
    wall: float


@dataclass(frozen=True)
class Effort:
    """What a run took of the process that did it. wall, own: seconds of it, and CPU seconds, with those of the plugins
    that it asks and without those of other programs that it started; used: all CPU seconds, of those programs too,
    since the process began."""

    wall: float
    own: float
    process: int
    used: float


def beat() -> Beat:
    """Runs the fixed job. Runs in a worker process."""
    sampler = Sampler(SAMPLER, POINTS)
    begun, cpu = time.perf_counter(), time.thread_time()
    for _ in range(FILLS):
        sampler.points(POINTS)
    return Beat(time.thread_time() - cpu, time.perf_counter() - begun)


def effort() -> Callable[[], Effort]:
    """Begins to watch a run of this process; what is returned ends it."""
    begun, cpu = time.perf_counter(), _own_seconds()

    def end() -> Effort:
        children = resource.getrusage(resource.RUSAGE_CHILDREN)
        own = _own_seconds()
        return Effort(time.perf_counter() - begun, own - cpu, os.getpid(), own + children.ru_utime + children.ru_stime)

    return end


def _own_seconds() -> float:
    """CPU seconds of this process, and of the plugins that it asks and waits for."""
    return time.process_time() + plugin_process.seconds()


def busy_seconds(stat: Path = Path("/proc/stat")) -> float | None:
    """CPU seconds that all processors of the machine were busy, for whomever, since it began; None where it is not
    told."""
    with suppress(OSError, ValueError, IndexError):
        first = stat.read_text().split("\n", 1)[0].split()
        user, nice, system, _, _, interrupt, soft, stolen = map(int, first[1:9])
        return (user + nice + system + interrupt + soft + stolen) / os.sysconf("SC_CLK_TCK")
    return None


class Watch:
    """What is seen of the machine from here on, by the process that has others time pictures."""

    def __init__(self) -> None:
        self._beats: list[Beat] = []
        self._efforts: list[Effort] = []
        self._begun, self._own, self._busy = time.perf_counter(), _own_seconds(), busy_seconds()

    def beat(self, beat: Beat) -> None:
        """A run of the fixed job."""
        self._beats.append(beat)

    def ran(self, effort: Effort) -> None:
        """A timed run."""
        self._efforts.append(effort)

    def others(self) -> float | None:
        """How many processors others had in use, in the mean; None where that is not known."""
        seconds, busy = time.perf_counter() - self._begun, busy_seconds()
        if busy is None or self._busy is None or seconds < LEAST_WATCHED:
            return None
        used: dict[int, float] = {}
        for each in self._efforts:
            used[each.process] = max(used.get(each.process, 0.0), each.used)
        ours = _own_seconds() - self._own + sum(used.values())
        return max(0.0, (busy - self._busy - ours) / seconds)

    def noise(self) -> Noise | None:
        """What it comes to so far; None before the fixed job was run."""
        return noise(self._beats, self._efforts, self.others()) if self._beats else None


class Elsewhere:
    """What is seen of other machines that time pictures: the runs of the fixed job there, and how long what was timed
    waited for a processor. What others used of theirs is not known."""

    def __init__(self) -> None:
        self._beats: dict[str, list[Beat]] = {}
        self._efforts: dict[str, list[Effort]] = {}

    def ran(self, machine: str, effort: Effort, beats: Sequence[Beat]) -> None:
        """A timed run there, and those of the fixed job before it."""
        self._beats.setdefault(machine, []).extend(beats)
        self._efforts.setdefault(machine, []).append(effort)

    def noise(self) -> Noise | None:
        """Of all of them together; None before the fixed job was run."""
        each = {name: noise(beats, self._efforts[name], None) for name, beats in self._beats.items() if beats}
        return together(each) if each else None


def together(machines: Mapping[str, Noise]) -> Noise:
    """What is known of several machines, by their names, as one: the worst of each. Where their fixed jobs took times
    that differ by more than MOST_SPREAD, times of different machines are not comparable, and that counts as loaded."""
    found = list(machines.values())
    seconds = {name: each.seconds for name, each in machines.items()}
    fastest, slowest = min(seconds, key=seconds.__getitem__), max(seconds, key=seconds.__getitem__)
    apart = seconds[slowest] / seconds[fastest] - 1.0
    differ = apart > MOST_SPREAD
    told = " ".join(f"{name}: {each.told}" for name, each in machines.items())
    if differ:
        told = (
            f"The pictures were timed on {len(found)} machines, of which {slowest} is {100 * apart:.0f} % slower than "
            f"{fastest} at the fixed job: times of different machines are mixed and not to be compared. {told}"
        )
    return Noise(
        runs=sum(each.runs for each in found),
        seconds=statistics.median(seconds.values()),
        spread=max(each.spread for each in found),
        drift=max((each.drift for each in found), key=abs),
        slowest=max(each.slowest for each in found),
        loaded=differ or any(each.loaded for each in found),
        told=told,
    )


def mixed(noise: Noise | None, machines: Mapping[str, int]) -> Noise | None:
    """What is known, where so many pictures were timed on each machine: of unlike ones, nothing says how their times
    compare. Machines are alike that have the same words in brackets, their processors."""
    kinds = {name.partition(" (")[2] for name in machines}
    if noise is None or len(kinds) < 2:
        return noise
    told = f"The times of {len(machines)} unlike machines are mixed, and not to be compared."
    return replace(noise, loaded=True, told=f"{told} {noise.told}")


def noise(beats: Sequence[Beat], efforts: Sequence[Effort], others: float | None) -> Noise:
    """What runs of the fixed job and timed runs, in their order, say of the machine, on which others used so many
    processors."""
    seconds = [each.cpu for each in beats]
    median, quarter = statistics.median(seconds), len(seconds) // 4
    spread = statistics.stdev(seconds) / median if len(seconds) > 1 else 0.0
    drift = statistics.median(seconds[-quarter:]) / statistics.median(seconds[:quarter]) - 1.0 if quarter else 0.0
    waited = waited_share(beats, efforts)
    why = [
        *([f"others used {others:.2g} of its processors"] if others is not None and others > MOST_OTHERS else []),
        *([f"runs waited for a processor {100 * waited:.0f} % of their time"] if waited > MOST_WAITED else []),
    ]
    if why:
        told = f"The machine was loaded, so that times are not to be trusted: {'; '.join(why)}"
    else:
        used = "" if others is None else f"; others used {others:.2f} of its processors"
        steady = "quiet" if spread <= MOST_SPREAD else "quiet but not steady, which the intervals of times take in"
        told = f"The machine was {steady}{used}"
    told += (
        f". A fixed job of {1e3 * median:.3g} ms, run {len(seconds)} times between the pictures, varied by "
        f"{100 * spread:.1f} % and was {100 * abs(drift):.1f} % {'slower' if drift >= 0 else 'faster'} at the end."
    )
    return Noise(len(seconds), median, spread, drift, max(seconds) / median, bool(why), told)


def waited_share(beats: Sequence[Beat], efforts: Sequence[Effort]) -> float:
    """The share of the time on the wall for which what was timed did not run. Of runs that leave the work to another
    program nothing can be told: they wait for that."""
    pairs = [(each.wall, each.cpu) for each in beats]
    pairs += [(each.wall, each.own) for each in efforts if 2.0 * each.own > each.wall]
    wall = sum(each for each, _ in pairs)
    return max(0.0, 1.0 - sum(cpu for _, cpu in pairs) / wall) if wall > 0.0 else 0.0
