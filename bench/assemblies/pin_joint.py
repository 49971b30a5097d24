"""A pin with clearance through an eye and a fork; the eye is pulled, straight and then askew."""

from shapes import at, box, cut, cylinder, fuse, part

import numpy as np

H = {"50k": 1.08, "200k": 0.62, "700k": 0.38}
PIN, HOLE = 10.0, 10.02


def hole(x, z):
    return np.abs(np.hypot(x, z) - HOLE) < 5e-3


def build(folder, s):
    def away(x, y, z):
        return abs((x * x + z * z) ** 0.5 - 10)

    def eye():
        body = fuse(cylinder((0, -10, 0), (0, 20, 0), 20), box((0, -10, -16), (70, 10, 16)))
        cut(body, cylinder((0, -11, 0), (0, 22, 0), HOLE))

    def fork():
        body = fuse(cylinder((0, -23, 0), (0, 46, 0), 20), box((-60, -23, -20), (0, 23, 20)))
        cut(body, box((-32, -10.5, -21), (21, 10.5, 21)), cylinder((0, -24, 0), (0, 48, 0), HOLE))

    part(f"{folder}/pin.msh", s, lambda: cylinder((0, -26, 0), (0, 52, 0), PIN), lambda *p: 2.6, {
        "middle": lambda x, y, z: np.abs(np.hypot(x, z) - PIN) < 5e-3,
    })
    part(f"{folder}/eye.msh", s, eye, lambda *p: 2.9 + 0.2 * away(*p), {
        "hole": lambda x, y, z: hole(x, z),
        "end": lambda x, y, z: at(70, x),
    })
    part(f"{folder}/fork.msh", s, fork, lambda *p: 2.9 + 0.2 * away(*p), {
        "holes": lambda x, y, z: hole(x, z),
        "end": lambda x, y, z: at(-60, x),
    })
