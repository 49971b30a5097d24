"""A slotted clamp on a shaft, tightened by a screw, then pushed along the shaft."""

import numpy as np
from shapes import around, at, bolt, bolt_groups, box, cut, cylinder, fuse, part

H = {"50k": 1.1, "200k": 0.635, "700k": 0.41}


def build(folder, s):
    def collar():
        body = fuse(cylinder((0, 0, 0), (0, 0, 20), 28), box((20, -14, 0), (46, 14, 20)))
        cut(body, cylinder((0, 0, -1), (0, 0, 22), 15), box((10, -1.5, -1), (47, 1.5, 21)), cylinder((37, -15, 10), (0, 30, 0), 4.2))

    part(f"{folder}/collar.msh", s, collar, lambda x, y, z: 2.7 + 0.1 * abs((x * x + y * y) ** 0.5 - 15), {
        "bore": lambda x, y, z: around(15, x, y),
        "upper": lambda x, y, z: at(14, y),
        "lower": lambda x, y, z: at(-14, y),
        "end": lambda x, y, z: at(46, x),
    })
    part(f"{folder}/shaft.msh", s, lambda: cylinder((0, 0, -25), (0, 0, 60), 15), lambda x, y, z: 3.1 + 0.1 * max(-z, z - 20, 0), {
        "seat": lambda x, y, z: around(15, x, y),
        "foot": lambda x, y, z: at(-25, z),
    })
    part(f"{folder}/screw.msh", s, lambda: bolt(14, 4, 6.5, 6), lambda *p: 2.4, bolt_groups(14))
