"""`aliascope plugin check`: plugins that are broken in one place each, and caught there and nowhere else."""

from __future__ import annotations

import json
import subprocess
import time
from pathlib import Path

import pytest
from commands import in_a_fork, run, separately

from aliascope.studies import plugin_check
from aliascope.studies.plugin_check import CHECKS, Outcome, check_one
from aliascope.studies.plugin_contracts import CONTRACTS
from aliascope.studies.plugin_probe import run_check
from aliascope.studies.plugin_subject import NothingToCheck, Subject

ROOT = Path(__file__).resolve().parents[2]
GOOD = (Path(__file__).parent / "mine.c").read_text()
EXAMPLE = (ROOT / "csrc" / "plugins" / "kronecker.c").read_text()
FILLS = {
    "past-end",
    "before-start",
    "range",
    "purity",
    "order",
    "threads",
    "seeds",
    "traits",
    "index-end",
    "uniformity",
}
"""The checks that call fill."""


def compiled(folder: Path, text: str = GOOD, *changes: tuple[str, str]) -> Path:
    """A plugin of a text in which each change (place, replacement) was made once."""
    for place, instead in changes:
        assert text.count(place) == 1, place
        text = text.replace(place, instead)
    source, out = folder / "mine.c", folder / "mine.so"
    source.write_text(text)
    include = ROOT / "csrc" / "include"
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-w", f"-I{include}", source, "-o", out, "-lm"], check=True)
    return out


def in_place(place: str, code: str) -> tuple[str, str]:
    return f"/* PLACE: {place} */", code


def failures(outcomes: list[Outcome]) -> dict[str, str]:
    return {outcome.name: outcome.text for outcome in outcomes if not outcome.holds}


def _what_fails(plugin: Path, spec: str) -> dict[str, str]:
    last = sorted(CHECKS, key=lambda name: name == "refusals")  # it limits the process's memory
    found = {name: run_check(name, str(plugin), spec, lambda text: None) for name in last}
    return {name: each["text"] for name, each in found.items() if each["status"] not in ("ok", "skipped")}


def checked_at_once(plugin: Path, spec: str = "mine") -> dict[str, str]:
    """What fails, all checks in one process: for plugins that leave it standing."""
    return in_a_fork(_what_fails, plugin, spec)


# --- plugins that hold ------------------------------------------------------------------------------------------------


def test_the_example_and_another_keep_to_every_contract(tmp_path: Path) -> None:
    outcomes = list(plugin_check.check(compiled(tmp_path, EXAMPLE), "kronecker:shift=0.25"))
    assert tuple(outcome.name for outcome in outcomes) == CHECKS
    assert failures(outcomes) == {}
    assert [outcome.name for outcome in outcomes if outcome.status == "skipped"] == ["uniformity"]
    # Values next to 1 are the library's to keep below 1 as float.
    near_one = in_place("value", "if (range->pixel_x == 3 && sample == 0) value = 1.0 - 0x1p-53;")
    assert failures(list(plugin_check.check(compiled(tmp_path, GOOD, near_one)))) == {}


@pytest.mark.parametrize(
    "spec", ["random", "jittered", "regular", "halton:scramble=shift", "sobol", "sobol:scramble=owen"]
)
def test_built_in_samplers_raise_no_false_alarm(spec: str) -> None:
    for name, contract in CONTRACTS.items():
        if name == "refusals":  # limits this process's memory
            continue
        try:
            contract(Subject(spec, lambda text: None))
        except NothingToCheck:
            assert (name, spec) in (("uniformity", "regular"), ("uniformity", "sobol"))


# --- plugins that break one contract and leave the process standing ---------------------------------------------------

OTHER_WEIGHTS = "for (size_t i = 0; i < count; i++) weights[i] = "
EVEN_AND_ODD = f"if (state->samples % 2 == 0) {OTHER_WEIGHTS}(first + i) % 2 / (state->samples / 2.0);"
WEIGHTED = ("| ASC_TRAIT_SEQUENCE", "| ASC_TRAIT_SEQUENCE | ASC_TRAIT_WEIGHTED")
NO_SEQUENCE = ("| ASC_TRAIT_SEQUENCE, 200000}", ", config->samples}")


@pytest.mark.parametrize(
    ("change", "names", "words"),
    [
        # range
        (in_place("value", "if (sample == 0 && range->pixel_x == 3) value = 1.0;"), "range", "is 1;"),
        (in_place("value", "if (sample == 0 && range->pixel_x == 3) value = 0.0 / 0.0;"), "range", "nan"),
        (in_place("value", "if (sample == 0 && range->pixel_x == 3) value = -0x1p-70;"), "range", "is -8.47"),
        (in_place("value", "if (sample == 0 && range->pixel_x == 3 && d == 0) continue;"), "range", "not written"),
        (
            in_place("value", "if (state->seed == UINT64_MAX && d == 0) value = 2.0;"),
            "range",
            "seed 18446744073709551615",
        ),
        (in_place("value", "if (sample == 199999) value = 1e300;"), "range", "sample 199999"),
        # purity, order, threads
        (
            in_place("value", "static uint64_t calls; value = (double)(mixed(++calls ^ key) >> 11) * 0x1p-53;"),
            "purity order threads traits",
            "the second time",
        ),
        (
            in_place("value", "value = (double)(mixed(mixed(key + i) + dimension) >> 11) * 0x1p-53;"),
            "order",
            "other bits",
        ),
        (in_place("value", "if (range->first_dimension && d == 0) value = 0.5;"), "order", "dimension"),
        (
            in_place("value", "value = (double)(mixed((uint64_t)(uintptr_t)opaque ^ sample) >> 11) * 0x1p-53;"),
            "purity seeds traits uniformity",
            "made alike",
        ),
        (
            (
                "      points[i * range->dimension_count + d] = value;\n    }",
                "      scratch[i * range->dimension_count + d] = value;\n    }\n"
                "  memcpy(points, scratch, range->sample_count * range->dimension_count * sizeof *points);",
            ),
            "threads",
            "at once gave other bits",
        ),
        # weights
        (in_place("weights", OTHER_WEIGHTS + "2.0 / (double)state->samples;"), "weights", "add up to 2"),
        (in_place("weights", "if (first == 0) weights[0] = 0.0 / 0.0;"), "weights", "nan"),
        (
            in_place(
                "weights", "if (state->samples % 2 == 0) " + OTHER_WEIGHTS + "(first + i) % 2 / (state->samples / 2.0);"
            ),
            "weights",
            "without ASC_TRAIT_WEIGHTED",
        ),
        (WEIGHTED, "weights", "all weights are 1/N"),
        # seeds, traits
        (("mixed(mixed(state->seed) ^ pixel)", "mixed(pixel)"), "seeds", "ASC_TRAIT_RANDOMISED, but seed 2"),
        (("mixed(state->seed) ^", "mixed((uint32_t)state->seed) ^"), "seeds", "seed 4294967297 has the points"),
        (("(uint32_t)range->pixel_y;", "(uint16_t)range->pixel_y;"), "seeds", "pixel 0,65536 has the points"),
        (("{state, ASC_TRAIT_RANDOMISED |", "{state, 0 |"), "seeds", "no ASC_TRAIT_RANDOMISED, but"),
        (
            ("mixed(mixed(state->seed) ^ pixel)", "mixed(mixed(state->seed + state->samples) ^ pixel)"),
            "traits",
            "first",
        ),
        (("ASC_TRAIT_RANDOMISED |", "64 | ASC_TRAIT_RANDOMISED |"), "traits", "unknown traits 0x40"),
        # uniformity
        (in_place("value", "value = value * (0.8 + 0.2 * value);"), "uniformity", "dimension 0 is not uniform"),
        (
            in_place("value", "if (dimension == 2) value = (double)(mixed(mixed(key + sample)) >> 11) * 0x1p-53;"),
            "uniformity",
            "dimensions 0 and 2",
        ),
        # refusals, index-end
        (('if (error) strcpy(error->text, "mine has no', '(void)("'), "refusals", "no message"),
        (("return ASC_UNSUPPORTED;", "return ASC_INVALID_VALUE;"), "refusals", "ASC_INVALID_VALUE"),
        (("13 points, at most", "13 points,\\n at most"), "refusals", "not one printable line"),
        (
            ("return ASC_UNSUPPORTED;", "return error ? ASC_UNSUPPORTED : ASC_PLUGIN;"),
            "refusals",
            "where `error` is NULL",
        ),
        (("config->samples % 13 == 0", "1"), "refusals", "none of"),
        (("| ASC_TRAIT_SEQUENCE, 200000}", ", config->samples + 1}"), "index-end", "it is N"),
        (NO_SEQUENCE, "", ""),  # and that is nothing wrong
    ],
)
def test_one_broken_contract_fails_one_check(tmp_path: Path, change: tuple[str, str], names: str, words: str) -> None:
    changes = [change]
    if "scratch" in change[1]:
        changes.append(in_place("globals", "static double scratch[1 << 18];"))
    found = checked_at_once(compiled(tmp_path, GOOD, *changes))
    assert set(found) == set(names.split()), found
    assert words in " ".join(found.values())


# --- plugins that take their process with them ------------------------------------------------------------------------


def reported(plugin: Path, *arguments: str) -> dict[str, str]:
    """What fails, by the command."""
    document = json.loads(run("plugin", "check", plugin, "--json", *arguments, code=1).stdout)
    assert document["holds"] is False
    assert [entry["name"] for entry in document["checks"]] == list(CHECKS)
    return {entry["name"]: entry["text"] for entry in document["checks"] if entry["status"] == "failed"}


def left_behind(plugin: Path) -> list[str]:
    """Processes that still have the plugin on their command line."""
    lines = []
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            lines.append(entry.read_bytes().replace(b"\0", b" ").decode(errors="replace"))
        except OSError:
            continue
    return [line for line in lines if str(plugin) in line]


@pytest.mark.parametrize(
    ("code", "names", "words"),
    [
        # Past the end, before the start: by a value, by one that slack would not show, by reading alone.
        ("points[range->sample_count * range->dimension_count] = 0.5;", "past-end", "wrote up to 8 bytes past the end"),
        (
            "points[range->sample_count * range->dimension_count + 100000] = 0.5;",
            "past-end",
            "crashed with SIGSEGV",
        ),
        (
            "volatile double x = points[range->sample_count * range->dimension_count]; (void)x;",
            "past-end",
            "past the end of which nothing",
        ),
        ("points[-1] = 0.5;", "before-start", "wrote up to 8 bytes before the start"),
        (
            "volatile double x = points[-3]; (void)x;",
            "before-start",
            "before the start of which nothing",
        ),
        # Ends of a process: each loses only the checks that come upon it.
        (
            "if (range->pixel_x == 256) *(volatile int *)0 = 1;",
            "seeds",
            "SIGSEGV (Segmentation fault), in fill of",
        ),
        ("if (range->pixel_x == 256) free((char *)opaque + 8);", "seeds", "crashed with SIGABRT (free(): invalid"),
        ("if (range->pixel_x == 256) _exit(0);", "seeds", "ended its process with exit code 0, in fill of N = 64"),
        ("if (range->pixel_x == 256) exit(3);", "seeds", "ended its process with exit code 3"),
        ("if (range->pixel_x == 256) __builtin_trap();", "seeds", "crashed with SIGILL"),
    ],
)
def test_crashes_and_stray_writes_are_reports(tmp_path: Path, code: str, names: str, words: str) -> None:
    plugin = compiled(tmp_path, GOOD, in_place("filled", code))
    outcomes = [check_one(name, plugin, "mine") for name in ("past-end", "before-start", "purity", "seeds")]
    found = failures(outcomes)
    assert set(found) == {names}, found
    assert words in found[names]


def test_the_command_reports_a_crash(tmp_path: Path) -> None:
    crash = in_place("filled", "if (range->pixel_x == 256) *(volatile int *)0 = 1;")
    text = "crashed with SIGSEGV (Segmentation fault), in fill of N = 64, D = 5, samples 0 to 63 of pixel 256,0"
    assert reported(compiled(tmp_path, GOOD, crash)) == {"seeds": text}


def test_stray_writes_of_weights_are_found(tmp_path: Path) -> None:
    plugin = compiled(tmp_path, GOOD, in_place("weights", "weights[count] = 1.0; weights[-1] = 1.0;"))
    found = failures([check_one(name, plugin, "mine") for name in ("past-end", "before-start", "weights")])
    assert set(found) == {"past-end", "before-start"}
    assert all("weights of N = " in text for text in found.values())


def test_a_sampler_that_always_crashes_fails_what_calls_it(tmp_path: Path) -> None:
    plugin = compiled(tmp_path, GOOD, in_place("filled", "abort();"))
    lines = run("plugin", "check", plugin, code=1).stdout.splitlines()
    assert [line.split()[0] for line in lines[:-1]] == list(CHECKS)
    assert {line.split()[0] for line in lines[:-1] if line.split()[1] == "failed"} == FILLS
    assert all("SIGABRT" in line for line in lines if "failed" in line)
    assert lines[-1].startswith(f"{plugin}: does not hold: ")


def test_a_call_that_hangs_loses_its_check(tmp_path: Path) -> None:
    plugin = compiled(tmp_path, GOOD, in_place("filled", "if (range->pixel_x == 256) for (;;) pause();"))
    assert reported(plugin, "--time-limit", "10") == {
        "seeds": "hung: no end within 10 s, in fill of N = 64, D = 5, samples 0 to 63 of pixel 256,0"
    }
    assert left_behind(plugin) == []


def test_after_two_that_hang_no_more_are_run(tmp_path: Path) -> None:
    plugin = compiled(tmp_path, GOOD, ("config->samples % 13 == 0", "config->samples == 7) for (;;);\n  if (0"))
    begin = time.monotonic()
    outcomes = list(plugin_check.check(plugin, time_limit=6))
    assert time.monotonic() - begin < 60
    assert [outcome.status for outcome in outcomes] == ["ok", "failed", "failed"] + ["not-run"] * (len(CHECKS) - 3)
    assert outcomes[1].text == "hung: no end within 6 s, in create for N = 7, D = 1"
    assert left_behind(plugin) == []


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("for (;;) pause();", "hung: no end within 5 s, while it was loaded"),
        ("abort();", "crashed with SIGABRT"),
    ],
)
def test_a_plugin_that_cannot_even_be_loaded(tmp_path: Path, code: str, words: str) -> None:
    start = f"__attribute__((constructor)) static void start(void) {{ {code} }}"
    outcomes = list(plugin_check.check(compiled(tmp_path, GOOD, in_place("globals", start)), time_limit=5))
    assert [outcome.status for outcome in outcomes] == ["failed"] + ["not-run"] * (len(CHECKS) - 1)
    assert words in outcomes[0].text


def test_a_crash_at_the_end_of_the_process_is_one_too(tmp_path: Path) -> None:
    end = "__attribute__((destructor)) static void end(void) { abort(); }"
    first = next(plugin_check.check(compiled(tmp_path, GOOD, in_place("globals", end))))
    assert (first.name, first.status) == ("table", "failed")
    assert "crashed with SIGABRT" in first.text
    assert "at the end of the process" in first.text


def test_bits_that_differ_between_processes_are_impure(tmp_path: Path) -> None:
    by_process = ("state->seed = config->seed;", "state->seed = config->seed + (uint64_t)getpid();")
    text = "the same calls gave other bits in another process"
    assert check_one("purity", compiled(tmp_path, GOOD, by_process), "mine").text == text
    (tmp_path / "second").mkdir()
    unwritten = ("state->power = config->values[0];", "")
    use = in_place("value", "value = value * 0.5 + (state->power < 0 ? 0.0 : 0.5);")
    assert not check_one("purity", compiled(tmp_path / "second", GOOD, unwritten, use), "mine").holds


# --- tables, files, specs ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("sizeof(asc_sampler_interface)", "8"), "struct_size is 8"),
        (("    .fill = fill,\n", ""), "the table has no `fill`"),
        (("    .create = create,\n", ""), "the table has no `create`"),
        (('.name = "mine"', '.name = "Mine Own"'), "not kebab-case"),
        (('.name = "mine"', '.name = "halton"'), 'a sampler named "halton" is there already'),
        (('.source = "nowhere"', '.source = ""'), "`source` is empty"),
        (("abi_version == ASC_ABI_VERSION &&", ""), "unknown ABI version"),
        (("&& strcmp(id, ASC_SAMPLER_INTERFACE_ID) == 0", ""), 'unknown id "asc.nothing/1"'),
        (("0.5, 2.0, 1.0", "0.5, 2.0, 3.0"), "not minimum <= fallback <= maximum"),
        (("ASC_REAL, NULL", "ASC_CHOICE, NULL"), "without its `choices`"),
        (("ASC_REAL, NULL, 0.5, 2.0, 1.0", 'ASC_CHOICE, "a|b", 0, 1, 2'), "no index of 2 choices"),
        (("ASC_REAL, NULL", "9, NULL"), "unknown kind 9"),
        ((".parameters = parameters,", ""), "`parameters` is NULL"),
    ],
)
def test_a_table_with_a_gap_fails(tmp_path: Path, change: tuple[str, str], words: str) -> None:
    outcomes = list(plugin_check.check(compiled(tmp_path, GOOD, change)))
    assert [outcome.status for outcome in outcomes] == ["failed"] + ["not-run"] * (len(CHECKS) - 1)
    assert words in outcomes[0].text


def test_what_is_no_plugin_ends_with_2(tmp_path: Path) -> None:
    (tmp_path / "text.so").write_text("no library")
    plugin = compiled(tmp_path)
    (tmp_path / "old").mkdir()
    old = compiled(tmp_path / "old", GOOD, ("abi_version == ASC_ABI_VERSION", "abi_version == 0"))
    (tmp_path / "other").mkdir()
    other = compiled(tmp_path / "other", "int other;")
    for path, words, arguments in (
        (tmp_path / "absent.so", "there is no such file", ()),
        (tmp_path, "there is no such file", ()),
        (tmp_path / "text.so", "cannot be loaded", ()),
        (other, "exports no asc_plugin_interface", ()),
        (old, "build it against this version's headers", ()),
        (plugin, 'the spec "halton" is of another', ("--spec", "halton")),
        (plugin, 'did you mean "power"', ("--spec", "mine:pover=1")),
        (plugin, "power", ("--spec", "mine:power=7")),
        (plugin, "time-limit", ("--time-limit", "0")),
    ):
        result = run("plugin", "check", path, *arguments, code=2)
        assert words in result.stderr
        assert result.stdout == ""
        if arguments[:1] != ("--time-limit",):  # of which typer makes some lines
            assert len(result.stderr.splitlines()) == 1


def test_a_spec_chooses_the_configuration(tmp_path: Path) -> None:
    plugin = compiled(tmp_path, GOOD, in_place("value", "if (state->power == 1.5 && dimension) value = 0.5;"))
    assert checked_at_once(plugin) == {}
    assert set(checked_at_once(plugin, "mine:power=1.5")) == {"uniformity"}


def test_what_a_plugin_prints_does_not_reach_the_document(tmp_path: Path) -> None:
    prints = in_place("filled", 'if (range->pixel_x == 256) { write(1, "noise", 5); write(2, "noise", 5); }')
    result = separately("plugin", "check", compiled(tmp_path, GOOD, prints), "--json")
    assert json.loads(result.stdout)["holds"] is True
    assert result.stderr == ""


def test_help_has_an_example() -> None:
    for words in (["plugin", "--help"], ["plugin", "check", "--help"]):
        assert "Example: aliascope plugin check" in run(*words).stdout
