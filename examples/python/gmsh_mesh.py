"""A part meshed by Gmsh, read by meshio, solved as a case: a round column with a bore is pressed on a smooth floor.

What to see: physical groups of Gmsh are the groups of the case. On smooth ends the column carries a uniform stress, so that the
force is Hooke's, to what the facets of the mesh leave of the round section. What to try next: your own geometry in place of the column; `friction`.
"""

import tempfile
from pathlib import Path

import numpy as np

import stiction

try:
    import gmsh
    import meshio
except (ImportError, OSError) as error:  # its wheel needs libraries for graphics, which servers may not have
    print(f"not run: Gmsh or meshio is not there ({error})")
    raise SystemExit(0) from None

RADIUS, BORE, HEIGHT, YOUNG, DOWN = 10.0, 4.0, 30.0, 210e3, 0.02  # mm, MPa

gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 0)
gmsh.option.setNumber("Mesh.MeshSizeMax", 4.0)
outer = gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, HEIGHT, RADIUS)
bore = gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, HEIGHT, BORE)
gmsh.model.occ.cut([(3, outer)], [(3, bore)])
gmsh.model.occ.synchronize()
[(_, column)] = gmsh.model.getEntities(3)
at = {round(gmsh.model.occ.getCenterOfMass(2, face)[2], 6): face for _, face in gmsh.model.getEntities(2)}
for dimension, entity, name in ((3, column, "column"), (2, at[0.0], "foot"), (2, at[HEIGHT], "head")):
    gmsh.model.addPhysicalGroup(dimension, [entity], name=name)
gmsh.model.mesh.generate(3)
with tempfile.TemporaryDirectory() as folder:
    gmsh.write(str(Path(folder) / "column.msh"))
    mesh = meshio.read(Path(folder) / "column.msh")
gmsh.finalize()

floor = {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}
case = stiction.Case(
    {
        "units": "mm, N, MPa",
        "materials": {"steel": {"young": YOUNG, "poisson": 0.3}},
        "fix": [
            {"on": "head", "components": "z", "value": [-DOWN]},
            {"on": {"point": [RADIUS, 0, HEIGHT]}, "components": "y"},  # against turning and sliding as a whole
            {"on": {"point": [0, RADIUS, HEIGHT]}, "components": "x"},
            {"on": {"point": [-RADIUS, 0, HEIGHT]}, "components": "y"},
        ],
        "contact": [{"name": "foot", "on": "foot", "against": floor, "friction": "none"}],
    },
    mesh=mesh,
)
area = case.facts().contacts["foot"]["area"]
result = case.solve()
foot = result.contact["foot"]
force = -foot.forces[:, 2].sum()
print(result)
print(f"{force:.1f} N on an area of {area:.2f} mm², {np.pi * (RADIUS**2 - BORE**2):.2f} if it were round")
hooke = YOUNG * DOWN / HEIGHT * np.pi * (RADIUS**2 - BORE**2)
assert np.isclose(force, hooke, rtol=0.01) and np.isclose(foot.pressure.mean(), YOUNG * DOWN / HEIGHT, rtol=0.01)
