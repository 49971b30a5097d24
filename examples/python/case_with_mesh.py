"""A case described by a dict on a mesh from memory, solved in load steps: a block is pressed on a floor, then dragged.

What to see: the keys are those of the case file, groups come with the mesh, fields are arrays by node of that mesh. What to try
next: `mesh=meshio.read("part.msh")`, `folder="results"` for ParaView and the report, `result.to_pyvista().plot()`.
"""

import numpy as np

import stiction

cells, size = (12, 6, 4), (60.0, 30.0, 20.0)  # mm
axes = [np.linspace(0, length, count + 1) for length, count in zip(size, cells, strict=True)]
points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
number = np.arange(len(points)).reshape([count + 1 for count in cells])
corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]  # VTK's order
hexes = np.stack([number[i:, j:, k:][: cells[0], : cells[1], : cells[2]].ravel() for i, j, k in corners], axis=1)
groups = {
    "sole": hexes[np.isclose(points[hexes[:, 0], 2], 0)][:, :4],  # corners of faces
    "head": np.flatnonzero(points[:, 2] == size[2]),  # nodes
}

case = stiction.Case(
    {
        "units": "mm, N, MPa",
        "materials": {"steel": {"young": 210e3, "poisson": 0.3}},
        "fix": [{"on": "head", "value": ["4e-3*max(t - 1, 0)", 0, "-2e-3*min(t, 1)"]}],
        "contact": [
            {
                "name": "sole",
                "on": "sole",
                "against": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}},
                "friction": {"coulomb": 0.3},
            }
        ],
        "step": [{"name": "press", "until": 1, "increments": 1}, {"name": "drag", "until": 2, "increments": 4}],
    },
    mesh=(points, hexes, groups),
)
print(case.facts())
result = case.solve()
for step in result.steps:
    sole = step.contact["sole"]
    along, _, down = sole.forces.sum(axis=0)
    print(f"t {step.t:.2f}: {-down:9.1f} N down, {along:9.1f} N along, {(sole.state == 2).sum()} of {len(sole.nodes)} nodes slip")
print(result.certificate)

sole = result.contact["sole"]
assert np.allclose(points[sole.nodes], sole.points)  # the numbers are those of the mesh
slips = sole.state == 2
friction = np.hypot(sole.forces[:, 0], sole.forces[:, 1])
assert slips.all() and np.allclose(friction, -0.3 * sole.forces[:, 2])  # at last all of it slides
force = sole.forces.sum(axis=0)
assert np.allclose(result.reaction.sum(axis=0), force, atol=1e-6 * abs(force[2]))
