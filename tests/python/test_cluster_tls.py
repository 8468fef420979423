"""A cluster whose way is closed: who has a certificate of its authority does jobs there, others are told what to do."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from clusters import cluster_of
from commands import complaint, run, separately

from aliascope.cluster.address import Tls, checked
from aliascope.errors import InvalidInput
from aliascope.image import read_image

distributed = pytest.importorskip("distributed")

SMALL = ("edge", "-m", "uniform:n=4,sampler=random", "-m", "none", "--size", "16x12")


@dataclass(frozen=True)
class Certified:
    """An authority's certificate, one that it signed, and its key."""

    authority: Path
    certificate: Path
    key: Path

    def words(self, ca: str = "--tls-ca") -> tuple[str | Path, ...]:
        return (ca, self.authority, "--tls-cert", self.certificate, "--tls-key", self.key)


def certified(folder: Path, name: str) -> Certified:
    """By an authority of its own."""
    made = Certified(*(folder / f"{name}{end}" for end in ("-authority.pem", ".pem", ".key")))
    authority_key = folder / f"{name}-authority.key"
    request = ("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")
    signed = ("-CA", made.authority, "-CAkey", authority_key)
    for out, key, more in ((made.authority, authority_key, ()), (made.certificate, made.key, signed)):
        words = (*request, "-days", "2", "-subj", f"/CN={out.stem}", "-out", out, "-keyout", key, *more)
        subprocess.run(words, check=True, capture_output=True)
    return made


@pytest.fixture(scope="module")
def ours(tmp_path_factory: pytest.TempPathFactory) -> Certified:
    return certified(tmp_path_factory.mktemp("ours"), "ours")


@pytest.fixture(scope="module")
def others(tmp_path_factory: pytest.TempPathFactory) -> Certified:
    return certified(tmp_path_factory.mktemp("others"), "others")


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory, ours: Certified) -> Iterator[str]:
    options = ("--protocol", "tls", *ours.words("--tls-ca-file"))
    with cluster_of(tmp_path_factory.mktemp("cluster"), (), scheduler=options, tls=ours.words()) as found:
        yield found


def test_who_has_a_certificate_draws_the_same_bits(address: str, ours: Certified, tmp_path: Path) -> None:
    assert address.startswith("tls://")
    here, there = tmp_path / "here", tmp_path / "there"
    elsewhere = ("--cluster", address, *ours.words())
    told = json.loads(run("compare", *SMALL, "-o", there, *elsewhere, "--json").stdout)
    assert (told["failed"], told["rendered"]) == (0, told["pictures"])
    run("compare", *SMALL, "-o", here)
    paths = sorted(path.relative_to(here) for path in here.glob("images/**/*.exr"))
    assert len(paths) == told["pictures"] > 4
    assert all((read_image(here / path) == read_image(there / path)).all() for path in paths)
    # The jobs went there by what was encrypted: the worker has no other door.
    with distributed.Client(address, security=Tls(*_files(ours)).security(distributed), set_as_default=False) as client:
        assert all(each.startswith("tls://") for each in client.scheduler_info()["workers"])


def _files(of: Certified) -> tuple[Path, Path, Path]:
    return of.authority, of.certificate, of.key


def commands(address: str, folder: Path) -> tuple[tuple[str | Path, ...], ...]:
    """Of a worker, and of who has jobs; the latter with the scene to draw."""
    return ("worker", address), ("compare", *SMALL, "-o", folder, "--cluster", address)


def last_line(*words: str | Path, code: int) -> str:
    """What a command ends with; dask's own words before it are no tracebacks."""
    lines = [line for line in separately(*words, code=code).stderr.splitlines() if "distributed" not in line[:50]]
    assert [line for line in lines[:-1] if line.startswith("aliascope: ")] == []
    assert lines[-1].startswith("aliascope: ")
    return lines[-1]


def test_without_certificates_it_says_which_to_give(address: str, tmp_path: Path) -> None:
    for words in commands(address, tmp_path):
        assert f"{address} asks for certificates: give --tls-ca, --tls-cert and --tls-key" in complaint(*words, code=2)


@pytest.mark.parametrize("command", [0, 1], ids=["worker", "compare"])
def test_who_has_none_of_the_authority_is_told_so(
    address: str, ours: Certified, others: Certified, tmp_path: Path, command: int
) -> None:
    words = commands(address, tmp_path)[command]
    foreign = last_line(*words, *others.words(), code=3)
    assert f"no scheduler answers at {address} ([SSL: CERTIFICATE_VERIFY_FAILED]" in foreign
    assert "are these certificates of its authority" in foreign
    # It trusts our authority, but has nothing that this authority signed.
    signed = Certified(ours.authority, others.certificate, others.key)
    assert "are these certificates of its authority" in last_line(*words, *signed.words(), code=3)
    plain = commands(address.replace("tls://", "tcp://"), tmp_path)[command]
    assert "if it has TLS, write tls:// and give --tls-ca, --tls-cert and --tls-key" in last_line(*plain, code=3)


def test_a_scheduler_without_tls_is_not_taken_for_one(ours: Certified, tmp_path: Path) -> None:
    (tmp_path / "cluster").mkdir()
    with cluster_of(tmp_path / "cluster") as address:
        for words in commands(address.replace("tcp://", "tls://"), tmp_path / "out"):
            assert "and has it TLS?" in last_line(*words, *ours.words(), code=3)


def test_tls_takes_three_files_that_belong_together(ours: Certified, others: Certified, tmp_path: Path) -> None:
    for words in commands("tls://boss:8786", tmp_path):
        assert "--tls-ca without --tls-" in complaint(*words, "--tls-ca", ours.authority, code=2)
    with pytest.raises(InvalidInput, match="is not encrypted"):
        checked("tcp://boss:8786", Tls(*_files(ours)))
    with pytest.raises(InvalidInput, match="there is no such file"):
        checked("tls://boss:8786", Tls(ours.authority, ours.certificate, tmp_path / "none"))
    with pytest.raises(InvalidInput, match=r"--tls-key .*others.key: .*not its key \(KEY_VALUES_MISMATCH\)"):
        checked("tls://boss:8786", Tls(ours.authority, ours.certificate, others.key))
    with pytest.raises(InvalidInput, match=r"--tls-ca .*ours.key: no certificate in PEM"):
        checked("tls://boss:8786", Tls(ours.key, ours.certificate, ours.key))
    locked = tmp_path / "locked.key"
    words = ("openssl", "pkey", "-in", ours.key, "-aes256", "-passout", "pass:x", "-out", locked)
    subprocess.run(words, check=True, capture_output=True)
    with pytest.raises(InvalidInput, match="has a pass phrase; give a key without one"):
        checked("tls://boss:8786", Tls(ours.authority, ours.certificate, locked))
    tls = Tls(*_files(ours))
    assert checked("tls://[::1]:8786", tls) == "tls://[::1]:8786"
    security = tls.security(distributed)
    assert (security.require_encryption, security.tls_ca_file) == (True, str(ours.authority))
    assert Tls().security(distributed) is None
    asked = complaint("compare", *SMALL, "-o", tmp_path, *ours.words(), code=2)
    assert "are those of a cluster: add --cluster tls://HOST:PORT" in asked
