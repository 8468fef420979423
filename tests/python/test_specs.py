"""Specs: their one canonical form, and what they refuse."""

from __future__ import annotations

import pytest

from aliascope import renderers, specs
from aliascope.errors import SpecError
from aliascope.native import samplers
from aliascope.specs import Form, Key, family, parse, spelled_out

FORMS = {
    "none": Form("none", "nothing"),
    "grid": Form(
        "grid",
        "for tests",
        (
            Key("n", "integer", 16, "count", 1, 100, is_count=True),
            Key("threshold", "real", 0.1, "t", 0, 1),
            Key("filter", "choice", "box", "f", choices=("box", "tent")),
            Key("sampler", "spec", "halton", "s", inner=samplers.canonical, named=True),
        ),
    ),
}


@pytest.mark.parametrize(
    ("text", "canonical"),
    [
        ("none", "none"),
        (" none ", "none"),
        ("grid", "grid"),
        ("grid:n=16,threshold=0.1", "grid"),
        ("grid:threshold=0.10,n=9", "grid:n=9"),
        ("grid:threshold=0.25,n=9", "grid:n=9,threshold=0.25"),
        ("grid:threshold=0.1000000001", "grid:threshold=0.1000000001"),
        ("grid:sampler=halton", "grid"),
        ("grid:sampler=sobol", "grid:sampler=sobol"),
        ("grid:sampler.scramble=owen,sampler=sobol", "grid:sampler=sobol,sampler.scramble=owen"),
        ("grid:sampler=sobol,sampler.scramble=none", "grid:sampler=sobol"),
        ("grid:sampler.scramble=shift", "grid:sampler=halton,sampler.scramble=shift"),
    ],
)
def test_one_canonical_form(text: str, canonical: str) -> None:
    spec = parse(text, FORMS, "mode of tests")
    assert spec.text == canonical
    assert parse(spec.text, FORMS, "mode of tests") == spec


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("gird", 'unknown mode of tests "gird"; did you mean "grid"?'),
        ("grid:m=3", 'unknown key "m"; did you mean "n"?|unknown key "m"; known'),
        ("none:m=3", 'unknown key "m"; it has none'),
        ("grid:n=0", r"n=0 lies outside \[1, 100\]"),
        ("grid:n=1.5", "not a whole number"),
        ("grid:threshold=nan", "outside"),
        ("grid:threshold=x", "not a number"),
        ("grid:filter=bocks", "none of box, tent"),
        ("grid:n", "key=value"),
        ("grid:n=1,n=2", "twice"),
        ("grid:", "key=value"),
        (":n=1", "no name"),
        ("grid:sampler=sobel", 'unknown sampler "sobel"; did you mean "sobol"'),
        ("grid:sampler.scrambel=owen", "unknown key"),
    ],
)
def test_refusals(text: str, message: str) -> None:
    with pytest.raises(SpecError, match=message):
        parse(text, FORMS, "mode of tests")


def test_a_family_leaves_out_the_count_alone() -> None:
    texts = ("grid:n=4", "grid:n=9,threshold=0.1", "grid:sampler=halton")
    assert {family(parse(text, FORMS, "m")) for text in texts} == {"grid halton"}
    assert family(parse("grid:threshold=0.5,sampler=sobol", FORMS, "m")) == "grid threshold=0.5 sobol"


def test_spelled_out_has_every_default_and_reads_back() -> None:
    spec = parse("grid:sampler.scramble=owen", FORMS, "m")
    assert spelled_out(spec) == "grid:filter=box,n=16,sampler=halton,sampler.scramble=owen,threshold=0.1"
    assert parse(spelled_out(spec), FORMS, "m") == spec
    assert spelled_out(parse("none", FORMS, "m")) == "none"


def test_settings_are_all_keys_with_their_values_those_left_out_too() -> None:
    def settings(renderer: str, mode: str) -> dict[str, str]:
        return specs.settings(renderers.mode_of(renderers.find(renderer), mode))

    assert settings("povray", "am1:depth=5")["threshold"] == "0.1"
    assert settings("osmesa", "none") == {"recentre": "1"}
    stated = {"n": "4", "sampler": "sobol", "sampler.scramble": "owen", "filter": "box", "filter.radius": "0.5"}
    assert stated.items() <= settings("embree", "uniform:n=4").items()
    assert {name.partition(".")[0] for name in settings("embree", "uniform:n=4")} == {
        key.name for key in renderers.find("embree").modes["uniform"].keys
    }
    # A default of an inner spec is there too, and one that is given takes its place.
    adaptive = settings("embree", "adaptive:method=mitchell,method.cells=1,n=64,sampler=halton")
    assert (adaptive["method"], adaptive["method.cells"], adaptive["sampler.scramble"]) == ("mitchell", "1", "none")
    assert {"method.margin", "method.tolerance"} <= set(adaptive)
