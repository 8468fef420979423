"""What is said of a regression run, to people and machines, on runs that were made up."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from regress_runs import CRASHED, EDGE, GONE, STAR, check, failing, observed, passing, verdict

from aliascope import history
from aliascope.errors import NotWritable
from aliascope.regression.records import Check, Run
from aliascope.studies import regress_files, regress_text
from aliascope.studies.regress import Asked, Seen

# --- lines ------------------------------------------------------------------------------------------------------------


def place(lines: list[str], *words: str) -> int:
    """The only line that has all of these."""
    found = [index for index, line in enumerate(lines) if all(word in line for word in words)]
    assert len(found) == 1, (words, lines)
    return found[0]


def test_failures_come_first_each_with_figures_and_commands() -> None:
    lines = regress_text.lines(failing(crashed=True))
    crashed, wrong, gone = (place(lines, word, name.text) for word, name in FAILED)
    fine = place(lines, "passed ", STAR.text)
    assert crashed < wrong < gone < fine
    told = lines[wrong : lines.index("", wrong)]
    assert re.search(r"FAIL +offset .* 1\.01 <= 0\.13 +% +-677 % +p 3e-12; 9 sigma", told[1])
    assert [line.split()[0] for line in told[1:6]] == ["FAIL", "warn", "ok", "ok", "ok"]
    assert any("worst pixel (51, 23), red: 0.8127, expected 0.6046" in line for line in told)
    cell = next(each for each in failing().cells if each.name == EDGE)
    assert [line.strip() for line in told[-2:]] == [f"again: {cell.again}", f"bless: {cell.bless}"]
    assert "no blessed figures" in lines[gone + 1]
    assert not any("bless:" in line for line in lines[crashed:wrong])  # a crash is nothing to bless


FAILED = (("CRASHED", CRASHED), ("FAILED ", EDGE), ("FAILED ", GONE))


def test_the_first_lines_say_how_much_is_tested_and_how_the_significance_is_shared() -> None:
    head = " ".join(regress_text.lines(passing())[:4])
    assert "2 cells on 2 scenes (embree 1, povray 1), 16 pictures each, 412 statistical tests" in head
    assert "Significance 0.001, corrected for all of them together: Bonferroni" in head


def test_controls_skips_and_warnings_follow_and_the_summary_ends() -> None:
    lines = regress_text.lines(failing())
    checks = max(index for index, line in enumerate(lines) if line.startswith(("  ok", "  FAIL")))
    control = place(lines, "control", "moved right by 1/32 pixel", "NOT CAUGHT")
    skipped = place(lines, "skipped  osmesa: libOSMesa.so.8 is not there")
    warning = place(lines, "warning", "CPU time: 1.7 times the blessed, at most 1.5")
    assert checks < control < skipped < warning < len(lines) - 1
    assert place(lines, "control", "gain of 1 %", "caught by gain") < control
    assert lines[-1] == (
        "FAILED: 2 of 3 cells failed, 2 of 3 controls caught, 1 warning, 1 cell not drawn, 1 skipped (osmesa); 61 s"
    )
    assert regress_text.lines(passing())[-1].startswith("PASSED: 0 of 2 cells failed, 2 of 2 controls caught")
    assert "(1 crashed)" in regress_text.lines(failing(crashed=True))[-1]


def test_quiet_leaves_failures_controls_and_the_summary() -> None:
    lines = regress_text.lines(failing(), quiet=True)
    assert not any(re.match("  (ok|warn)|passed|warning|empty", line) for line in lines)
    place(lines, "FAIL ", "offset")
    assert sum(line.startswith("control") for line in lines) == 3
    assert lines[-1] == regress_text.lines(failing())[-1]


def test_lines_are_as_wide_as_a_screen_but_for_commands() -> None:
    """And figures and limits stand below each other."""
    lines = regress_text.lines(failing(crashed=True))
    long = [line for line in lines if len(line) > 120]
    assert all(re.match(" +(again|bless): ", line) for line in long)
    columns = {
        line.index(sign)
        for line in lines
        for sign in ("<=", ">=")
        if re.match("  (ok|warn|FAIL)", line) and sign in line
    }
    assert len(columns) == 1


@pytest.mark.parametrize(
    ("made", "head", "figures"),
    [
        (check(EDGE, "a", 0.05, 0.1), "50 %", "0.05 <= 0.1"),
        (check(EDGE, "a", 0.2, 0.1), "-100 %", "0.2 <= 0.1"),
        (check(EDGE, "a", 5.0, 0.1), "50 times", "5 <= 0.1"),
        (check(EDGE, "a", 2.0, 0.5, at_least=True), "75 %", "2 >= 0.5"),
        (check(EDGE, "a", 0.25, 0.5, at_least=True), "-100 %", "0.25 >= 0.5"),
        (check(EDGE, "a", 0.25, -0.5, at_least=True), "150 %", "0.25 >= -0.5"),
        (check(EDGE, "a", -1.0, -0.5, at_least=True), "-100 %", "-1 >= -0.5"),
        (check(EDGE, "a", -1.0, 0.5, at_least=True), "-", "-1 >= 0.5"),
        (check(EDGE, "a", 1.0, 0.0), "-", "1 <= 0"),
        (check(EDGE, "a", math.nan, 0.5), "-", "none <= 0.5"),
        (check(EDGE, "a", math.inf, 0.5), "-", "infinite <= 0.5"),
        (check(EDGE, "a", 786433.0, 786432.0), "-0 %", "786,433 <= 786,432"),
    ],
)
def test_figures_and_head_room(made: Check, head: str, figures: str) -> None:
    assert regress_text.headroom(made) == head
    assert figures in regress_text.check_lines(made)[0]


def test_details_have_a_line_of_their_own_where_they_need_it() -> None:
    """And are left to the documents where the check passed."""
    long = "beyond their limits: " + ", ".join(f"({16 * i}, 0)" for i in range(20))
    fine, wrong = (check(EDGE, "block", figure, 0.1, detail=long) for figure in (0.05, 0.2))
    assert len(regress_text.check_lines(fine)) == 1
    lines = regress_text.check_lines(wrong)
    assert " ".join(" ".join(lines[1:]).split()) == long
    assert all(len(line) <= 120 for line in lines)
    assert long in regress_files.markdown(
        dataclasses.replace(passing(), cells=(verdict(EDGE, fine), verdict(STAR, wrong)))
    )


# --- JSON -------------------------------------------------------------------------------------------------------------


def test_the_document_has_all_of_a_run_and_no_nan() -> None:
    run = failing(crashed=True)
    odd = dataclasses.replace(run.cells[0], checks=(check(STAR, "odd", math.inf, math.nan),))
    run = dataclasses.replace(run, cells=(odd, *run.cells[1:]))
    document = json.loads(regress_files.results(run), parse_constant=lambda word: pytest.fail(word))
    assert (document["passed"], document["tests"], document["significance"]) == (False, 412, 0.001)
    cells = document["cells"]
    assert [cell["status"] for cell in cells] == ["failed", "failed", "failed", "crashed"]
    assert (cells[0]["checks"][0]["observed"], cells[0]["checks"][0]["headroom"]) == (None, None)
    assert cells[1]["scene"] == "edge"
    assert cells[1]["checks"][0]["about"] == "offset <red> & co"
    assert cells[1]["observed"]["worst"] == {"x": 51, "y": 23, "channel": 0, "value": 0.8127, "expected": 0.6046}
    assert len(cells[1]["observed"]["replicates"]) == 16
    assert "mean" not in cells[1]["observed"]
    assert cells[1]["again"] == run.cells[1].again
    assert [control["caught"] for control in document["controls"]] == [True, True, False]
    assert document["empty"][0]["scene"] == "terrain"
    assert document["skipped"] == {"osmesa": "libOSMesa.so.8 is not there"}
    names = {field.name for field in dataclasses.fields(Run)}
    assert names <= set(document)


# --- JUnit ------------------------------------------------------------------------------------------------------------

NEEDED = {
    "testsuite": {"name", "package", "id", "timestamp", "hostname", "tests", "failures", "errors", "time"},
    "testcase": {"name", "classname", "time"},
    "property": {"name", "value"},
    "failure": {"type", "message"},
    "error": {"type", "message"},
}
"""What the schema of Ant's JUnit task has as required (and the message, which CI systems show)."""
ORDER = {"testsuite": "properties,(testcase,)*system-out,system-err,", "testcase": "((skipped|error|failure),)?"}
"""The content that it has, as a regular expression of tags."""


@pytest.mark.parametrize("run", [passing(), failing(), failing(crashed=True)])
def test_junit_has_the_structure_of_its_schema(run: Run) -> None:
    root = ElementTree.fromstring(regress_files.junit(run))
    assert root.tag == "testsuites"
    assert {child.tag for child in root} == {"testsuite"}
    for element in root.iter():
        assert NEEDED.get(element.tag, set()) <= set(element.attrib), element.tag
        if element.tag in ORDER:
            assert re.fullmatch(ORDER[element.tag], "".join(f"{child.tag}," for child in element))
    for place, suite in enumerate(root):
        cases = suite.findall("testcase")
        assert int(suite.get("id", "")) == place
        assert int(suite.get("tests", "")) == len(cases)
        for attribute, tag in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
            assert int(suite.get(attribute, "")) == len(suite.findall(f"testcase/{tag}"))
        assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d", suite.get("timestamp", ""))
        seconds = [suite.get("time", ""), *(case.get("time", "") for case in cases)]
        assert all(re.fullmatch(r"\d+\.\d+", each) for each in seconds)  # a decimal has no exponent
        assert float(seconds[0]) == pytest.approx(sum(map(float, seconds[1:])), abs=1e-3 * len(seconds))


def test_junit_has_a_suite_a_scene_and_a_case_a_cell_and_control() -> None:
    run = failing(crashed=True)
    root = ElementTree.fromstring(regress_files.junit(run))
    suites = {suite.get("name"): suite for suite in root}
    assert list(suites) == ["siemens-star", "edge", "discs", "terrain", "the controls", "the renderers"]
    (edge,) = suites["edge"].findall("testcase")
    assert (edge.get("classname"), edge.get("name")) == ("aliascope.edge.embree", EDGE.mode)
    assert float(edge.get("time", "")) > 0.0
    failure = edge.find("failure")
    assert failure is not None
    assert failure.get("message") == "offset <red> & co: 1.01 %, at most 0.13"
    cell = next(cell for cell in run.cells if cell.name == EDGE)
    assert failure.text == "\n".join(regress_text.cell_lines(cell))
    crash = suites["discs"].find("testcase/error")
    assert crash is not None
    assert "SIGSEGV" in (crash.text or "")
    assert "\x00" not in (crash.text or "")  # XML has no such character
    skipped = suites["terrain"].find("testcase/skipped")
    assert skipped is not None
    assert "shadows of meshes" in (skipped.text or "")
    assert [case.find("failure") is None for case in suites["the controls"].findall("testcase")] == [True, True, False]
    assert suites["the renderers"].find("testcase/skipped") is not None


# --- Markdown ---------------------------------------------------------------------------------------------------------


def test_markdown_begins_with_failures_and_folds_the_rest() -> None:
    run = failing(crashed=True)
    made = regress_files.markdown(run)
    order = [
        made.index(each)
        for each in (
            "## aliascope regress: FAILED",
            "3 of 4 cells failed (1 crashed)",
            f"| `{CRASHED.text}` |",
            f"| `{EDGE.text}` | offset &lt;red&gt; &amp; co",
            "again: aliascope regress edge",
            "### Controls",
            "**not caught**",
            "### Warnings",
            "### Skipped",
            "<details><summary>All checks of 1 cell that passed",
            "<details><summary>1 cell not drawn",
        )
    ]
    assert order == sorted(order)
    assert made.count("<details>") == made.count("</details>") == 3
    rows = [line for line in made.splitlines() if line.startswith("| `")]
    assert all(len(re.findall(r"(?<!\\)\|", row)) in (6, 4) for row in rows)  # five columns, of controls three
    assert "## aliascope regress: passed" in regress_files.markdown(passing())


def test_markup_in_words_stays_words() -> None:
    cell = verdict(EDGE, problem="a | b <script> *c*\n# d")
    made = regress_files.markdown(dataclasses.replace(passing(), cells=(cell,)))
    assert "a \\| b &lt;script&gt; \\*c\\* # d" in made


# --- files ------------------------------------------------------------------------------------------------------------


def test_files_are_written_where_they_were_asked_for(tmp_path: Path) -> None:
    run = dataclasses.replace(passing(), cells=(*passing().cells, verdict(GONE, observed=observed(GONE))))
    page = regress_files.write(tmp_path / "out", run, NOTHING, tmp_path / "a" / "junit.xml", tmp_path / "note.md")
    assert page == tmp_path / "out" / "report.html"
    assert (tmp_path / "a" / "junit.xml").read_text() == regress_files.junit(run)
    assert (tmp_path / "note.md").read_text() == (tmp_path / "out" / "summary.md").read_text()
    assert json.loads((tmp_path / "out" / "results.json").read_text()) == regress_files.document(run)
    regress_files.write(tmp_path / "out", run, NOTHING)
    kept = history.load(tmp_path / "out" / "history.sqlite")  # each run is added
    assert [[cell.name for cell in each.cells] for each in kept] == [[cell.name for cell in run.cells]] * 2
    with pytest.raises(NotWritable, match="cannot be written"):
        regress_files.write(tmp_path / "note.md", run, NOTHING)
    with pytest.raises(NotWritable, match="choose another folder with -o"):
        regress_files.check_writable(tmp_path / "note.md")


NOTHING = Seen(Asked(), (), {}, (), (), {}, {}, {}, "", 0.0)
"""Of a run that was made up nothing was rendered."""
