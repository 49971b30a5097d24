"""Three teeth each of two spur gears with backlash, turned until the flanks press on one another."""

import numpy as np
from shapes import around, cut, cylinder, fuse, occ, part, prism, rounded

H = {"50k": 1.12, "200k": 0.64, "700k": 0.393}
MODULE, ANGLE, BACKLASH, WIDTH = 4.0, np.radians(20), 0.15, 8.0


class Gear:
    def __init__(self, teeth, bore, turn):
        self.teeth, self.bore, self.turn = teeth, bore, turn
        self.pitch = MODULE * teeth / 2
        self.base, self.root, self.tip = self.pitch * np.cos(ANGLE), self.pitch - 1.25 * MODULE, self.pitch + MODULE

    def half(self, radius):
        """Half the angle that a tooth takes at this radius: an involute from the base circle outwards."""
        a = np.arccos(np.clip(self.base / np.maximum(radius, self.base), 0, 1))
        at_pitch = (np.pi * MODULE / 2 - BACKLASH / 2) / (2 * self.pitch)
        return at_pitch + np.tan(ANGLE) - ANGLE - (np.tan(a) - a)

    def flank(self, side):
        """Whether points lie on the flanks of one side of the teeth."""

        def inside(x, y, z):
            radius, pitch = np.hypot(x, y), 2 * np.pi / self.teeth
            angle = np.arctan2(y, x) - self.turn
            angle -= pitch * np.round(angle / pitch)
            return (np.abs(angle - side * self.half(radius)) * radius < 0.01) & (radius > self.base - 1e-3)

        return inside

    def shape(self):
        pitch = 2 * np.pi / self.teeth
        places = []

        def polar(radius, angle):
            return (radius * np.cos(angle), radius * np.sin(angle))

        def tooth(middle):
            radii = np.linspace(self.base, self.tip, 12)
            ends = []
            for side in (-1, 1):
                foot = middle + side * self.half(self.base)
                places.append(polar(self.root, foot))
                low = occ.addPoint(*polar(self.root - 1.5, foot), 0)
                flank = [occ.addPoint(*polar(r, middle + side * self.half(r)), 0) for r in radii]
                ends.append((low, flank[-1], [occ.addLine(low, flank[0]), occ.addSpline(flank)]))
            (low0, high0, lines0), (low1, high1, lines1) = ends
            loop = occ.addCurveLoop([*lines0, occ.addLine(high0, high1), *(-l for l in reversed(lines1)), occ.addLine(low1, low0)])
            face = occ.addPlaneSurface([loop])
            return next(s for s in occ.extrude([(2, face)], 0, 0, WIDTH) if s[0] == 3)

        far = self.root / np.cos(1.8 * pitch) + 1
        wedge = prism([(0, 0), polar(far, self.turn - 1.8 * pitch), polar(far, self.turn + 1.8 * pitch)], 0, WIDTH)
        rim = occ.intersect([cylinder((0, 0, 0), (0, 0, WIDTH), self.root)], [wedge])[0][0]
        body = cut(rim, cylinder((0, 0, -1), (0, 0, WIDTH + 2), self.bore))
        body = fuse(body, *(tooth(self.turn + k * pitch) for k in (-1, 0, 1)))
        rounded(body, 1.0, *places)


def build(folder, s):
    small = Gear(18, 18, 0)
    # A gap of the large gear is opposite; it is turned until one flank touches.
    large = Gear(27, 34, np.pi + np.pi / 27 + BACKLASH / 2 / 54)
    for name, gear, centre in [("small", small, 90), ("large", large, -90)]:

        def size(x, y, z):
            other = large if name == "small" else small
            to_teeth = max(gear.root - (x * x + y * y) ** 0.5, ((x - centre) ** 2 + y * y) ** 0.5 - other.tip - 1, 0)
            return 1.05 + 0.3 * to_teeth

        # Seen from its own centre either gear is touched on the same side.
        part(f"{folder}/{name}.msh", s, gear.shape, size, {
            "flanks": gear.flank(1),
            "bore": lambda x, y, z: around(gear.bore, x, y),
        })
