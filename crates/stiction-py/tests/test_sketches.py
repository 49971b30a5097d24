"""The four ways in: matrices, meshes, own assembly, discrete problems, each as a user writes it."""

import fem
import meshio
import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spl
import skfem
from skfem.models.elasticity import lame_parameters, linear_elasticity

import stiction
import stiction.discrete as sd


def test_matrices_from_files(tmp_path):
    points, K, B, gap, top = fem.column((4, 3, 3), (2.0, 1.0, 1.0), poisson=0.3)
    held = 1e5 * sp.diags_array(np.isin(np.arange(K.shape[0]), top).astype(float))  # stiff springs, so that K alone is posed
    f = held @ np.tile([3e-3, 0.0, -5e-3], len(points))
    for name, matrix in (("K", K + held), ("B", B)):
        sp.save_npz(tmp_path / f"{name}.npz", sp.csr_matrix(matrix))
    for name, array in (("f", f), ("gap", gap), ("X", points)):
        np.save(tmp_path / f"{name}.npy", array)

    K, B = sp.load_npz(tmp_path / "K.npz"), sp.load_npz(tmp_path / "B.npz")
    f, gap, X = (np.load(tmp_path / f"{name}.npy") for name in ("f", "gap", "X"))
    problem = stiction.Problem(K, B, f, gap, mu=0.3, rows="point", coordinates=X)
    sol = problem.solve(tolerance=1e-8, threads=4)
    assert sol.u.shape == f.shape and sol.forces.shape == (len(gap), 3) and sol.slip.shape == (len(gap), 2)
    assert set(np.unique(sol.state)) <= {0, 1, 2} and "natural_residual" in str(sol.certificate)
    totals = []
    for mu in np.linspace(0, 0.6, 7):
        sol = problem.with_friction(mu).solve(start=sol)
        totals.append(sol.forces.sum(axis=0))
        assert (np.hypot(*sol.forces[:, 1:].T) <= mu * sol.forces[:, 0] + 1e-7 * sol.forces.max()).all()
    assert totals[0][1] == pytest.approx(0, abs=1e-6) and np.all(np.diff([total[1] for total in totals]) > -1e-6)
    judged = problem.with_friction(0.6).check(sol.u, sol.forces)
    assert judged.passed and judged.worst <= 1e-8
    assert not problem.with_friction(0.1).check(sol.u, sol.forces).passed


def test_a_mesh_of_meshio_in_load_steps(tmp_path):
    points, cells = fem.block((3, 3, 3), (1, 1, 1))[0], []
    number = np.arange(len(points)).reshape(4, 4, 4)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = np.stack([number[i : i + 3, j : j + 3, k : k + 3].ravel() for i, j, k in corners], axis=1)
    low, high = cells[points[cells[:, 0], 2] == 0][:, :4], cells[points[cells[:, 4], 2] == 1][:, 4:]
    sets = {"foot": [[], np.arange(len(low)), []], "head": [[], [], np.arange(len(high))]}
    mesh = meshio.Mesh(points, [("hexahedron", cells), ("quad", low), ("quad", high)], cell_sets=sets)
    case = stiction.Case(
        {
            "units": "mm, N, MPa",
            "materials": {"soft": {"young": 2000, "poisson": 0.0}},
            "fix": [{"on": "head", "value": [0, 0, "-5e-3*t"]}],
            "contact": [{"name": "foot", "on": "foot", "friction": {"coulomb": 0.2},
                         "against": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}}],
            "step": [{"name": "press", "until": 1, "increments": 5}],
        },
        mesh=mesh,
    )  # fmt: skip
    assert "foot" in str(case.facts())
    result = case.solve(progress=lambda p: p.seconds < 600, folder=tmp_path / "out")
    assert [step.contact["foot"].pressure.mean() for step in result.steps] == pytest.approx([2, 4, 6, 8, 10])
    foot = result.steps[-1].contact["foot"]
    assert foot.shear.shape == foot.slip.shape == (len(foot.nodes), 3)
    assert result.displacement.shape == points.shape and result.stress.shape == (len(cells), 6) and result.summary["steps"]
    assert (tmp_path / "out" / "report.html").exists() and len(result.to_meshio().points) == len(points)


def test_own_assembly_by_scikit_fem(tmp_path):
    line = np.linspace(0, 1, 5)
    m = skfem.MeshHex.init_tensor(line, line, line).with_boundaries({"foot": lambda x: x[2] == 0, "top": lambda x: x[2] == 1})
    V = skfem.Basis(m, skfem.ElementVector(skfem.ElementHex1()))
    K = linear_elasticity(*lame_parameters(210e3, 0.3)).assemble(V)
    held = V.get_dofs("top").flatten()
    u0 = np.zeros(V.N)
    u0[V.nodal_dofs[2]] = -1e-3
    foot = np.unique(m.facets[:, m.boundaries["foot"]])
    rows = stiction.rows(foot, [0, 0, -1], V.N, dofs=V.nodal_dofs.T)
    problem = stiction.Problem(
        K, rows.B, np.zeros(V.N), 0.0, mu=0.3, held=held, values=u0[held], coordinates=m.p.T, dofs=V.nodal_dofs.T
    )
    sol = problem.solve()
    m.save(tmp_path / "foot.vtu", {"u": sol.u[V.nodal_dofs].T})
    assert np.allclose(meshio.read(tmp_path / "foot.vtu").point_data["u"], sol.u[V.nodal_dofs].T)
    K_t, free = sol.tangent()
    squares = spl.eigsh(K_t, 3, M=(free.T @ free).tocsc(), sigma=0, return_eigenvectors=False)
    assert (squares > 0).all() and free.shape[0] == V.N
    # From the inside: no motion of the tied rows, held unknowns at rest.
    assert abs(problem.constraints(sol) @ free).max() < 1e-12 and abs(free[held]).max() == 0


def test_discrete_steps_with_memory():
    """A block on a table under a push that grows: it sticks, then slides with the rest of the push."""
    r, velocities = None, []
    for push in np.linspace(0.1, 1.0, 10):
        sol = sd.solve(W=np.eye(3), q=[-1.0, push, 0.0], mu=0.5, start=r)
        r = sol.r
        velocities.append(sol.u[0, 1])
    expected = np.maximum(np.linspace(0.1, 1.0, 10) - 0.5, 0)
    assert np.allclose(velocities, expected, atol=1e-7)
    assert sol.r.shape == sol.u.shape == (1, 3) and sol.certificate.passed
    bodies = sd.solve(M=np.eye(3), H=np.eye(3), f=[-1.0, 1.0, 0.0], w=np.zeros(3), mu=0.5)
    assert np.allclose(bodies.r, sol.r, atol=1e-7) and np.allclose(bodies.v, bodies.u.ravel())
