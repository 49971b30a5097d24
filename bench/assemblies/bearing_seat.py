"""The outer ring of a bearing in a block of aluminium, pressed in, then loaded by its balls and along its axis."""

from shapes import around, at, box, cut, cylinder, fuse, part, revolved

H = {"50k": 1.0, "200k": 0.54, "700k": 0.328}


def build(folder, s):
    def housing():
        body = fuse(cylinder((0, 0, 0), (0, 0, 22), 54), box((-54, -60, 0), (54, 0, 22)), box((-85, -60, 0), (85, -46, 22)))
        holes = [cylinder((x, -61, 11), (0, 16, 0), 6) for x in (-68, 68)]
        cut(body, cylinder((0, 0, -1), (0, 0, 24), 36), *holes)

    ring = [(30, 2), (36, 2), (36, 20), (30, 20), (30, 15), (28.5, 14), (28.5, 8), (30, 7)]
    part(f"{folder}/ring.msh", s, lambda: revolved(ring), lambda *p: 4.0, {
        "seat": lambda x, y, z: around(36, x, y),
        "race": lambda x, y, z: around(28.5, x, y),
    })
    part(f"{folder}/housing.msh", s, housing, lambda x, y, z: 4.6 + 0.12 * abs((x * x + y * y) ** 0.5 - 36), {
        "bore": lambda x, y, z: around(36, x, y),
        "foot": lambda x, y, z: at(-60, y),
    })
