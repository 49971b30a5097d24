"""Writes the meshes with data beside this script: python3 make_fields.py (needs: pip install gmsh).

A bar of hexahedra with numbers that are formulas of place: "mu" and "v" (a vector, in two time steps of which the first is
wrong) at nodes, "layer" at cells and surface elements by their centres, as views of Gmsh written with their mesh.
"""

import pathlib

import gmsh

HERE = pathlib.Path(__file__).parent


def centre(nodes, where):
    points = [where[n] for n in nodes]
    return [sum(p[c] for p in points) / len(points) for c in range(3)]


def write(name, version, binary):
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 1)
    gmsh.model.add("bar")
    box = gmsh.model.occ.addBox(0, 0, 0, 2, 1, 1)
    gmsh.model.occ.synchronize()
    for _, curve in gmsh.model.getEntities(1):
        along_x = abs(gmsh.model.getBoundingBox(1, curve)[3] - gmsh.model.getBoundingBox(1, curve)[0]) > 1.5
        gmsh.model.mesh.setTransfiniteCurve(curve, 4 if along_x else 2)
    for _, surface in gmsh.model.getEntities(2):
        gmsh.model.mesh.setTransfiniteSurface(surface)
        gmsh.model.mesh.setRecombine(2, surface)
    gmsh.model.mesh.setTransfiniteVolume(box)
    gmsh.model.mesh.generate(3)
    bottom = [s for d, s in gmsh.model.getEntities(2) if gmsh.model.getBoundingBox(2, s)[5] < 0.5]
    gmsh.model.addPhysicalGroup(2, bottom, name="bottom")
    gmsh.model.addPhysicalGroup(3, [box], name="body")
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    where = {int(t): xyz[3 * i : 3 * i + 3] for i, t in enumerate(tags)}
    mu, v = gmsh.view.add("mu"), gmsh.view.add("v")
    order = sorted(where, reverse=True)
    gmsh.view.addModelData(mu, 0, "bar", "NodeData", order, [[9.0] for _ in order])
    gmsh.view.addModelData(
        mu, 1, "bar", "NodeData", order, [[0.1 + 0.05 * where[t][0] + 0.02 * where[t][1]] for t in order], time=1.5
    )
    gmsh.view.addModelData(v, 0, "bar", "NodeData", order, [[1.0, 2.0, 3.0] for _ in order])
    layer = gmsh.view.add("layer")
    elements, values = [], []
    for dimension in (2, 3):
        for entity_dimension, entity in gmsh.model.getEntities(dimension):
            kinds, numbers, nodes = gmsh.model.mesh.getElements(entity_dimension, entity)
            for kind, numbers, nodes in zip(kinds, numbers, nodes):
                k = len(nodes) // len(numbers)
                for i, number in enumerate(numbers):
                    x = centre([int(n) for n in nodes[k * i : k * i + k]], where)
                    elements.append(int(number))
                    values.append([0.5 + 0.1 * x[0] if dimension == 3 else 7 + x[0] + x[2]])
    gmsh.view.addModelData(layer, 0, "bar", "ElementData", elements, values)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.option.setNumber("PostProcessing.SaveMesh", 0)
    path = str(HERE / f"{name}.msh")
    gmsh.write(path)
    for view in (mu, v, layer):
        gmsh.view.write(view, path, append=True)
    gmsh.finalize()


for version in (2.2, 4.1):
    for binary in (0, 1):
        write(f"fields-{str(version).replace('.', '')}-{['ascii', 'binary'][binary]}", version, binary)
