"""Makes the meshes of the bolted joint, low.msh, high.msh and bolt.msh: halves, cut by the plane y = 0.

    python3 cases/joint/joint.py

needs the Python package gmsh."""

import os

import gmsh


def part(name, shape, size, sides):
    """Meshes what `shape` builds and names the flat sides: `sides` has (name, axis, place)."""
    gmsh.model.add(name)
    occ = gmsh.model.occ
    body = shape(occ)
    half, _ = occ.intersect(body, [(3, occ.addBox(-100, 0, -100, 200, 100, 200))])
    occ.synchronize()
    faces = gmsh.model.getBoundary(half, oriented=False)
    for side, axis, place in sides:
        box = [gmsh.model.getBoundingBox(*face) for face in faces]
        flat = [face[1] for face, b in zip(faces, box) if abs(b[axis] - place) + abs(b[axis + 3] - place) < 1e-5]
        gmsh.model.addPhysicalGroup(2, flat, name=side)
    gmsh.model.addPhysicalGroup(3, [half[0][1]], name="body")
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.model.mesh.generate(3)
    gmsh.write(os.path.join(os.path.dirname(os.path.abspath(__file__)), name + ".msh"))


def plate(start, bottom):
    def shape(occ):
        box = (3, occ.addBox(start, -20, bottom, 60, 40, 8))
        return occ.cut([box], [(3, occ.addCylinder(0, 0, bottom, 0, 0, 8, 6))])[0]

    return shape


def bolt(occ):
    cylinders = [(-8, 16, 5), (8, 6, 10), (-14, 6, 10)]
    shank, head, nut = [(3, occ.addCylinder(0, 0, z, 0, 0, height, r)) for z, height, r in cylinders]
    return occ.fuse([shank], [head, nut])[0]


gmsh.initialize()
part("low", plate(-40, -8), 4.5, [("end", 0, -40), ("cut", 1, 0), ("inner", 2, 0), ("outer", 2, -8)])
part("high", plate(-20, 0), 4, [("end", 0, 40), ("cut", 1, 0), ("inner", 2, 0), ("outer", 2, 8)])
part("bolt", bolt, 3, [("cut", 1, 0), ("under-head", 2, 8), ("under-nut", 2, -8)])
gmsh.finalize()
