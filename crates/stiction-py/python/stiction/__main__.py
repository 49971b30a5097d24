"""The command ``stiction``, as ``python -m stiction`` too."""

import sys

from ._stiction import command


def main() -> int:
    """Do what the command line says and return the exit code."""
    return command(["stiction", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
