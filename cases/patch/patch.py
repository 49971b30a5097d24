"""Makes low.msh (hexahedra) and high.msh (tetrahedra), two halves of a column cut by the slope z = 1 + 0.3 x:

    python3 cases/patch/patch.py

needs the Python package gmsh."""

import os

import gmsh


def half(name, heights, cells, recombined):
    """The part of the unit square's column between `heights` at x = 0 and x = 1."""
    gmsh.model.add(name)
    geo = gmsh.model.geo
    (low0, high0), (low1, high1) = heights
    corners = [geo.addPoint(*x) for x in [(0, 0, low0), (1, 0, low1), (1, 0, high1), (0, 0, high0)]]
    lines = [geo.addLine(corners[i], corners[(i + 1) % 4]) for i in range(4)]
    front = geo.addPlaneSurface([geo.addCurveLoop(lines)])
    for line, count in zip(lines, [cells[0], cells[2]] * 2):
        geo.mesh.setTransfiniteCurve(line, count + 1)
    geo.mesh.setTransfiniteSurface(front)
    if recombined:
        geo.mesh.setRecombine(2, front)
    column = geo.extrude([(2, front)], 0, 1, 0, [cells[1]], recombine=recombined)
    geo.synchronize()
    for side, entity in [("bottom", column[2]), ("top", column[4])]:
        gmsh.model.addPhysicalGroup(2, [entity[1]], name=side)
    gmsh.model.addPhysicalGroup(3, [column[1][1]], name="body")
    gmsh.model.mesh.generate(3)
    gmsh.write(os.path.join(os.path.dirname(os.path.abspath(__file__)), name + ".msh"))


gmsh.initialize()
half("low", [(0, 1), (0, 1.3)], [4, 3, 3], True)
half("high", [(1, 2.3), (1.3, 2.3)], [3, 5, 4], False)
gmsh.finalize()
