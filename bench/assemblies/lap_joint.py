"""Three plates that overlap, held together by four bolts; the one in the middle is pulled."""

from shapes import at, bolt, bolt_groups, box, cut, cylinder, part

H = {"50k": 1.55, "200k": 0.82, "700k": 0.53}
PLACES = [(x, y) for x in (20, 60) for y in (-15, 15)]


def build(folder, s):
    def near(x, y, z):
        return min(((x - a) ** 2 + (y - b) ** 2) ** 0.5 for a, b in PLACES)

    plates = [("upper", 5, 13, -50, 80, 5.2), ("middle", -5, 5, 0, 140, 5.5), ("lower", -13, -5, -50, 80, 4.8)]
    for name, low, high, left, right, h in plates:

        def plate():
            cut(box((left, -30, low), (right, 30, high)), *(cylinder((x, y, low - 1), (0, 0, high - low + 2), 5.5) for x, y in PLACES))

        part(f"{folder}/{name}.msh", s, plate, lambda *p: (0.6 * h + min(0.4 * h, 0.1 * max(near(*p) - 8, 0))), {
            "top": lambda x, y, z: at(high, z),
            "bottom": lambda x, y, z: at(low, z),
            "end": lambda x, y, z: at(140 if name == "middle" else -50, x),
        })
    part(f"{folder}/bolt.msh", s, lambda: bolt(13, 5, 8.5, 7), lambda *p: 3.4, bolt_groups(13))
