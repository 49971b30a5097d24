"""Makes the meshes of an assembly and puts its case file beside them.

    python3 bench/assemblies/build.py NAME SIZE FOLDER          # flange 50k /tmp/flange
"""

import importlib
import os
import shutil
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
NAMES = sorted(f[:-5] for f in os.listdir(HERE) if f.endswith(".toml"))


def build(name, size, folder):
    os.makedirs(folder, exist_ok=True)
    assembly = importlib.import_module(name)
    assembly.build(folder, assembly.H[size] if size in assembly.H else float(size))
    return shutil.copy(os.path.join(HERE, f"{name}.toml"), folder)


if __name__ == "__main__":
    if len(sys.argv) != 4 or sys.argv[1] not in NAMES:
        sys.exit(f"{__doc__}\nNAME is one of {', '.join(NAMES)}; SIZE is 50k, 200k, 700k or a factor on the length of edges")
    build(*sys.argv[1:])
