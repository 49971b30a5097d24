"""The certificate judges answers of CalculiX and GetFEM: the brick of Haslinger, Kučera and Dostál on a floor, by penalty contact.

What to see: assembled by scikit-fem the brick is the one of the shipped case. Displacements of the sole by the other programs, with
the rest in equilibrium, are refused for what contact demands, penetration among it; a stiffer penalty comes nearer to ours, which
passes. What to try next: the answer of another program, `problem.check(u, forces)`.
"""

import shutil
import subprocess
import tempfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import scipy.sparse.linalg as spl
import skfem
from skfem.models.elasticity import lame_parameters, linear_elasticity

import stiction

YOUNG, POISSON, MU = 21.19e10, 0.277, 0.35  # Pa

case = stiction.Case(
    {
        "mesh": {"block": {"size": [3, 1, 1], "cells": [12, 4, 4], "element": "tet4", "split": "six"}},
        "materials": {"steel": {"young": YOUNG, "poisson": POISSON}},
        "fix": [{"on": "x-min"}],
        "load": [{"on": "x-max", "traction": [0, 0, 1e6]}, {"on": "z-max", "traction": [0, 0, "-2/3*1e6*(3 - x)"]}],
        "contact": [{"on": "z-min", "against": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}, "friction": {"coulomb": MU}}],
    }
)
result = case.solve()
[(_, tets)] = result.cells
mesh = skfem.MeshTet(np.ascontiguousarray(result.points.T), np.ascontiguousarray(tets.T))
basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTetP1()))
x, dofs = mesh.p.T, basis.nodal_dofs.T
K = linear_elasticity(*lame_parameters(YOUNG, POISSON)).assemble(basis)
K = 0.5 * (K + K.T)
lift = skfem.LinearForm(lambda v, w: 1e6 * v[2]).assemble(basis.boundary(lambda x: x[0] == 3))
press = skfem.LinearForm(lambda v, w: -2e6 / 3 * (3 - w.x[0]) * v[2]).assemble(basis.boundary(lambda x: x[2] == 1))
f, held = lift + press, dofs[x[:, 0] == 0].ravel()
sole = np.flatnonzero((x[:, 2] == 0) & (x[:, 0] > 0))
B = stiction.rows(sole, [0, 0, -1], basis.N, dofs=dofs).B
problem = stiction.Problem(K, B, f, 0.0, MU, held=held, coordinates=x, dofs=dofs)
ours = problem.solve()
assert np.allclose(ours.u[dofs], result.displacement, atol=1e-8 * np.abs(ours.u).max())
print("ours:", problem.check(ours.u, ours.forces), sep="\n")
assert problem.check(ours.u, ours.forces).passed


def deck(penalty):
    """Linear tetrahedra on a plate at rest, loads at nodes, contact by a linear penalty: pressure over penetration."""
    n, m = len(x), len(tets)
    plate = [(-1, -1, -1), (4, -1, -1), (4, 2, -1), (-1, 2, -1), (-1, -1, 0), (4, -1, 0), (4, 2, 0), (-1, 2, 0)]

    def numbered(rows, first=1):
        return [f"{first + i}, " + ", ".join(f"{value:.15g}" for value in row) for i, row in enumerate(rows)]

    low = [(i + 1, k + 1) for i, t in enumerate(tets) for k, face in enumerate([(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)])
           if (x[t[list(face)], 2] == 0).all()]  # fmt: skip
    lines = ["*NODE, NSET=brick", *numbered(x), "*NODE, NSET=ground", *numbered(plate, n + 1)]
    lines += ["*ELEMENT, TYPE=C3D4, ELSET=brick", *numbered(tets + 1)]
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=plate", *numbered([range(n + 1, n + 9)], m + 1)]
    lines += ["*SURFACE, NAME=sole, TYPE=ELEMENT", *[f"{cell}, S{face}" for cell, face in low]]
    lines += ["*SURFACE, NAME=floor, TYPE=ELEMENT", f"{m + 1}, S2", "*MATERIAL, NAME=steel", "*ELASTIC", f"{YOUNG}, {POISSON}"]
    lines += [f"*SOLID SECTION, ELSET={name}, MATERIAL=steel" for name in ("brick", "plate")]
    lines += ["*SURFACE INTERACTION, NAME=dry", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{penalty}"]
    lines += ["*FRICTION", f"{MU}, {penalty / 100}", "*CONTACT PAIR, INTERACTION=dry, TYPE=SURFACE TO SURFACE", "sole, floor"]
    lines += ["*BOUNDARY", "ground, 1, 3", *[f"{i + 1}, 1, 3" for i in np.flatnonzero(x[:, 0] == 0)]]
    lines += ["*STEP, INC=1000", "*STATIC", "0.2, 1", "*CLOAD"]
    lines += [f"{i + 1}, {c + 1}, {f[dofs[i, c]]:.15g}" for i in range(n) for c in range(3) if f[dofs[i, c]]]
    return "\n".join([*lines, "*NODE PRINT, NSET=brick", "U", "*END STEP", ""])


def by_calculix(penalty):
    """Its displacements, (nodes, 3), seven digits."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "brick.inp").write_text(deck(penalty))
        subprocess.run(["ccx", "brick"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        printed = (Path(folder) / "brick.dat").read_text().split("displacements")[-1].splitlines()[2:]
    return np.array([line.split()[1:4] for line in printed if line.strip()], dtype=float)


def by_getfem(penalty):
    """The same by the penalized contact of GetFEM."""
    import getfem

    mesh = getfem.Mesh("empty", 3)
    for t in tets:
        mesh.add_convex(getfem.GeoTrans("GT_PK(3,1)"), x[t].T)
    faces = mesh.outer_faces()
    centres = np.array([mesh.pts(mesh.pid_in_faces(face[:, None])).mean(axis=1) for face in faces.T])
    for region, (axis, at) in enumerate([(0, 0), (0, 3), (2, 1), (2, 0)], 1):
        mesh.set_region(region, faces[:, np.isclose(centres[:, axis], at)])
    space, scalar = getfem.MeshFem(mesh, 3), getfem.MeshFem(mesh, 1)
    for each in (space, scalar):
        each.set_fem(getfem.Fem("FEM_PK(3,1)"))
    rule = getfem.MeshIm(mesh, getfem.Integ("IM_TETRAHEDRON(5)"))
    model = getfem.Model("real")
    model.add_fem_variable("u", space)
    for name, value in zip(("lame", "shear", "r", "mu"), (*lame_parameters(YOUNG, POISSON), penalty, MU), strict=True):
        model.add_initialized_data(name, value)
    model.add_isotropic_linearized_elasticity_brick(rule, "u", "lame", "shear")
    model.add_Dirichlet_condition_with_simplification("u", 1)
    model.add_linear_term(rule, "-[0, 0, 1e6].Test_u", 2)
    model.add_linear_term(rule, "[0, 0, 2e6/3*(3 - X(1))].Test_u", 3)
    model.add_initialized_fem_data("height", scalar, scalar.basic_dof_nodes()[2])
    model.add_penalized_contact_with_rigid_obstacle_brick(rule, "u", "height", "r", "mu", 4, 1)
    model.solve("max_res", 1e-12, "max_iter", 100)
    nodes = {tuple(node): i for i, node in enumerate(space.basic_dof_nodes()[:, ::3].T.round(9))}
    order = [nodes[tuple(point)] for point in x.round(9)]
    return model.variable("u").reshape(-1, 3)[order]


def judge(name, by, factors):
    inner = np.setdiff1d(np.arange(basis.N), np.concatenate([held, dofs[sole].ravel()]))
    worst = []
    for factor in factors:
        u = np.zeros(basis.N)
        u[dofs[sole]] = by(factor * YOUNG)[sole]
        # Digits that were not printed are not held against it: inside the brick equilibrium is made exact.
        u[inner] = spl.spsolve(K[inner][:, inner].tocsc(), f[inner] - K[inner] @ u)
        forces = (B @ (f - K @ u)).reshape(-1, 3)  # what holds the sole where it is
        judged = problem.check(u, forces)
        away = np.abs(u - ours.u).max() / np.abs(ours.u).max()
        print(f"{name} with a penalty of {factor} E per metre, {100 * away:.2f} % from ours:", judged, sep="\n")
        assert not judged.passed and judged.measures["equilibrium"] < 1e-10 < judged.measures["penetration"]
        worst.append((judged.measures["penetration"], away))
    assert worst[1] < worst[0] and worst[1][1] < 0.2 * worst[0][1] and worst[1][1] < 2e-3  # its limit is our answer


if shutil.which("ccx"):
    judge("CalculiX", by_calculix, (20, 200))
else:
    print("CalculiX (ccx) is not there: its answers are not made")
if find_spec("getfem"):
    judge("GetFEM", by_getfem, (20, 200))
else:
    print("GetFEM is not there: its answers are not made")
