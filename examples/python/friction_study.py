"""Forces and slip for many coefficients of friction on one factor: a column of hexahedra pressed on a floor and dragged.

What to see: the stiffness is factorised once, each further coefficient takes some Newton steps from the solution before it. Points
slide one after the other as the coefficient falls. What to try next: `with_load` for load cases.
"""

import time

import numpy as np
import scipy.sparse.linalg as spl
import skfem
from skfem.models.elasticity import lame_parameters, linear_elasticity

import stiction

mesh = skfem.MeshHex.init_tensor(*(np.linspace(0, length, count + 1) for length, count in ((2, 16), (1, 8), (1, 8))))
basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHex1()))
K = linear_elasticity(*lame_parameters(2000.0, 0.3)).assemble(basis)
dofs = basis.nodal_dofs.T
foot, top = (np.flatnonzero(mesh.p[2] == z) for z in (0.0, 1.0))
B = stiction.rows(foot, [0, 0, -1], basis.N, dofs=dofs).B
held, values = dofs[top].ravel(), np.tile([6e-3, 0.0, -5e-3], len(top))

n = basis.N
problem = stiction.Problem(K, B, np.zeros(n), gap=0.0, mu=0.0, held=held, values=values, coordinates=mesh.p.T, dofs=dofs)
solution = problem.solve()
print(f"the first took {solution.seconds:.2f} s")
begin = time.perf_counter()
curve = []
for mu in np.linspace(0.05, 0.6, 23):
    solution = problem.with_friction(mu).solve(start=solution)
    normal, first, second = solution.forces.T
    curve.append((mu, normal.sum(), first.sum(), np.hypot(first, second).sum(), (solution.state == 1).mean()))
print(f"the {len(curve)} others {(time.perf_counter() - begin) / len(curve):.3f} s each")
for mu, normal, along, _, stick in curve[::4]:
    print(f"mu {mu:.3f}: {normal:7.3f} N down, {along:6.3f} N along, {100 * stick:3.0f} % of the points stick")

mu, normal, along, friction, stick = np.array(curve).T
slides, sticks = stick == 0, stick == 1
assert slides.any() and sticks.any() and (~slides & ~sticks).any()
assert np.allclose(friction[slides], mu[slides] * normal[slides])  # each point at its bound
u = np.zeros(n)  # where all sticks the sole is as good as held: by SciPy alone
u[held] = values
free = np.setdiff1d(np.arange(n), np.concatenate([held, dofs[foot].ravel()]))
u[free] = spl.spsolve(K[free][:, free].tocsc(), -K[free] @ u)
assert np.allclose(along[sticks], -(K @ u)[dofs[foot, 0]].sum(), rtol=1e-6)
