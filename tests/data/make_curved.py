"""Writes curved quadratic meshes beside this script: python3 make_curved.py (needs: pip install gmsh meshio).

A quarter of a cylinder of radius 1 and height 1 as tet10, hex20 and wedge15, by Gmsh as MSH 4.1 (binary), MSH 2.2 (text) and
.inp, by meshio, which does not know wedge15, as .vtu and .inp; the volume of the curved cells and the areas of the curved faces by Gmsh's own
Jacobians in curved.txt: "file what measure".
"""

import os
import pathlib

import gmsh
import meshio
import numpy as np

HERE = pathlib.Path(__file__).parent


def build(kind):
    gmsh.clear()
    gmsh.model.add(kind)
    geo = gmsh.model.geo
    o, a, m, b = [geo.addPoint(*x) for x in [(0, 0, 0), (1, 0, 0), (0.5**0.5, 0.5**0.5, 0), (0, 1, 0)]]
    p, q, r = [geo.addPoint(*x) for x in [(0.45, 0, 0), (0.4, 0.4, 0), (0, 0.45, 0)]]
    line = geo.addLine
    op, pq, qr, ro = line(o, p), line(p, q), line(q, r), line(r, o)
    pa, qm, rb = line(p, a), line(q, m), line(r, b)
    am, mb = geo.addCircleArc(a, o, m), geo.addCircleArc(m, o, b)
    loops = [[op, pq, qr, ro], [pa, am, -qm, -pq], [qm, mb, -rb, -qr]]
    faces = [geo.addPlaneSurface([geo.addCurveLoop(loop)]) for loop in loops]
    for curve in [op, pq, qr, ro, pa, qm, rb, am, mb]:
        geo.mesh.setTransfiniteCurve(curve, 2)
    for face in faces:
        geo.mesh.setTransfiniteSurface(face)
        if kind.startswith("hex"):
            geo.mesh.setRecombine(2, face)
    extruded = geo.extrude([(2, f) for f in faces], 0, 0, 1, numElements=[2], recombine=kind != "tet10")
    geo.synchronize()
    volumes = [tag for dim, tag in extruded if dim == 3]
    curved = []
    for _, tag in gmsh.model.getEntities(2):
        low, high = gmsh.model.getParametrizationBounds(2, tag)
        x = np.array(gmsh.model.getValue(2, tag, [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])]))
        normal = np.array(gmsh.model.getNormal(tag, [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])]))
        if abs(np.hypot(x[0], x[1]) - 1) < 1e-3 and abs(normal[2]) < 1e-6:
            curved.append(tag)
    gmsh.model.addPhysicalGroup(3, volumes, 1, name="body")
    gmsh.model.addPhysicalGroup(2, curved, 2, name="curved")
    gmsh.model.addPhysicalGroup(2, faces, 3, name="bottom")
    gmsh.option.setNumber("Mesh.ElementOrder", 2)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 0 if kind in ("hex27", "wedge18") else 1)
    gmsh.model.mesh.generate(3)
    return curved


def measure(dim, tags):
    total = 0.0
    for tag in tags:
        types, _, _ = gmsh.model.mesh.getElements(dim, tag)
        for t in types:
            local, weights = gmsh.model.mesh.getIntegrationPoints(t, "Gauss8")
            _, dets, _ = gmsh.model.mesh.getJacobians(t, local, tag)
            total += np.sum(np.abs(np.array(dets).reshape(-1, len(weights))) @ np.array(weights))
    return total


os.chdir(HERE)  # Gmsh writes the name it is given into the .inp
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
lines = []
for kind in ["tet10", "hex20", "wedge15"]:
    curved = build(kind)
    volumes = [tag for _, tag in gmsh.model.getEntities(3)]
    lines.append(f"curved-{kind}\tbody\t{float(measure(3, volumes))!r}")
    lines.append(f"curved-{kind}\tcurved\t{float(measure(2, curved))!r}")
    for name, version, binary in [("-22.msh", 2.2, 0), ("-41.msh", 4.1, 1)]:
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.write(f"curved-{kind}{name}")
    gmsh.option.setNumber("Mesh.SaveGroupsOfElements", -1111)
    gmsh.write(f"curved-{kind}-gmsh.inp")
    if kind == "wedge15":
        continue
    mesh = meshio.read(HERE / f"curved-{kind}-22.msh")
    mesh.cell_data = {"part": mesh.cell_data["gmsh:physical"]}
    mesh.cell_sets = {}
    mesh.write(HERE / f"curved-{kind}-meshio.vtu")
    solid = {"tet10": "tetra10", "hex20": "hexahedron20"}[kind]
    meshio.Mesh(mesh.points, {solid: mesh.cells_dict[solid]}).write(HERE / f"curved-{kind}-meshio.inp")
for kind in ["hex27", "wedge18"]:  # the same with nodes within faces and cells, only as MSH
    build(kind)
    for name, version, binary in [("-22.msh", 2.2, 0), ("-41.msh", 4.1, 1)]:
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.write(f"curved-{kind}{name}")
(HERE / "curved.txt").write_text("\n".join(lines) + "\n")
