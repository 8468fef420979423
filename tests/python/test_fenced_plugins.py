"""Plugins of anybody, given with --plugin: they run in a process of their own, which they cannot leave."""

from __future__ import annotations

import json
import multiprocessing
import os
import re
import signal
import socket
import time
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import in_a_fork, separately
from test_hostile_plugin import EVERYTHING, LOOKS
from test_plugin_check import GOOD, compiled, in_place

from aliascope import calibration, landlock, scene_io, seccomp
from aliascope.errors import AliascopeError
from aliascope.image import read_image
from aliascope.native import plugin_process, samplers, tracer

REACHES = r"""
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>

static void *nothing(void *it) { return it; }

static int limited(pid_t process) {
  struct rlimit limit;
  return syscall(SYS_prlimit64, process, RLIMIT_NOFILE, NULL, &limit) == 0;
}

static int forked(pid_t child) {
  if (child == 0) _exit(0);
  return child > 0;
}

#ifndef SYS_fork /* newer machines have clone alone */
#define SYS_fork SYS_clone, SIGCHLD
#endif

static int shrunk(void) {
  for (int fd = 3; fd < 64; fd++)
    if (ftruncate(fd, 0) == 0) return 1;
  return 0;
}

static int threaded(void) {
  pthread_t thread;
  return pthread_create(&thread, NULL, nothing, NULL) == 0 && pthread_join(thread, NULL) == 0;
}

__attribute__((constructor)) static void reach(void) {
  did(" fork", forked(fork()));
  did(" old-fork", forked(syscall(SYS_fork, 0, 0, 0, 0)));
  did(" exec", execl("/nowhere", "nowhere", NULL) != 0 && errno != EPERM);
  did(" signal", kill(getppid(), 0) == 0);
  did(" thread-signal", syscall(SYS_tgkill, getppid(), getppid(), 0) == 0);
  did(" queue-signal", sigqueue(getppid(), 0, (union sigval){0}) == 0);
  did(" limit", limited(getppid()));
  did(" local-socket", socket(AF_UNIX, SOCK_STREAM, 0) >= 0);
  did(" outlive", prctl(PR_SET_PDEATHSIG, 0) == 0);
  did(" owner", fcntl(0, F_SETOWN, getppid()) == 0);
  did(" shrink", shrunk());
  did(" secret", getenv("LOOK_TOKEN") != NULL);
  did(" threads", threaded());
  did(" itself", kill(getpid(), 0) != 0 && raise(0) == 0);
}
"""


def test_a_plugin_reads_its_folder_and_reaches_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "theirs"
    folder.mkdir()
    secret, new = tmp_path / "secret", tmp_path / "new"
    secret.write_text("mine")
    monkeypatch.setenv("LOOK_TOKEN", "of a CI, perhaps")
    with socket.create_server(("127.0.0.1", 0)) as server:
        where = {"BESIDE": folder / "mine.c", "SECRET": secret, "NEW": new, "PORT": server.getsockname()[1]}
        text = LOOKS + REACHES
        for name, value in where.items():
            text = text.replace(f'getenv("LOOK_{name}")', f'"{value}"')
        text = text.replace("static char told[99]", "static char told[250]")
        plugin = compiled(folder, GOOD, in_place("globals", text), ('.title = "random points"', ".title = told"))
        held = separately("list", "samplers", "--plugin", plugin, "--json").stdout
        assert not new.exists()
        free = separately("list", "samplers", "--trust-plugin", plugin, "--json").stdout
    kept, could = (_title(json.loads(text)) for text in (held, free))
    assert could.startswith(EVERYTHING)
    assert {"fork", "old-fork", "exec", "signal", "limit", "local-socket", "outlive", "secret"} <= set(could.split())
    expected = ["did:", *(["data"] if landlock.abi() else []), *(["threads", "itself"] if seccomp.works() else [])]
    assert kept.split() == expected
    assert secret.read_text() == "mine"


def _title(document: Any) -> str:
    return next(str(each["title"]) for each in document["samplers"] if each["name"] == "mine")


@pytest.mark.parametrize(
    "mode",
    [
        "uniform:n=16,sampler=mine",
        "uniform:n=1500,sampler=mine",  # more than are drawn of a pixel at a time
        "uniform:n=4,sampler=mine,filter=gaussian",
        "adaptive:sampler=mine,n=64",
    ],
)
def test_its_pictures_are_the_same_bits(tmp_path: Path, mode: str) -> None:
    plugin = compiled(tmp_path)
    pictures = []
    for option in ("--plugin", "--trust-plugin"):
        out = tmp_path / f"{option}.exr"
        words = ("-r", "embree", "-m", mode, "--size", "37x21", "-o", out, "--threads", "3")
        separately("render", "depth-of-field", *words, option, plugin)
        pictures.append(read_image(out))
    assert np.array_equal(*(np.asarray(each) for each in pictures))


def _asked(plugin: str, trusted: bool, what: list[tuple[Any, ...]]) -> list[np.ndarray[Any, Any]]:
    samplers.load_plugin(plugin, trusted=trusted)
    found = []
    for n, dimensions, first, count in what:
        made = samplers.Sampler("mine:power=2", n, dimensions, seed=7)
        found += [made.points(count, first, pixel=(-5, 2**31 - 1)), made.weights(count, first)]
    return found


def test_its_points_are_the_same_bits_however_many(tmp_path: Path) -> None:
    """A channel takes 32,768 numbers: fewer than one sample here, and many samples of few dimensions."""
    plugin = str(compiled(tmp_path, GOOD, ("config->dimensions > 8", "config->dimensions > 80000")))
    what: list[tuple[Any, ...]] = [(1, 2, 0, 1), (99999, 3, 0, 99999), (9, 70000, 1, 3), (5, 32768, 0, 2), (5, 1, 4, 1)]
    inside, outside = (in_a_fork(_asked, plugin, trusted, what) for trusted in (True, False))
    assert all(map(np.array_equal, inside, outside))
    assert len(inside) == 2 * len(what)


CRASH = "raise(SIGSEGV);"
SIGNALS = in_place("globals", "#include <signal.h>\n#include <stdio.h>")


@pytest.mark.parametrize(
    ("place", "code", "words"),
    [
        ("filled", "raise(SIGSEGV);", "crashed with SIGSEGV; it may take"),
        ("weights", "raise(SIGSEGV);", "crashed with SIGSEGV"),
        ("filled", 'fputs("of\\nthree\\033[2J words\\n", stderr); abort();', "crashed with SIGABRT (three [2J words)"),
        ("filled", 'puts("x"); _exit(0);', "ended its process with exit code 0"),
        ("filled", "for (;;) *(volatile char *)malloc(1 << 26) = 1;", "crashed with SIGSEGV"),
        ("filled", "if (ftruncate(2, (off_t)1 << 27)) abort();", "crashed with SIGABRT"),  # what it says has a bound
        ("filled", "for (;;) raise(SIGSTOP);", "had not answered within 0.5 s, and was ended"),
        ("filled", "for (;;) sleep(1);", "had not answered within 0.5 s, and was ended"),
        ("filled", "return 99;", "had not answered"),
    ],
)
def test_what_it_does_to_its_process_is_one_error(tmp_path: Path, place: str, code: str, words: str) -> None:
    plugin = compiled(tmp_path, GOOD, SIGNALS, in_place(place, f"if (state->samples == 7) {{ {code} }}"))
    failed, after, again = in_a_fork(_tried_twice, str(plugin))
    assert words in failed, failed
    assert failed.startswith(("the process of the plugin has ended", str(plugin)))
    assert after, "what is asked next is answered"
    assert words in again


def _tried_twice(plugin: str) -> tuple[str, bool, str]:
    plugin_process.TIME_LIMIT = 0.5
    samplers.load_plugin(plugin)
    asked = _complaint(lambda: _points_and_weights(7))
    fine = samplers.points("mine", 8)
    return asked, bool(np.all(fine < 1.0)), _complaint(lambda: _points_and_weights(7))


def _points_and_weights(n: int) -> None:
    sampler = samplers.Sampler("mine", n)
    sampler.points(n)
    sampler.weights(n)


def _complaint(act: Callable[[], Any]) -> str:
    try:
        act()
    except AliascopeError as error:
        return str(error)
    return "no error"


def test_memory_that_it_may_not_have_is_said_with_the_limit(tmp_path: Path) -> None:
    much = ("mine *state = malloc(sizeof *state);", "mine *state = malloc(sizeof *state << 40);")
    failed = separately("points", "mine", "-n", "4", "--plugin", compiled(tmp_path, GOOD, much), code=4).stderr
    assert re.search(r"out of memory: the plugin may take \d\S* GiB", failed)


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("raise(SIGBUS);", "as it was loaded, the plugin crashed with SIGBUS"),
        ("for (;;) sleep(1);", "as it was loaded, the plugin had not answered within 2 s"),
        ("_exit(3);", "as it was loaded, the plugin ended its process with exit code 3"),
    ],
)
def test_one_that_does_it_as_it_is_loaded_is_no_plugin(tmp_path: Path, code: str, words: str) -> None:
    begins = f"#include <signal.h>\n__attribute__((constructor)) static void begin(void) {{ {code} }}"
    plugin = compiled(tmp_path, GOOD, in_place("globals", begins))
    assert words in in_a_fork(_loaded, str(plugin))


def _loaded(plugin: str) -> str:
    plugin_process.TIME_LIMIT = 2.0
    return _complaint(lambda: samplers.load_plugin(plugin))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"mine",', '"mi\\033[2Jne",', "the name of its sampler is not kebab-case"),
        ('"mine",', '"<script>",', "the name of its sampler is not kebab-case"),
        ('"random points"', f'"{"long " * 99}"', "a text of its table is too long"),
        ('{"power", ASC_REAL, NULL, 0.5, 2.0, 1.0', '{"power", ASC_REAL, NULL, 0.5, 2.0, 3.0', "not within its range"),
        (
            '{"power", ASC_REAL, NULL, 0.5, 2.0, 1.0',
            '{"power", ASC_CHOICE, "a|b", 0.5, 2.0, 2.0',
            "not within its range",
        ),
        ('{"power", ASC_REAL, NULL', '{"po wer", ASC_REAL, NULL', "not kebab-case"),
        (".parameter_count = 1", ".parameter_count = 65", "at most 64 parameters"),
    ],
)
def test_a_table_that_lies_is_refused(tmp_path: Path, old: str, new: str, words: str) -> None:
    plugin = compiled(tmp_path, GOOD, (old, new))
    failed = separately("list", "samplers", "--plugin", plugin, code=2).stderr
    assert words in failed
    assert len(failed.splitlines()) == 1


def test_texts_of_a_table_reach_no_terminal(tmp_path: Path) -> None:
    plugin = compiled(tmp_path, GOOD, ('"random points"', '"\\033[2J\\xff points"'))
    listed = separately("list", "samplers", "--plugin", plugin).stdout
    assert "\\x1b[2J" in listed
    assert "\x1b" not in listed


def test_a_crash_loses_its_picture_alone(tmp_path: Path) -> None:
    crash = in_place("filled", "if (state->samples == 7) *(volatile int *)0 = 0;")
    plugin = compiled(tmp_path, GOOD, crash)
    modes = [word for n in (4, 7, 16) for word in ("-m", f"uniform:n={n},sampler=mine")]
    words = ("--size", "16x12", "-o", tmp_path / "out", "-j", "1", "--json")
    document = json.loads(separately("compare", "edge", *modes, *words, "--plugin", plugin, code=4).stdout)
    assert (document["pictures"], document["failed"]) == (6, 3)  # three seeds
    for failure in document["failures"]:
        assert "n=7" in failure["command"]
        assert "the plugin crashed with SIGSEGV" in failure["message"]


@pytest.mark.parametrize("which", ["the command", "the process that ends the plugin"])
def test_a_plugin_ends_with_those_who_ask_it(tmp_path: Path, which: str) -> None:
    """Also one that is busy for ever."""
    plugin = compiled(tmp_path, GOOD, in_place("filled", "for (;;) sleep(1);"))
    context = multiprocessing.get_context("fork")
    out, into = context.Pipe(duplex=False)
    process = context.Process(target=_fills, args=(into, str(plugin)))
    process.start()
    hosts = out.recv()
    assert hosts
    os.kill(process.pid or 0 if which == "the command" else hosts[0], signal.SIGKILL)
    process.join()
    deadline = time.monotonic() + 60.0
    while any(Path(f"/proc/{host}").exists() for host in hosts):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def _fills(into: Connection, plugin: str) -> None:
    samplers.load_plugin(plugin)
    into.send(list(_below(os.getpid())))
    _complaint(lambda: samplers.points("mine", 8))


def _below(process: int) -> Iterator[int]:
    for child in Path(f"/proc/{process}/task/{process}/children").read_text().split():
        yield int(child)
        yield from _below(int(child))


def test_trusted_or_not_is_said_once(tmp_path: Path) -> None:
    plugin = compiled(tmp_path)
    failed = separately("list", "samplers", "--plugin", plugin, "--trust-plugin", plugin, code=2).stderr
    assert "give it with --plugin or with --trust-plugin, not with both" in failed


WORKS = """
  struct timespec now = {0};
  for (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now); now.tv_sec == 0 && now.tv_nsec < 50000000;)
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
"""
"""Until its thread has had 50 ms of a processor in all."""


def test_its_work_is_in_the_cost_of_the_picture_and_is_no_load_of_others(tmp_path: Path) -> None:
    plugin = str(compiled(tmp_path, GOOD, in_place("globals", "#include <time.h>"), in_place("filled", WORKS)))
    cost, effort = in_a_fork(_worked, plugin)
    assert cost >= 0.04  # some of the 50 ms went by as the plugin was loaded
    assert effort.own >= 0.04
    assert effort.used >= effort.own


def _worked(plugin: str) -> tuple[float, calibration.Effort]:
    samplers.load_plugin(plugin)
    ended = calibration.effort()
    made = tracer.Tracer(scene_io.load("edge").scene, (8, 8))
    cost = made.render("mine", 1, 0, 1)[1]
    return cost.cpu_seconds, ended()


def test_times_are_kept_apart_by_where_it_ran(tmp_path: Path) -> None:
    plugin = compiled(tmp_path)
    words = ("compare", "edge", "-m", "uniform:n=4,sampler=mine", "--size", "16x12", "-o", tmp_path / "out", "--json")
    for option, rendered in (("--plugin", 3), ("--trust-plugin", 3), ("--plugin", 0)):
        done = separately(*words, option, plugin)
        document = json.loads(done.stdout)
        assert (document["pictures"], document["rendered"]) == (3, rendered), option
        told = "runs behind a fence: its times have that in them; --trust-plugin is for one of yours"
        assert (told in done.stderr, "--trust-plugin" in done.stderr) == (option == "--plugin",) * 2
    another = [word.replace("mine", "random") if isinstance(word, str) else word for word in words]
    assert "--trust-plugin" not in separately(*another, "--plugin", plugin).stderr
