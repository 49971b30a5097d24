"""Eight square plates on one another, each turned and meshed otherwise than the one below it; contact alone holds seven."""

from shapes import at, box, part

H = {"50k": 1.14, "200k": 0.66, "700k": 0.43}


def build(folder, s):
    for i in range(8):
        part(f"{folder}/plate{i}.msh", s, lambda: box((-30, -30, 8 * i), (30, 30, 8 * i + 8)), lambda *p: 4.8 + 0.5 * (i % 3), {
            "bottom": lambda x, y, z: at(8 * i, z),
            "top": lambda x, y, z: at(8 * i + 8, z),
        })
