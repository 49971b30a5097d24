"""Where the book's files are, and how programs are run for it."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
OUT = ROOT / "target" / "book"
SOURCE = OUT / "source"
WORK = OUT / "work"


class Failure(Exception):
    """Something in the book is not as a page says."""


def write(page, text):
    """A page of the book, by its path without suffix."""
    path = SOURCE / f"{page}.md"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def insert(page, name, text):
    """Puts text in the place of the line `<!-- made: NAME -->` of a page."""
    path, mark = SOURCE / f"{page}.md", f"<!-- made: {name} -->"
    whole = path.read_text()
    if whole.count(mark) != 1:
        raise Failure(f"docs/{page}.md has no single line {mark}")
    path.write_text(whole.replace(mark, text))


def run(command, folder, status=0):
    """What a command prints, standard error included; `status` is the exit code it must end with."""
    done = subprocess.run(
        command, cwd=folder, shell=isinstance(command, str), executable="/bin/bash" if isinstance(command, str) else None,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    if done.returncode != status:
        raise Failure(f"{command} ended with exit code {done.returncode}, not {status}:\n{done.stdout}")
    return done.stdout


def fence(text, kind=""):
    """A block of code, its fence longer than any within."""
    mark = "```"
    while mark in text:
        mark += "`"
    return f"{mark}{kind}\n{text.rstrip()}\n{mark}\n"


def pictures(folder, page, names):
    """Copies pictures of a result folder beside the pages; returns their paths in the book."""
    target = SOURCE / "made" / page
    target.mkdir(parents=True, exist_ok=True)
    paths = []
    for name in names:
        (target / name).write_bytes((folder / name).read_bytes())
        paths.append(f"/made/{page}/{name}")
    return paths


def figure(path, caption, width=None):
    options = f":width: {width}\n" if width else ""
    return f"```{{figure}} {path}\n:alt: {caption}\n{options}\n{caption}\n```\n"
