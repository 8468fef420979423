"""What renderers do to a compare: they crash, hang, flood, are not there; and a clock that goes back all the while. A
job that fails loses itself alone."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from datetime import datetime
from pathlib import Path
from typing import Any
from unittest.mock import patch

import fake_povray
import pytest
from commands import COMMAND, checked, environment, run
from crashing import compiled
from killed_compares import PATIENCE, leftovers, pictures, started

from aliascope import draws, plan

SEEDS = plan.SEEDS["quick"]
PLACES = min(SEEDS, draws.MOST)

TROUBLE = r"""
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "aliascope/plugin.h"

static asc_status create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  (void)error;
  unsigned long long *seed = malloc(sizeof *seed);
  *seed = config->seed;
  *made = (asc_sampler_state){seed, ASC_TRAIT_RANDOMISED, config->samples};
  return ASC_OK;
}

static asc_status fill(const void *state, const asc_range *range, double *points) {
  (void)range, (void)points;
  switch (*(const unsigned long long *)state) {
    case 0: for (;;) pause();
    case 1: raise(SIGSEGV);
    default: abort();
  }
}

static const asc_sampler_interface trouble = {
    .struct_size = sizeof(asc_sampler_interface), .name = "trouble", .title = "trouble", .source = "on purpose",
    .create = create, .destroy = free, .fill = fill,
};

ASC_PLUGIN_EXPORT const void *asc_plugin_interface(uint32_t abi_version, const char *id);
const void *asc_plugin_interface(uint32_t abi_version, const char *id) {
  return abi_version == ASC_ABI_VERSION && strcmp(id, ASC_SAMPLER_INTERFACE_ID) == 0 ? &trouble : NULL;
}
"""
"""A sampler whose pictures hang with seed 0, crash with 1, and abort with 2."""

CLOCK = r"""
#define _GNU_SOURCE
#include <stdatomic.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static atomic_long calls;

int clock_gettime(clockid_t clock, struct timespec *now) {
  const long failed = syscall(SYS_clock_gettime, clock, now);
  if (!failed && clock == CLOCK_REALTIME) now->tv_sec -= 3600 * atomic_fetch_add(&calls, 1);
  return (int)failed;
}
int gettimeofday(struct timeval *restrict now, void *restrict zone) {
  (void)zone;
  struct timespec exact;
  clock_gettime(CLOCK_REALTIME, &exact);
  *now = (struct timeval){exact.tv_sec, exact.tv_nsec / 1000};
  return 0;
}
time_t time(time_t *now) {
  struct timespec exact;
  clock_gettime(CLOCK_REALTIME, &exact);
  return now ? *now = exact.tv_sec : exact.tv_sec;
}
"""
"""A clock on the wall that is an hour earlier each time one looks at it, for the workers and their programs."""


class Later(datetime):
    """A clock that is far ahead when a run starts."""

    @classmethod
    def now(cls, tz: Any = None) -> Later:
        return cls(2099, 1, 1, tzinfo=tz)


def set_back(library: Path) -> None:
    """In the process of a compare: an hour earlier at each look, in the processes that it starts too."""
    seconds = iter(range(10**10, 0, -3600))
    patch("time.time", lambda: float(next(seconds))).start()
    patch("aliascope.studies.compare.datetime", Later).start()
    os.environ["LD_PRELOAD"] = str(library)


def test_jobs_that_crash_or_hang_lose_themselves_alone_while_the_clock_goes_back(tmp_path: Path) -> None:
    plugin, clock = compiled(tmp_path, "trouble", TROUBLE), compiled(tmp_path, "clock", CLOCK)
    folder = tmp_path / "out"
    good = ("compare", "edge", "-r", "embree", "-m", "uniform:n=1", "--size", "16x12", "--json")
    words = (*good, "-m", "uniform:n=4,sampler=trouble", "--trust-plugin", str(plugin), "--time-limit", "15")
    with started(folder, arguments=words, prepare=lambda: set_back(clock)) as process:
        process.join(PATIENCE)
        assert process.exitcode == 4
        assert process.pid is not None
        assert leftovers(process.pid) == []
    document = json.loads((tmp_path / "out.out").read_text())
    assert (document["pictures"], document["failed"]) == (SEEDS, SEEDS)
    messages = {re.search(r"--seed (\d+)", each["command"])[1]: each["message"] for each in document["failures"]}  # type: ignore[index]
    assert messages == {
        "0": "gave nothing within 22.5 s and was ended",
        "1": "its process ended by SIGSEGV",
        "2": "its process ended by SIGABRT",
    }
    (row,) = document["rows"]
    assert row["pictures"] == SEEDS
    # The run started in what is now the future; that is no reason not to go on from it.
    assert "2099-01-01" in (folder / "report.html").read_text()
    (tmp_path / "out.out").unlink()
    with started(folder, "--resume", arguments=good) as process:
        process.join(PATIENCE)
        assert process.exitcode == 0
    again = json.loads((tmp_path / "out.out").read_text())
    assert (again["rendered"], again["reused"], again["rows"]) == (0, SEEDS, [row])
    assert len(pictures(folder)) == 2 * SEEDS


def test_povray_that_misbehaves_loses_its_own_jobs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What test_povray_process.py has of a run, at the level of a compare, while the clock goes back."""
    for name in ("plot_svg", "spectrum_svg", "filters_svg"):
        monkeypatch.setattr(f"aliascope.report.{name}", lambda *_: "<svg xmlns='http://www.w3.org/2000/svg'/>")
    short = fake_povray.write_png(tmp_path / "short.png", 16, 12)
    short.write_bytes(short.read_bytes()[:-30])
    other = fake_povray.write_png(tmp_path / "other.png", 12, 16)
    peak = "grep VmHWM /proc/$PPID/status"
    hang = fake_povray.recording_its_processes(tmp_path / "record")
    trouble = {
        "am1:depth=2": (
            f"if mkdir {tmp_path}/hung 2>/dev/null; then {hang}; fi",
            "had not ended after 15 s",
        ),
        "am1:depth=7": (
            f"{peak} >> {tmp_path}/before; timeout 1 cat /dev/zero; {peak} >> {tmp_path}/after; echo no more; exit 1",
            "no more",
        ),
        "am1:depth=4": (fake_povray.leaving(short), "broken picture"),
        "am1:depth=5": (f"printf '%s' '{fake_povray.STATISTICS}'", "left no picture"),
        "am1:depth=6": (fake_povray.leaving(other), "12x16 pixels and 3 channels instead of 16x12"),
    }
    cases = "".join(f"*+R{mode[-1]}*) {body};; " for mode, (body, _) in trouble.items())
    script = f'case "$*" in *version*) echo "POV-Ray 3.7.0.10" >&2; exit 0;; {cases}esac'
    path = environment(fake_povray.install(tmp_path / "bin", script))
    path |= {"LD_PRELOAD": str(compiled(tmp_path, "clock", CLOCK))}
    modes = [word for mode in ("msaa:n=4", *trouble) for word in ("-m", mode)]
    limits = ("--size", "16x12", "--time-limit", "15", "--json")
    result = run("compare", "edge", *modes, *limits, "-o", tmp_path / "out", code=4, env=path)
    document = json.loads(result.stdout)
    assert (document["pictures"], document["failed"]) == (PLACES, PLACES * len(trouble))
    report = (tmp_path / "out" / "report.html").read_text()
    for mode, (_, words) in trouble.items():
        told = [failure["message"] for failure in document["failures"] if failure["mode"] == mode]
        assert len(told) == PLACES
        assert any(words in message for message in told), told
        assert words in report
    assert all(fake_povray.ends(pid) for pid in fake_povray.recorded(tmp_path / "record"))
    # Kilobytes of the process that runs each: of gigabytes a second, a quarter of one megabyte is kept.
    before, after = (
        [int(line.split()[1]) for line in (tmp_path / name).read_text().splitlines()] for name in ("before", "after")
    )
    assert len(before) == len(after) == PLACES
    assert all(high - low < 32 << 10 for low, high in zip(before, after, strict=True))


def test_without_osmesa_and_embree(tmp_path: Path) -> None:
    """Libraries that cannot be loaded: what needs them is skipped, and said."""
    for name in ("libOSMesa.so.8", "libembree3.so.3"):
        (tmp_path / name).write_bytes(b"no library")
    without = {**os.environ, "LD_LIBRARY_PATH": str(tmp_path)}

    def compare(*words: str, code: int) -> subprocess.CompletedProcess[str]:
        command = [*COMMAND, "compare", "edge", *words, "-m", "none", "--size", "16x12", "-o", str(tmp_path / "out")]
        return checked(subprocess.run(command, capture_output=True, text=True, env=without, check=False), code)

    document = json.loads(compare("-m", "uniform:n=1", "--json", code=0).stdout)
    assert set(document["skipped"]) == {"osmesa", "embree"}
    assert "OSMesa (Debian: libosmesa6) cannot be loaded" in document["skipped"]["osmesa"]
    assert "Embree" in document["skipped"]["embree"]
    assert (document["pictures"], document["failed"]) == (PLACES, 0)
    assert {row["renderer"] for row in document["rows"]} == {"povray"}
    (line,) = compare("-r", "osmesa", code=3).stderr.splitlines()
    assert line.startswith("aliascope: OSMesa (Debian: libosmesa6) cannot be loaded")


def test_a_process_that_begins_as_the_others_end_says_nothing() -> None:
    """In place of one that has crashed, when there is nothing more to do: pebble is made to be slow to end it."""
    script = """
import os, time
import pebble.pool.process as pebbles
from aliascope.errors import JobFailed
from aliascope.workers import Workers
ends = pebbles.stop_process
pebbles.stop_process = lambda process: (time.sleep(1.0), ends(process))
with Workers(1) as workers:
    try:
        workers.begin(os._exit, [1], 60.0).result()
    except JobFailed as error:
        print(error)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=PATIENCE, check=True)
    assert (done.stdout, done.stderr) == ("its process ended with exit code 1\n", "")
