"""Two flanges of a pipe with a gasket between them and eight bolts: tightened, put under pressure, then bent."""

import numpy as np
from shapes import around, at, cut, cylinder, fuse, occ, part, revolved

H = {"50k": 1.0, "200k": 0.6, "700k": 0.38}
CIRCLE = 48.0
PLACES = [(CIRCLE * np.cos(a), CIRCLE * np.sin(a)) for a in np.pi / 4 * (np.arange(8) + 0.5)]


def build(folder, s):
    def flange(sign):
        outline = [(25, 1), (62, 1), (62, 13), (34, 13), (31, 20), (31, 50), (25, 50)]
        body = revolved([(r, sign * z) for r, z in outline])
        cut(body, *(cylinder((x, y, 0), (0, 0, sign * 15), 4.5) for x, y in PLACES))

    def bolt():
        # Cut across its shank in the middle: the section of the pretension.
        halves = []
        for sign in (1, -1):
            shank = cylinder((0, 0, 0), (0, 0, 13 * sign), 4)
            halves.append(fuse(shank, cylinder((0, 0, 13 * sign), (0, 0, 6 * sign), 7)))
        occ.fragment(halves[:1], halves[1:])

    for name, sign, h in [("upper", 1, 6.0), ("lower", -1, 6.6)]:
        part(f"{folder}/{name}.msh", lambda: flange(sign), lambda x, y, z: s * (h + 0.05 * max(abs(z) - 13, 0)), {
            "face": lambda x, y, z: at(sign, z),
            "seat": lambda x, y, z: at(13 * sign, z),
            "bore": lambda x, y, z: around(25, x, y),
            "end": lambda x, y, z: at(50 * sign, z),
        })
    part(f"{folder}/gasket.msh", lambda: revolved([(26, -1), (40, -1), (40, 1), (26, 1)]), lambda *p: s * 4.0, {
        "top": lambda x, y, z: at(1, z),
        "bottom": lambda x, y, z: at(-1, z),
    })
    part(f"{folder}/bolt.msh", bolt, lambda *p: s * 3.2, {
        "head": lambda x, y, z: at(13, z),
        "nut": lambda x, y, z: at(-13, z),
        "cut": lambda x, y, z: at(0, z),
    })
