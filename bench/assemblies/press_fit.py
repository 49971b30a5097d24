"""A hub with four holes is pressed onto a hollow shaft by an interference, then turned."""

from shapes import around, at, cut, cylinder, part, revolved

H = {"50k": 1.3, "200k": 0.735, "700k": 0.45}


def build(folder, s):
    def from_seat(x, y, z):
        return abs((x * x + y * y) ** 0.5 - 20) + max(0, abs(z) - 15)

    def in_hub(x, y, z):
        from_hole = max(((min(abs(x), abs(y))) ** 2 + (max(abs(x), abs(y)) - 31) ** 2) ** 0.5 - 4, 0)
        return min(3.4 + 0.15 * from_seat(x, y, z), 2 + 0.3 * from_hole)

    def hub():
        ring = revolved([(20, -15), (45, -15), (45, -6), (38, -6), (38, 6), (45, 6), (45, 15), (20, 15)])
        cut(ring, *(cylinder((x, y, -20), (0, 0, 40), 4) for x, y in [(31, 0), (-31, 0), (0, 31), (0, -31)]))

    part(f"{folder}/hub.msh", s, hub, in_hub, {
        "bore": lambda x, y, z: around(20, x, y),
        "rim": lambda x, y, z: around(45, x, y),
        "end": lambda x, y, z: at(15, z),
    })
    part(f"{folder}/shaft.msh", s, lambda: revolved([(8, -45), (20, -45), (20, 25), (8, 25)]), lambda *p: 3.8 + 0.15 * from_seat(*p), {
        "seat": lambda x, y, z: around(20, x, y),
        "foot": lambda x, y, z: at(-45, z),
    })
