"""The extremes: the columns of the map, in its order."""

from __future__ import annotations

from aliascope.stability.records import Extreme

_ALL = (
    Extreme("far", "geometry", "Moved away from the origin, with the camera", "units"),
    Extreme("scaled", "geometry", "The whole scene scaled", "factor", both_ways=True),
    Extreme("depth-range", "geometry", "From the nearest to the farthest thing in view", "ratio of distances"),
    Extreme("sliver", "geometry", "Triangles long and thin", "length over width"),
    Extreme("near-axis", "geometry", "An edge almost along an axis", "slope"),
    Extreme("near-diagonal", "geometry", "An edge almost along a diagonal", "slope, less 1"),
    Extreme("on-samples", "geometry", "Edges through sample points and the corners of pixels", "pixels away"),
    Extreme("coplanar", "geometry", "Faces that touch, or lie in one plane", "gap, in units"),
    Extreme("grazing", "geometry", "A surface seen almost from its side", "degrees short of 90"),
    Extreme("watertight", "geometry", "Rays along edges and through corners of a closed mesh", "rays"),
    Extreme("dense", "geometry", "Triangles in one pixel", "triangles"),
    Extreme("narrow", "geometry", "A narrow field of view", "degrees"),
    Extreme("wide", "geometry", "A wide field of view", "degrees short of 180"),
    Extreme("shadow", "geometry", "Surfaces that shadow themselves, at every scale", "factor", both_ways=True),
    Extreme("bright", "radiance", "Light above the usual", "radiance"),
    Extreme("dim", "radiance", "Light below the usual", "radiance"),
    Extreme("mixed", "radiance", "Bright and dim in one pixel", "ratio"),
    Extreme("firefly", "radiance", "One sample that outshines all others", "samples"),
    Extreme("not-finite", "radiance", "Values that are no numbers", "how many"),
    Extreme("hard-edge", "radiance", "Negative lobes beside a bright edge", "contrast"),
    Extreme("output", "radiance", "The range that the renderer's own files hold", "radiance"),
    Extreme("one-sample", "counts", "As few samples as there are", "samples"),
    Extreme("sum", "counts", "Samples added up in one pixel", "samples"),
    Extreme("index", "counts", "Late points of a sequence", "index"),
    Extreme("prime", "counts", "A number of points that is prime", "points"),
    Extreme("dimensions", "counts", "Many dimensions", "dimensions"),
    Extreme("picture-size", "counts", "Pictures of one row or column", "pixels"),
    Extreme("mean", "statistics", "A mean far above the deviation", "mean over deviation"),
    Extreme("zero-variance", "statistics", "Values that are all alike", "values"),
    Extreme("black", "statistics", "Contrast of black on black", "radiance"),
    Extreme("confidence", "statistics", "Confidence near 1", "1 - confidence"),
    Extreme("freedom", "statistics", "Degrees of freedom, few and many", "degrees"),
    Extreme("coincident", "points", "Points that fall together", "points"),
    Extreme("collinear", "points", "Points in a line", "points"),
    Extreme("border", "points", "Points at 0 and just below 1", "distance from the border"),
    Extreme("axis-lines", "points", "Half-planes of lines almost along an axis", "slope"),
    Extreme("few-points", "points", "One point, or few", "points"),
    Extreme("grid", "points", "Points of a grid, on which cells meet in fours", "points"),
    Extreme("equal", "metrics", "Pictures that are equal", "pixels"),
    Extreme("black-reference", "metrics", "A black reference", "error"),
    Extreme("huge", "metrics", "Values far above 1", "radiance"),
    Extreme("constant", "metrics", "Pictures of one colour", "difference"),
)

EXTREMES: dict[str, Extreme] = {each.name: each for each in _ALL}
