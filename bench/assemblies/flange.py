"""Two flanges of a pipe with a gasket between them and eight bolts: tightened, put under pressure, then bent."""

import numpy as np
from shapes import around, at, bolt, bolt_groups, cut, cylinder, part, revolved

H = {"50k": 1.5, "200k": 0.78, "700k": 0.445}
CIRCLE = 48.0
PLACES = [(CIRCLE * np.cos(a), CIRCLE * np.sin(a)) for a in np.pi / 4 * (np.arange(8) + 0.5)]


def build(folder, s):
    def flange(sign):
        outline = [(25, 1), (62, 1), (62, 13), (34, 13), (31, 20), (31, 50), (25, 50)]
        body = revolved([(r, sign * z) for r, z in outline])
        cut(body, *(cylinder((x, y, 0), (0, 0, sign * 15), 4.5) for x, y in PLACES))

    for name, sign, h in [("upper", 1, 6.0), ("lower", -1, 6.6)]:
        part(f"{folder}/{name}.msh", s, lambda: flange(sign), lambda x, y, z: h + 0.05 * max(abs(z) - 13, 0), {
            "face": lambda x, y, z: at(sign, z),
            "seat": lambda x, y, z: at(13 * sign, z),
            "bore": lambda x, y, z: around(25, x, y),
            "end": lambda x, y, z: at(50 * sign, z),
        })
    part(f"{folder}/gasket.msh", s, lambda: revolved([(26, -1), (40, -1), (40, 1), (26, 1)]), lambda *p: 4.0, {
        "top": lambda x, y, z: at(1, z),
        "bottom": lambda x, y, z: at(-1, z),
    })
    part(f"{folder}/bolt.msh", s, lambda: bolt(13, 4, 7, 6), lambda *p: 3.2, bolt_groups(13))
