"""Makes low.msh and high.msh, two cylinders of radius 100 mm that touch along x = z = 0, each as a slice 1 mm thick of a
block whose surface is the parabola of that radius; the cells do not match:

    python3 cases/cattaneo/cattaneo.py

needs nothing but Python."""

import os

RADIUS = 100.0
SIZE = 20.0  # half width, and height
INNER = 1.2  # half width of the fine part, 1.2 contact radii
GROWTH = 1.35  # from one cell to the next beyond it


def grown(start, first):
    """Places from `start` to SIZE, the steps growing from about `first`."""
    steps = [first]
    while sum(steps) < SIZE - start:
        steps.append(GROWTH * steps[-1])
    scale = (SIZE - start) / sum(steps)
    places = [start]
    for step in steps:
        places.append(places[-1] + scale * step)
    return places


def half(name, side, cells):
    """The body above (side 1) or below (side -1), with so many cells across the fine part."""
    fine = 2 * INNER / cells
    right = grown(INNER, GROWTH * fine)
    xs = [-x for x in reversed(right[1:])] + [-INNER + i * fine for i in range(cells)] + right
    depths = grown(0, fine)
    nodes = [
        (x, y, side * (d + x * x / (2 * RADIUS) * (1 - d / SIZE))) for d in depths for y in (0, 1) for x in xs
    ]
    nx, ny = len(xs), 2
    at = lambda i, j, k: 1 + i + nx * (j + ny * k)
    quads, hexes = [], []
    for i in range(nx - 1):
        for tag, k in [(1, 0), (2, len(depths) - 1)]:
            quads.append((tag, [at(i, 0, k), at(i + 1, 0, k), at(i + 1, 1, k), at(i, 1, k)]))
        for k in range(len(depths) - 1):
            ring = lambda k: [at(i, 0, k), at(i + 1, 0, k), at(i + 1, 1, k), at(i, 1, k)]
            hexes.append(ring(k) + ring(k + 1) if side > 0 else ring(k + 1) + ring(k))
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "3"]
    lines += ['2 1 "arc"', '2 2 "far"', '3 3 "body"', "$EndPhysicalNames", "$Nodes", str(len(nodes))]
    lines += ["%d %.12g %g %.12g" % (n, x, y, z) for n, (x, y, z) in enumerate(nodes, 1)]
    lines += ["$EndNodes", "$Elements", str(len(quads) + len(hexes))]
    cells = [(3, tag, corners) for tag, corners in quads] + [(5, 3, corners) for corners in hexes]
    lines += ["%d %d 2 %d %d %s" % (n, kind, tag, tag, " ".join(map(str, corners)))
              for n, (kind, tag, corners) in enumerate(cells, 1)]
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), name + ".msh"), "w") as file:
        file.write("\n".join(lines + ["$EndElements", ""]))


half("low", -1, 50)
half("high", 1, 64)
