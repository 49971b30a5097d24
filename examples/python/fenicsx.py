"""Assembled by FEniCSx, in contact by Stiction: a block pressed on a rough floor and dragged.

What to see: the stiffness is PETSc's, handed over by its arrays; unknown ``3 block + direction`` of dolfinx is the order that
Stiction takes by itself. What to try next: a mesh of tetrahedra, a finer one (multigrid takes over).
"""

import numpy as np
import scipy.sparse as sp

import stiction

try:
    import ufl
    from dolfinx import fem, mesh
    from dolfinx.fem import petsc
    from mpi4py import MPI
except ImportError as error:
    print(f"not run: FEniCSx is not there ({error})")
    raise SystemExit(0) from None

YOUNG, MU, DOWN, DRAG = 2000.0, 0.3, 5e-3, 2e-2  # MPa, -, mm, mm

domain = mesh.create_box(MPI.COMM_SELF, [[0, 0, 0], [2, 1, 1]], [8, 4, 4], mesh.CellType.hexahedron)
if hasattr(fem, "functionspace"):
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
else:  # before dolfinx 0.7
    V = fem.VectorFunctionSpace(domain, ("Lagrange", 1))
u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
a = YOUNG * ufl.inner(ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v))) * ufl.dx  # Poisson's ratio is zero
A = petsc.assemble_matrix(fem.form(a))
A.assemble()
start, column, value = A.getValuesCSR()
K = sp.csr_array((value, column, start))
K = 0.5 * (K + K.T)  # symmetric to the last digit

points = V.tabulate_dof_coordinates()
foot, top = (fem.locate_dofs_geometrical(V, lambda x, z=z: np.isclose(x[2], z)) for z in (0.0, 1.0))
held = (3 * top[:, None] + np.arange(3)).ravel()
values = np.tile([DRAG, 0.0, -DOWN], len(top))
rows = stiction.rows(foot, [0, 0, -1], K.shape[0])  # the floor lies below
problem = stiction.Problem(K, rows.B, np.zeros(K.shape[0]), gap=0.0, mu=MU, held=held, values=values, coordinates=points)
solution = problem.solve()
print(solution)

normal, along = solution.forces[:, 0].sum(), solution.forces[:, 1].sum()
print(f"on the floor {normal:.4f} N down, {along:.4f} N along")
assert (solution.state == 2).any() and along <= MU * normal * (1 + 1e-9)
assert np.isclose(solution.reactions.reshape(-1, 3)[:, 0].sum(), along)  # what drags is what rubs
found = fem.Function(V)
found.x.array[:] = solution.u  # for a picture: dolfinx.io
assert np.allclose(found.x.array.reshape(-1, 3)[top], [DRAG, 0, -DOWN])
pressed = problem.with_friction(0.0).solve()
assert np.isclose(pressed.forces[:, 0].sum(), YOUNG * 2.0 * DOWN)  # E times strain times area
