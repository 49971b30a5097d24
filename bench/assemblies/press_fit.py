"""A hub with four holes is pressed onto a hollow shaft by an interference, then turned."""

from shapes import around, at, cut, cylinder, part, revolved

H = {"50k": 1.0, "200k": 0.6, "700k": 0.38}


def build(folder, s):
    def near(x, y, z):
        distance = abs((x * x + y * y) ** 0.5 - 20) + max(0, abs(z) - 15)
        return distance

    def hub():
        ring = revolved([(20, -15), (45, -15), (45, -6), (38, -6), (38, 6), (45, 6), (45, 15), (20, 15)])
        cut(ring, *(cylinder((x, y, -20), (0, 0, 40), 4) for x, y in [(31, 0), (-31, 0), (0, 31), (0, -31)]))

    part(f"{folder}/hub.msh", hub, lambda *p: s * (3.4 + 0.15 * near(*p)), {
        "bore": lambda x, y, z: around(20, x, y),
        "rim": lambda x, y, z: around(45, x, y),
        "end": lambda x, y, z: at(15, z),
    })
    part(f"{folder}/shaft.msh", lambda: revolved([(8, -45), (20, -45), (20, 25), (8, 25)]), lambda *p: s * (3.8 + 0.15 * near(*p)), {
        "seat": lambda x, y, z: around(20, x, y),
        "foot": lambda x, y, z: at(-45, z),
    })
