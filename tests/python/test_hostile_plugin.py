"""`aliascope plugin check` of a plugin that does, as soon as it is loaded, what nobody asked of it."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest
from commands import in_a_fork, run
from test_plugin_check import GOOD, compiled, in_place

from aliascope import landlock
from aliascope.studies.plugin_probe import TABLE, run_check

LOOKS = r"""
#include <arpa/inet.h>
#include <stdio.h>
#include <sys/socket.h>
#include <sys/wait.h>

static char told[99] = "did:";

static void did(const char *what, int it) { if (it) strcat(told, what); }

static int opened(const char *path, const char *how) {
  FILE *file = fopen(path, how);
  if (file) fclose(file);
  return file != NULL;
}

static int connected(int port) {
  struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = htons(port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
  return connect(socket(AF_INET, SOCK_STREAM, 0), (struct sockaddr *)&to, sizeof to) == 0;
}

__attribute__((constructor)) static void look(void) {
  did(" data", opened(getenv("LOOK_BESIDE"), "r"));
  did(" read", opened(getenv("LOOK_SECRET"), "r"));
  did(" write", opened(getenv("LOOK_NEW"), "w"));
  did(" write-beside", opened(getenv("LOOK_BESIDE"), "a"));
  did(" start", system("exit 0") == 0);
  did(" connect", connected(atoi(getenv("LOOK_PORT"))));
}
"""
EVERYTHING = "did: data read write write-beside start connect"


@pytest.fixture
def looking(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "theirs"
    folder.mkdir()
    plugin = compiled(folder, GOOD, in_place("globals", LOOKS), ('.title = "random points"', ".title = told"))
    (tmp_path / "secret").write_text("mine")
    monkeypatch.setenv("LOOK_BESIDE", str(folder / "mine.c"))
    monkeypatch.setenv("LOOK_SECRET", str(tmp_path / "secret"))
    monkeypatch.setenv("LOOK_NEW", str(tmp_path / "new"))
    return plugin


def test_a_plugin_that_is_checked_reads_its_folder_and_does_nothing_else(
    looking: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        monkeypatch.setenv("LOOK_PORT", str(server.getsockname()[1]))
        done = run("plugin", "check", looking)
        assert done.returncode == 0, done.stdout
        # Free, it does all of it: what it did not do above, it was kept from.
        free = in_a_fork(run_check, TABLE, str(looking), None, print)["text"]
    assert EVERYTHING in free
    first = done.stdout.splitlines()[0]
    assert ("did: data (" in first) == bool(landlock.abi()), first
    secret, new = Path(os.environ["LOOK_SECRET"]), Path(os.environ["LOOK_NEW"])
    assert secret.read_text() == "mine"
    assert new.exists()  # by the free one


def test_a_plugin_in_the_home_folder_is_read_alone(looking: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(looking.parent))
    monkeypatch.setenv("LOOK_PORT", "1")
    first = run("plugin", "check", looking).stdout.splitlines()[0]
    assert ("did: (" in first) == bool(landlock.abi()), first
