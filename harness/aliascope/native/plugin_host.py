"""The process of one plugin: python -P -m aliascope.native.plugin_host SHARED ALIVE MEMORY PATH.

SHARED is the file of the memory that it shares with its client, ALIVE the socket that ends with the client, MEMORY what
the plugin may have, in bytes. There are two processes: the outer one, in which no line of the plugin runs, ends the
inner one when the client ends or closes its socket, and ends as that one does.
"""

from __future__ import annotations

import ctypes
import os
import select
import signal
import socket
import sys
import time
from pathlib import Path
from typing import NoReturn

SIGNALLED = 128
"""What the outer process ends with where a signal ended the inner one, and its number."""

_SET_PARENT_DEATH_SIGNAL = 1
"""PR_SET_PDEATHSIG of linux/prctl.h."""


def main() -> None:
    shared, alive, memory = (int(word) for word in sys.argv[1:4])
    path = sys.argv[4]
    client = socket.socket(fileno=alive)
    inner = os.fork()
    if inner == 0:
        client.close()
        ctypes.CDLL(None).prctl(_SET_PARENT_DEATH_SIGNAL, signal.SIGKILL)  # the outer one may be killed itself
        _serve(shared, path, memory)
    os.close(shared)
    ended = os.pidfd_open(inner)
    ready, _, _ = select.select([client.fileno(), ended], [], [])
    if ended not in ready:
        os.kill(inner, signal.SIGKILL)
    status = os.waitstatus_to_exitcode(os.waitpid(inner, 0)[1])
    os._exit(SIGNALLED - status if status < 0 else status)


def _serve(shared: int, path: str, memory: int) -> NoReturn:
    """Holds this process, and lets the plugin's threads answer."""
    from aliascope.native import plugin_fence
    from aliascope.native.loading import error_box, module

    library = module("_sampler", "the library libaliascope")
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the client's to handle
    plugin_fence.hold(Path(path), memory)
    library.lib.asc_plugin_serve(shared, os.fsencode(path), error_box(library.ffi))
    while True:
        time.sleep(3600)


if __name__ == "__main__":
    main()
