"""The root of a blade in the slot of a disc: pulled outwards, then pushed along and across the slot."""

from shapes import at, box, cut, fuse, part, prism, rounded

H = {"50k": 1.04, "200k": 0.585, "700k": 0.36}
# The flank runs from the neck to the shoulder, down and outwards.
NECK, SHOULDER = (6, -2), (12, -10)


def mirrored(right):
    return right + [(-x, y) for x, y in reversed(right)]


def flank(x, y):
    (a, b), (c, d) = NECK, SHOULDER
    return abs((abs(x) - a) * (d - b) - (y - b) * (c - a)) < 1e-2


def build(folder, s):
    def distance(x, y, z):
        return max(abs(abs(x) - 9) - 4, abs(y + 6) - 5, 0)

    def blade():
        root = prism(mirrored([(6, 4), NECK, SHOULDER, (12, -14)]), 0, 24)
        root = rounded(root, 1.5, (6, -2), (-6, -2))
        root = rounded(root, 1, (12, -10), (-12, -10), (12, -14), (-12, -14))
        fuse(root, box((-13, 4, 0), (13, 8, 24)), box((-3, 8, 2), (3, 48, 22)))

    def disc():
        slot = prism(mirrored([(6.3, 1), (6.3, -2.4), (12.4, -10.5333333), (12.4, -15)]), -1, 25)
        slot = rounded(slot, 1.5, (12.4, -10.5333333), (-12.4, -10.5333333), (12.4, -15), (-12.4, -15))
        cut(box((-32, -45, 0), (32, 0, 24)), slot)

    part(f"{folder}/blade.msh", s, blade, lambda *p: 2.0 + 0.15 * distance(*p), {
        "flanks": lambda x, y, z: flank(x, y),
        "tip": lambda x, y, z: at(48, y),
    })
    part(f"{folder}/disc.msh", s, disc, lambda *p: 2.2 + 0.2 * distance(*p), {
        "flanks": lambda x, y, z: flank(x, y),
        "sides": lambda x, y, z: at(32, abs(x)),
        "foot": lambda x, y, z: at(-45, y),
    })
