"""Makes several.msh, one layer of tetrahedra in a triangular prism:

    python3 cases/several/several.py

The edges of the triangle are A B on the obstacle, A C held and B C loaded; several.toml says why they stand so."""

import os

N = 10  # edges along each side of the triangle
DEPTH = 0.05
NU = 0.3

ratio = (1 - NU) / NU  # (lambda + 2 mu) / lambda
slope = 2 * NU / (1 - 2 * NU) * ratio**0.5  # of m: sqrt(lambda (lambda + 2 mu)) / mu
stiff = 2 * (1 - NU) / (1 - 2 * NU)  # (lambda + 2 mu) / mu
k = 1 / (slope**2 + stiff)
A, B, C = (0, 0), (1, 0), (1 - stiff * k, slope * k)

nodes, number = [], {}
for z in range(2):
    for j in range(N + 1):
        for i in range(N + 1 - j):
            a, b = i / N, j / N
            number[i, j, z] = len(nodes) + 1
            nodes.append((A[0] + a * (B[0] - A[0]) + b * (C[0] - A[0]), b * C[1], DEPTH * z))

cells, faces = [], {"contact": [], "held": [], "loaded": [], "sides": []}


def prism(low):
    """Three tetrahedra; each side is cut from its node with the least number, so that neighbours fit."""
    low = sorted(low, key=lambda ij: number[(*ij, 0)])
    (a, b, c), (x, y, z) = [[number[(*ij, level)] for ij in low] for level in range(2)]
    for tet in [(a, b, c, z), (a, b, y, z), (a, x, y, z)]:
        p = [nodes[v - 1] for v in tet]
        u, v, w = [[p[q][c] - p[0][c] for c in range(3)] for q in (1, 2, 3)]
        volume = sum(u[c] * (v[c - 2] * w[c - 1] - v[c - 1] * w[c - 2]) for c in range(3))
        cells.append(tet if volume > 0 else (tet[1], tet[0], tet[2], tet[3]))
    faces["sides"] += [(a, b, c), (x, y, z)]


def side(name, p, q):
    """Two triangles, cut as the prism beside them."""
    p, q = sorted([p, q], key=lambda ij: number[(*ij, 0)])
    (a, b), (x, y) = [[number[(*ij, level)] for ij in (p, q)] for level in range(2)]
    faces[name] += [(a, b, y), (a, x, y)]


for j in range(N):
    for i in range(N - j):
        prism([(i, j), (i + 1, j), (i, j + 1)])
        if i + j < N - 1:
            prism([(i + 1, j), (i + 1, j + 1), (i, j + 1)])
    side("contact", (j, 0), (j + 1, 0))
    side("held", (0, j), (0, j + 1))
    side("loaded", (N - j, j), (N - j - 1, j + 1))

lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(faces) + 1)]
lines += [f'2 {tag} "{name}"' for tag, name in enumerate(faces, 1)] + ['3 9 "body"', "$EndPhysicalNames"]
lines += ["$Nodes", str(len(nodes))] + [f"{i} {x:.17g} {y:.17g} {z:.17g}" for i, (x, y, z) in enumerate(nodes, 1)]
lines += ["$EndNodes", "$Elements"]
elements = [(2, tag, face) for tag, name in enumerate(faces, 1) for face in faces[name]]
elements += [(4, 9, cell) for cell in cells]
lines += [str(len(elements))]
lines += [f"{i} {kind} 2 {tag} {tag} " + " ".join(map(str, e)) for i, (kind, tag, e) in enumerate(elements, 1)]
lines += ["$EndElements", ""]
with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "several.msh"), "w") as file:
    file.write("\n".join(lines))
