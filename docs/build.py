#!/usr/bin/env python3
"""Builds the book: `python3 docs/build.py` writes target/book/html/index.html.

It makes its own virtual environment (docs/requirements.txt, the package of Python), builds the command, runs the shipped
cases, the cases to start from, and the programs and sessions of the pages, and gives all of it to Sphinx. Every warning
is an error. It needs Rust, a C compiler, and Python 3.11 or newer with `venv`; PYTHON names another interpreter.

    --pages-only    leave command, package and shipped cases as they were built last
    --tested        the numbers of the shipped cases are those that `cargo test` has just obtained
    --linkcheck     look whether the links to other sites lead somewhere; needs a network
"""

import argparse
import hashlib
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BOOK = ROOT / "docs" / "book"
OUT = ROOT / "target" / "book"


def environment(pages_only):
    """The interpreter of the book's environment, with everything installed."""
    home = OUT / "venv"
    python = home / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    wanted = ROOT / "docs" / "requirements.txt"
    digest = hashlib.sha256(wanted.read_bytes()).hexdigest()
    stamp = home / "requirements.sha256"
    if not stamp.exists() or stamp.read_text() != digest:
        run(os.environ.get("PYTHON", sys.executable), "-m", "venv", "--clear", home)
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", wanted)
        stamp.write_text(digest)
        pages_only = False
    if not pages_only:
        package = ROOT / "crates" / "stiction-py"
        pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        run(*pip, "--force-reinstall", "--no-deps", package)
    return python


def run(*command, **more):
    print("+", " ".join(str(c) for c in command), flush=True)
    subprocess.run([str(c) for c in command], check=True, **more)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pages-only", action="store_true")
    parser.add_argument("--tested", action="store_true")
    parser.add_argument("--linkcheck", action="store_true")
    given = parser.parse_args()
    if sys.version_info < (3, 11):
        sys.exit("the book needs Python 3.11 or newer")
    OUT.mkdir(parents=True, exist_ok=True)
    python = environment(given.pages_only)
    if not given.pages_only:
        # Where the tests have run, the program is there.
        if not given.tested:
            run("cargo", "build", "--release", "-p", "stiction-cli", cwd=ROOT)
            run("cargo", "test", "--release", "-q", "-p", "stiction-cli", "--test", "commands", "shipped::", cwd=ROOT)
    program = ROOT / "target" / "release"
    path = os.pathsep.join([str(program), str(python.parent), os.environ["PATH"]])
    variables = {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT / "docs")}
    run(python, "-m", "book", env=variables, cwd=OUT)
    source, html = OUT / "source", OUT / "html"
    builder = "linkcheck" if given.linkcheck else "html"
    target = OUT / "linkcheck" if given.linkcheck else html
    sphinx = [python, "-m", "sphinx", "-b", builder, "-W", "--keep-going", "-n", "-q"]
    run(*sphinx, "-c", BOOK, "-d", OUT / "doctrees", source, target, env=variables)
    print(f"the book: {html / 'index.html'}" if builder == "html" else "all links lead somewhere")


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as failed:
        sys.exit(f"docs/build.py: {Path(str(failed.cmd[0])).name} ended with exit code {failed.returncode}")
