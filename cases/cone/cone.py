"""Makes cone.stl, a shallow cone of 96 triangles with its tip at the origin, in metres:

    python3 cases/cone/cone.py

Corners of the rim lie on the cone z = -0.02 r, 1.5 mm from its axis; the solid is below."""

import math
import os
import struct

SLOPE, RIM, SIDES = 0.02, 1.5e-3, 96

rim = [(RIM * math.cos(a), RIM * math.sin(a), -SLOPE * RIM) for a in (2 * math.pi * k / SIDES for k in range(SIDES))]
with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "cone.stl"), "wb") as file:
    file.write(b"shallow cone, slope 0.02, metres".ljust(80) + struct.pack("<I", SIDES))
    for k in range(SIDES):
        # The normal is left to the order of the corners.
        file.write(struct.pack("<12fH", 0, 0, 0, 0, 0, 0, *rim[k], *rim[(k + 1) % SIDES], 0))
