"""The profiles."""

from __future__ import annotations

import pytest

from aliascope import plan, renderers


def texts(profile: str, name: str) -> list[str]:
    return [renderers.mode_of(renderers.find(name), mode).text for mode in plan.profile(profile)[name]]


@pytest.mark.parametrize("name", list(renderers.RENDERERS))
def test_full_has_every_mode_of_quick_and_none_twice(name: str) -> None:
    assert set(texts("quick", name)) <= set(texts("full", name))
    for profile in plan.PROFILES:
        assert len(set(texts(profile, name))) == len(texts(profile, name))


def test_the_planar_patterns_have_their_counts() -> None:
    embree = renderers.find("embree")
    for pattern in plan.PLANAR:
        for n in (16, 64, 256):
            mode = renderers.mode_of(embree, f"uniform:n={n},sampler={pattern}")
            assert mode.text in texts("full", "embree")
            # What is drawn does not depend on the scene; no cell stays empty for the count's sake.
            embree.seeded(mode)  # raises Unsupported for a count that the pattern has not


def test_a_further_sampler_joins_every_renderer_that_takes_one() -> None:
    own = plan.with_samplers(plan.QUICK, ["r2"])
    for name, count in (("embree", len(plan.COUNTS)), ("povray", 2), ("osmesa", 3)):
        added = own[name][len(plan.QUICK[name]) :]
        assert own[name][: len(plan.QUICK[name])] == plan.QUICK[name]
        assert len(added) == count
        assert all(renderers.mode_of(renderers.find(name), mode).word("sampler") == "r2" for mode in added)
