"""A pile of spheres falls into a box: a time stepper of Moreau and Jean over `stiction.discrete`, warm-started.

Each step solves ``M v' = H r + M v + dt f`` with ``0 <= u_n + gap / dt``, impulses ``r`` within Coulomb's cone; then ``x' = x + dt v'``.
What to see: about a thousand contacts a step; the energy falls in every step, and the floor comes to carry the weight but for
the friction of the walls. What to try next: another coefficient, spheres of two sizes, `method="newton"` for smaller tolerances.
"""

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from stiction import discrete

COUNT, RADIUS, DENSITY, MU, GRAVITY, DT, STEPS = 7, 0.01, 2500.0, 0.4, 9.81, 2e-3, 40  # spheres along an edge; m, kg, s
TOLERANCE = 1e-4

rng = np.random.default_rng(1)
lattice = np.stack(np.meshgrid(*3 * [np.arange(COUNT)], indexing="ij"), axis=-1).reshape(-1, 3) + 0.5
x = 2.02 * RADIUS * lattice + rng.uniform(-0.01, 0.01, lattice.shape) * RADIUS
x[:, :2] += rng.uniform(0, 0.9, (COUNT, 2))[lattice[:, 2].astype(int)] * RADIUS  # layers do not stand upon one another
box = 2.02 * RADIUS * COUNT + 0.9 * RADIUS
n = len(x)
mass, inertia = DENSITY * 4 / 3 * np.pi * RADIUS**3, DENSITY * 8 / 15 * np.pi * RADIUS**5
M = sp.diags_array(np.tile(3 * [mass] + 3 * [inertia], n)).tocsr()
weight = np.tile([0, 0, -mass * GRAVITY, 0, 0, 0], n)
walls = [(np.eye(3)[c] * sign, 0.0 if sign > 0 else -box) for c, sign in ((0, 1), (0, -1), (1, 1), (1, -1), (2, 1))]


def contacts(x):
    """First and second body (-1 for a wall), unit normal from the second to the first, gap, and a name for each contact."""
    pairs = cKDTree(x).query_pairs(2.2 * RADIUS, output_type="ndarray")
    between = x[pairs[:, 0]] - x[pairs[:, 1]]
    distance = np.linalg.norm(between, axis=1)
    parts = [(pairs, between / distance[:, None], distance - 2 * RADIUS, pairs @ [n, 1])]
    for number, (normal, offset) in enumerate(walls):
        gap = x @ normal - offset - RADIUS
        near = np.flatnonzero(gap < 0.2 * RADIUS)
        bodies = np.stack([near, np.full(len(near), -1)], axis=1)
        parts.append((bodies, np.broadcast_to(normal, (len(near), 3)), gap[near], n * n + number * n + near))
    return [np.concatenate(part) for part in zip(*parts, strict=True)]


def directions(bodies, normals):
    """H, ``(6 n, 3 m)``: what an impulse along the axes of each contact does to both bodies."""
    helper = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, helper)
    first /= np.linalg.norm(first, axis=1)[:, None]
    axes = np.stack([normals, first, np.cross(normals, first)], axis=1)  # (m, 3, 3)
    blocks = []
    for side, sign in ((0, 1.0), (1, -1.0)):
        here = np.flatnonzero(bodies[:, side] >= 0)
        turn = np.cross(-sign * RADIUS * normals[here, None], sign * axes[here])  # arm from the centre to the contact
        values = np.concatenate([sign * axes[here], turn], axis=2)  # (k, 3, 6)
        row = 6 * bodies[here, side][:, None, None] + np.arange(6)
        column = 3 * here[:, None, None] + np.arange(3)[:, None]
        full = np.broadcast_to(row, values.shape).ravel(), np.broadcast_to(column, values.shape).ravel()
        blocks.append(sp.coo_array((values.ravel(), full), shape=(6 * n, 3 * len(bodies))))
    return (blocks[0] + blocks[1]).tocsr()


def energy(x, v):
    return 0.5 * v @ (M @ v) + mass * GRAVITY * x[:, 2].sum()


v, names, r, steps = np.zeros(6 * n), np.zeros(0, dtype=int), np.zeros((0, 3)), []
begun, energies, most = energy(x, v), [energy(x, v)], 0
for step in range(STEPS):
    bodies, normals, gap, new = contacts(x)
    start = discrete.matched(r, names, new)
    w = np.zeros(3 * len(new))
    w[0::3] = np.maximum(gap, 0.0) / DT
    H, momentum = directions(bodies, normals), v.reshape(n, 6)[:, :3].sum(axis=0) * mass
    solution = discrete.solve(M=M, H=H, f=M @ v + DT * weight, w=w, mu=MU, start=start, tolerance=TOLERANCE, method="gauss-seidel")
    v, r, names = solution.v, solution.r, new
    outside = np.where(new >= n * n, 1.0, 0.0)  # walls and floor; spheres push one another with equal forces
    gained = v.reshape(n, 6)[:, :3].sum(axis=0) * mass - momentum - DT * weight.reshape(n, 6)[:, :3].sum(axis=0)
    assert np.allclose((H @ (r * outside[:, None]).ravel()).reshape(n, 6)[:, :3].sum(axis=0), gained, atol=1e-9)
    x = x + DT * v.reshape(n, 6)[:, :3]
    energies.append(energy(x, v))
    most = max(most, len(new))
    steps.append(solution.counts["sweeps"])
    if step % 10 == 9:
        print(f"t {DT * (step + 1):.2f} s: {len(new)} contacts, {(r[:, 0] > 0).sum()} closed, energy {energies[-1]:.5f} J, {solution.seconds:.2f} s")

print(f"at most {most} contacts, {np.mean(steps):.0f} sweeps on average")
assert most >= 1000
# With u_n >= -gap / dt the impulses do no work, and the implicit step loses the rest: no step gains energy.
assert (np.diff(energies) < TOLERANCE * begun).all() and energies[-1] < energies[0]
assert -contacts(x)[2].min() < 0.02 * RADIUS  # contacts are linear within a step, spheres are not
floor = r[new >= n * n + 4 * n, 0].sum() / DT
print(f"the floor carries {floor:.2f} N, the spheres weigh {n * mass * GRAVITY:.2f} N")
