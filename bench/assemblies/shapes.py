"""Parts of assemblies by Gmsh: a shape, a size of cells that varies in space, and groups told by where their nodes lie."""

import os
import sys

import gmsh
import numpy as np

occ = gmsh.model.occ
# Far smaller than any detail of the parts (mm), far larger than the rounding of the geometry.
NEAR = 1e-3


def box(low, high):
    return (3, occ.addBox(*low, *np.subtract(high, low)))


def cylinder(point, axis, radius):
    return (3, occ.addCylinder(*point, *axis, radius))


def prism(outline, low, high):
    """The polygon (x, y) between z = low and z = high."""
    points = [occ.addPoint(x, y, low) for x, y in outline]
    lines = [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1])]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    return next(s for s in occ.extrude([(2, face)], 0, 0, high - low) if s[0] == 3)


def revolved(outline):
    """The polygon (r, z) turned about the z axis."""
    points = [occ.addPoint(r, 0, z) for r, z in outline]
    lines = [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1])]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    return next(s for s in occ.revolve([(2, face)], 0, 0, 0, 0, 0, 1, 2 * np.pi) if s[0] == 3)


def cut(body, *tools):
    return occ.cut([body], list(tools))[0][0]


def fuse(body, *others):
    return occ.fuse([body], list(others))[0][0]


def rounded(body, radius, *places):
    """The body with the straight edges along z rounded that stand at these (x, y)."""
    occ.synchronize()
    edges = []
    for _, edge in gmsh.model.getBoundary([body], oriented=False, recursive=False, combined=False):
        edges += [e for _, e in gmsh.model.getBoundary([(2, edge)], oriented=False)]
    chosen = set()
    for edge in edges:
        x0, y0, z0, x1, y1, z1 = gmsh.model.getBoundingBox(1, edge)
        if any(np.allclose([x0, x1, y0, y1], [x, x, y, y], atol=NEAR) for x, y in places):
            chosen.add(edge)
    if len(chosen) < len(places):
        sys.exit(f"rounded: {len(chosen)} edges stand at {places}")
    return occ.fillet([body[1]], sorted(chosen), [radius])[0]


def bolt(half, shank, head, height):
    """A bolt with head and nut about the z axis, clamping from -half to half, cut across in the middle for its pretension."""
    parts = []
    for sign in (1, -1):
        stem = cylinder((0, 0, 0), (0, 0, half * sign), shank)
        parts.append(fuse(stem, cylinder((0, 0, half * sign), (0, 0, height * sign), head)))
    occ.fragment(parts[:1], parts[1:])


def bolt_groups(half):
    return {"head": lambda x, y, z: at(half, z), "nut": lambda x, y, z: at(-half, z), "cut": lambda x, y, z: at(0, z)}


def part(path, s, shape, size, groups, volumes={}):
    """Writes the mesh of tet10 of `shape()` to `path`.

    `s * size(x, y, z)` is the wanted length of edges. `groups` maps a name to a function of arrays x, y, z: the faces of the body
    all of whose nodes fulfil it. Faces between its volumes may be named too. `volumes` maps a name to a function of the bounding
    box (x0, y0, z0, x1, y1, z1) of a volume; without it the cells are a group with the name of the file.
    """
    gmsh.initialize(interruptible=False)
    for option, value in [
        ("General.Terminal", 0),
        ("General.NumThreads", 1),
        ("Mesh.MeshSizeExtendFromBoundary", 0),
        ("Mesh.MeshSizeFromPoints", 0),
        ("Mesh.ElementOrder", 2),
        ("Mesh.HighOrderOptimize", 1),
        ("Mesh.OptimizeNetgen", 1),
        ("Mesh.MshFileVersion", 4.1),
        ("Mesh.Binary", 1),
    ]:
        gmsh.option.setNumber(option, value)
    try:
        shape()
        occ.synchronize()
        # What shapes were made from and does not bound a volume would be meshed too.
        body = gmsh.model.getEntities(3)
        used = {(2, f) for _, f in gmsh.model.getBoundary(body, oriented=False, combined=False)}
        occ.remove([e for e in gmsh.model.getEntities(2) if e not in used], recursive=True)
        occ.remove([e for e in gmsh.model.getEntities(1) if not len(gmsh.model.getAdjacencies(1, e[1])[0])], recursive=True)
        occ.synchronize()
        gmsh.model.mesh.setSizeCallback(lambda dim, tag, x, y, z, lc: s * size(x, y, z))
        gmsh.model.mesh.generate(3)
        faces = {}
        for _, face in gmsh.model.getEntities(2):
            nodes = gmsh.model.mesh.getNodes(2, face, includeBoundary=True)[1].reshape(-1, 3)
            faces[face] = nodes
        for name, inside in groups.items():
            chosen = [face for face, nodes in faces.items() if np.all(inside(*nodes.T))]
            if not chosen:
                sys.exit(f"{path}: no face is of the group {name}")
            gmsh.model.addPhysicalGroup(2, chosen, name=name)
        for name, inside in (volumes or {os.path.splitext(os.path.basename(path))[0]: lambda *b: True}).items():
            chosen = [volume for _, volume in body if inside(*gmsh.model.getBoundingBox(3, volume))]
            gmsh.model.addPhysicalGroup(3, chosen, name=name)
        gmsh.write(path)
    finally:
        gmsh.finalize()


def at(value, coordinate):
    """Whether a coordinate has this value."""
    return np.abs(coordinate - value) < NEAR


def around(radius, x, y):
    """Whether a point lies at this distance from the axis."""
    # Middles of edges lie on the surface as well as Gmsh finds it.
    return np.abs(np.hypot(x, y) - radius) < 10 * NEAR
