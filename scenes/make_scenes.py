"""Writes the scenes and the mesh that have too many numbers to write by hand.

Run: .venv/bin/python scenes/make_scenes.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import trimesh

HERE = Path(__file__).parent
COMMAND = "# Generated: .venv/bin/python scenes/make_scenes.py\n"
PIXEL = 2.0 / 96

FLAT = """
[view]
size = [128, 96]
background = [{background}]

[camera]
type = "orthographic"
eye = [0.0, 0.0, 4.0]
look_at = [0.0, 0.0, 0.0]
height = 2.0
"""


def polygon(material: str, points: list[tuple[float, float]], z: float = 0.0) -> str:
    corners = ", ".join(f"[{x:.9g}, {y:.9g}, {z:.9g}]" for x, y in points)
    return f'\n[[surfaces]]\ntype = "polygon"\nmaterial = "{material}"\npoints = [{corners}]\n'


def siemens_star() -> str:
    """36 spokes, off the middle; toward the centre they are narrower than a pixel, and their turn is irrational."""
    spokes, centre, radius, turn = 36, (-0.2113, 0.0877), 0.8719, 0.0371
    text = (
        COMMAND
        + 'title = "Siemens star"\nshows = "Spokes that narrow toward the centre at every angle: where they blur into '
        + 'grey is the limit of the pixels, and rings or moire there are alias."\n'
        + FLAT.format(background="0.0417, 0.0533, 0.0719")
        + "\n[materials.spoke]\nemission = [0.9273, 0.8941, 0.8117]\n"
    )
    for k in range(spokes):
        ends = [2 * math.pi * (k + part) / spokes + turn for part in (0.0, 0.5)]
        rim = [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in ends]
        text += polygon("spoke", [centre, *rim])
    return text


def comb() -> str:
    """22 slivers, nearly horizontal, from nine tenths of a pixel thick down to one sixteenth; each leans
    differently, and the lower ones lie in front where they cross."""
    text = (
        COMMAND
        + 'title = "Comb"\nshows = "Slivers thinner than a pixel and nearly horizontal: a renderer that samples too '
        + 'little breaks them into dashes, or loses them."\n'
        + FLAT.format(background="0.0291, 0.0317, 0.0373")
        + "\n[materials.tooth]\nemission = [0.8919, 0.9347, 0.7813]\n"
        + "\n[materials.rust]\nemission = [0.9571, 0.4129, 0.1931]\n"
    )
    for k in range(22):
        thickness = PIXEL * 0.9 * (1 / 14.4) ** (k / 21)
        slope = (0.0137 + 0.00291 * k) * (-1) ** k
        y = 0.9231 - 0.0843 * k + 0.0017 * math.sin(7.3 * k)
        left, right = -1.1873 + 0.0129 * k, 1.2317 - 0.0093 * k
        material = "rust" if k % 5 == 2 else "tooth"
        middle = 0.5 * (left + right)
        low = [(x, y + slope * (x - middle)) for x in (left, right)]
        high = [(x, y + slope * (x - middle) + thickness) for x in (right, left)]
        text += polygon(material, low + high, 0.0131 * k)
    return text


def surface(kind: str, material: str, motion: str = "", **numbers: object) -> str:
    lines = [f"{key} = {value!r}" for key, value in numbers.items()]
    moves = [f"motion = {motion}"] if motion else []
    return "\n".join(["\n[[surfaces]]", f'type = "{kind}"', f'material = "{material}"', *lines, *moves]) + "\n"


def disc(material: str, x: float, y: float, z: float, radius: float, motion: str = "") -> str:
    return surface("disc", material, motion, centre=[round(c, 9) for c in (x, y, z)], radius=round(radius, 9))


def solid(material: str, points: list[tuple[float, float, float]], motion: str = "") -> str:
    corners = [[round(c, 9) for c in point] for point in points]
    return surface("polygon", material, motion, points=corners)


FOCUS, LENS = 7.3137, 0.4319


def depth_of_field() -> str:
    """Seven columns of an edge, a disc and a light point, nearer to farther: their circles of confusion have radii of
    5.2 pixels down to a twentieth of one and up again, and keep apart on the picture."""
    fov, eye = 33.71, (0.0713, 0.0419, FOCUS)
    pixel = 2.0 * math.tan(math.radians(fov) / 2) / 96
    text = (
        COMMAND
        + 'title = "Depth of field"\nshows = "Leaning edges, discs and points of light in a row through the focus of a '
        + 'lens: sharp in the middle, and blurred by its disc in front and behind."\n'
        + "\n[view]\nsize = [128, 96]\nbackground = [0.0371, 0.0433, 0.0619]\n"
        + f'\n[camera]\ntype = "perspective"\neye = [{eye[0]}, {eye[1]}, {eye[2]}]\n'
        + f"look_at = [{eye[0]}, {eye[1]}, 0.0]\nvertical_fov_degrees = {fov}\n"
        + f"lens_radius = {LENS}\nfocus_distance = {FOCUS}\n"
    )
    bars = [(0.9137, 0.3319, 0.2371), (0.9419, 0.6173, 0.2137), (0.8719, 0.8337, 0.4391), (0.9231, 0.9173, 0.8819)]
    bars += [(0.4719, 0.8371, 0.5713), (0.2937, 0.6719, 0.8933), (0.5137, 0.4733, 0.9271)]
    text += "\n[materials.spark]\nemission = [7.1937, 6.4319, 5.1733]\n"
    for k, colour in enumerate(bars):
        text += f"\n[materials.colour{k}]\nemission = [{', '.join(map(str, colour))}]\n"
    for k, blur_px in enumerate((5.213, 3.519, 1.737, 0.0519, -1.7733, -3.4419, -5.1371)):
        depth = 1.0 / (1.0 / FOCUS + blur_px * pixel / LENS)
        middle = -53.27 + 17.719 * k

        def at(x_px: float, y_px: float, depth: float = depth) -> tuple[float, float, float]:
            return eye[0] + x_px * pixel * depth, eye[1] + y_px * pixel * depth, eye[2] - depth

        lean = 2.137 + 0.319 * math.sin(5.3 * k)
        low, high = 3.719 + 0.833 * math.cos(3.1 * k), 38.371 + 0.719 * math.sin(2.7 * k)
        corners = [(-3.917, low), (3.733, low + 1.319), (3.733 + lean, high), (-3.917 + lean, high - 1.873)]
        text += solid(f"colour{k}", [at(middle + x, y) for x, y in corners])
        down = -16.319 - 1.237 * math.sin(1.9 * k)
        text += disc(f"colour{k}", *at(middle + 0.173 * math.sin(4.1 * k), down), 4.1371 * pixel * depth)
        text += disc("spark", *at(middle + 0.619, -36.873 + 1.137 * math.cos(2.3 * k)), 0.6719 * pixel * depth)
    return text


SPOKES = 7


def wheel(x: float, y: float, turn: float, scale: float, motion: str) -> str:
    """Spokes before a dark plate, a bright ring of short bars outside, a hub."""

    def at(radius: float, angle: float, z: float) -> tuple[float, float, float]:
        return x + scale * radius * math.cos(angle), y + scale * radius * math.sin(angle), z

    text = disc("plate", x, y, 0.0, 0.4937 * scale, motion)
    for k in range(SPOKES):
        middle = turn + 2 * math.pi * k / SPOKES
        thin, wide = 0.313 - 0.0171 * k, 0.0919 + 0.0083 * k
        spoke = [at(0.0731, middle - thin, 0.1), at(0.4519, middle - wide, 0.1)]
        spoke += [at(0.4519, middle + wide, 0.1), at(0.0731, middle + thin, 0.1)]
        text += solid("lacquer" if k == 0 else "spoke", spoke, motion)
    return text + disc("hub", x, y, 0.2, 0.1137 * scale, motion)


def motion_blur() -> str:
    """One wheel that slides and one that turns, while the shutter is open for two thirds of the time."""
    text = (
        COMMAND
        + 'title = "Motion blur"\nshows = "Two wheels under an open shutter: one slides to the right, its spokes blur '
        + 'by how much they stand across its way; one turns, and its spokes blur toward the rim."\n'
        + FLAT.format(background="0.3719, 0.4337, 0.5173")
        + "shutter = [0.1137, 0.7819]\n"
    )
    colours = {
        "plate": "0.0719, 0.0633, 0.0571",
        "spoke": "0.8937, 0.8519, 0.7371",
        "lacquer": "0.9173, 0.2419, 0.1337",
    }
    for name, colour in (colours | {"hub": "0.6319, 0.5137, 0.2733"}).items():
        text += f"\n[materials.{name}]\nemission = [{colour}]\n"
    text += wheel(-0.7373, 0.1937, 0.2719, 1.1419, '{ type = "translate", by = [0.2937, -0.0713, 0.0] }')
    centre = (0.6619, -0.1873)
    turning = f"axis = [0.0, 0.0, 1.0], centre = [{centre[0]}, {centre[1]}, 0.0], degrees = 28.73"
    return text + wheel(*centre, 0.4133, 1.2419, '{ type = "rotate", ' + turning + " }")


def emissions(colours: dict[str, str]) -> str:
    return "".join(f"\n[materials.{name}]\nemission = [{colour}]\n" for name, colour in colours.items())


def soft_shadow() -> str:
    """A fence of seven boards and two rails on a floor, under a parallelogram of light."""
    text = (
        COMMAND
        + 'title = "Soft shadow"\nshows = "A fence of straight boards between a floor and a lamp with an area: its '
        + 'shadow is sharp where a board stands on the floor and fades with the distance from it."\n'
        + "\n[view]\nsize = [128, 96]\nbackground = [0.2931, 0.3617, 0.4573]\n"
        + '\n[camera]\ntype = "perspective"\neye = [0.5719, 2.6173, 3.9137]\nlook_at = [0.1033, 0.2719, 0.2977]\n'
        + "vertical_fov_degrees = 33.71\n"
        + "\n[materials.floor]\nalbedo = [0.7419, 0.7173, 0.6637]\nemission = [0.0393, 0.0437, 0.0519]\n"
        + "\n[materials.board]\nalbedo = [0.7713, 0.4119, 0.2527]\nemission = [0.2137, 0.1091, 0.0673]\n"
    )
    text += solid(
        "floor", [(-2.7137, 0.0, -1.6719), (2.8371, 0.0, -1.5733), (2.6917, 0.0, 2.6379), (-2.5319, 0.0, 2.8371)]
    )
    start, along = (-1.2719, -0.4137), (0.9719, -0.2355)

    def at(way: float, height: float, off: float = 0.0) -> tuple[float, float, float]:
        return start[0] + along[0] * way - along[1] * off, height, start[1] + along[1] * way + along[0] * off

    for k in range(7):
        left, lean = 0.3937 * k + 0.0171 * math.sin(5.1 * k), 0.0137 * math.cos(3.7 * k)
        right, top = left + 0.1519, 0.8137 + 0.0433 * math.sin(2.9 * k)
        text += solid(
            "board",
            [
                at(left, 0.0),
                at(right, 0.0),
                at(right + lean, top),
                at((left + right) / 2 + lean, top + 0.1173),
                at(left + lean, top),
            ],
        )
    for height in (0.1937, 0.5719):
        rail = [at(-0.1173, height, -0.0319), at(2.6719, height + 0.0137, -0.0319)]
        text += solid("board", [*rail, at(2.6719, height + 0.1019, -0.0319), at(-0.1173, height + 0.0937, -0.0319)])
    return (
        text
        + '\n[[lights]]\ntype = "area"\ncorner = [-2.1137, 1.9319, -2.7719]\n'
        + "edges = [[0.9371, 0.0, 0.1719], [-0.0713, 0.5137, -0.4319]]\nintensity = [1.3937, 1.2933, 1.1319]\n"
    )


def block(material: str, x: float, z: float, width: float, depth: float, height: float, turn: float) -> str:
    """A box on the floor y = 0 about (x, z), without its bottom."""
    corners = []
    for across, away in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        a, b = across * width / 2, away * depth / 2
        corners.append((x + a * math.cos(turn) + b * math.sin(turn), z - a * math.sin(turn) + b * math.cos(turn)))
    text = solid(material, [(cx, height, cz) for cx, cz in corners])
    for (ax, az), (bx, bz) in zip(corners, [*corners[1:], corners[0]], strict=True):
        text += solid(material, [(ax, 0.0, az), (bx, 0.0, bz), (bx, height, bz), (ax, height, az)])
    return text


def cornell_box() -> str:
    """After the room of Goral, Torrance, Greenberg and Battaile 1984; its measures are our own."""
    text = (
        COMMAND
        + 'title = "Cornell box"\nshows = "A closed room under a square of light: walls colour each other and the '
        + "blocks, whose shadows are soft; all light here came over a surface, except the lamp's own.\"\n"
        + "\n[view]\nsize = [128, 96]\n"
        + '\n[camera]\ntype = "perspective"\neye = [0.0319, 1.0173, 4.3719]\nlook_at = [0.0137, 0.9913, 0.0]\n'
        + "vertical_fov_degrees = 36.37\n"
        + "\n[transport]\ndiffuse_bounces = 4\n"
    )
    for name, albedo in {
        "chalk": "0.7319, 0.7137, 0.6713",
        "rose": "0.6337, 0.0719, 0.0613",
        "grass": "0.1373, 0.4719, 0.0937",
    }.items():
        text += f"\n[materials.{name}]\nalbedo = [{albedo}]\n"
    text += emissions({"lamp": "14.1937, 11.9133, 8.4719"})
    left, right, top, back, front = -1.3137, 1.3519, 1.9937, -1.1719, 1.6137
    floor = [(left, 0.0, front), (right, 0.0, front), (right, 0.0, back), (left, 0.0, back)]
    # The ceiling has a hole for the lamp, which would light it from a hair's breadth otherwise.
    lamp = [(-0.3819, top, 0.2537), (0.4019, top, 0.2719), (0.4137, top, -0.4173), (-0.3719, top, -0.4337)]
    ceiling = [(x, top, z) for x, _, z in floor]
    text += solid("chalk", floor) + solid("lamp", lamp)
    for k in range(4):
        text += solid("chalk", [ceiling[k], ceiling[(k + 1) % 4], lamp[(k + 1) % 4], lamp[k]])
    text += solid("chalk", [(left, 0.0, back), (right, 0.0, back), (right, top, back), (left, top, back)])
    text += solid("rose", [(left, 0.0, front), (left, 0.0, back), (left, top, back), (left, top, front)])
    text += solid("grass", [(right, 0.0, front), (right, 0.0, back), (right, top, back), (right, top, front)])
    return (
        text
        + block("chalk", -0.4719, -0.3937, 0.6137, 0.5937, 1.1719, 0.3137)
        + block("chalk", 0.4937, 0.3719, 0.5713, 0.5519, 0.5619, -0.2873)
    )


def highlights() -> str:
    """Bars of light and lamps, 10^4 times as bright as the walls behind them, over a floor that mirrors them."""
    text = (
        COMMAND
        + 'title = "Highlights"\nshows = "Tubes and points of light thinner than a pixel, ten thousand times as bright '
        + 'as what is behind them, and their images in a floor: one sample that hits outweighs all that miss."\n'
        + "\n[view]\nsize = [128, 96]\nbackground = [0.0193, 0.0237, 0.0341]\n"
        + '\n[camera]\ntype = "perspective"\neye = [0.0713, 0.8137, 5.1937]\nlook_at = [0.0713, 0.7319, 0.0]\n'
        + "vertical_fov_degrees = 33.19\n"
        + "\n[transport]\nmirror_bounces = 1\n"
        + "\n[materials.floor]\nemission = [0.0119, 0.0137, 0.0173]\nreflection = [0.4937, 0.5219, 0.5713]\n"
    )
    text += emissions(
        {
            "house0": "0.0719, 0.0633, 0.0937",
            "house1": "0.1137, 0.0819, 0.0713",
            "house2": "0.0519, 0.0913, 0.1073",
            "pink": "193.7, 47.19, 121.3",
            "cyan": "37.19, 171.3, 201.9",
            "amber": "213.7, 137.3, 31.73",
            "lamp": "237.1, 219.3, 181.9",
        }
    )
    text += solid(
        "floor", [(-4.1373, 0.0, -2.6719), (4.2719, 0.0, -2.5937), (3.0913, 0.0, 4.1137), (-3.2137, 0.0, 4.0719)]
    )
    walls = [
        (-1.9137, -1.1319, 1.4719),
        (-1.0371, -0.3319, 1.0137),
        (-0.2519, 0.4713, 1.7319),
        (0.5519, 1.2137, 1.1937),
        (1.2919, 2.0373, 1.5519),
    ]
    for k, (left, right, top) in enumerate(walls):
        z = -0.6137 - 0.0719 * k
        text += solid(f"house{k % 3}", [(left, 0.0, z), (right, 0.0, z), (right, top, z), (left, top, z)])
    for k in range(11):
        x, low, high = -1.7719 + 0.3473 * k, 0.1937 + 0.0713 * math.sin(2.3 * k), 0.7137 + 0.2719 * math.cos(1.7 * k)
        thick, lean = 0.0037 + 0.00171 * (k % 4), 0.2473 * math.sin(3.1 * k)
        points = [(x, low), (x + thick, low), (x + thick + lean, high), (x + lean, high)]
        text += solid(("pink", "cyan", "amber")[k % 3], [(px, py, -0.3719 + 0.0137 * k) for px, py in points])
    for k in range(9):
        x, y, z = -1.7137 + 0.4319 * k, 1.1713 + 0.3137 * math.sin(4.7 * k + 0.9), -0.2137 + 0.0119 * k
        radius = 0.0037 + 0.00193 * (k % 5)
        turns = [0.3137 * k + 2 * math.pi * j / 11 for j in range(11)]
        text += solid("lamp", [(x + radius * math.cos(a), y + radius * math.sin(a), z) for a in turns])
    return text


def terrain_mesh() -> trimesh.Trimesh:
    """A height field of 224 x 224 cells: hills, and ridges down to the size of a cell."""
    cells = 224
    x, z = np.meshgrid(np.linspace(-3.0, 3.0, cells + 1), np.linspace(-4.0, 2.0, cells + 1), indexing="xy")
    y = (
        0.31 * np.sin(1.7 * x + 0.4) * np.cos(1.3 * z - 0.7)
        + 0.13 * np.sin(4.1 * x - 2.3 * z + 1.1)
        + 0.043 * np.sin(11.3 * z + 3.7 * x) * np.sin(9.7 * x)
        + 0.011 * np.sin(37.1 * x + 5.3 * z) * np.cos(31.7 * z)
    )
    corner = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    faces = np.concatenate([np.stack([a, d, c], -1).reshape(-1, 3), np.stack([a, c, b], -1).reshape(-1, 3)])
    vertices = np.stack([x, y, z], -1).reshape(-1, 3).astype(np.float32)
    return trimesh.Trimesh(vertices, faces, process=False)


def main() -> None:
    (HERE / "siemens-star.toml").write_text(siemens_star())
    (HERE / "comb.toml").write_text(comb())
    (HERE / "depth-of-field.toml").write_text(depth_of_field())
    (HERE / "motion-blur.toml").write_text(motion_blur())
    (HERE / "soft-shadow.toml").write_text(soft_shadow())
    (HERE / "cornell-box.toml").write_text(cornell_box())
    (HERE / "highlights.toml").write_text(highlights())
    terrain_mesh().export(HERE / "terrain.ply", encoding="binary", vertex_normal=False)


if __name__ == "__main__":
    main()
