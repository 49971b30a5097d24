"""Files of results of `stiction ccx` beside those of `ccx`, and read by ccx2paraview where it is installed.

    python3 bench/external/frd.py [--stiction target/release/stiction] [--ccx ccx]

A bar of each kind of element (C3D4, C3D10, C3D8, C3D20), bent by prescribed displacements and without contact, is solved by both: nodes,
elements and heads of the blocks have to be the same to the character, displacements, stresses, strains and forces to the digits of
the file. The binary form has to hold
the numbers of the text to single precision. With ccx2paraview (pip, with vtk) the file is converted and its displacements compared with
the text. Ends with code 1 where something differs.
"""

import argparse
import os
import struct
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
# Corners of a cell of half steps, then the middles of its edges in the order of CalculiX.
HEX = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
HEX_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
TETS = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
TET_EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
CELLS = (4, 2, 2)


def bar(kind, output):
    """A deck of a bar of 2 x 1 x 1, its nodes and elements with gaps in their numbers."""
    numbers, elements = {}, []

    def node(key):
        return numbers.setdefault(key, 10 * len(numbers) + 3)

    for i in range(CELLS[0]):
        for j in range(CELLS[1]):
            for k in range(CELLS[2]):
                corners = [(2 * i + a, 2 * j + b, 2 * k + c) for a, b, c in HEX]
                parts = [corners] if kind in ("C3D8", "C3D20") else [[corners[n] for n in tet] for tet in TETS]
                for part in parts:
                    edges = {"C3D20": HEX_EDGES, "C3D10": TET_EDGES}.get(kind, [])
                    middles = [tuple((part[a][c] + part[b][c]) // 2 for c in range(3)) for a, b in edges]
                    elements.append([node(key) for key in part + middles])
    lines = ["*NODE"] + [f"{n},{x / 4},{y / 4},{z / 4}" for (x, y, z), n in numbers.items()] + [f"*ELEMENT, TYPE={kind}, ELSET=ALL"]
    for number, nodes in enumerate(elements):
        words = [str(5 * number + 2)] + [str(n) for n in nodes]
        lines += [",".join(words[:12]) + ("," if len(words) > 12 else "")] + ([",".join(words[12:])] if len(words) > 12 else [])
    for name, x in (("ROOT", 0), ("TIP", 2 * CELLS[0])):
        lines += [f"*NSET, NSET={name}"] + [str(n) for key, n in numbers.items() if key[0] == x]
    file = "FILE" if output == "text" else "OUTPUT"
    element = "EL FILE" if output == "text" else "ELEMENT OUTPUT"
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", "1000, 0.3", "*SOLID SECTION, ELSET=ALL, MATERIAL=M", "*BOUNDARY", "ROOT,1,3", "*STEP",
              "*STATIC", "*BOUNDARY", "TIP,1,1,0.004", "TIP,2,2,0.01", "TIP,3,3,-0.02", f"*NODE {file}", "U,RF", f"*{element}", "S,E",
              "*END STEP"]
    return "\n".join(lines) + "\n"


def run(command, folder):
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    if done.returncode != 0:
        raise RuntimeError(f"{command}: {done.stdout.decode()[-2000:]}")


def parts(path):
    """Lines of mesh, and for each block of results its head and its rows, of a file of text."""
    mesh, blocks, rows = [], {}, None
    for line in open(path):
        line = line.rstrip("\n")
        if line[:6] in ("    2C", "    3C"):
            rows = mesh
        if line.startswith("    1PSTEP"):
            head = []
            rows = None
        if line.startswith("  100C") or line.startswith(" -4") or line.startswith(" -5"):
            head.append(line)
            if line.startswith(" -4"):
                rows = blocks.setdefault(line[5:13].strip(), (head, []))[1]
        elif rows is not None:
            rows.append(line)
    return mesh, blocks


def numbers_of(rows):
    values = {}
    for row in rows:
        if row.startswith(" -1"):
            values[int(row[3:13])] = [float(row[at:at + 12]) for at in range(13, len(row), 12)]
    return values


def binary_blocks(path):
    """Values of each block of results of a binary file."""
    data, at, blocks = open(path, "rb").read(), 0, {}

    def line():
        nonlocal at
        end = data.index(b"\n", at)
        text = data[at:end].decode()
        at = end + 1
        return text

    elements = 0
    while True:
        text = line()
        if text.startswith(" 9999"):
            return blocks
        if text.startswith("    2C"):
            at += int(text[24:36]) * 28
        elif text.startswith("    3C"):
            for elements in range(int(text[24:36])):
                kind = struct.unpack_from("<i", data, at + 4)[0]
                at += 16 + 4 * {1: 8, 3: 4, 4: 20, 6: 10}[kind]
        elif text.startswith("  100C"):
            count = int(text[24:36])
        elif text.startswith(" -4"):
            name, width = text[5:13].strip(), int(text[13:18])
            for _ in range(width):
                last = line()
            stored = width - 1 if "ALL" in last else width
            blocks[name] = {}
            for _ in range(count):
                row = struct.unpack_from(f"<i{stored}f", data, at)
                at += 4 + 4 * stored
                blocks[name][row[0]] = row[1:]


def difference(ours, theirs):
    """The largest difference of values over the largest value."""
    assert list(ours) == list(theirs), "other nodes"
    scale = max(abs(x) for row in theirs.values() for x in row)
    return max(abs(a - b) for n in ours for a, b in zip(ours[n], theirs[n])) / scale


def converted(path, ours):
    """The difference of the displacements that ccx2paraview reads, and the volume of its cells."""
    try:
        import ccx2paraview.common
        import vtk
    except ImportError:
        return None
    ccx2paraview.common.Converter(path, ["vtu"]).run()
    reader = vtk.vtkXMLUnstructuredGridReader()
    folder = os.path.dirname(path)
    reader.SetFileName(os.path.join(folder, next(name for name in sorted(os.listdir(folder)) if name.endswith(".vtu"))))
    reader.Update()
    grid = reader.GetOutput()
    array = grid.GetPointData().GetArray("U")
    read = {n: array.GetTuple(i)[:3] for i, n in enumerate(ours)}
    sizes = vtk.vtkCellSizeFilter()
    sizes.SetInputData(grid)
    sizes.Update()
    volumes = sizes.GetOutput().GetCellData().GetArray("Volume")
    volume = sum(volumes.GetValue(i) for i in range(grid.GetNumberOfCells()))
    return difference(read, ours), volume


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--stiction", default=os.path.join(HERE, "../../target/release/stiction"))
    parser.add_argument("--ccx", default="ccx")
    arguments = parser.parse_args()
    stiction, failed = os.path.abspath(arguments.stiction), []

    def check(good, what):
        if not good:
            failed.append(what)
            print("  DIFFERS:", what)

    for kind in ("C3D4", "C3D10", "C3D8", "C3D20"):
        with tempfile.TemporaryDirectory() as folder:
            places = {name: os.path.join(folder, name) for name in ("ours", "theirs")}
            for place in places.values():
                os.mkdir(place)
                for output in ("text", "binary"):
                    open(os.path.join(place, output + ".inp"), "w").write(bar(kind, output))
            for output in ("text", "binary"):
                run([stiction, "ccx", "-i", output], places["ours"])
                run([arguments.ccx, "-i", output], places["theirs"])
            ours, theirs = (parts(os.path.join(places[name], "text.frd")) for name in ("ours", "theirs"))
            check(ours[0] == theirs[0], f"{kind}: lines of nodes and elements")
            row = []
            for name, (head, rows) in ours[1].items():
                check(head == theirs[1][name][0], f"{kind}: head of {name}")
                apart = difference(numbers_of(rows), numbers_of(theirs[1][name][1]))
                row.append(f"{name} {apart:.1e}")
                # The numbers have six digits; those by which CalculiX extrapolates from integration points have four and more.
                allowed = 5e-5 if name in ("STRESS", "TOSTRAIN") else 1e-5
                check(apart <= allowed, f"{kind}: {name} differs by {apart:.1e}")
            for name, values in binary_blocks(os.path.join(places["ours"], "binary.frd")).items():
                text = numbers_of(ours[1][name][1])
                check(difference(values, text) <= 1e-5, f"{kind}: {name} as bytes")
            theirs_read = binary_blocks(os.path.join(places["theirs"], "binary.frd"))
            check(list(theirs_read)[:4] == list(ours[1]), f"{kind}: blocks {list(theirs_read)}")
            found = converted(os.path.join(places["ours"], "text.frd"), numbers_of(ours[1]["DISP"][1]))
            if found:
                check(found[0] <= 1e-6, f"{kind}: ccx2paraview reads other displacements, {found[0]:.1e}")
                check(abs(found[1] - 2.0) < 1e-5, f"{kind}: ccx2paraview reads cells of the volume {found[1]}")
                row.append(f"ccx2paraview {found[0]:.1e}, volume {found[1]:.6f}")
            print(f"{kind:6}", ", ".join(row))
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
