"""Runs the fuzz targets for a time each, or keeps the smallest inputs that reach all that their corpora do.

    run.py [--seconds S] [--at-once N] [TARGET ...]     `make fuzz`
    run.py --keep [TARGET ...]                          what was found goes to tests/fuzz/corpus, minimised

What a run finds grows in .build/fuzz/corpus; the input of a finding is kept in .build/fuzz/findings.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import IO

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BUILD = ROOT / ".build" / "fuzz"
KEPT = HERE / "corpus"
LONGEST = 600
"""Bytes of an input, but of texts and files."""
LARGEST_KEPT = 8192
"""Bytes of an input in tests/fuzz/corpus: what is there is in the repository for good."""
SECONDS_AN_INPUT, MEGABYTES = 60, 4096
UNGUIDED = ("picture",)
"""What reads these is not counted, so that all inputs seem alike: the kept ones are made by hand, one of each kind."""
LONGER = {
    "spec": 2048,
    "scene": 4096,
    "gltf": 8192,
    "mesh": 4096,
    "picture": 8192,
    "points": 4096,
    "renderer": 4096,
    "modes": 2048,
}


@dataclass(frozen=True)
class Target:
    """`name` is that of its source, fuzz_NAME.c or fuzz_NAME.py."""

    name: str

    @property
    def command(self) -> list[str]:
        script = HERE / f"fuzz_{self.name}.py"
        return [sys.executable, str(script)] if script.is_file() else [str(BUILD / f"fuzz_{self.name}")]

    @property
    def corpora(self) -> list[Path]:
        """Where new inputs go, then what is kept."""
        grown = BUILD / "corpus" / self.name
        grown.mkdir(parents=True, exist_ok=True)
        kept = KEPT / self.name
        return [grown, kept] if kept.is_dir() else [grown]

    def options(self) -> list[str]:
        dictionary = HERE / f"{self.name}.dict"
        return [
            f"-max_len={LONGER.get(self.name, LONGEST)}",
            "-len_control=0",
            f"-timeout={SECONDS_AN_INPUT}",
            f"-rss_limit_mb={MEGABYTES}",
            f"-artifact_prefix={BUILD / 'findings' / self.name}-",
            *([f"-dict={dictionary}"] if dictionary.is_file() else []),
            *(["-keep_seed=1"] if self.name in UNGUIDED else []),
        ]


def targets() -> dict[str, Target]:
    sources = [*HERE.glob("fuzz_*.c"), *HERE.glob("fuzz_*.py")]
    names = sorted(path.stem.removeprefix("fuzz_") for path in sources)
    return {name: Target(name) for name in names}


def environment() -> dict[str, str]:
    """A failed allocation is a status to be handled, not a finding."""
    return os.environ | {
        "ASAN_OPTIONS": "allocator_may_return_null=1",
        "LSAN_OPTIONS": f"suppressions={ROOT / 'tests' / 'c' / 'leaks.supp'}:print_suppressions=0",
        "PYTHONPATH": str(ROOT / "harness"),
    }


def run(target: Target, options: list[str], output: IO[bytes] | None = None) -> subprocess.CompletedProcess[bytes]:
    """Runs a target in scratch folders of its own, which are there no more after it."""
    to = {"stdout": output, "stderr": subprocess.STDOUT} if output else {"capture_output": True}
    with tempfile.TemporaryDirectory() as scratch:
        program = Path(scratch) / "program"
        program.write_text(f'#!/bin/sh\nexec {shlex.join(target.command)} "$@"\n')
        program.chmod(0o700)
        more = {"TMPDIR": scratch, "FUZZ_PROGRAM": str(program)}
        return subprocess.run([*target.command, *options], env=environment() | more, check=False, **to)


def fuzz(target: Target, seconds: int) -> bool:
    """Prints its line; whether there was no finding."""
    log = BUILD / f"{target.name}.log"
    options = [*target.options(), f"-max_total_time={seconds}", "-print_final_stats=1"]
    with log.open("wb") as output:
        status = run(target, [*options, *map(str, target.corpora)], output).returncode
    text = log.read_text(encoding="utf-8", errors="replace")
    executions = re.findall(r"^stat::number_of_executed_units:\s*(\d+)", text, re.MULTILINE)
    states = re.findall(r"^#\d+\s+\w+\s+cov: (\d+) ft: \d+ corp: (\d+)/(\S+)", text, re.MULTILINE)
    coverage, inputs, size = states[-1] if states else ("0", "0", "0b")
    finding = re.findall(r"Test unit written to (\S+)", text)
    said = f"{int(executions[-1]) if executions else 0:>10,} executions  coverage {coverage:>5}"
    said += f"  corpus {inputs:>5} ({size})"
    if status == 0:
        print(f"  {target.name:<12} {said}  no finding", flush=True)
        return True
    last = finding[-1] if finding else "no input kept"
    print(f"  {target.name:<12} {said}  FINDING: {last}; see {log}", flush=True)
    return False


def keep(target: Target) -> bool:
    """Minimises what is kept and what has grown into what is kept."""
    with tempfile.TemporaryDirectory() as folder:
        small = Path(folder) / "small"
        small.mkdir()
        for path in (path for corpus in reversed(target.corpora) for path in corpus.iterdir()):
            if path.stat().st_size <= LARGEST_KEPT:
                shutil.copy(path, small)
        made = Path(folder) / "made"
        made.mkdir()
        options = [option for option in target.options() if not option.startswith("-dict")]
        done = run(target, ["-set_cover_merge=1", "-use_counters=0", *options, str(made), str(small)])
        found = sorted(made.iterdir())
        if done.returncode or not found:
            print(f"  {target.name}: not minimised: {done.stderr.decode(errors='replace')[-400:]}")
            return False
        kept = KEPT / target.name
        shutil.rmtree(kept, ignore_errors=True)
        shutil.copytree(made, kept)
        print(f"  {target.name:<12} {len(found)} inputs, {sum(path.stat().st_size for path in found):,} bytes")
    return True


def main() -> int:
    known = targets()
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("target", nargs="*", choices=[*known, []], help="all, where none is named")
    arguments.add_argument("--seconds", type=int, default=60, help="of each target")
    arguments.add_argument("--at-once", type=int, default=os.cpu_count() or 1, help="targets that run side by side")
    arguments.add_argument("--keep", action="store_true", help="minimise into tests/fuzz/corpus instead")
    given = arguments.parse_args()
    (BUILD / "findings").mkdir(parents=True, exist_ok=True)
    chosen = [known[name] for name in given.target or known if not (given.keep and name in UNGUIDED)]
    with ThreadPoolExecutor(max(1, given.at_once)) as pool:
        well = list(pool.map(keep if given.keep else lambda target: fuzz(target, given.seconds), chosen))
    return 0 if all(well) else 1


if __name__ == "__main__":
    sys.exit(main())
