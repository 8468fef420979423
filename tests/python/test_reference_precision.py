"""Converged references are finer than what they judge: a standard error below a fifth of the best mode's error."""

from __future__ import annotations

import numpy as np
import pytest
from reference_scenes import REPOSITORY, stored

from aliascope import plan
from aliascope.native import tracer
from aliascope.references import files

BEST = "sobol:scramble=owen", 256
"""Of the quick profile: no mode of any renderer takes more samples, no pattern in it errs less at 256."""
LEAST_RATIO = 5.0


def converged() -> list[tuple[str, str]]:
    """Scene and filter of every reference that has standard errors."""
    names = sorted((REPOSITORY / "reference").glob("*/128x96-*.standard-error.exr"))
    return [(path.parent.name, path.name.removeprefix("128x96-").removesuffix(".standard-error.exr")) for path in names]


def test_the_best_mode_is_in_the_profile() -> None:
    assert f"uniform:n={BEST[1]},sampler=sobol,sampler.scramble=owen" in plan.QUICK["embree"]
    assert len(converged()) >= 10


@pytest.mark.parametrize(("name", "filter_"), converged())
def test_standard_errors_are_below_a_fifth_of_the_least_error(name: str, filter_: str) -> None:
    of = stored(name)
    reference = files.load(REPOSITORY / "reference", name, of, of.view.size, filter_)
    assert reference.standard_error_rms is not None
    pixels, _ = tracer.Tracer(of, of.view.size).render(*BEST, 0, 2, filter_)
    error = float(np.sqrt(((pixels.astype(np.float64) - reference.exact) ** 2).mean()))
    assert reference.standard_error_rms * LEAST_RATIO < error
