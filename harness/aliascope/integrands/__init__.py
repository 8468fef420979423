"""Integrands: functions on the unit cube with known integrals, for every estimator and sampler to be tried on.

>>> box = parse("box:high=0.75,low=0.25")
>>> box.exact(2), box.variation(2), box.evaluate([[0.5, 0.5], [0.5, 0.8]]).tolist()
(0.25, 4.0, [1.0, 0.0])
"""

from __future__ import annotations

from collections.abc import Mapping

from aliascope import specs
from aliascope.integrands import genz, plain, shapes
from aliascope.integrands.base import SMOOTHNESS, Integrand, Kind, Smoothness

__all__ = ["KINDS", "SMOOTHNESS", "Integrand", "Kind", "Smoothness", "parse"]

KINDS: Mapping[str, Kind] = {kind.name: kind for kind in (*plain.KINDS, *genz.KINDS, *shapes.KINDS)}
_FORMS = {name: kind.form for name, kind in KINDS.items()}


def parse(text: str) -> Integrand:
    """The integrand that a spec names. Raises SpecError, with the near misses of an unknown name or key."""
    spec = specs.parse(text, _FORMS, "integrand")
    kind = KINDS[spec.name]
    return Integrand(spec.text, kind, kind.make(spec))
