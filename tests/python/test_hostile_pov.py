"""A `.pov` file of somebody else: what it may not read, write, start or use up, whichever way it is held here."""

from __future__ import annotations

import shutil
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fake_povray
import pytest
from commands import environment

from aliascope import errors, landlock
from aliascope.renderers import confinement, povray_file, povray_process
from aliascope.renderers.confinement import Protection
from aliascope.renderers.povray_file import PovFile
from aliascope.studies import doctor

BALL = "camera { location <0, 0, -3> look_at 0 } sphere { 0, 1 pigment { rgb 1 } finish { ambient 1 } }\n"
SIZE = (32, 24)
LIMIT = 120.0
UNCONFINED = Protection("limits alone", network=False)


def _ways() -> list[Protection]:
    """What works here: the best, the one after it, and none, which is everywhere."""
    found = [confinement.protection()]
    if found[0].by == "bubblewrap":
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(confinement.shutil, "which", _without_bubblewrap)
            found.append(confinement.protection.__wrapped__())
    return [each for each in found if each.files] + [UNCONFINED]


_which = shutil.which


def _without_bubblewrap(name: str, **options: Any) -> str | None:
    return None if name == "bwrap" else _which(name, **options)


@pytest.fixture(params=_ways(), ids=lambda way: way.by.replace(" ", "-"))
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Protection:
    """Each way to hold a scene that works here."""
    monkeypatch.setattr(confinement, "protection", lambda: request.param)
    chosen: Protection = request.param
    return chosen


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A folder with a scene's parts in it, beside one that is none of the scene's business."""
    folder = tmp_path / "scene"
    (folder / "below").mkdir(parents=True)
    (folder / "below" / "ball.inc").write_text(BALL)
    other = tmp_path / "other"
    other.mkdir()
    (other / "secret.inc").write_text("#declare Secret = 1;\n" + BALL)
    (folder / "link.inc").symlink_to(other / "secret.inc")
    return folder


def draw(folder: Path, text: str, limit: float = LIMIT) -> povray_file.Drawn:
    """As a sweep draws it. The check of its text is passed by, as macros pass it."""
    scene = folder / "scene.pov"
    scene.write_text("#version 3.7; global_settings { assumed_gamma 1 }\n" + text)
    return povray_file.draw(PovFile(scene, povray_file.library_paths()), SIZE, ("-A",), limit)


def test_a_scene_reads_its_folder_and_povrays_own(place: Path, way: Protection) -> None:
    drawn = draw(place, '#include "below/ball.inc"\n#include "colors.inc"\n')
    assert drawn.pixels.max() == 1.0


READS = {
    "absolute": '#include "{other}/secret.inc"',
    "upward": '#include "../other/secret.inc"',
    "link": '#include "link.inc"',
    "spelled": '#include concat("../oth", "er/secret.inc")',
    "data": '#fopen F "{other}/secret.inc" read #read (F, A)\n#include "below/ball.inc"',
    "password": '#fopen F "/etc/passwd" read #read (F, A)\n#include "below/ball.inc"',
    "picture": '#include "below/ball.inc"\nbox {{ 0, 1 pigment {{ image_map {{ png "{other}/grey.png" }} }} }}',
    "key": '#fopen F "{home}/.ssh/id" read #read (F, A)\n#include "below/ball.inc"',
}


@pytest.mark.parametrize("read", READS)
def test_a_scene_reads_nothing_else(
    place: Path, way: Protection, read: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    home, other = tmp_path / "home", tmp_path / "other"
    (home / ".ssh").mkdir(parents=True)
    (home / ".ssh" / "id").write_text("1, 2\n")
    fake_povray.write_png(other / "grey.png", 8, 8)
    monkeypatch.setenv("HOME", str(home))
    text = READS[read].format(other=other, home=home)
    if not way.files:
        assert "it can read and write what you can" in way.told
        return
    with pytest.raises(errors.AliascopeError, match=r"[Cc]annot (open|find)") as caught:
        draw(place, text)
    assert caught.value.exit_code in (2, 4)
    assert str(caught.value).isprintable()


def test_what_is_not_there_is_said_with_what_a_scene_may_read(place: Path, way: Protection) -> None:
    with pytest.raises(errors.InvalidInput, match=r"scene.pov:2: .*a scene reads what lies in its folder and below"):
        draw(place, '#include "nowhere.inc"')


@pytest.mark.parametrize("target", ["{other}/new.txt", "../other/new.txt", "new.txt", "/tmp/aliascope-hostile-new.txt"])
def test_a_scene_writes_nothing(place: Path, way: Protection, target: str, tmp_path: Path) -> None:
    if not way.files:
        return
    name = target.format(other=tmp_path / "other")
    with pytest.raises(errors.InvalidInput, match="Cannot open user file"):
        draw(place, f'#fopen F "{name}" write #write (F, "x") #fclose F\n#include "below/ball.inc"')
    assert not list(tmp_path.rglob("new.txt"))
    assert not Path("/tmp/aliascope-hostile-new.txt").exists()


def test_what_its_text_says_of_writing_is_refused_before(place: Path) -> None:
    scene = place / "scene.pov"
    scene.write_text(BALL + '#fopen F "old.txt" read\n/* of two\nlines */ #fopen G "new.txt" write')
    told = r'scene.pov:4: the scene writes files \(lines \*/ #fopen G "new.txt" write\)'
    with pytest.raises(errors.InvalidInput, match=told):
        povray_file.open_file(scene)


def test_no_command_is_run(place: Path, way: Protection, tmp_path: Path) -> None:
    """An ini file can name commands, and a scene cannot name an ini file; were one taken all the same, POV-Ray's own
    setting forbids them."""
    ini = place / "commands.ini"
    ini.write_text(f'Pre_Scene_Command="touch {tmp_path}/ran"\n')
    scene = place / "scene.pov"
    scene.write_text(BALL)
    output = ""
    try:
        povray_file.draw(PovFile(scene, ()), SIZE, (str(ini),), LIMIT)
    except errors.JobFailed as error:
        output = str(error)
    assert not (tmp_path / "ran").exists()
    assert "prohibited" in output or "shellout" not in output


LOOP = "#while (1) #end"


def test_a_scene_that_never_ends_is_ended(place: Path, way: Protection) -> None:
    with pytest.raises(povray_process.TimeLimit, match="not ended after 1 s"):
        draw(place, BALL + LOOP, 1.0)


def test_memory_has_a_limit(place: Path, way: Protection, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(confinement, "memory_limit", lambda: 1 << 30)
    with pytest.raises(errors.AliascopeError, match="asked for more than 1 GiB of memory"):
        draw(place, BALL + "#declare Large = array[400000000];")


def test_output_has_a_limit(place: Path, way: Protection, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In one file."""
    monkeypatch.setattr(povray_file, "LEAST_LEFT", 1 << 20)
    folder = fake_povray.install(tmp_path / "bin", "exec cat /usr/lib/*/lib[c-m]*.so* > $HOME/f")
    monkeypatch.setenv("PATH", environment(folder)["PATH"])
    with pytest.raises(errors.JobFailed, match="wrote more than 1 MiB into a file, the most that it may"):
        draw(place, BALL)


def test_many_files_have_a_limit(place: Path, way: Protection, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(confinement, "MOST_FILES", 40)
    folder = fake_povray.install(tmp_path / "bin", "cd $HOME; for i in $(seq 50); do echo x > f$i; done; sleep 60")
    monkeypatch.setenv("PATH", environment(folder)["PATH"])
    with pytest.raises(errors.JobFailed, match="left more than 40 files in its scratch folder, and was killed"):
        draw(place, BALL)


def test_a_full_scratch_folder_has_a_limit(
    place: Path, way: Protection, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(povray_file, "LEAST_LEFT", 1 << 20)
    body = "cd $HOME; for i in 1 2 3; do head -c 1000000 /usr/bin/env /usr/lib/*/libc.so.6 > f$i; done; sleep 60"
    folder = fake_povray.install(tmp_path / "bin", body)
    monkeypatch.setenv("PATH", environment(folder)["PATH"])
    with pytest.raises(errors.JobFailed, match="left more than 2 MiB in its scratch folder, and was killed"):
        draw(place, BALL)


@pytest.fixture
def listening() -> Iterator[tuple[int, list[int]]]:
    """A port of this machine, and who came."""
    came: list[int] = []
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(0.2)
        stop = threading.Event()

        def serve() -> None:
            while not stop.is_set():
                try:
                    server.accept()[0].close()
                except OSError:
                    continue
                came.append(1)

        thread = threading.Thread(target=serve)
        thread.start()
        yield server.getsockname()[1], came
        stop.set()
        thread.join()


def test_no_network(place: Path, way: Protection, tmp_path: Path, listening: tuple[int, list[int]]) -> None:
    """Of a program that would use it: bash, which POV-Ray is not."""
    port, came = listening
    folder = tmp_path / "scratch"
    folder.mkdir()
    fence = confinement.Fence((), folder, 1 << 20, 1 << 20, 4 << 30, 60)
    with confinement.held(fence, {}) as held:
        command = [*held.before, "/bin/bash", "-c", f"echo x > /dev/tcp/127.0.0.1/{port}"]
        done = subprocess.run(command, preexec_fn=held.in_child, capture_output=True, timeout=60, check=False)
    open_to_it = not way.network and not (way.by == "Landlock" and landlock.closes_network())
    assert (done.returncode == 0) == open_to_it
    if not open_to_it:
        assert not came


def test_it_sees_neither_other_processes_nor_the_environment(
    place: Path, way: Protection, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ALIASCOPE_SECRET", "hidden")
    folder = fake_povray.install(tmp_path / "bin", "env; ls /proc/[0-9]*/environ /etc/shadow 2>&1; exit 1")
    monkeypatch.setenv("PATH", environment(folder)["PATH"])
    with pytest.raises(errors.JobFailed) as caught:
        draw(place, BALL)
    cause = caught.value.__cause__
    assert isinstance(cause, povray_process.RunFailed)
    assert "hidden" not in cause.output
    if way.by == "bubblewrap":
        assert "cannot access '/proc/" in cause.output
        assert "cannot access '/etc/shadow'" in cause.output


def test_a_killed_scene_leaves_no_process(
    place: Path, way: Protection, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mark = f"{4000 + (hash(str(tmp_path)) & 0xFFFF)}.25"
    folder = fake_povray.install(tmp_path / "bin", f"sleep {mark} & sleep {mark}")
    monkeypatch.setenv("PATH", environment(folder)["PATH"])
    with pytest.raises(povray_process.TimeLimit):
        draw(place, BALL, 1.0)

    def there() -> bool:
        return any(mark in _words(path) for path in Path("/proc").glob("[0-9]*"))

    assert fake_povray_waits(lambda: not there())


def _words(path: Path) -> str:
    try:
        return (path / "cmdline").read_text(errors="replace")
    except OSError:
        return ""


def fake_povray_waits(done: Any) -> bool:
    """Whether it is so within a minute: what is killed in a namespace goes with its first process."""
    for _ in range(600):
        if done():
            return True
        threading.Event().wait(0.1)
    return False


def test_a_confinement_that_fails_is_no_crash(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As where Landlock is taken away between the probe and the run."""

    def refuse(rules: int) -> None:
        raise OSError(1, "Operation not permitted")

    monkeypatch.setattr(confinement, "protection", lambda: Protection("Landlock", network=False))
    monkeypatch.setattr(landlock, "ruleset", lambda *_: -1 if not landlock.abi() else _nothing())
    monkeypatch.setattr(landlock, "restrict", refuse)
    if landlock.abi():
        with pytest.raises(errors.NotAvailable, match="cannot be confined here"):
            draw(place, BALL)


def _nothing() -> int:
    import os

    return os.open(os.devnull, os.O_RDONLY)


# --- before POV-Ray sees it -------------------------------------------------------------------------------------------


def test_a_scene_in_the_home_folder_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It could read all that lies there, keys too."""
    scene = tmp_path / "scene.pov"
    scene.write_text(BALL)
    for home in (tmp_path, tmp_path / "user" / "home"):
        monkeypatch.setenv("HOME", str(home))
        with pytest.raises(errors.InvalidInput, match="has your home folder in it, or is that: move the scene"):
            povray_file.open_file(scene)
    monkeypatch.setenv("HOME", "/")
    assert povray_file.open_file(scene).path == scene


@pytest.mark.parametrize(
    "name", ['a"b.pov', "a=b.pov", "a;b.pov", "a'b.pov", "a\nPre_Scene_Command=touch x.pov", "\x1b[31m.pov"]
)
def test_the_name_of_a_scene_is_one_in_an_ini_file(place: Path, name: str) -> None:
    (place / name).write_text(BALL)
    with pytest.raises(errors.InvalidInput, match="rename the scene") as caught:
        povray_file.open_file(place / name)
    assert str(caught.value).isprintable()


def test_includes_that_lead_out_are_not_looked_at(place: Path) -> None:
    """Their lines would stand in an error."""
    (place.parent / "other" / "secret.inc").write_text('camera {} #fopen Secret "x" write')
    for name in ("../other/secret.inc", "link.inc", f"{place.parent}/other/secret.inc", "a\0b", "x" * 5000):
        scene = place / "scene.pov"
        scene.write_text(f'#include "{name}"\n')
        with pytest.raises(errors.InvalidInput, match="no camera"):
            povray_file.open_file(scene)


def test_includes_of_each_other_end(place: Path) -> None:
    (place / "a.inc").write_text('#include "below/../b.inc"\n' + BALL)
    (place / "b.inc").write_text('#include "below/../a.inc"\n#include "./scene.pov"\n')
    scene = place / "scene.pov"
    scene.write_text('#include "a.inc"\n')
    assert povray_file.open_file(scene).path == scene
    for number in range(povray_file.MOST_TEXTS + 1):
        (place / f"{number}.inc").write_text(f'#include "{number + 1}.inc"\n')
    scene.write_text(BALL + '#include "0.inc"\n')
    with pytest.raises(errors.InvalidInput, match="at most 1000 files and 64 MiB"):
        povray_file.open_file(scene)


TANGLES = {
    "comments": "/*" * 200_000,
    "quotes": '\\"' * 200_000,
    "lines": '"\\' * 200_000,
    "opens": "#fopen a " * 100_000,
    "includes": "#include " * 100_000,
    "blanks": "#fopen" + " " * 500_000,
}


def test_no_text_takes_longer_than_its_length(place: Path) -> None:
    """In a process that has to end: what grows with the square of these takes hours."""
    for name, tangle in TANGLES.items():
        (place / f"{name}.pov").write_text(BALL + tangle)
    code = "import sys; from pathlib import Path; from aliascope.renderers import povray_file as f; "
    code += "[f.open_file(Path(name)) for name in sys.argv[1:]]"
    names = [str(place / f"{name}.pov") for name in TANGLES]
    subprocess.run([sys.executable, "-c", code, *names], timeout=240, check=True)


def test_what_a_scene_prints_is_told_from_statistics(place: Path) -> None:
    """Numbers that are none, and beginnings without an end."""
    text = "Pixels: 1 Samples: 1\n" * 2000 + "Trace Time: (1.1.1 seconds)\nParse Time: (1.2.3 seconds)\n" * 500
    assert povray_process.read_statistics(text) == []
    assert povray_file._parse_seconds(text + "Parse Time: " * 5000) == 0.0


# --- what is said -----------------------------------------------------------------------------------------------------


def test_without_confinement_it_is_said(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (place / "scene.pov").write_text(BALL)
    monkeypatch.setattr(confinement, "protection", lambda: UNCONFINED)
    assert "can read and write what you can" in " ".join(povray_file.open_file(place / "scene.pov").notes)
    assert "limits on time, memory and output alone" in doctor.lines_of(doctor.examine(["embree"], quick=True))[2]


def test_the_probe_does_not_believe_a_bubblewrap_that_holds_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "bin"
    folder.mkdir()
    program = folder / "bwrap"
    program.write_text('#!/bin/sh\nwhile [ "$1" != -- ]; do shift; done; shift; exec "$@"\n')
    program.chmod(0o755)
    monkeypatch.setenv("PATH", environment(folder)["PATH"])
    assert confinement.protection.__wrapped__().by != "bubblewrap"


def test_the_doctor_says_what_holds_a_scene() -> None:
    document = doctor.examine(["embree"], quick=True)
    assert document["confinement"]["by"] == confinement.protection().by
    assert confinement.protection().told in " ".join(" ".join(doctor.lines_of(document)).split())


def test_limits_of_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    assert confinement.LEAST_MEMORY <= confinement.memory_limit() <= confinement.MOST_MEMORY
