"""Writes the Gmsh files beside this script: python3 make_meshes.py (needs: pip install gmsh meshio).

Two stacked cylinders of radius 0.5, a bar of hexahedra, and their volumes and areas as meshio sees them, in
reference.txt: "file group measure".
"""

import pathlib

import gmsh
import meshio
import numpy as np

HERE = pathlib.Path(__file__).parent
FORMATS = [("22-ascii", 2.2, 0), ("22-binary", 2.2, 1), ("41-ascii", 4.1, 0), ("41-binary", 4.1, 1)]


def write(name):
    for suffix, version, binary in FORMATS:
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.write(str(HERE / f"{name}-{suffix}.msh"))


def cylinders():
    gmsh.model.add("cylinders")
    lower = gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 0.6, 0.5)
    upper = gmsh.model.occ.addCylinder(0, 0, 0.6, 0, 0, 0.4, 0.5)
    gmsh.model.occ.fragment([(3, lower)], [(3, upper)])
    gmsh.model.occ.synchronize()

    def at(dim, z):
        low, high = [-1, -1, z - 1e-3], [1, 1, z + 1e-3]
        return [tag for _, tag in gmsh.model.getEntitiesInBoundingBox(*low, *high, dim=dim)]

    flat = [at(2, z) for z in (0, 0.6, 1)]
    sides = [tag for _, tag in gmsh.model.getEntities(2) if [tag] not in flat]
    gmsh.model.addPhysicalGroup(3, [lower], name="lower part")
    gmsh.model.addPhysicalGroup(3, [upper], name="upper part")
    gmsh.model.addPhysicalGroup(3, [lower, upper], name="all")  # a volume in two groups
    gmsh.model.addPhysicalGroup(2, flat[0], name="bottom")
    gmsh.model.addPhysicalGroup(2, flat[1], name="between")
    gmsh.model.addPhysicalGroup(2, flat[2], tag=77)  # no name
    gmsh.model.addPhysicalGroup(2, sides, name="side")
    gmsh.model.addPhysicalGroup(1, at(1, 1), name="rim")
    gmsh.model.addPhysicalGroup(0, at(0, 0), name="seam")
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.33)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.33)
    gmsh.model.mesh.generate(3)
    write("cylinders")


def bar():
    gmsh.model.add("bar")
    gmsh.model.geo.addPoint(0, 0, 0, tag=1)
    line = gmsh.model.geo.extrude([(0, 1)], 2, 0, 0, [3], recombine=True)[1]
    face = gmsh.model.geo.extrude([line], 0, 1, 0, [2], recombine=True)
    body = gmsh.model.geo.extrude([face[1]], 0, 0, 1, [2], recombine=True)
    gmsh.model.geo.synchronize()
    gmsh.model.addPhysicalGroup(3, [body[1][1]], name="bar")
    gmsh.model.addPhysicalGroup(2, [face[1][1]], name="sole")
    gmsh.model.mesh.generate(3)
    write("bar")


def measure(kind, x):
    """Areas of triangles and plane quadrilaterals, volumes of tetrahedra and parallelepipeds."""
    if kind == "triangle":
        return np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1) / 2
    if kind == "quad":
        return np.linalg.norm(np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]), axis=1) / 2
    last = {"tetra": 3, "hexahedron": 4}[kind]
    edges = np.stack([x[:, 1] - x[:, 0], x[:, 2 if last == 3 else 3] - x[:, 0], x[:, last] - x[:, 0]], axis=1)
    return np.abs(np.linalg.det(edges)) / (6 if last == 3 else 1)


def reference(model):
    mesh = meshio.read(HERE / f"{model}-41-ascii.msh")
    sums = {}
    for number, block in enumerate(mesh.cells):
        if block.type in ("vertex", "line"):
            continue
        sizes = measure(block.type, mesh.points[block.data])
        for name, sets in mesh.cell_sets.items():
            if not name.startswith("gmsh:") and sets[number] is not None and len(sets[number]):
                sums[name] = sums.get(name, 0) + sizes[sets[number]].sum()
    # meshio leaves out groups without a name, and keeps the entities
    return [f"{model}\t{name}\t{value:.15g}" for name, value in sorted(sums.items())]


gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 2)
cylinders()
bar()
(HERE / "reference.txt").write_text("\n".join(reference("cylinders") + reference("bar")) + "\n")
gmsh.finalize()
