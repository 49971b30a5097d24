"""Assembled by scikit-fem, in contact by Stiction: a block pressed on a rough floor and dragged.

What to see: K, the groups and the numbering are scikit-fem's; the rows of B are one node each. Without
Poisson's effect the force on the floor is Hooke's. What to try next: a finer mesh (multigrid takes over), other elements of `nodal_dofs`.
"""

import numpy as np
import skfem
from skfem.models.elasticity import lame_parameters, linear_elasticity

import stiction

YOUNG, MU, DOWN, DRAG = 2000.0, 0.3, 5e-3, 0.02  # MPa, -, mm, mm

mesh = skfem.MeshHex.init_tensor(*(np.linspace(0, length, count + 1) for length, count in ((2, 8), (1, 4), (1, 4))))
basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHex1()))
K = linear_elasticity(*lame_parameters(YOUNG, 0.0)).assemble(basis)

dofs = basis.nodal_dofs.T  # (nodes, 3): unknowns along x, y, z
foot, top = (np.flatnonzero(mesh.p[2] == z) for z in (0.0, 1.0))
held = dofs[top].ravel()
values = np.tile([DRAG, 0.0, -DOWN], len(top))
B = stiction.rows(foot, [0, 0, -1], basis.N, dofs=dofs).B  # the floor lies below

problem = stiction.Problem(K, B, np.zeros(basis.N), gap=0.0, mu=MU, held=held, values=values, coordinates=mesh.p.T, dofs=dofs)
solution = problem.solve()
print(solution)
print(solution.certificate)

normal, along = solution.forces[:, 0].sum(), solution.forces[:, 1].sum()
print(f"on the floor {normal:.4f} N down, {along:.4f} N along")
assert (solution.state == 2).any() and along <= MU * normal * (1 + 1e-9)
assert np.isclose(solution.reactions.reshape(-1, 3)[:, 0].sum(), along)  # what drags is what rubs
u = solution.u[dofs]  # (nodes, 3), for a picture: mesh.save("block.vtu", {"u": u})
assert np.allclose(u[top], [DRAG, 0, -DOWN])
pressed = problem.with_friction(0.0).solve()
assert np.isclose(pressed.forces[:, 0].sum(), YOUNG * 2.0 * DOWN)  # E times strain times area
