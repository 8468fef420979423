"""From which level on each sampler declines, as measured: a pattern that has no such count, dimension or index."""

from __future__ import annotations

from collections.abc import Mapping

from aliascope.stability.records import NEVER

_FIRST: Mapping[str, Mapping[float, tuple[str, ...]]] = {
    "index": {
        16.0: ("cook",),
        2.0**17: ("best-candidate",),
        2.0**24 - 1.0: (
            "sgi-8x8",
            "standard-msaa",
        ),
        2.0**24: (
            "blue-noise",
            "mitchell-spacetime",
            "n-queens",
            "poisson-disk",
        ),
        2.0**32 - 1.0: ("orthogonal-array",),
        2.0**32: (
            "correlated-multi-jittered",
            "larcher-pillichshammer",
            "latin-square",
            "multi-jittered",
            "pmj02",
            "sobol",
            "sobol:scramble=digit",
            "sobol:scramble=owen",
            "sobol:scramble=owen-full",
            "sobol:scramble=shift",
        ),
        2.0**53 - 1.0: (
            "clenshaw-curtis",
            "jittered",
            "lattice",
            "n-rooks",
            "pan-diagonal",
            "regular",
        ),
        2.0**53: (
            "halton",
            "halton:scramble=digit",
            "halton:scramble=owen",
            "halton:scramble=shift",
            "hammersley",
            "hammersley:scramble=digit",
            "hammersley:scramble=owen",
            "hammersley:scramble=shift",
            "r2",
            "random",
            "zaremba",
            "zaremba:digits=finite",
        ),
    },
    "prime": {
        2.0: (
            "clenshaw-curtis",
            "cook",
            "gauss-legendre",
            "jittered",
            "mitchell-spacetime",
            "n-queens",
            "orthogonal-array",
            "pan-diagonal",
            "regular",
        ),
        3.0: (
            "sgi-8x8",
            "standard-msaa",
        ),
        7.0: ("lattice",),
        65537.0: ("blue-noise",),
    },
    "one-sample": {
        1.0: ("cook",),
        2.0: (
            "clenshaw-curtis",
            "gauss-legendre",
            "jittered",
            "mitchell-spacetime",
            "n-queens",
            "orthogonal-array",
            "pan-diagonal",
            "regular",
        ),
        3.0: (
            "sgi-8x8",
            "standard-msaa",
        ),
        4.0: ("lattice",),
    },
    "dimensions": {
        1.0: (
            "cook",
            "larcher-pillichshammer",
            "mitchell-spacetime",
            "pan-diagonal",
            "sgi-8x8",
            "standard-msaa",
            "zaremba",
            "zaremba:digits=finite",
        ),
        10.0: (
            "clenshaw-curtis",
            "gauss-legendre",
            "regular",
        ),
        100.0: ("orthogonal-array",),
    },
}
"""By extreme, the first level at which samplers decline, and which do. All others never do."""


def refuses_from(spec: str, extreme: str) -> float:
    """The first level at which this row may decline."""
    levels = _FIRST.get(extreme, {})
    return next((at for at, specs in levels.items() if spec in specs), NEVER)
