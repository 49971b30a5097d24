"""Two boxes in contact through FreeCAD, with this program in place of `ccx`: set up by FreeCAD's Python, solved, loaded back, compared.

    freecadcmd bench/external/freecad_contact.py            (STICTION=target/release/stiction by default)

FreeCAD writes the deck, calls the program through a link named `ccx`, reads JOB.frd and JOB.dat, and makes a result object. The
displacements and von Mises stresses of that object are compared with `result.vtu` and the nodal stress of the same deck solved by
`stiction solve`. Prints the largest differences; an exception or a difference beyond the six digits of the file ends with code 1.
Needs FreeCAD 0.20 or later (Debian: freecad-python3), run without a screen.
"""

import os
import subprocess
import sys
import tempfile
import traceback

# FreeCAD finds the faces of a surface by their places: where two bodies touch it takes those of both.
GAP = 1e-3


def tetrahedra(size, cells, origin, first_node, first_element):
    """Ten-node tetrahedra that fill a box: nodes by number and elements by number, nodes in the order of CalculiX."""
    numbers, nodes, elements = {}, {}, {}

    def node(key):
        # Keys count half cells.
        if key not in numbers:
            numbers[key] = first_node + len(numbers)
            nodes[numbers[key]] = tuple(origin[c] + size[c] * key[c] / (2 * cells[c]) for c in range(3))
        return numbers[key]

    # Six tetrahedra around the diagonal: one for each order of the axes.
    orders = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)]
    for i in range(cells[0]):
        for j in range(cells[1]):
            for k in range(cells[2]):
                for number, order in enumerate(orders):
                    at = [2 * i, 2 * j, 2 * k]
                    corners = [tuple(at)]
                    for axis in order:
                        at[axis] += 2
                        corners.append(tuple(at))
                    if number >= 3:  # an odd order turns the tetrahedron inside out
                        corners[1], corners[2] = corners[2], corners[1]
                    ends = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
                    middles = [tuple((corners[a][c] + corners[b][c]) // 2 for c in range(3)) for a, b in ends]
                    elements[first_element + len(elements)] = [node(key) for key in corners + middles]
    return nodes, elements


def mesh_of(boxes):
    import Fem

    mesh, nodes, elements = Fem.FemMesh(), {}, {}
    for size, cells, origin in boxes:
        more = tetrahedra(size, cells, origin, len(nodes) + 1, len(elements) + 1)
        nodes.update(more[0])
        elements.update(more[1])
    for number, place in nodes.items():
        mesh.addNode(*place, number)
    for number, n in elements.items():
        # FreeCAD has the first two corners of a tetrahedron the other way round.
        mesh.addVolume([n[1], n[0], n[2], n[3], n[4], n[6], n[5], n[8], n[7], n[9]], number)
    return mesh


def analysis_in(folder, program):
    import FreeCAD
    import ObjectsFem
    from femtools import ccxtools

    settings = FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Mod/Fem/Ccx")
    settings.SetBool("UseStandardCcxLocation", False)
    settings.SetString("ccxBinaryPath", program)
    doc = FreeCAD.newDocument("boxes")
    low = doc.addObject("Part::Box", "Low")
    low.Length, low.Width, low.Height = 20, 20, 10
    up = doc.addObject("Part::Box", "Up")
    up.Length, up.Width, up.Height = 12, 12, 10
    up.Placement = FreeCAD.Placement(FreeCAD.Vector(4, 4, 10 + GAP), FreeCAD.Rotation(0, 0, 0))
    both = doc.addObject("Part::Compound", "Both")
    both.Links = [low, up]
    doc.recompute()
    analysis = ObjectsFem.makeAnalysis(doc, "Analysis")
    solver = ObjectsFem.makeSolverCalculixCcxTools(doc, "Solver")
    solver.AnalysisType, solver.GeometricalNonlinearity = "static", "linear"
    solver.IterationsControlParameterTimeUse = False
    analysis.addObject(solver)
    steel = ObjectsFem.makeMaterialSolid(doc, "Steel")
    steel.Material = dict(steel.Material, Name="Steel", YoungsModulus="210000 MPa", PoissonRatio="0.30")
    analysis.addObject(steel)

    def face(box, height):
        for number, face in enumerate(box.Shape.Faces):
            if abs(face.BoundBox.ZMin - height) < 1e-6 and abs(face.BoundBox.ZMax - height) < 1e-6:
                return box, f"Face{number + 1}"
        raise RuntimeError(f"no face at the height {height}")

    fixed = ObjectsFem.makeConstraintFixed(doc, "Fixed")
    fixed.References = [face(low, 0)]
    analysis.addObject(fixed)
    moved = ObjectsFem.makeConstraintDisplacement(doc, "Moved")
    moved.References = [face(up, 20 + GAP)]
    moved.xFree = moved.yFree = moved.zFree = False
    moved.xFix = moved.zFix = False
    moved.yFix = True
    moved.xDisplacement, moved.zDisplacement = 0.002, -0.01 - GAP
    analysis.addObject(moved)
    contact = ObjectsFem.makeConstraintContact(doc, "Contact")
    contact.References = [face(up, 10 + GAP), face(low, 10)]
    contact.Friction, contact.Slope = 0.2, 1e6
    analysis.addObject(contact)
    mesh = doc.addObject("Fem::FemMeshObject", "Mesh")
    mesh.FemMesh = mesh_of([((20, 20, 10), (5, 5, 2), (0, 0, 0)), ((12, 12, 10), (4, 4, 3), (4, 4, 10 + GAP))])
    analysis.addObject(mesh)
    doc.recompute()
    tools = ccxtools.FemToolsCcx(analysis, solver, test_mode=False)
    tools.update_objects()
    tools.setup_working_dir(folder)
    problems = tools.check_prerequisites()
    if problems:
        raise RuntimeError(problems)
    tools.purge_results()
    tools.write_inp_file()
    print("version", tools.get_ccx_version())
    if tools.ccx_run() != 0:
        raise RuntimeError("the solver failed: " + tools.ccx_stdout)
    tools.load_results()
    results = [o for o in doc.Objects if o.isDerivedFrom("Fem::FemResultObject")]
    print("objects of results:", [(o.Name, o.ResultType if hasattr(o, "ResultType") else o.TypeId) for o in results])
    return tools.inp_file_name, results[-1]


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    sys.path.insert(0, here)
    import decks

    stiction = os.path.abspath(os.environ.get("STICTION", os.path.join(here, "../../target/release/stiction")))
    with tempfile.TemporaryDirectory() as folder:
        program = os.path.join(folder, "ccx")
        os.symlink(stiction, program)
        job, result = analysis_in(folder, program)
        out = os.path.join(folder, "out")
        subprocess.run([stiction, "solve", job, "-o", out, "--no-pictures", "--no-report", "--progress", "none"], check=True,
                       stdout=subprocess.DEVNULL)
        labels = decks.solid_nodes(decks.cards(decks.text_of(job)))
        u = decks.array(decks.last_result(out), "displacement")
        known = dict(zip(labels, u))
        largest = max(abs(x) for v in u for x in v)
        pairs = list(zip(result.NodeNumbers, result.DisplacementVectors))
        assert len(pairs) == len(labels), (len(pairs), len(labels))
        difference = max(abs(a - b) for label, v in pairs for a, b in zip((v.x, v.y, v.z), known[label]))
        print(f"{len(pairs)} nodes, displacement at most {largest:.6g}, difference {difference / largest:.2e} of it")
        print(f"von Mises stress from {min(result.vonMises):.4g} to {max(result.vonMises):.4g}")
        # Six digits of the file, half a unit in the last.
        assert difference <= 1e-5 * largest and max(result.vonMises) > 0
        print("agrees")


# freecadcmd runs a script as a module of its own name.
try:
    main()
except BaseException:
    traceback.print_exc()
    sys.stdout.flush()
    os._exit(1)
sys.stdout.flush()
os._exit(0)
