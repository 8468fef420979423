"""What others may read: no folder of the user's home, no password, and commands that still work when pasted."""

from __future__ import annotations

import json
import os
import re
import shutil
import sqlite3
import subprocess
import zlib
from pathlib import Path

import numpy as np
import pytest
from commands import run

from aliascope import cli, image, places, sharing
from aliascope.records import Failure
from aliascope.report.encode import from_text
from aliascope.sharing import command_line, masked, records_shared, shared, shell_word
from aliascope.studies import sweep_scene
from aliascope.studies.sweep_search import Candidate

NAME = "mrs-nobody"
"""Of the user, in whose home all is."""


@pytest.fixture(autouse=True)
def home(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.getbasetemp() / "homes" / NAME
    folder.mkdir(parents=True, exist_ok=True)
    monkeypatch.setenv("HOME", str(folder))
    return folder


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("{home}/a.toml:3: wrong", "~/a.toml:3: wrong"),
        ("cannot read '{home}/a b.toml'", "cannot read '~/a b.toml'"),
        ("{home}", "~"),
        ("it is in {home}.", "it is in ~."),
        ("povray +I{home}/a.pov +L{home}", "povray +I~/a.pov +L~"),
        ("--out={home}/x,{home}/y", "--out=~/x,~/y"),
        ("file://{home}/x", "file://~/x"),
        ("{home}-old/x {home}.bak /data{home}2", "{home}-old/x {home}.bak /data{home}2"),
    ],
)
def test_the_home_is_a_tilde(home: Path, text: str, expected: str) -> None:
    assert shared(text.format(home=home)) == expected.format(home=home)


def test_a_home_behind_a_link_is_found_by_both_names(
    home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "link").symlink_to(home)
    monkeypatch.setenv("HOME", str(tmp_path / "link"))
    assert shared(f"{tmp_path}/link/a {home}/a") == "~/a ~/a"


def test_the_root_is_no_home(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/")
    assert shared("/etc/a /b; df / now") == "/etc/a /b; df / now"


@pytest.mark.parametrize(
    "word",
    [
        "{home}/a.toml",
        "{home}",
        "{home}/",
        "{home}/a b/c'd.toml",
        "--map={home}/$x/a.png",
        "+I{home}/a",
        "a b",
        "",
        "~/a",
    ],
)
def test_a_command_works_when_pasted(home: Path, word: str) -> None:
    word = word.format(home=home)
    line = command_line(["printf", "%s", word, "end"])
    assert str(home) not in line
    assert subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=True).stdout == f"{word}end"


def test_a_path_is_a_word_of_a_command(home: Path) -> None:
    assert shell_word(home / "out" / "a") == "~/out/a"
    assert shell_word(Path("/data/a b")) == "'/data/a b'"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("tcp://ada:lovelace@host:8786 is gone", "tcp://***@host:8786 is gone"),
        ("https://host/x?access_token=abc123&y=2", "https://host/x?access_token=***&y=2"),
        ("password: hunter2, again", "password: ***, again"),
        ('{"api_key": "abc"}', '{"api_key": ***}'),
        ("--tls-key /etc/key.pem --size 3x3", "--tls-key *** --size 3x3"),
        ("Authorization: Bearer abcdefghij", "Authorization: Bearer ***"),
        ("authorization: basic YWJjOmRlZg==", "authorization: basic ***"),
        ("token=a1 auth_token=a2 TOKEN=a3", "token=*** auth_token=*** TOKEN=***"),
        ("passwd=a1 db_password=a2 passphrase=a3", "passwd=*** db_password=*** passphrase=***"),
        ("client_secret=a1 AWS_CREDENTIALS=a2", "client_secret=*** AWS_CREDENTIALS=***"),
        ("apikey=a1 access_key=a2 private-key=a3 TLS_KEY=a4", "apikey=*** access_key=*** private-key=*** TLS_KEY=***"),
        ("secret='a b' token=\"c d\" end", "secret=*** token=*** end"),
        ("--Token 'a b' --PASSWORD a1 end", "--Token *** --PASSWORD *** end"),
        ("-----BEGIN PRIVATE KEY-----\nMII and no more", "***"),
        ("-----BEGIN RSA PRIVATE KEY-----\nMII\n-----END RSA PRIVATE KEY----- end", "*** end"),
        ("embree uniform:n=4,sampler=sobol: key 3 of a mesh", "embree uniform:n=4,sampler=sobol: key 3 of a mesh"),
        ("tcp://127.0.0.1:8786 and a@b", "tcp://127.0.0.1:8786 and a@b"),
    ],
)
def test_secrets_are_masked(text: str, expected: str) -> None:
    assert masked(text) == expected


def test_a_secret_is_masked_as_a_word_of_its_own() -> None:
    words = ["aliascope", "compare", "--cluster", "tls://me:pw@h:1", "--tls-key", "a b", "--auth-token=xyz", "-j", "2"]
    assert command_line(words) == "aliascope compare --cluster 'tls://***@h:1' --tls-key *** '--auth-token=***' -j 2"


@pytest.mark.parametrize("option", ["--token", "-token", "--API-KEY", "--db-passphrase", "-Secret"])
def test_the_word_after_an_option_that_says_so_is_masked(option: str) -> None:
    assert command_line(["x", option, "a b", "c"]) == f"x {option} *** c"


def test_a_home_that_is_none(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A relative one, one within the other, and a user whom nobody knows."""
    monkeypatch.setenv("HOME", "a/b")
    assert shared("a/b/c") == "a/b/c"
    (tmp_path / "me" / "real").mkdir(parents=True)
    (tmp_path / "me" / "real" / "link").symlink_to(tmp_path / "me" / "real")
    monkeypatch.setenv("HOME", f"{tmp_path}/me/real/link")
    assert shared(f"{tmp_path}/me/real/link/a {tmp_path}/me/real/b") == "~/a ~/b"
    monkeypatch.delenv("HOME")

    def unknown() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", unknown)
    sharing._homes_of.cache_clear()
    try:
        assert shared("/home/me/a") == "/home/me/a"
    finally:
        sharing._homes_of.cache_clear()


def test_lists_and_keys_are_shared_too(home: Path) -> None:
    assert records_shared([f"{home}/a", {f"{home}/b": [f"{home}/c"]}]) == ["~/a", {"~/b": ["~/c"]}]


def test_texts_in_records_in_any_depth(home: Path) -> None:
    failure = Failure("a", "b", "c", f"no {home}/x", f"cat {home}/x")
    found = records_shared({f"{home}/k": [(failure, 3, None)]})
    assert found == {"~/k": [(Failure("a", "b", "c", "no ~/x", "cat ~/x"), 3, None)]}
    assert records_shared(failure) is not failure
    plain = Failure("a", "b", "c", "d", "e")
    pixels = np.zeros(3)
    assert records_shared((plain, pixels))[1] is pixels
    assert records_shared(plain) is plain


# --- what the commands write ------------------------------------------------------------------------------------------

BROKEN = """name = "broken"
title = "Broken"
command = ["/bin/sh", "-c", "echo no {folder}/data, no tcp://me:secret-word@host; exit 3", "{scene.toml}", "{out}"]
output = { format = "exr", values = "linear" }
time = "cpu"
seeded = false
[modes.plain.keys]
[profiles]
quick = ["plain"]
"""


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A home in which commands have written; nothing in it but what they wrote, and under "mine" what is the user's."""
    folder = tmp_path_factory.mktemp("homes") / NAME
    mine = folder / "mine"
    mine.mkdir(parents=True)
    scene = shutil.copy(places.SCENES / "edge.toml", mine / "own.toml")
    (mine / "broken.toml").write_text(BROKEN)
    env = {**os.environ, "HOME": str(folder)}
    small, out = ["--size", "20x16"], folder / "out"
    embree, mode = ["-r", "embree"], ["-m", "uniform:n=4"]
    run("compare", scene, *embree, "-r", mine / "broken.toml", *mode, "-m", "plain", *small, "-o", out / "compare",
        code=4, env=env)  # fmt: skip
    out.joinpath("render").mkdir()
    run("render", scene, *embree, *mode, *small, "-o", out / "render" / "a.exr", env=env)
    run("reference", scene, *small, "-o", out / "references", env=env)
    run("agree", scene, *embree, "-r", "osmesa", *small, "--samples", "4", "--replicates", "4", "-j", "2", "-o",
        out / "agree", env=env)  # fmt: skip
    with pytest.MonkeyPatch.context() as patch:
        few = [[Candidate("embree", "uniform:n=4,sampler=random"), Candidate("embree", "uniform:n=9,sampler=random")]]
        patch.setattr(sweep_scene, "ladders_of", lambda scene: (few, {"povray": f"no {folder}/povray"}))
        run("sweep", scene, *small, "--budget", "4m", "-o", out / "sweep", env=env)
    run("regress", scene, *embree, *mode, "--references", out / "references", "-o", out / "regress",
        "--junit", out / "junit.xml", "--markdown", out / "review.md", code=1, env=env)  # fmt: skip
    run("stability", "variance/mean", "--quick", "-j", "1", "-o", out / "stability", env=env)
    return folder


def unpacked(path: Path) -> bytes:
    """The contents of a file, and what is deflated in a page."""
    data = path.read_bytes()
    if path.suffix != ".html":
        return data
    for text in re.findall(r">([^<]{16,})</script>", data.decode()):
        try:
            data += zlib.decompress(from_text(text))
        except (ValueError, IndexError, zlib.error):  # a script, or a picture
            continue
    return data


def files_of(folder: Path) -> list[Path]:
    return [path for path in sorted(folder.rglob("*")) if path.is_file() and folder / "mine" not in path.parents]


def test_no_file_that_was_written_names_the_home_the_user_or_the_machine(written: Path) -> None:
    found = files_of(written / "out")
    names = {path.relative_to(written / "out").as_posix() for path in found}
    assert {"compare/report.html", "compare/results.csv", "compare/results.sqlite", "compare/log.jsonl"} <= names
    assert {"render/a.exr", "references/own/20x16-box.exr", "agree/report.html", "agree/results.json"} <= names
    assert {"sweep/report.html", "regress/report.html", "junit.xml", "review.md", "stability/report.html"} <= names
    assert [path for path in found if NAME.encode() in unpacked(path)] == []
    assert [path for path in found if b"secret-word" in unpacked(path)] == []
    host = os.uname().nodename
    if len(host) > 5:  # a shorter one may stand in a picture by chance
        local = ("log.jsonl", "results.sqlite")
        assert [path for path in found if path.name not in local and host.encode() in unpacked(path)] == []


def test_the_search_would_find_it(written: Path, tmp_path: Path) -> None:
    page = (written / "out" / "compare" / "report.html").read_bytes()
    assert b"~/mine/own.toml" in unpacked(written / "out" / "compare" / "report.html")
    (tmp_path / "a.html").write_bytes(page)
    assert len(unpacked(tmp_path / "a.html")) > len(page)
    image.write_exr(tmp_path / "a.exr", np.zeros((2, 2, 3), np.float32), {"command": f"cat {written}/x"})
    assert NAME.encode() in unpacked(tmp_path / "a.exr")


def test_the_command_of_a_picture_works_when_pasted(written: Path, tmp_path: Path) -> None:
    command = image.read_header(written / "out" / "render" / "a.exr")["command"]
    assert command.startswith("aliascope render ~/mine/own.toml -r embree -m uniform:n=4")
    words = subprocess.run(
        ["bash", "-c", f"printf '%s\\n' {command}"],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "HOME": str(written)},
    ).stdout.splitlines()
    assert str(written / "mine" / "own.toml") in words
    run(*words[1:], cwd=tmp_path, env={**os.environ, "HOME": str(written)})
    assert np.array_equal(
        image.read_image(tmp_path / "out.exr"), image.read_image(written / "out" / "render" / "a.exr")
    )


def test_a_failed_job_can_be_run_again(written: Path) -> None:
    lines = [json.loads(line) for line in (written / "out" / "compare" / "log.jsonl").read_text().splitlines()]
    again = next(line["again"] for line in lines if line["event"] == "failed")
    assert again.startswith("aliascope render ~/mine/own.toml -r ~/mine/broken.toml -m plain --seed 0")
    store = sqlite3.connect(written / "out" / "compare" / "results.sqlite")
    assert store.execute("SELECT DISTINCT scene_path FROM job").fetchall() == [("~/mine/own.toml",)]
    store.close()


def test_the_machine_is_told_without_its_name() -> None:
    assert set(places.machine()) == {"processor", "cores", "system"}
    assert os.uname().nodename not in places.machine().values()


def test_of_the_command_line_too(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["x", "compare", f"{home}/a.toml", "--cluster", "tcp://me:pw@host:1"])
    assert cli.shared.command_said() == "aliascope compare ~/a.toml --cluster 'tcp://***@host:1'"
