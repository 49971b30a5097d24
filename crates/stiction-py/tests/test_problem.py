"""Problems from matrices: closed forms, second roads, formats, errors."""

import pickle
import warnings

import clarabel
import fem
import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from scipy.optimize import nnls

import stiction

SPRINGS = 1e3 * np.eye(3)
FLOOR = [[0, 0, -1], [1, 0, 0], [0, 1, 0]]


def node(f, gap=0.0, **friction):
    return stiction.Problem(SPRINGS, FLOOR, f, gap, **friction)


@pytest.fixture(scope="module")
def dragged():
    """A soft box pressed on a floor and dragged: unknowns of its top are prescribed."""
    points, K, B, gap, top = fem.column((4, 3, 3), (2.0, 1.0, 1.0), poisson=0.3, lift=1e-3)
    values = np.tile([4e-3, 1e-3, -5e-3], len(top) // 3)
    arguments = dict(K=K, B=B, f=np.zeros(K.shape[0]), gap=gap, mu=0.3, held=top, values=values)
    return points, arguments, stiction.Problem(**arguments, coordinates=points).solve()


def test_a_node_pushed_below_the_limit_sticks_and_above_it_slips():
    stuck = node([2.9, 0, -10], mu=0.3).solve()
    assert stuck.state.tolist() == [1]
    assert np.allclose(stuck.forces, [[10, 2.9, 0]]) and np.allclose(stuck.u, 0, atol=1e-12)
    sliding = node([3.1, 0, -10], mu=0.3).solve()
    assert sliding.state.tolist() == [2]
    assert np.allclose(sliding.forces, [[10, 3, 0]]) and np.allclose(sliding.u, [1e-4, 0, 0], atol=1e-12)
    assert np.allclose(sliding.slip, [[1e-4, 0]], atol=1e-12)


def test_a_node_that_is_pulled_opens_and_one_over_a_gap_meets_it():
    with pytest.warns(UserWarning, match="touches"):
        pulled = node([1, 0, 2.0], mu=0.3).solve()
    assert pulled.state.tolist() == [0] and np.allclose(pulled.u, [1e-3, 0, 2e-3])
    assert np.allclose(pulled.gap, [2e-3]) and not pulled.forces.any()
    # Springs carry 1000 N/mm over the gap of 0.004 mm, the floor the rest.
    assert np.allclose(node([0, 0, -10], gap=4e-3).solve().forces, [[6, 0, 0]])


def test_given_limited_bonded_and_directed_friction():
    assert np.allclose(node([5, 0, -10], tresca=2).solve().forces, [[10, 2, 0]])
    assert np.allclose(node([5, 0, -10], mu=0.3, cohesion=1).solve().forces, [[10, 4, 0]])
    assert np.allclose(node([0, 0, 2], cohesion=1, tension=3).solve().forces, [[-2, 0, 0]])
    assert np.allclose(node([0, 0, 5], cohesion=1, tension=3).solve().forces, [[-3, 0, 0]])
    assert np.allclose(node([5, 0, -10], mu=0.3, limit=1).solve().forces, [[10, 1, 0]])
    assert np.allclose(node([5, 1, 10], bonded=np.array([True])).solve().forces, [[-10, 5, 1]])
    # Along the second tangent half of the friction.
    assert np.allclose(node([0, 5, -10], mu=0.3, across=0.5).solve().forces, [[10, 0, 1.5]])
    frictionless = node([5, 0, -10]).solve()
    assert np.allclose(frictionless.forces, [[10, 0, 0]]) and np.allclose(frictionless.u, [5e-3, 0, 0])


def test_friction_remembers_the_last_step():
    first = node([4, 0, -10], mu=0.3).solve()
    assert np.allclose(first.jump, [[1e-3, 0]])
    # Without the push the spring pulls back with 1 N, which friction takes: nothing moves.
    back = node([4, 0, -10], mu=0.3).with_load([0, 0, -10], slip_reference=first).solve()
    assert np.allclose(back.u, first.u) and np.allclose(back.forces, [[10, -1, 0]])
    # Forgotten, it would have sprung back.
    assert np.allclose(node([0, 0, -10], mu=0.3).solve().u, 0, atol=1e-12)


def test_a_column_presses_as_hooke_says():
    points, K, B, gap, top = fem.column((3, 3, 4), lift=1e-3)
    values = np.tile([0.0, 0.0, -5e-3], len(top) // 3)
    solution = stiction.Problem(K, B, np.zeros(K.shape[0]), gap, 0.3, held=top, values=values).solve()
    assert solution.forces[:, 0].sum() == pytest.approx(2000 * 4e-3, rel=1e-9)
    assert solution.reactions.reshape(-1, 3).sum(axis=0) == pytest.approx([0, 0, -2000 * 4e-3], rel=1e-9, abs=1e-9)
    assert np.allclose(solution.u[top], values)


def test_frictionless_contact_is_the_least_squares_problem_with_signs(dragged):
    _, arguments, _ = dragged
    solution = stiction.Problem(**{**arguments, "mu": 0.0}).solve()
    K, B, held, values = (arguments[name] for name in ("K", "B", "held", "values"))
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    stiffness = K[free][:, free].toarray()
    normal = B[0::3]
    load = -K[free][:, held] @ values
    gap = arguments["gap"] - normal[:, held] @ values
    # min 1/2 l' Q l + l' (gap - N K^-1 f) over l >= 0, with Q = L L'
    compliance = normal[:, free] @ np.linalg.solve(stiffness, normal[:, free].T.toarray())
    factor = np.linalg.cholesky(compliance)
    offset = gap - normal[:, free] @ np.linalg.solve(stiffness, load)
    multipliers, _ = nnls(factor.T, -np.linalg.solve(factor, offset))
    assert np.allclose(solution.forces[:, 0], multipliers, atol=1e-8 * multipliers.max())
    assert (multipliers > 0).any()


def test_the_answer_minimises_the_energy_with_its_own_bounds_of_friction(dragged):
    """At the bounds mu lambda_n Coulomb's answer is that of given friction: a cone program for clarabel."""
    _, arguments, solution = dragged
    K, B, held, values = (arguments[name] for name in ("K", "B", "held", "values"))
    n, m = K.shape[0], len(arguments["gap"])
    bound = 0.3 * solution.forces[:, 0]
    # Unknowns u and s_j >= |T_j u|.
    unit = 1e-3  # displacements near one suit the solver
    energy = sp.block_diag([unit * K, sp.csc_array((m, m))], format="csc")
    cost = np.concatenate([arguments["f"] * -1.0, bound])
    fixed = sp.csr_array((np.ones(len(held)), (np.arange(len(held)), held)), shape=(len(held), n + m))
    normal = sp.hstack([B[0::3], sp.csr_array((m, m))], format="csr")
    cones = []
    for j in range(m):
        slope = sp.csr_array(([-1.0], ([0], [n + j])), shape=(1, n + m))
        cones += [slope, sp.hstack([-B[3 * j + 1 : 3 * j + 3], sp.csr_array((2, m))], format="csr")]
    rows = sp.vstack([fixed, normal, *cones], format="csc")
    right = np.concatenate([values / unit, arguments["gap"] / unit, np.zeros(3 * m)])
    kinds = [clarabel.ZeroConeT(len(held)), clarabel.NonnegativeConeT(m)] + m * [clarabel.SecondOrderConeT(3)]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-11
    found = clarabel.DefaultSolver(sp.triu(energy, format="csc"), cost, rows, right, kinds, settings).solve()
    assert np.allclose(unit * np.asarray(found.x)[:n], solution.u, atol=1e-6 * np.abs(solution.u).max())
    assert {0, 2} <= set(solution.state) or {1, 2} <= set(solution.state)


def test_all_formats_give_the_same_bits(dragged):
    _, arguments, _ = dragged
    K, B = arguments["K"], arguments["B"]
    expected = stiction.Problem(**arguments).solve(threads=1)

    def long_indices(matrix):
        copy = matrix.copy()
        copy.indices, copy.indptr = copy.indices.astype(np.int64), copy.indptr.astype(np.int64)
        return copy

    def shuffled(matrix):
        """Each entry in two halves and in descending order."""
        halves = matrix.tocoo()
        reverse = slice(None, None, -1)
        parts = (np.tile(0.5 * halves.data[reverse], 2), (np.tile(halves.row[reverse], 2), np.tile(halves.col[reverse], 2)))
        return sp.coo_matrix(parts, shape=matrix.shape)

    formats = {
        "csc": (K.tocsc(), B.tocsc()),
        "coo": (K.tocoo(), B.tocoo()),
        "matrix": (sp.csr_matrix(K), sp.csr_matrix(B)),
        "int64": (long_indices(K), long_indices(B)),
        "dense": (K.toarray(), B.toarray()),
        "duplicates": (shuffled(K), shuffled(B)),
        "tuple": ((K.data, K.indices, K.indptr), (B.data, B.indices, B.indptr)),
    }
    for name, (stiffness, jump) in formats.items():
        got = stiction.Problem(**{**arguments, "K": stiffness, "B": jump}).solve(threads=1)
        assert np.array_equal(got.u, expected.u) and np.array_equal(got.forces, expected.forces), name
    block = sp.vstack([B[0::3], B[1::3], B[2::3]], format="csr")
    got = stiction.Problem(**{**arguments, "B": block}, rows="block").solve(threads=1)
    assert np.array_equal(got.forces, expected.forces)


def test_inputs_are_not_changed(dragged):
    _, arguments, _ = dragged
    K = arguments["K"].copy()
    stiction.Problem(**{**arguments, "K": K}).solve()
    assert (K != arguments["K"]).nnz == 0


def test_prescribed_displacements_are_those_of_an_elimination_by_hand(dragged):
    _, arguments, _ = dragged
    K, B, held, values = (arguments[name] for name in ("K", "B", "held", "values"))
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    by_hand = stiction.Problem(
        K[free][:, free],
        B[:, free],
        -K[free][:, held] @ values,
        arguments["gap"] - B[0::3][:, held] @ values,
        0.3,
    ).solve()
    got = stiction.Problem(**arguments).solve()
    assert np.allclose(got.u[free], by_hand.u, atol=1e-9 * np.abs(by_hand.u).max())
    assert np.allclose(got.forces, by_hand.forces, atol=1e-7)
    reactions = K[held] @ got.u + B[:, held].T @ got.forces.ravel()
    assert np.allclose(got.reactions, reactions, atol=1e-9 * np.abs(reactions).max())


def test_held_in_any_order_and_as_a_mask(dragged):
    _, arguments, expected = dragged
    order = np.random.default_rng(1).permutation(len(arguments["held"]))
    shuffled = {**arguments, "held": arguments["held"][order], "values": arguments["values"][order]}
    got = stiction.Problem(**shuffled).solve()
    assert np.allclose(got.u, expected.u) and np.allclose(got.reactions, expected.reactions[order], atol=1e-9)
    mask = np.zeros(len(arguments["f"]), dtype=bool)
    mask[arguments["held"]] = True
    by_mask = stiction.Problem(**{**arguments, "held": mask, "values": 0.0}).solve()
    by_list = stiction.Problem(**{**arguments, "values": 0.0}).solve()
    assert np.array_equal(by_mask.u, by_list.u)


def test_unknowns_in_another_order(dragged):
    points, arguments, expected = dragged
    nodes = len(points)
    dofs = np.arange(3 * nodes).reshape(3, nodes).T  # all x, then all y, then all z
    order = dofs.ravel()
    inverse = np.argsort(order)
    stiffness, jump = arguments["K"][inverse][:, inverse], arguments["B"][:, inverse]
    # Unknown `order[i]` of the new numbering is unknown `i` of the old one.
    held = order[arguments["held"]]
    given = {**arguments, "K": stiffness, "B": jump, "held": held}
    got = stiction.Problem(**given, coordinates=points, dofs=dofs).solve()
    assert np.allclose(got.u[order], expected.u) and np.allclose(got.reactions, expected.reactions, atol=1e-9)
    assert got.certificate.measures.keys() == expected.certificate.measures.keys()
    other = stiction.Problem(**given, coordinates=points, dofs=dofs).with_load(np.zeros(3 * nodes))
    assert np.allclose(other.solve().u[order], expected.u)
    assert other.check(got.u, got.forces).passed


def test_the_balance_of_forces_is_judged_where_it_can_be(dragged):
    points, arguments, solution = dragged
    assert {"force_balance", "moment_balance"} <= solution.certificate.measures.keys()
    # Springs to the ground in K carry forces that are neither load nor reaction.
    grounded = {**arguments, "K": arguments["K"] + 10 * sp.eye_array(len(arguments["f"]))}
    solution = stiction.Problem(**grounded, coordinates=points).solve()
    assert solution.solved and "force_balance" not in solution.certificate.measures


def test_multigrid_and_factor_agree():
    points, K, B, gap, top = fem.column((14, 14, 14), poisson=0.3)
    values = np.tile([2e-3, 0.0, -5e-3], len(top) // 3)
    problem = stiction.Problem(K, B, np.zeros(K.shape[0]), gap, 0.4, held=top, values=values, coordinates=points)
    by_multigrid = problem.solve(method="multigrid", tolerance=1e-9)
    by_factor = problem.solve(method="dense", tolerance=1e-9)
    assert (by_multigrid.method, by_factor.method) == ("multigrid", "dense")
    assert np.allclose(by_multigrid.forces, by_factor.forces, atol=1e-6 * by_factor.forces.max())
    # From its own answer there is next to nothing to do.
    again = problem.solve(method="multigrid", tolerance=1e-9, start=by_multigrid)
    assert again.counts["cycles"] <= by_multigrid.counts["cycles"] // 2


def test_a_warm_start_takes_fewer_steps(dragged):
    _, arguments, solution = dragged
    problem = stiction.Problem(**arguments)
    cold = problem.solve(method="dense")
    for start in (cold, cold.forces):
        assert problem.solve(method="dense", start=start).counts["newton_steps"] < cold.counts["newton_steps"]


def test_other_friction_and_load_share_the_factor_and_nothing_else(dragged):
    _, arguments, _ = dragged
    problem = stiction.Problem(**arguments)
    before = problem.solve()
    for mu in (0.0, 0.2, 0.6):
        new = stiction.Problem(**{**arguments, "mu": mu}).solve()
        assert np.allclose(problem.with_friction(mu).solve().forces, new.forces, atol=1e-7)
    assert np.array_equal(problem.solve().forces, before.forces)
    load = np.zeros(len(arguments["f"]))
    load[arguments["held"]] = 1.0
    loaded = problem.with_load(load, gap=0.5e-3).solve()
    new = stiction.Problem(**{**arguments, "f": load, "gap": 0.5e-3}).solve()
    assert np.allclose(loaded.u, new.u) and np.allclose(loaded.reactions, new.reactions)


def test_the_certificate_refuses_a_penalty_answer_and_accepts_ours(dragged):
    points, arguments, solution = dragged
    problem = stiction.Problem(**arguments, coordinates=points)
    assert problem.check(solution.u, solution.forces).passed
    # Frictionless penalty contact at the nodes that are pressed: N u - gap = lambda / penalty.
    K, B, held, values = (arguments[name] for name in ("K", "B", "held", "values"))
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    active = B[0::3][solution.state > 0]
    gap = arguments["gap"][solution.state > 0]
    penalty = 1e5
    matrix = (K + penalty * active.T @ active).tocsc()
    load = penalty * active.T @ gap
    u = np.zeros(K.shape[0])
    u[held] = values
    u[free] = spl.spsolve(matrix[free][:, free], load[free] - matrix[free][:, held] @ values)
    forces = np.zeros((len(arguments["gap"]), 3))
    forces[solution.state > 0, 0] = penalty * (active @ u - gap)
    judged = problem.with_friction(0.0).check(u, forces)
    assert not judged.passed and judged.measures["equilibrium"] < 1e-8
    assert judged.measures["penetration"] > 1e-4 and "penetration" in str(judged)
    with pytest.raises(stiction.InputError, match="is prescribed"):
        problem.check(np.zeros(K.shape[0]), forces)


@pytest.mark.parametrize("mu", [0.0, 50.0])
@pytest.mark.parametrize("reordered", [False, True])
def test_small_loads_move_a_joint_as_its_constraints_say(dragged, mu, reordered):
    """Without friction, and where all stick, the answer follows the load linearly as long as no state changes."""
    points, arguments, _ = dragged
    K, B, held = arguments["K"], arguments["B"], arguments["held"]
    n = K.shape[0]
    order = np.arange(n).reshape(3, -1).T.ravel() if reordered else np.arange(n)
    inverse = np.argsort(order)
    given = dict(K=K[inverse][:, inverse], B=B[:, inverse], held=order[held], f=np.zeros(n), gap=arguments["gap"])
    given |= dict(values=np.tile([0.0, 0.0, -5e-3], len(held) // 3), mu=mu, coordinates=points, dofs=order.reshape(-1, 3))
    problem = stiction.Problem(**given)
    before = problem.solve(tolerance=1e-10)
    assert (before.state == (1 if mu else 2)).all()
    load = np.zeros(n)
    node = np.flatnonzero(np.isclose(points[:, 2], 1 / 3))[1]
    load[order[3 * node : 3 * node + 3]] = [0.1, 0.05, -0.1]
    after = problem.with_load(load).solve(tolerance=1e-10)
    C = problem.constraints(before)
    assert C.shape == ((3 if mu else 1) * problem.points, n)
    free = np.setdiff1d(np.arange(n), given["held"])
    saddle = sp.block_array([[given["K"][free][:, free], C[:, free].T], [C[:, free], None]], format="csc")
    motion = spl.spsolve(saddle, np.concatenate([load[free], np.zeros(C.shape[0])]))[: len(free)]
    assert np.allclose((after.u - before.u)[free], motion, atol=1e-6 * np.abs(motion).max())


def test_a_body_that_only_contact_holds_and_one_that_flies_away():
    points, K, B, gap, _ = fem.column((2, 2, 2))
    press = np.zeros(K.shape[0])
    press[2::3] = -1.0
    resting = stiction.Problem(K, B, press, gap, 0.5, coordinates=points).solve()
    assert resting.forces.sum(axis=0) == pytest.approx([len(points), 0, 0], abs=1e-7)
    with pytest.raises(stiction.NotCertified, match="no equilibrium: the loads carry away the body: translation along z; it lifts off: all of its") as caught:
        stiction.Problem(K, B, -press, gap, 0.5, coordinates=points).solve()
    assert caught.value.result.status == "no_equilibrium"
    assert "press it down" in str(caught.value) and "e+308" not in str(caught.value) + str(caught.value.result.certificate)
    flying = stiction.Problem(K, B, -press, gap, 0.5, coordinates=points).solve(check=False)
    assert flying.status == "no_equilibrium" and not flying.solved


def test_results_do_not_depend_on_threads(dragged):
    _, arguments, _ = dragged
    one, two = (stiction.Problem(**arguments).solve(threads=threads) for threads in (1, 2))
    assert np.array_equal(one.u, two.u) and np.array_equal(one.forces, two.forces)


def test_progress_is_heard_stops_and_comes_through(dragged):
    _, arguments, _ = dragged
    heard = []
    solution = stiction.Problem(**arguments).solve(progress=heard.append)
    assert {"ordering", "factorisation", "newton"} <= {p.phase for p in heard}
    assert [p.iteration for p in heard if p.phase == "newton"] == list(solution.history[:, 0])
    assert heard[-1].open + heard[-1].stick + heard[-1].slip == len(arguments["gap"])
    with pytest.raises(stiction.NotCertified, match="stopped"):
        stiction.Problem(**arguments).solve(progress=lambda p: False)
    with pytest.raises(ZeroDivisionError):
        stiction.Problem(**arguments).solve(progress=lambda p: 1 / 0)


def test_nothing_is_printed(dragged, capfd):
    stiction.Problem(**dragged[1]).solve()
    assert capfd.readouterr() == ("", "")


def test_results_and_errors_are_read_and_pickled(dragged):
    solution = dragged[2]
    assert repr(solution).startswith("<Solution solved after ") and "certificate passed" in repr(solution)
    assert "natural_residual" in str(solution.certificate)
    copy = pickle.loads(pickle.dumps(solution))
    assert np.array_equal(copy.u, solution.u) and copy.certificate == solution.certificate
    error = pickle.loads(pickle.dumps(stiction.InputError("K", "wrong", "mend it")))
    assert (error.place, error.what, error.remedy, str(error)) == ("K", "wrong", "mend it", "K: wrong; mend it")
    short = pickle.loads(pickle.dumps(stiction.NotCertified("why", solution)))
    assert short.result.status == "solved" and str(short) == "why"


BIG = sp.csr_array(np.eye(3))


@pytest.mark.parametrize(
    ("change", "place", "text"),
    [
        ({"K": np.eye(4)}, "B", "3 columns where 4"),
        ({"K": np.ones((3, 4))}, "K", "3 rows and 4 columns"),
        ({"K": np.array([[1, 2, 0], [0, 1, 0], [0, 0, 1.0]])}, "K", r"not symmetric at \(0, 1\): 2 and 0"),
        ({"K": sp.csr_array([[1, 0.5, 0], [0.4, 1, 0], [0, 0, 1.0]])}, "K", r"not symmetric at \(0, 1\): 0.5 and 0.4"),
        ({"K": np.diag([1.0, np.nan, 1.0])}, "K", r"\(1, 1\) is NaN"),
        ({"K": np.diag([1.0, 0.0, 1.0])}, "K", "diagonal entry of unknown 1 is 0; give a stiffness"),
        ({"K": -np.eye(3)}, "K", "diagonal entry of unknown 0 is -1; so are all others: give the stiffness with the other sign"),
        ({"K": -SPRINGS + [[0, 7e-9, 0], [0, 0, 0], [0, 0, 0]]}, "K", "unknown 0 is -1000; so are all others"),
        ({"K": SPRINGS + [[0, 7.31239e-6, 0], [0, 0, 0], [0, 0, 0]]}, "K", r"not symmetric at \(0, 1\): 7.3124e-6 and 0;"),
        ({"B": stiction.rows([0], [0, 0, -1], 3)}, "B", "it is all of a Rows; give its matrix: rows.B"),
        ({"gap": -1e-3, "held": [0, 1, 2]}, "gap", "^gap: contact point 0 is held and overlaps by 0.001; .* gap of at least 0"),
        ({"gap": 0.1, "held": [2], "values": -0.3}, "gap", "contact point 0 is held and overlaps by 0.2"),
        ({"K": 1j * np.eye(3)}, "K", "complex128"),
        ({"K": [1, 2, 3]}, "K", "1 dimensions"),
        ({"K": [[1, 2], [3]]}, "K", "no array"),
        ({"K": (1, 2)}, "K", "tuple of 2"),
        ({"K": (np.ones(3), np.array([0, 1, 5]), np.arange(4))}, "K", "do not ascend below 3"),
        ({"K": (np.ones(3), np.array([0, 1, -1]), np.arange(4))}, "K", "do not ascend below 3"),
        ({"K": (np.ones(3), np.arange(3), np.array([0, 2, 1, 3]))}, "K", "descends at row 1"),
        ({"K": (np.ones(3), np.arange(3), np.array([0, 1, 2, 9]))}, "K", "descends at row 2"),
        ({"K": (np.ones(3), np.arange(3.0), np.arange(4))}, "K", "indices are of type float64"),
        ({"B": np.ones((2, 3))}, "B", "2 rows, no multiple of three"),
        ({"f": [1, 2]}, "f", r"\(2,\) where \(3,\)"),
        ({"f": [1, np.inf, 0]}, "f", "^f: entry 1 is inf; give finite numbers"),
        ({"f": ["a", "b", "c"]}, "f", "type <U1"),
        ({"gap": [0, 0]}, "gap", r"\(2,\) where \(1,\)"),
        ({"gap": np.nan}, "gap", "^gap: entry 0 is NaN"),
        ({"mu": -0.1}, "mu", "-0.1 at point 0"),
        ({"mu": np.nan}, "mu", "nan at point 0"),
        ({"tresca": -1.0}, "mu", "^mu: the slip bound of point 0 is -1"),
        ({"tension": 1.0}, "tension", "belongs to cohesion"),
        ({"cohesion": 1.0, "limit": 1.0}, "cohesion", "does not go with `limit`"),
        ({"cohesion": -1.0}, "cohesion", "-1 at point 0"),
        ({"mu": 1.0, "cohesion": 1.0, "tension": 2.0}, "mu", "beyond the apex"),
        ({"across": 2.0}, "across", "^across: entry 0 is 2"),
        ({"bonded": [1]}, "bonded", "mask of 1"),
        ({"rows": "points"}, "rows", "'points'"),
        ({"held": [3]}, "held", "no unknown 3 among 3"),
        ({"held": [-1]}, "held", "no unknown -1"),
        ({"held": [0, 0]}, "held", "twice"),
        ({"held": [0.5]}, "held", "float64"),
        ({"held": [0], "values": [1, 2]}, "values", r"\(2,\)"),
        ({"values": 1.0}, "values", "belong to `held`"),
        ({"held": [0], "values": 0.2, "mu": 0.3}, "held", "row of point 0 are held, and it slides by 0.2"),
        ({"slip_reference": [[1.0]]}, "slip_reference", r"\(1, 2\)"),
        ({"coordinates": np.zeros((2, 3))}, "coordinates", "2 nodes have 6 unknowns, and K has 3"),
        ({"coordinates": np.full((1, 3), np.nan)}, "coordinates", "not all finite"),
        ({"coordinates": np.zeros((1, 3)), "dofs": [[0, 1, 1]]}, "dofs", "each unknown once"),
        ({"dofs": [[0, 1, 2]]}, "dofs", "coordinates"),
    ],
)
def test_what_cannot_be_posed_is_named(change, place, text):
    with pytest.raises(stiction.InputError, match=text) as caught:
        stiction.Problem(**{"K": BIG, "B": FLOOR, "f": [0, 0, -1], "gap": 0, **change})
    assert caught.value.place == place and caught.value.remedy


@pytest.mark.parametrize(
    ("name", "text"),
    [("friction", "did you mean `mu`"), ("fixed", "`held`"), ("limits", "`limit`"), ("xyzzy", "there are K, B, f, gap, mu")],
)
def test_an_unknown_argument_is_answered_by_the_one_that_was_meant(name, text):
    with pytest.raises(TypeError, match=f"no argument `{name}`.*{text}"):
        stiction.Problem(BIG, FLOOR, [0, 0, -1], 0, **{name: 1})


def test_a_point_carried_to_its_counterpart_by_what_is_prescribed_does_not_overlap():
    # 0.1 + 0.2 is more than 0.3 by rounding.
    carried = stiction.Problem(BIG, [[0, -1, -1], [1, 0, 0], [0, 1, 0]], [1, 0, 0], 0.3, held=[1, 2], values=[-0.1, -0.2])
    assert carried.solve().certificate.passed


def test_normals_the_wrong_way_round_are_warned_of():
    with pytest.warns(UserWarning, match="none of 1 contact points touches .* normals point from the body"):
        stiction.Problem(SPRINGS, stiction.rows([0], [0, 0, 1], 3).B, [0, 0, -1], 0).solve()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        stiction.Problem(SPRINGS, stiction.rows([0], [0, 0, -1], 3).B, [0, 0, -1], 0).solve()


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"method": "fast"}, "auto, dense, solves or multigrid"),
        ({"method": "multigrid"}, "coordinates"),
        ({"tolerance": 0}, "positive"),
        ({"tolerance": np.nan}, "positive"),
        ({"threads": 0}, "1 to 4096"),
        ({"max_iterations": 0}, "max_iterations: it is 0; give a whole number"),
        ({"max_iterations": 1.5}, "it is 1.5"),
        ({"max_iterations": np.nan}, "it is nan"),
        ({"memory_limit": -1}, "memory_limit: it is -1"),
        ({"start": [1.0]}, r"\(3,\)"),
        ({"start": [[1.0, 2.0]]}, r"\(1, 3\)"),
        ({"start": [[np.nan, 0, 0]]}, "finite"),
    ],
)
def test_settings_that_cannot_be_used_are_named(change, text):
    with pytest.raises(stiction.InputError, match=text):
        node([0, 0, -1]).solve(**change)


@pytest.mark.parametrize("tolerance", [np.nan, np.inf, 0.0, -1e-8])
def test_nothing_is_judged_by_a_tolerance_that_is_none(tolerance):
    with pytest.raises(stiction.InputError, match="tolerance: it is .*; give a positive number"):
        node([0, 0, -1]).check([0, 0, 0], [[1, 0, 0]], tolerance=tolerance)


def test_an_indefinite_stiffness_and_too_little_memory_are_errors():
    indefinite = np.array([[1, 2, 0], [2, 1, 0], [0, 0, 1.0]])
    with pytest.raises(stiction.InputError, match="not positive definite"):
        stiction.Problem(indefinite, FLOOR, [0, 0, -1], 0).solve()
    with pytest.raises(stiction.TooLarge, match="may be used") as caught:
        node([0, 0, -1]).solve(memory_limit=1)
    assert isinstance(caught.value, MemoryError) and "`memory_limit`" in caught.value.remedy
