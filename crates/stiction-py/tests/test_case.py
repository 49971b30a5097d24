"""Cases: closed forms, meshes from memory, load steps, folders, errors."""

import json
import pathlib

import fem
import meshio
import numpy as np
import pytest

import stiction

SIZE, CELLS = [2.0, 1.0, 1.0], [4, 2, 3]
FLOOR = {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}
CASES = pathlib.Path(__file__).parents[3] / "cases"


def described(**changes):
    """A block pressed on a floor and dragged; its Poisson ratio is zero."""
    return {
        "title": "block",
        "mesh": {"block": {"size": SIZE, "cells": CELLS, "element": "hex8"}},
        "materials": {"soft": {"young": 2000.0, "poisson": 0.0}},
        "fix": [{"on": "z-max", "value": [0, 0, -5e-3]}],
        "contact": [{"name": "sole", "on": "z-min", "against": FLOOR, "friction": {"coulomb": 0.3}}],
        **changes,
    }


def arrays():
    """The same block as points, hexahedra and groups, without this package."""
    points, _ = fem.block(CELLS, SIZE)
    numbers = np.arange(len(points)).reshape([count + 1 for count in CELLS])
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    at = [numbers[i : i + CELLS[0], j : j + CELLS[1], k : k + CELLS[2]].ravel() for i, j, k in corners]
    cells = np.stack(at, axis=1)
    bottom = cells[np.isclose(points[cells[:, 0], 2], 0)][:, :4]
    top = cells[np.isclose(points[cells[:, 4], 2], SIZE[2])][:, 4:]
    return points, cells, bottom, top


def test_a_block_presses_as_hooke_says():
    case = stiction.Case(described())
    facts = case.facts()
    assert (facts.nodes, facts.cells, facts.points) == (60, 24, 15)
    assert facts.contacts["sole"]["area"] == pytest.approx(2.0) and "sole" in str(facts)
    result = case.solve()
    sole = result.contact["sole"]
    assert np.allclose(sole.pressure, 10.0) and sole.forces.sum(axis=0) == pytest.approx([0, 0, -20], abs=1e-8)
    # A stress of E times the strain, all of it along z.
    assert np.allclose(result.stress, [0, 0, -10, 0, 0, 0], atol=1e-5)
    assert np.allclose(result.displacement[:, 2], -5e-3 * result.points[:, 2], atol=1e-12)
    assert result.reaction.sum(axis=0) == pytest.approx([0, 0, -20], abs=1e-8)
    assert result.summary["title"] == "block" and repr(result).startswith("<Result solved: 60 nodes")


def test_matrices_and_case_are_one_problem():
    points, K, B, gap, top = fem.column(CELLS, SIZE, poisson=0.0)
    values = np.tile([4e-3, 0.0, -5e-3], len(top) // 3)
    by_matrices = stiction.Problem(K, B, np.zeros(K.shape[0]), gap, 0.3, held=top, values=values).solve()
    result = stiction.Case(described(fix=[{"on": "z-max", "value": [4e-3, 0, -5e-3]}])).solve()
    order = np.lexsort(points.T), np.lexsort(result.points.T)
    assert np.allclose(by_matrices.u.reshape(-1, 3)[order[0]], result.displacement[order[1]], atol=1e-9)


def meshes():
    points, cells, bottom, top = arrays()
    groups = {"foot": bottom, "head": top}
    blocks = [("hexahedron", cells), ("quad", bottom), ("quad", top)]
    count = len(cells)
    by_sets = meshio.Mesh(points, blocks, cell_sets={"foot": [[], np.arange(len(bottom)), []], "head": [[], [], np.arange(len(top))]})
    tags = [np.ones(count, int), np.full(len(bottom), 2), np.full(len(top), 3)]
    physical = meshio.Mesh(
        points,
        blocks,
        cell_data={"gmsh:physical": tags},
        field_data={"all": np.array([1, 3]), "foot": np.array([2, 2]), "head": np.array([3, 2])},
    )
    head_nodes = np.unique(top)
    skewed = [points, {"hex8": cells}, {"foot": bottom, "head": head_nodes}]
    explicit = (points, [("hex8", cells[:10]), ("hex8", cells[10:])], {"foot": {"faces": bottom}, "head": {"nodes": head_nodes}})
    return {
        "arrays": (points, cells, groups),
        "nodes": tuple(skewed),
        "explicit": explicit,
        "sets": by_sets,
        "physical": physical,
    }


@pytest.mark.parametrize("name", ["arrays", "nodes", "explicit", "sets", "physical"])
def test_meshes_from_memory_give_the_answer_of_the_block(name):
    keys = dict(
        fix=[{"on": "head", "value": [4e-3, 0, -5e-3]}],
        contact=[{"name": "sole", "on": "foot", "against": FLOOR, "friction": {"coulomb": 0.3}}],
    )
    given = {key: value for key, value in described(**keys).items() if key != "mesh"}
    result = stiction.Case(given, mesh=meshes()[name]).solve()
    expected = stiction.Case(described(fix=[{"on": "z-max", "value": [4e-3, 0, -5e-3]}])).solve()
    order = np.lexsort(result.points.T), np.lexsort(expected.points.T)
    assert np.allclose(result.displacement[order[0]], expected.displacement[order[1]], atol=1e-10)
    # The numbers are those of the caller.
    assert np.array_equal(result.points, arrays()[0])
    assert result.contact["sole"].forces.sum(axis=0) == pytest.approx(expected.contact["sole"].forces.sum(axis=0))


def with_arrays():
    """Temperatures of the nodes, coefficients of the faces below and of the cells."""
    points, cells, bottom, _ = arrays()
    T, of_cells, of_faces = points[:, 2] * 10.0, np.full(len(cells), 0.5), np.full(len(bottom), 0.2)
    blocks = [("quad", bottom), ("hexahedron", cells)]
    sets = {"foot": [np.arange(len(bottom)), []]}
    yield (points, cells, {"foot": bottom}, {"T": T, "mu": np.full(len(cells), 0.2)})
    yield meshio.Mesh(points, blocks, point_data={"T": T}, cell_data={"mu": [of_faces, of_cells]}, cell_sets=sets)
    try:
        import pyvista
    except ImportError:
        return
    grid = pyvista.UnstructuredGrid({12: cells, 9: bottom}, points)
    is_face = grid.celltypes == 9
    grid.point_data["T"], grid.cell_data["mu"] = T, np.where(is_face, 0.2, 0.5)
    grid.cell_data["foot"] = is_face.astype(np.uint8)
    yield grid


def test_arrays_of_meshes_from_memory_are_those_that_a_case_names():
    # Along the normals nothing is prescribed above: the block is pressed by its heat and by what it is moved.
    def keys(temperature, mu, foot):
        above = [{"on": {"box": [[0, 0, SIZE[2]], SIZE]}, "value": [4e-3, 0, -5e-3]}]
        contact = [{"name": "sole", "on": foot, "against": FLOOR, "friction": {"coulomb": mu}}]
        materials = {"soft": {"young": 2000.0, "poisson": 0.3, "expansion": 1e-4}}
        return described(fix=above, contact=contact, load=[{"temperature": temperature}], materials=materials)

    expected = stiction.Case(keys("10*z", 0.2, "z-min")).solve()
    order = np.lexsort(expected.points.T)
    assert expected.contact["sole"].state.tolist().count(2) > 0
    for mesh in with_arrays():
        given = {key: value for key, value in keys({"array": "T"}, {"array": "mu"}, "foot").items() if key != "mesh"}
        result = stiction.Case(given, mesh=mesh).solve()
        found = result.displacement[np.lexsort(result.points.T)]
        assert np.allclose(found, expected.displacement[order], atol=1e-10), type(mesh)
    points, cells, bottom, _ = arrays()
    blocks = [("hexahedron", cells), ("quad", bottom)]
    for mesh, text in [
        ((points, cells, {"foot": bottom}, {"T": np.ones(7)}), r"array 'T': its shape is \(7,\)"),
        ((points, cells, {"foot": bottom}), 'the mesh has no array "T"'),
        (meshio.Mesh(points, blocks, point_data={"T": points}, cell_sets={"foot": [[], np.arange(len(bottom))]}), "it has 3 components"),
    ]:
        with pytest.raises(stiction.InputError, match=text):
            stiction.Case(given, mesh=mesh).solve()


def test_pyvista_in_and_out():
    pyvista = pytest.importorskip("pyvista")
    points, cells, bottom, top = arrays()
    grid = pyvista.UnstructuredGrid({12: cells, 9: np.concatenate([bottom, top])}, points)
    is_bottom = np.zeros(grid.n_cells, dtype=np.int8)
    quads = np.flatnonzero(grid.celltypes == 9)
    is_bottom[quads[: len(bottom)]] = 1
    grid.cell_data["foot"] = is_bottom
    grid.point_data["head"] = np.isclose(points[:, 2], SIZE[2]).astype(np.int8)
    keys = dict(
        fix=[{"on": "head", "value": [0, 0, -5e-3]}],
        contact=[{"name": "sole", "on": "foot", "against": FLOOR, "friction": "none"}],
    )
    result = stiction.Case({**described(**keys), "mesh": None}, mesh=grid).solve()
    assert np.allclose(result.contact["sole"].pressure, 10.0)
    out = result.to_pyvista()
    assert out.n_cells == len(cells) and np.allclose(out.point_data["displacement"], result.displacement)
    assert np.allclose(out.cell_data["von_mises"], 10.0, atol=1e-4)


def test_meshio_out(tmp_path):
    result = stiction.Case(described()).solve()
    result.to_meshio().write(tmp_path / "result.vtu")
    again = meshio.read(tmp_path / "result.vtu")
    assert np.allclose(again.point_data["displacement"], result.displacement)
    assert np.allclose(again.cell_data["von_mises"][0], 10.0, atol=1e-4)


def stepped(**changes):
    return described(
        fix=[{"on": "z-max", "value": ["4e-3*t", 0, -5e-3]}],
        step=[{"name": "drag", "until": 1, "increments": 4}],
        **changes,
    )


def test_load_steps_are_kept_and_heard():
    heard = []
    result = stiction.Case(stepped()).solve(progress=heard.append)
    assert [step.t for step in result.steps] == [0.25, 0.5, 0.75, 1.0] == [step["t"] for step in result.summary["steps"]]
    drags = [step.contact["sole"].forces[:, 0].sum() for step in result.steps]
    # Friction grows with the drag up to the coefficient times the force.
    assert all(a < b + 1e-9 for a, b in zip(drags, drags[1:], strict=False)) and drags[-1] <= 0.3 * 20 * (1 + 1e-6)
    assert np.allclose(result.steps[-1].displacement, result.displacement)
    assert {p.step for p in heard if p.phase == "newton"} == {1, 2, 3, 4}
    assert [p.t for p in heard if p.phase == "step finished"] == [0.25, 0.5, 0.75, 1.0]
    with pytest.raises(ZeroDivisionError):
        stiction.Case(stepped()).solve(progress=lambda p: 1 / 0)
    with pytest.raises(stiction.NotCertified):
        stiction.Case(stepped()).solve(progress=lambda p: p.step < 3)


def test_folders_hold_what_the_command_writes(tmp_path):
    result = stiction.Case(stepped()).solve(folder=tmp_path / "out", report=False)
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {name.split()[0] for name in result.files} <= written and {"summary.json", "result.pvd", "problem.npz"} <= written
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["certificate"] == result.summary["certificate"] and summary["steps"] == result.summary["steps"]
    again = stiction.Case(stepped()).solve(folder=tmp_path / "out", resume=True, report=False)
    assert again.steps == [] and np.allclose(again.displacement, result.displacement)
    single = stiction.Case(described()).solve(folder=tmp_path / "single")
    assert "report.html" in single.files and (tmp_path / "single" / "report.html").exists()


def test_text_files_and_overrides(tmp_path):
    text = """
title = "block"
mesh = { block = { size = [2, 1, 1], cells = [4, 2, 3], element = "hex8" } }
materials = { soft = { young = 2000, poisson = 0 } }
fix = [{ on = "z-max", value = [0, 0, -5e-3] }]
contact = [{ name = "sole", on = "z-min", against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }, friction = "none" }]
"""
    (tmp_path / "block.toml").write_text(text)
    expected = stiction.Case(described()).solve()
    for case in (text, tmp_path / "block.toml", str(tmp_path / "block.toml")):
        assert np.allclose(stiction.Case(case).solve().displacement, expected.displacement)
    halved = stiction.Case(text, overrides={"materials.soft.young": 1000.0})
    assert np.allclose(halved.solve().contact["sole"].pressure, 5.0)


def test_a_shipped_case_and_its_answer_by_the_command():
    result = stiction.Case(CASES / "block" / "block.toml").solve()
    assert result.solved and result.summary["versions"]["summary"] == 2


def test_two_bodies_have_two_sides():
    case = described(
        mesh={
            "parts": {
                "base": {"block": {"size": [2, 2, 1], "cells": [4, 4, 2], "element": "hex8"}},
                "stamp": {"block": {"size": [1, 1, 1], "cells": [3, 3, 2], "element": "hex8"}, "move": [0.5, 0.5, 1]},
            }
        },
        fix=[{"on": "base.z-min"}, {"on": "stamp.z-max", "value": [0, 0, -5e-3]}],
        contact=[{"name": "joint", "on": "stamp.z-min", "against": "base.z-max", "friction": {"coulomb": 0.3}}],
    )
    joint = stiction.Case(case).solve().contact["joint"]
    assert joint.master is not None
    assert joint.forces.sum(axis=0) == pytest.approx(joint.master.forces.sum(axis=0), rel=1e-6, abs=1e-6)


def test_bodies_that_fly_away_are_not_certified():
    case = described(fix=[], load=[{"on": "z-max", "force": [0, 0, 10]}])
    with pytest.raises(stiction.NotCertified, match="no equilibrium") as caught:
        stiction.Case(case).solve()
    assert caught.value.result.status == "no_equilibrium"


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"contacts": []}, "contacts"),
        ({"materials": {"soft": {"yung": 1.0, "poisson": 0}}}, "young"),
        ({"fix": [{"on": "nowhere"}]}, "nowhere"),
        ({"title": object()}, "object"),
        ({"title": 'quotes " and \\ and é\n'}, None),
        ({"materials": {"name with spaces": {"young": np.float64(2e3), "poisson": np.int64(0)}}}, None),
        ({"fix": [{"on": "z-max", "value": np.array([0, 0, -5e-3])}]}, None),
    ],
)
def test_dicts_are_read_as_case_files_are(changes, text):
    if text is None:
        assert stiction.Case(described(**changes)).solve().solved
        return
    with pytest.raises(stiction.InputError, match=text) as caught:
        stiction.Case(described(**changes)).solve()
    if text != "object":
        assert caught.value.place.startswith("case:") and "^" in caught.value.excerpt


@pytest.mark.parametrize(
    ("mesh", "text"),
    [
        (3, "int is no mesh"),
        ((np.zeros((4, 2)), np.zeros((1, 4), int)), r"\(4, 2\)"),
        ((np.zeros((4, 3)), np.zeros((1, 5), int)), "no kind of cell"),
        ((np.zeros((4, 3)), {"pyramid": np.zeros((1, 5), int)}), "pyramid"),
        ((np.eye(4, 3), {"tet4": [[0, 1, 2, 9]]}), "no number 9 among 4"),
        ((np.eye(4, 3), {"tet4": [[0, 1, 2, 3]]}, {"a": [0.5]}), "float64"),
        ((np.eye(4, 3), {"tet4": [[0, 1, 2, 3]]}, {"a": {"edges": [0]}}), "edges"),
        ((np.eye(4, 3), {"tet4": [[0, 1, 2, 3]]}, {"a": {"cells": [7]}}), "no number 7 among 1"),
        ((np.eye(4, 3), {"tet4": [[3, 2, 1, 0]]}), "mesh"),
        ((np.full((4, 3), np.nan), {"tet4": [[0, 1, 2, 3]]}), "mesh"),
        (meshio.Mesh(np.eye(5, 3), [("pyramid", [[0, 1, 2, 3, 4]])]), "pyramid"),
        ("absent.msh", "absent.msh"),
    ],
)
def test_meshes_that_cannot_be_used_are_named(mesh, text):
    given = {key: value for key, value in described().items() if key != "mesh"}
    with pytest.raises(stiction.InputError, match=text):
        stiction.Case(given, mesh=mesh).solve()


def test_interrupted_cases(tmp_path):
    from test_processes import run

    ended = run(
        """
        import os, signal, sys, threading, time
        import stiction
        sys.path.insert(0, sys.argv[1])
        from test_case import described
        size = {"size": [1, 1, 1], "cells": [30, 30, 30], "element": "hex8"}
        sent = []
        def send():
            sent.append(time.perf_counter())
            os.kill(os.getpid(), signal.SIGINT)
        for delay in (0.01, 0.1, 0.3):
            case = stiction.Case(described(mesh={"block": size}))
            threading.Timer(delay, send).start()
            try:
                while True:
                    case.facts()
                    case.solve(folder=sys.argv[2])
            except KeyboardInterrupt:
                print(time.perf_counter() - sent[-1])
        """,
        str(pathlib.Path(__file__).parent),
        str(tmp_path / "out"),
    )
    delays = [float(line) for line in ended.stdout.split()]
    assert len(delays) == 3 and max(delays) < 3.0, ended.stderr


def bent(**changes):
    """A block held at one end, bent down on a floor."""
    return {
        "mesh": {"block": {"size": [3, 1, 1], "cells": [6, 2, 2]}},
        "materials": {"steel": {"young": 21.19e10, "poisson": 0.277}},
        "fix": [{"on": "x-min"}],
        "load": [
            {"on": "x-max", "traction": [0, 0, 1e6]},
            {"on": "z-max", "traction": [0, 0, "-2/3*1e6*(3 - x)"]},
        ],
        "contact": [{"name": "sole", "on": "z-min", "against": FLOOR, "friction": "none"}],
        **changes,
    }


def test_an_accuracy_is_reached_on_finer_meshes():
    heard = []
    result = stiction.Case(bent(accuracy={"energy": 0.05})).solve(progress=heard.append)
    reached = result.accuracy
    assert reached["reached"] and result.error == reached["levels"][-1]["error"] <= 0.05
    meshes = [(event.iteration, event.residual) for event in heard if event.phase == "mesh"]
    assert meshes == [(level["level"] + 1, level["error"]) for level in reached["levels"]] and len(meshes) >= 3
    assert [kind for kind, _ in result.cells] == ["tet10"] and len(result.cells[0][1]) == reached["levels"][-1]["cells"]
    assert len(result.cell_error) == len(result.stress) and np.all(result.cell_error >= 0)
    # The limit for meshes without end, known from other programs, with its own uncertainty: energy -72.6928.
    energy = next(value for value in reached["values"] if value["name"] == "energy")
    assert abs(energy["value"] + 72.6928) <= energy["bar"] + 5e-4
    assert result.to_meshio().cell_data["error"][0].shape == result.cell_error.shape


def test_no_mesh_is_refined_for_constant_stress():
    result = stiction.Case(described(accuracy={"energy": 0.01, "forces": 0.01})).solve()
    assert result.accuracy["reached"] and len(result.accuracy["levels"]) == 1 and result.error < 1e-8


def test_a_refining_case_goes_on_where_it_ended(tmp_path):
    goals = {"energy": 0.05, "max_unknowns": 2500}
    short = stiction.Case(bent(accuracy=goals)).solve(folder=tmp_path / "out", report=False)
    assert not short.accuracy["reached"] and "max_unknowns" in short.accuracy["ended"]
    heard = []
    case = stiction.Case(bent(accuracy={"energy": 0.05}))
    on = case.solve(folder=tmp_path / "out", resume=True, report=False, progress=heard.append)
    assert on.accuracy["reached"] and on.accuracy["levels"][: len(short.accuracy["levels"])] == short.accuracy["levels"]
    assert [event.iteration for event in heard if event.phase == "mesh"][0] == len(short.accuracy["levels"]) + 1
    with pytest.raises(stiction.InputError, match="another case"):
        stiction.Case(bent(accuracy=goals, fix=[{"on": "x-max"}])).solve(folder=tmp_path / "out", resume=True)
