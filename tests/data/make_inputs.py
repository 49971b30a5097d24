"""Writes the mesh files beside this script: python3 make_inputs.py (needs: pip install gmsh meshio pyvista).

One brick of 2 x 1 x 1 as hexahedra (brick) and as tetrahedra (tets), each as .msh, .inp and .vtu by the programs that
the names tell, and in pyramid.* what this program does not compute with.
"""

import os
import pathlib

import gmsh
import meshio
import numpy as np
import pyvista

HERE = pathlib.Path(__file__).parent
SIDES = [("left", 0, 0.0), ("right", 0, 2.0), ("bottom", 2, 0.0), ("top", 2, 1.0)]


def model(name, cells, recombine):
    gmsh.model.add(name)
    gmsh.model.occ.addBox(0, 0, 0, 2, 1, 1)
    gmsh.model.occ.synchronize()
    for dim, tag in gmsh.model.getEntities(1):
        low, high = np.split(np.array(gmsh.model.getBoundingBox(dim, tag)), 2)
        axis = int(np.argmax(high - low))
        gmsh.model.mesh.setTransfiniteCurve(tag, cells[axis] + 1)
    for _, tag in gmsh.model.getEntities(2):
        gmsh.model.mesh.setTransfiniteSurface(tag)
        if recombine:
            gmsh.model.mesh.setRecombine(2, tag)
    gmsh.model.mesh.setTransfiniteVolume(1)
    gmsh.model.addPhysicalGroup(3, [1], name="body")
    for group, axis, at in SIDES:
        low, high = [-1e-3] * 3, [2.001, 1.001, 1.001]
        low[axis], high[axis] = at - 1e-3, at + 1e-3
        faces = [tag for _, tag in gmsh.model.getEntitiesInBoundingBox(*low, *high, dim=2)]
        gmsh.model.addPhysicalGroup(2, faces, name=group)
    gmsh.model.mesh.generate(3)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.write(f"{name}.msh")
    gmsh.option.setNumber("Mesh.SaveGroupsOfElements", 1)
    gmsh.option.setNumber("Mesh.SaveGroupsOfNodes", 1)
    gmsh.write(f"{name}-gmsh.inp")


def convert(name):
    """By meshio: the groups as element sets in the input, as an array of integers in the grid."""
    mesh = meshio.read(HERE / f"{name}.msh")
    tags = {int(data[0]): group for group, data in mesh.field_data.items()}
    kinds = [block.type for block in mesh.cells]
    physical = mesh.cell_data["gmsh:physical"]
    sets = {
        group: [np.flatnonzero(values == tag) for values in physical]
        for tag, group in tags.items()
    }
    points = {group: np.unique(np.concatenate([c.data[s].ravel() for c, s in zip(mesh.cells, cells)])) for group, cells in sets.items()}
    solid = [i for i, kind in enumerate(kinds) if kind in ("tetra", "hexahedron")]
    inp = meshio.Mesh(
        mesh.points,
        [mesh.cells[i] for i in solid],
        point_sets={group: points[group].astype(np.int32) for group, _, _ in SIDES},
        cell_sets={"body": [np.arange(len(mesh.cells[i].data)) for i in solid]},
    )
    meshio.abaqus.write(HERE / f"{name}-meshio.inp", inp)
    grid = meshio.Mesh(mesh.points, mesh.cells, cell_data={"part": physical})
    # the plain variants of encoding only once: the grids are the same
    variants = [("ascii", dict(binary=False)), ("binary", dict(binary=True, compression=None)), ("zlib", dict(binary=True))]
    for suffix, options in variants if name == "brick" else variants[2:]:
        meshio.vtu.write(HERE / f"{name}-meshio-{suffix}.vtu", grid, **options)


def by_vtk(name):
    """By VTK: appended data, with and without base64 and compression, and other widths of numbers."""
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    grid = pyvista.read(HERE / f"{name}-meshio-zlib.vtu")
    grid["bottom"] = (grid.points[:, 2] < 1e-9).astype(np.int8)  # a mask of nodes
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    for suffix, encoded, compressed, wide in [
        ("raw", False, False, True),
        ("raw-zlib", False, True, False),
        ("base64", True, False, False),
        ("base64-zlib", True, True, True),
        ("inline-zlib", None, True, True),
        ("lz4", False, "lz4", True),
    ]:
        writer.SetFileName(str(HERE / f"{name}-vtk-{suffix}.vtu"))
        if encoded is None:
            writer.SetDataModeToBinary()
        else:
            writer.SetDataModeToAppended()
            writer.SetEncodeAppendedData(encoded)
        if compressed == "lz4":
            writer.SetCompressorTypeToLZ4()
        elif compressed:
            writer.SetCompressorTypeToZLib()
        else:
            writer.SetCompressorTypeToNone()
        writer.SetBlockSize(400)  # several blocks an array
        writer.SetHeaderTypeToUInt64() if wide else writer.SetHeaderTypeToUInt32()
        writer.SetIdTypeToInt64() if wide else writer.SetIdTypeToInt32()
        writer.SetByteOrderToBigEndian() if suffix == "base64" else writer.SetByteOrderToLittleEndian()
        writer.Write()
    grid.save(HERE / f"{name}-pyvista.vtu", binary=True)


def unusable():
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1.0]])
    pyramid = meshio.Mesh(points, [("pyramid", [[0, 1, 2, 3, 4]])])
    meshio.vtu.write(HERE / "pyramid-meshio.vtu", pyramid, binary=False)


os.chdir(HERE)  # Gmsh writes the path into the file
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
model("brick", [4, 2, 2], True)
model("tets", [2, 1, 1], False)
for name in ["brick", "tets"]:
    convert(name)
by_vtk("brick")
unusable()
gmsh.finalize()
