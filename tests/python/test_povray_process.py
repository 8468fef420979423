"""What the POV-Ray renderer makes of trouble: each failure is one line, of the right kind, with nothing left behind."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import fake_povray
import pytest
from povray_scenes import PLAIN, render

from aliascope.errors import AliascopeError, JobFailed, NotAvailable
from aliascope.renderers import povray_process
from aliascope.renderers.povray import RENDERER
from aliascope.renderers.povray_process import KEPT_BYTES, run


@pytest.fixture
def fake(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Puts a povray with the given commands first on the PATH."""

    def install(body: str) -> None:
        folder = fake_povray.install(tmp_path / "bin", body)
        monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")

    return install


def failure(kind: type[AliascopeError], text: str = "none", **options: Any) -> str:
    """The one line that rendering fails with."""
    with pytest.raises(kind) as caught:
        render(PLAIN, text, **options)
    assert caught.value.exit_code == kind.exit_code
    message = str(caught.value)
    assert message.isprintable()  # so it is one line
    assert len(message) < 500
    return message


def test_a_good_fake_makes_a_picture(fake: Any, tmp_path: Path) -> None:
    """So that the failures below are of what each of them does, and not of the fake."""
    fake(fake_povray.leaving(fake_povray.write_png(tmp_path / "good.png", 8, 8)))
    rendering = render(PLAIN, "none")
    assert rendering.cost.samples == 64
    assert (rendering.cost.cpu_seconds, rendering.cost.wall_seconds) == (0.002, 0.003)


def test_without_povray(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "not installed" in failure(NotAvailable)
    with pytest.raises(NotAvailable, match="not installed"):
        RENDERER.versions()


def test_a_file_that_is_no_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "povray").write_bytes(b"\x7fELF no")
    (tmp_path / "povray").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "does not start" in failure(NotAvailable)


def test_a_program_that_states_no_version(fake: Any) -> None:
    fake("echo something else")
    with pytest.raises(NotAvailable, match="does not state a version"):
        RENDERER.versions()


def test_an_error_exit_shows_its_last_lines(fake: Any) -> None:
    fake("echo early; echo 'Parse Error: No matching' >&2; echo ' brace \033[1m' >&2; echo 'Render failed' >&2; exit 1")
    message = failure(JobFailed)
    assert "status 1: Parse Error: No matching brace ?[1m Render failed" in message


STARVED = r"echo run >> runs; printf 'Timed out waiting for\n  worker thread startup\n' >&2; exit 1"


def test_one_that_was_too_busy_to_start_is_started_again(fake: Any, tmp_path: Path) -> None:
    """Its words are broken over lines where they happen to be; the folder is the same in all tries of a picture."""
    good = fake_povray.leaving(fake_povray.write_png(tmp_path / "good.png", 8, 8))
    fake(f"if [ $(wc -l < runs || echo 0) -ge 2 ]; then {good}; else {STARVED}; fi")
    assert render(PLAIN, "none").cost.samples == 64


def test_one_that_never_starts_is_given_up(fake: Any, tmp_path: Path) -> None:
    fake(f"echo try >> {tmp_path}/tries; {STARVED}")
    assert "worker thread startup" in failure(JobFailed)
    assert (tmp_path / "tries").read_text().count("try") == povray_process.STARTS


def test_death_by_a_signal_is_named(fake: Any) -> None:
    fake("echo tracing >&2; kill -SEGV $$")
    assert "SIGSEGV: tracing" in failure(JobFailed)


def test_a_program_that_hangs_is_killed_with_its_children(fake: Any, tmp_path: Path) -> None:
    fake(fake_povray.recording_its_processes(tmp_path / "record"))
    assert "after 1 s, its time limit" in failure(JobFailed, time_limit=1.0)
    numbers = fake_povray.recorded(tmp_path / "record")
    assert len(numbers) == 2
    assert all(fake_povray.ends(pid) for pid in numbers)


def test_a_child_that_stays_behind_holds_nothing_up(fake: Any, tmp_path: Path) -> None:
    """It has the pipe open, so there is no end of file to wait for."""
    picture = fake_povray.write_png(tmp_path / "good.png", 8, 8)
    fake(f"sleep 60 & echo $! > {tmp_path}/record; {fake_povray.leaving(picture)}")
    start = time.monotonic()
    assert render(PLAIN, "none", time_limit=20.0).cost.samples == 64
    assert time.monotonic() - start < 10.0  # seconds; it takes 0.01, and waiting for the child would take 60
    assert all(fake_povray.ends(pid) for pid in fake_povray.recorded(tmp_path / "record"))


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells a child of its parent's death")
def test_a_worker_that_is_killed_takes_povray_with_it(fake: Any, tmp_path: Path) -> None:
    fake(f"echo $$ > {tmp_path}/part; mv {tmp_path}/part {tmp_path}/record; exec sleep 60")
    script = "import sys; from pathlib import Path; from aliascope.renderers.povray_process import run, executable; "
    script += "run(executable(), [], Path(sys.argv[1]), 60.0)"
    worker = subprocess.Popen([sys.executable, "-c", script, str(tmp_path)])
    try:
        (pid,) = fake_povray.recorded(tmp_path / "record", patience=20.0)
        assert fake_povray.alive(pid)
    finally:
        worker.send_signal(signal.SIGKILL)
        worker.wait()
    assert fake_povray.ends(pid)


def test_a_flood_of_output_is_not_kept(fake: Any, tmp_path: Path) -> None:
    fake("head -c 200000000 /dev/zero | tr '\\0' 'x'; echo; echo 'the last words'; exit 1")
    assert "the last words" in failure(JobFailed)
    fake("head -c 20000000 /dev/zero")
    assert len(run(str(tmp_path / "bin" / "povray"), [], tmp_path, 20.0)) == KEPT_BYTES
    fake("exec cat /dev/zero")
    assert "time limit" in failure(JobFailed, time_limit=1.0)


def test_success_without_a_picture_is_a_failure(fake: Any) -> None:
    fake(f"printf '%s' '{fake_povray.STATISTICS}'")
    assert "left no picture" in failure(JobFailed)


def test_success_without_statistics_is_a_failure(fake: Any, tmp_path: Path) -> None:
    fake(f"cp {fake_povray.write_png(tmp_path / 'good.png', 8, 8)} picture.png")
    assert "statistics of 0 pictures instead of 1" in failure(JobFailed)


@pytest.mark.parametrize(("width", "height", "channels"), [(8, 7, 3), (16, 4, 3), (8, 8, 4), (8, 8, 1)])
def test_a_picture_of_another_size_is_a_failure(
    fake: Any, tmp_path: Path, width: int, height: int, channels: int
) -> None:
    fake(fake_povray.leaving(fake_povray.write_png(tmp_path / "other.png", width, height, channels)))
    assert f"{width}x{height} pixels and {channels} channels instead of 8x8 and 3" in failure(JobFailed)


def test_a_picture_cut_short_is_a_failure(fake: Any, tmp_path: Path) -> None:
    picture = fake_povray.write_png(tmp_path / "short.png", 8, 8)
    picture.write_bytes(picture.read_bytes()[:-30])
    fake(fake_povray.leaving(picture))
    assert "broken picture" in failure(JobFailed)
    picture.write_bytes(b"")
    assert "broken picture" in failure(JobFailed)


def test_what_povray_says_of_an_error_is_passed_on(tmp_path: Path) -> None:
    (tmp_path / "scene.pov").write_text("sphere { 1 2")
    path = shutil.which("povray")
    assert path
    with pytest.raises(JobFailed, match=r"status 1: .*Cannot parse input"):
        run(path, ["+Iscene.pov", "-D"], tmp_path, 20.0)
