"""A grid of bars above a floor, from scipy matrices alone: pressed down in the middle and dragged.

What to see: all of the normal force is the load's and the floor's; friction is the coefficient times it where points slip,
and the certificate says how far the answer is from the problem. What to try next: more nodes; `coordinates=` for multigrid.
"""

import numpy as np
import scipy.sparse as sp

import stiction

N, STIFFNESS, GROUND, MU = 20, 1e3, 1.0, 0.3  # nodes along an edge; N/mm of a bar, and of a spring to where a node was

line = sp.diags_array([-np.ones(N - 1), np.full(N, 2.0), -np.ones(N - 1)], offsets=[-1, 0, 1])
grid = sp.kron(line, sp.eye_array(N)) + sp.kron(sp.eye_array(N), line)  # each bar couples two nodes, edges are held
K = sp.kron(STIFFNESS * grid + GROUND * sp.eye_array(N * N), sp.eye_array(3))  # the same along x, y, z
point = [[0, 0, -1], [1, 0, 0], [0, 1, 0]]  # the jump at a node above a floor: -u_z, u_x, u_y
B = sp.kron(sp.eye_array(N * N), point)

places = np.linspace(-1, 1, N)
bump = np.exp(-4 * (places[:, None] ** 2 + places**2)).ravel()
f = np.outer(bump, [5.0, 0.0, -10.0]).ravel()  # N

problem = stiction.Problem(K, B, f, gap=0.02, mu=MU)
solution = problem.solve()
print(solution)
print(solution.certificate)
for mu in (0.0, 0.1, 0.6):  # the factor is kept
    other = problem.with_friction(mu).solve(start=solution)
    print(f"mu {mu}: normal force {other.forces[:, 0].sum():.3f} N, friction {other.forces[:, 1].sum():.3f} N")

slips = solution.state == 2
assert slips.any() and np.allclose(np.hypot(*solution.forces[slips, 1:].T), MU * solution.forces[slips, 0])
equilibrium = f - K @ solution.u - B.T @ solution.forces.ravel()
assert np.linalg.norm(equilibrium) < 1e-8 * np.linalg.norm(f)
