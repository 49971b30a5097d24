"""An angle bracket on a plate with two bolts: tightened, then pulled."""

import numpy as np
from shapes import around, at, bolt, bolt_groups, box, cut, cylinder, occ, part, prism, rounded

H = {"50k": 1.04, "200k": 0.55, "700k": 0.355}
PLACES = [(60, -16), (60, 16)]


def build(folder, s):
    def near(x, y, z):
        return min(((x - a) ** 2 + (y - b) ** 2) ** 0.5 for a, b in PLACES)

    def holes(low, high):
        return [cylinder((x, y, low - 1), (0, 0, high - low + 2), 6.5) for x, y in PLACES]

    def bracket():
        # Drawn in x and z and pulled along y: made flat, then set upright.
        body = prism([(0, 0), (95, 0), (95, 12), (12, 12), (12, 85), (0, 85)], -32, 32)
        body = rounded(body, 8, (12, 12))
        occ.rotate([body], 0, 0, 0, 1, 0, 0, np.pi / 2)
        cut(body, *holes(0, 12))

    part(f"{folder}/bracket.msh", s, bracket, lambda x, y, z: 4.0 + 0.08 * near(x, y, z) + 0.02 * max(z, 0), {
        "foot": lambda x, y, z: at(0, z),
        "top": lambda x, y, z: at(12, z),
        "back": lambda x, y, z: at(0, x),
    })
    part(f"{folder}/plate.msh", s, lambda: cut(box((-25, -50, -16), (120, 50, 0)), *holes(-16, 0)), lambda *p: 4.4 + 0.1 * near(*p), {
        "top": lambda x, y, z: at(0, z),
        "under": lambda x, y, z: at(-16, z),
        "ends": lambda x, y, z: at(-25, x) | at(120, x),
    })
    part(f"{folder}/bolt.msh", s, lambda: bolt(14, 6, 10, 8), lambda *p: 3.4, bolt_groups(14))
