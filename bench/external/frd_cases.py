"""The .frd file of every shipped case, read by ccx2paraview, beside the result.vtu of the same run.

    python3 bench/external/frd_cases.py [--stiction target/release/stiction] [CASE ..]

Needs ccx2paraview and vtk (pip). Displacements and reactions of the last increment have to be those of result.vtu to the six
digits of the file, and the cells have to have the same volume. Ends with code 1 where they differ.
"""

import argparse
import glob
import os
import subprocess
import sys
import tempfile

import ccx2paraview.common
import vtk

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
# Half a unit of the sixth digit, of a largest value that begins with 1.
ALLOWED = 5.001e-6


def grid_of(path):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def rows(grid, name):
    array = grid.GetPointData().GetArray(name)
    return [array.GetTuple(i)[:3] for i in range(array.GetNumberOfTuples())] if array else None


def volume(grid):
    sizes = vtk.vtkCellSizeFilter()
    sizes.SetInputData(grid)
    sizes.Update()
    values = sizes.GetOutput().GetCellData().GetArray("Volume")
    return sum(values.GetValue(i) for i in range(values.GetNumberOfTuples()))


def last(folder, pattern):
    """The file of the last increment: numbers grow along the names."""
    found = glob.glob(os.path.join(folder, pattern))
    return max(found, key=lambda path: (len(path), path))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--stiction", default=os.path.join(ROOT, "target", "release", "stiction"))
    parser.add_argument("cases", nargs="*")
    arguments = parser.parse_args()
    names = arguments.cases or sorted(os.path.basename(os.path.dirname(p)) for p in glob.glob(os.path.join(ROOT, "cases/*/expect.toml")))
    failed = 0
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            frd, results = os.path.join(folder, name + ".frd"), os.path.join(folder, "results")
            command = [os.path.abspath(arguments.stiction), "solve", os.path.join(ROOT, "cases", name, name + ".toml"), "-o", results]
            done = subprocess.run([*command, "--frd", frd, "--no-report", "--no-pictures", "--progress", "none"], capture_output=True)
            assert done.returncode == 0, done.stderr.decode()
            ccx2paraview.common.Converter(frd, ["vtu"]).run()
            theirs, ours = grid_of(last(folder, name + "*.vtu")), grid_of(last(results, "result*.vtu"))
            said = [f"{ours.GetNumberOfPoints()} nodes, {ours.GetNumberOfCells()} cells"]
            good = (ours.GetNumberOfPoints(), ours.GetNumberOfCells()) == (theirs.GetNumberOfPoints(), theirs.GetNumberOfCells())
            for mine, other in (("displacement", "U"), ("reaction", "RF")):
                a, b = rows(ours, mine), rows(theirs, other)
                if a is None or b is None:
                    good = False
                    said.append(f"{other} is missing")
                    continue
                scale = max(abs(x) for row in a for x in row) or 1.0
                apart = max(abs(x - y) for p, q in zip(a, b) for x, y in zip(p, q)) / scale
                good = good and apart <= ALLOWED
                said.append(f"{other} {apart:.1e}")
            apart = abs(volume(theirs) / volume(ours) - 1.0)
            good = good and apart <= ALLOWED
            said.append(f"volume {apart:.1e}")
            failed += not good
            print(f"| {name} | {' | '.join(said)} |{'' if good else ' DIFFERS'}", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
