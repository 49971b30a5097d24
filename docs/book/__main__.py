"""Writes target/book/source; `docs/build.py` calls it with the command and the package on their paths."""

import shutil
import sys

from . import commands, examples, keys, pages, recipes, verification
from .place import SOURCE, WORK, Failure


def main():
    for folder in (SOURCE, WORK):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    for make in (pages, commands, keys, recipes, verification, examples):
        make.write()


try:
    main()
except Failure as failure:
    sys.exit(f"the book: {failure}")
