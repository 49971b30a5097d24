"""A tapered hip stem of titanium in a bone: cortical outside, spongy around the upper part of the stem."""

import numpy as np
from shapes import at, cut, cylinder, fuse, occ, part

H = {"50k": 1.13, "200k": 0.67, "700k": 0.435}
# The cross-sections are ellipses, longer by this along x.
LONG = 1.35
TOP, TIP, DEEP = 8.0, 5.0, -90.0


def taper(z):
    return TOP + (TOP - TIP) * z / -DEEP


def radius(x, y):
    return np.hypot(x / LONG, y)


def cone(low, high, at_low, at_high):
    body = (3, occ.addCone(0, 0, low, 0, 0, high - low, at_low, at_high))
    occ.dilate([body], 0, 0, 0, LONG, 1, 1)
    return body


def build(folder, s):
    def stem():
        body = cone(DEEP, 0, TIP, TOP)
        neck = cylinder((0, 0, -4), (32, 0, 36), 5.5)
        fuse(body, neck, (3, occ.addSphere(32, 0, 32, 13)))

    def bone():
        outer = cone(-150, -2, 12.5, 16.5)
        spongy = occ.intersect([cone(-60, -2, 8.5, 13.5)], [outer], removeTool=False)[0][0]
        cavity = cone(-94, 6, taper(-94), taper(6))
        canal = cylinder((0, 0, -151), (0, 0, 58), 4.5)
        cortical = occ.cut([outer], [spongy, cavity, canal], removeTool=False)[0][0]
        spongy = occ.cut([spongy], [cavity])[0][0]
        occ.remove([canal], recursive=True)
        occ.fragment([cortical], [spongy])

    def wall(x, y, z):
        return (np.abs(radius(x, y) - taper(z)) < 5e-3) & (z > DEEP - 5)

    def size(x, y, z):
        return 3.0 + 0.15 * abs(radius(x, y) - taper(z)) + 0.05 * max(-90 - z, 0)

    part(f"{folder}/stem.msh", s, stem, size, {
        "wall": lambda x, y, z: wall(x, y, z) & (z < 1e-3),
        "head": lambda x, y, z: np.hypot(np.hypot(x - 32, y), z - 32) < 13.01,
    })
    part(f"{folder}/bone.msh", s, bone, size, {
        "cavity": wall,
        "foot": lambda x, y, z: at(-150, z),
    }, {"cortical": lambda *b: b[2] < -140, "spongy": lambda *b: b[2] > -140})
