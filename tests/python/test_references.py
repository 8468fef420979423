"""References as a whole: against a million rays in a pixel, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_scenes import BACKGROUND, COLOURS, SIZE, box, brute_force, disc, polygon, reference_of, scene, stored

from aliascope import references
from aliascope.errors import Unsupported
from aliascope.geometry import Frame, frame_of
from aliascope.model import Scene
from aliascope.references import METHODS, Ambiguous, Method, Reference, make
from aliascope.references.result import Exact

RED, GREEN, BLUE = (np.array(COLOURS[name]) for name in ("red", "green", "blue"))
PERSPECTIVE = {
    "type": "perspective",
    "eye": [1.3, 2.1, 16.0],
    "look_at": [0.4, -0.2, 0.0],
    "up": [0.1, 1.0, 0.05],
    "vertical_fov_degrees": 33.0,
}


def against_rays(
    of: Scene, size: tuple[int, int], pixels: list[tuple[int, int]], reference: Reference | None = None
) -> None:
    exact = (reference or make(of, size)).exact
    for seed, (x, y) in enumerate(pixels):
        mean, standard_error = brute_force(of, size, (x, y), seed)
        # 5 standard errors: about 1 in 2 million for each value. 1e-12: pixels of one colour, which have none.
        assert np.all(np.abs(exact[y, x] - mean) <= 5 * standard_error + 1e-12), (x, y, exact[y, x], mean)


def edge_pixels(
    of: Scene, size: tuple[int, int], many: int, reference: Reference | None = None
) -> list[tuple[int, int]]:
    """Pixels, spread over the picture, that differ from a neighbour on each axis."""
    exact = (reference or make(of, size)).exact.sum(axis=2)
    along, down = np.abs(np.diff(exact, axis=1))[1:], np.abs(np.diff(exact, axis=0))[:, 1:]
    rows, columns = np.nonzero((along > 1e-3) & (down > 1e-3))
    chosen = np.linspace(0, len(rows) - 1, many).astype(int)
    return [(int(columns[i]) + 1, int(rows[i]) + 1) for i in chosen]


@pytest.mark.parametrize(
    ("name", "method"),
    [
        ("edge", "polygons"),
        ("discs", "discs"),
        ("zone-plate", "zone-plate"),
        ("siemens-star", "polygons"),
        ("comb", "polygons"),
        ("checker-horizon", "checkerboard"),
    ],
)
def test_scenes_agree_with_a_million_rays(name: str, method: str) -> None:
    of, reference = stored(name), reference_of(name)
    assert reference.method == method
    assert reference.pixels.dtype == np.float32
    assert reference.pixels.shape == reference.exact.shape == (96, 128, 3)
    assert np.array_equal(reference.pixels, reference.exact.astype(np.float32))
    assert 0.0 < reference.error < 1e-9
    assert reference.standard_error is None
    many = 2 if len(of.surfaces) > 10 else 4
    against_rays(of, (128, 96), edge_pixels(of, (128, 96), many, reference), reference)


def test_neighbours_of_one_material_may_share_a_plane() -> None:
    """Which of them is in front does not show: together they are their union."""
    one, other = box(1.3, 1.2, 6.7, 5.9), box(3.1, 2.7, 9.6, 7.2)
    exact = make(scene(one, other), SIZE).exact
    apart = make(scene(one, other | {"points": [[x, y, 1.0] for x, y, _ in other["points"]]}), SIZE).exact
    assert np.abs(exact - apart).max() < 1e-14
    assert np.abs(exact - make(scene(other, one), SIZE).exact).max() < 1e-14


def test_another_size_is_the_same_scene() -> None:
    of = stored("edge")
    whole, fine = make(of, (64, 48)).exact, make(of, (128, 96)).exact
    averaged = fine.reshape(48, 2, 64, 2, 3).mean(axis=(1, 3))
    assert np.abs(whole - averaged).max() < 1e-12  # both are within 2e-12 of the truth, by their own bounds


LAYERED = {
    "nested": [box(1.3, 1.2, 9.7, 7.9), box(3.1, 2.7, 5.6, 5.2, 1.0, "green")],
    "partial": [box(1.3, 1.2, 6.7, 5.9), box(3.1, 2.7, 9.6, 7.2, -2.0, "green")],
    "far polygon listed last and concave": [
        polygon([(2.2, 1.1), (9.4, 1.7), (8.3, 7.6), (5.7, 3.2), (2.9, 7.3)], 3.0, "blue"),
        box(0.7, 4.2, 11.4, 6.3, 1.0, "green"),
    ],
    "tilted": [
        polygon([(1.2, 1.3, 2.0), (9.9, 2.1, -3.0), (8.6, 7.7, 1.0 - 3.6091)], 0.0, "red"),
        polygon([(2.2, 6.8, -4.0), (4.1, 0.7, -5.0), (10.8, 4.9, -8.0)], 0.0, "green"),
    ],
    "one over the next in a circle": [
        polygon([(1.1, 2.2, 1.0), (10.4, 2.6, -1.0), (10.4, 3.7, -1.0), (1.1, 3.3, 1.0)], material="red"),
        polygon([(9.2, 0.6, 1.0), (10.3, 0.9, 1.0), (4.9, 8.4, -1.0), (3.8, 8.1, -1.0)], material="green"),
        polygon([(5.6, 8.3, 1.0), (4.1, 8.4, 1.0), (1.4, 0.8, -1.0), (2.9, 0.7, -1.0)], material="blue"),
    ],
    "disc in disc in polygon": [
        box(0.6, 0.7, 11.2, 8.4, -3.0, "green"),
        disc(5.7, 4.3, 3.3, -1.0, "red"),
        disc(5.1, 4.6, 1.2, 0.5, "blue"),
    ],
    "polygon in disc, disc in that": [
        disc(5.7, 4.3, 4.1, -1.0, "red"),
        box(4.1, 2.2, 7.3, 6.7, 0.0, "green"),
        disc(5.6, 4.7, 1.1, 1.0, "blue"),
    ],
    "hidden disc, disc in front of two layers": [
        box(0.6, 0.7, 11.2, 8.4, -3.0, "green"),
        disc(5.7, 4.3, 3.3, -4.0, "red"),
        box(2.3, 1.8, 10.3, 7.9, -2.0, "red"),
        disc(5.4, 4.6, 1.6, 0.0, "blue"),
    ],
    "polygon behind a disc": [box(4.1, 3.2, 6.3, 5.7, -1.0), disc(5.2, 4.4, 2.6, 0.0)],
    "discs side by side": [disc(3.1, 4.2, 2.0), disc(7.1001, 4.2, 2.0, 0.0, "red")],
    "discs cut by the border of the picture": [
        box(-3.0, -3.0, 14.0, 11.0, -3.0, "green"),
        disc(0.7, 1.2, 1.7, 0.0, "red"),
        disc(11.3, 7.1, 2.3, 0.0, "blue"),
    ],
}


@pytest.mark.parametrize("name", LAYERED)
def test_layers_agree_with_a_million_rays(name: str) -> None:
    of = scene(*LAYERED[name])
    against_rays(of, SIZE, edge_pixels(of, SIZE, 4))


@pytest.mark.parametrize("name", ["partial", "tilted", "one over the next in a circle"])
def test_perspective_agrees_with_a_million_rays(name: str) -> None:
    of = scene(*LAYERED[name], camera=PERSPECTIVE)
    assert make(of, SIZE).method == "polygons"
    against_rays(of, SIZE, edge_pixels(of, SIZE, 4))


def test_perspective_disc_that_faces_the_viewer() -> None:
    camera = {"type": "perspective", "eye": [0.6, 0.3, 9.0], "look_at": [0.6, 0.3, 0.0], "vertical_fov_degrees": 52.0}
    of = scene(disc(3.3, 2.2, 1.4, 1.0), disc(8.8, 6.2, 2.1, -2.0, "red"), camera=camera)
    against_rays(of, SIZE, edge_pixels(of, SIZE, 4))


def test_areas_of_layers_by_hand() -> None:
    exact = make(scene(box(1.25, 1.5, 6.0, 5.0), box(1.5, 1.75, 4.0, 4.0, 1.0, "green")), SIZE).exact
    # Pixel (1, 1): green covers 1/2 x 1/4, red 3/4 x 1/2 less that. Dyadic numbers: only the sums round, 4 of them.
    expected = BACKGROUND + 0.125 * (GREEN - BACKGROUND) + 0.25 * (RED - BACKGROUND)
    assert np.abs(exact[1, 1] - expected).max() < 1e-15
    assert np.array_equal(exact[2, 2], GREEN)
    assert np.array_equal(exact[4, 4], RED)
    assert np.array_equal(exact[8, 11], BACKGROUND)


def test_neighbours_that_share_an_edge_leave_no_gap() -> None:
    corners = [(-1.0, -1.0), (5.17, -1.0), (6.83, 10.0), (-1.0, 10.0)]
    others = [(5.17, -1.0), (13.0, -1.0), (13.0, 10.0), (6.83, 10.0)]
    exact = make(scene(polygon(corners, material="red"), polygon(others, material="red")), SIZE).exact
    assert np.abs(exact - RED).max() < 1e-13  # a few roundings of coordinates up to 13: 2e-15 each


def test_a_fold_is_not_a_crossing() -> None:
    left = polygon([(1.3, 1.1, 0.0), (6.2, 1.1, 3.3), (6.2, 7.7, 3.3), (1.3, 7.7, 0.0)], material="red")
    right = polygon([(6.2, 1.1, 3.3), (3.9, 1.1, 1.0), (3.9, 7.7, 1.0), (6.2, 7.7, 3.3)], material="green")
    against_rays(scene(left, right), SIZE, [(3, 1), (3, 4), (6, 7)])


def test_a_polygon_seen_from_its_edge_or_behind_the_eye_is_not_there() -> None:
    edge_on = polygon([(2.0, 2.0, 0.0), (9.0, 7.0, 0.0), (9.0, 7.0, 5.0), (2.0, 2.0, 5.0)])
    assert np.array_equal(make(scene(edge_on, box(1, 1, 5, 5, z=17.0)), SIZE).exact, make(scene(), SIZE).exact)


ZONES = {"rings": {"emission": [1, 1, 1], "pattern": {"type": "zone-plate", "scale": 1.0}}}
CHECKED = {"tiles": {"emission": [1, 1, 1], "pattern": {"type": "checker", "scale": 1.0}}}
BRIGHT = {
    "emission": [1e30, 1, 1],
    "pattern": {"type": "zone-plate", "scale": 1.0, "colours": [[1e20, 0, 0], [1e10, 1, 1]]},
}
REFUSED = {
    "cross": (scene(box(1, 1, 8, 8, 0.0), polygon([(2, 2, -1), (9, 2, 2), (9, 7, 2), (2, 7, -1)])), "cross each other"),
    "same depth": (scene(box(1, 1, 8, 8), box(4, 4, 9, 9, material="blue")), "same depth"),
    "discs at the same depth": (scene(disc(4, 4, 2), disc(6, 4, 2, material="red")), "same depth"),
    "disc over an edge": (scene(box(1, 1, 6, 8), disc(6, 4, 2, 1.0)), "cut by another outline"),
    "disc behind an edge": (scene(box(1, 1, 6, 8, 2.0), disc(6, 4, 2, 1.0)), "cut by another outline"),
    "disc over a disc's edge": (scene(disc(5, 4, 2), disc(6, 4, 2, 1.0)), "cut by another outline"),
    "disc past a disc's edge by a thousandth": (scene(disc(5, 4, 3), disc(6.001, 4, 2, 1.0)), "cut by another"),
    "disc of a billion pixels": (scene(disc(-1e9, 4, 1e9 + 5)), "larger, or farther away"),
    "tilted disc": (scene(disc(5, 4, 2) | {"normal": [0.1, 0, 1]}), "does not face the viewer"),
    "sphere": (
        scene({"type": "sphere", "material": "red", "centre": [0, 0, 0], "radius": 1}),
        '"polygons" has no answer for sphere; "discs" has no answer for sphere',
    ),
    "plane": (
        scene({"type": "plane", "material": "red", "point": [0, 0, 0], "normal": [0, 1, 0]}),
        "the plane has no checkerboard",
    ),
    "mesh": (scene({"type": "mesh", "material": "red", "file": "m.obj"}), "answer for mesh"),
    "light": (
        scene(box(1, 1, 5, 5), lights=[{"type": "point", "position": [0, 0, 9], "intensity": [1, 1, 1]}]),
        "point light",
    ),
    "lens before what is tilted": (
        scene(box(1, 1, 5, 5), camera=PERSPECTIVE | {"lens_radius": 0.1, "focus_distance": 16.0}),
        "not parallel to the picture",
    ),
    "checker": (scene(box(1, 1, 5, 5, material="tiles"), materials=CHECKED), "checker"),
    "bow tie": (scene(polygon([(1, 1), (8, 8), (8, 1), (1, 6)])), "crosses or touches itself"),
    "not planar": (scene(polygon([(1, 1, 0), (8, 1, 1), (8, 8, 0), (1, 8, 1)])), "do not lie in one plane"),
    "partly covered rings": (scene(box(1.5, 1, 5, 5, material="rings"), materials=ZONES), r"covers pixel \(1, 1\)"),
    "tilted rings": (
        scene(polygon([(-20, -20, 0), (30, -20, 0.1), (30, 30, 0.1), (-20, 30, 0)], 0, "rings"), materials=ZONES),
        "not parallel to the picture",
    ),
    "brighter than float32": (
        scene(box(-1, -1, 13, 10, material="rings"), materials={"rings": BRIGHT}),
        "more than float32 holds",
    ),
    "far away": (scene(box(1e12, 1e12, 2e12, 2e12), box(-1e9, -1e9, 1e9 + 0.5, 5.5)), "rounding could move"),
    "behind the eye in part": (scene(polygon([(1, 1, 0), (8, 1, 20), (8, 8, 20)])), "reaches behind the eye"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_no_exact_answer_is_refused(name: str) -> None:
    of, reason = REFUSED[name]
    with pytest.raises(Unsupported, match=reason):
        make(of, SIZE)


def test_other_filters_are_refused() -> None:
    with pytest.raises(Unsupported, match='filter "mitchell"'):
        make(stored("edge"), (128, 96), "mitchell")


def test_where_a_method_refuses_the_next_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    of = scene(box(1.3, 1.2, 9.7, 7.9))

    def refusing(name: str, error: Exception) -> Method:
        def refuse(of: Scene, frame: Frame) -> Exact:
            raise error

        return Method(name, name, METHODS[0].features, refuse)

    one, other = refusing("one", Unsupported("not for one")), refusing("other", Unsupported("not for the other"))
    monkeypatch.setattr(references, "METHODS", (one, other, METHODS[0]))
    assert make(of, SIZE).method == METHODS[0].name
    monkeypatch.setattr(references, "METHODS", (one, other))
    with pytest.raises(Unsupported, match="not for one; not for the other"):
        make(of, SIZE)
    # That no answer is right is not for another method to decide.
    monkeypatch.setattr(references, "METHODS", (refusing("one", Ambiguous("by a rounding")), METHODS[0]))
    with pytest.raises(Ambiguous, match="by a rounding"):
        make(of, SIZE)


def test_methods_have_names_of_their_own() -> None:
    assert len({method.name for method in METHODS}) == len(METHODS)
    answers = 0
    for method in METHODS:
        if method.requires is not None:
            assert method.cannot(scene(box(1, 1, 5, 5))) is not None
        elif "polygon" in method.features:
            assert method.cannot(scene(box(1, 1, 5, 5))) is None
            try:
                pixels = method.make(scene(box(1, 1, 5, 5)), frame_of(scene(), SIZE)).pixels
            except Unsupported:  # a method for special polygons
                continue
            assert np.array_equal(pixels[2, 2], RED)
            answers += 1
    assert answers >= 3


coordinates = st.floats(1.0, 8.0, allow_subnormal=False)


def two_layers(corners: list[tuple[float, float]], round_: tuple[float, float, float], x: float, y: float) -> Scene:
    """A triangle and a disc below a layer that hides neither, moved by (x, y) pixels."""
    moved = [(cx + x, cy + y) for cx, cy in corners]
    return scene(polygon(moved, 0.0, "red"), disc(round_[0] + x, round_[1] + y + 40, round_[2], 1.0), size=(12, 60))


@settings(max_examples=40, deadline=None)
@given(
    corners=st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=3),
    round_=st.tuples(coordinates, coordinates, st.floats(1e-3, 4.0)),
    x=st.integers(0, 3),
    y=st.integers(0, 9),
)
def test_moving_by_whole_pixels_moves_the_picture(
    corners: list[tuple[float, float]], round_: tuple[float, float, float], x: int, y: int
) -> None:
    if abs(np.cross(*np.diff(np.column_stack([corners, np.zeros(3)]), axis=0))[2]) < 1e-3:
        return  # no area
    still, moved = (make(two_layers(corners, round_, *by), (12, 60)) for by in ((0, 0), (x, y)))
    background = np.array(BACKGROUND)
    shifted = np.broadcast_to(background, still.exact.shape).copy()
    shifted[y:, x:] = still.exact[: 60 - y, : 12 - x]
    # What the move brings in from the left and above is background; what was cut at the right border may differ.
    assert np.abs(shifted - moved.exact)[:, : 12 - 4 + x].max() <= still.error + moved.error


@settings(max_examples=40, deadline=None)
@given(
    corners=st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=3),
    round_=st.tuples(coordinates, coordinates, st.floats(1e-3, 4.0)),
)
def test_a_mirrored_scene_makes_a_mirrored_picture(
    corners: list[tuple[float, float]], round_: tuple[float, float, float]
) -> None:
    if abs(np.cross(*np.diff(np.column_stack([corners, np.zeros(3)]), axis=0))[2]) < 1e-3:
        return  # no area
    straight = make(two_layers(corners, round_, 0, 0), (12, 60))
    flipped = make(
        two_layers([(12 - cx, cy) for cx, cy in corners], (12 - round_[0], round_[1], round_[2]), 0, 0), (12, 60)
    )
    assert np.abs(straight.exact[:, ::-1] - flipped.exact).max() <= straight.error + flipped.error
