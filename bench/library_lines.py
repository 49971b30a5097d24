#!/usr/bin/env python3
"""Lines of the library without tests, comments and blank lines: library_lines.py [COMMIT...], by default of HEAD.

Tests are `tests.rs`, `*_tests.rs`, folders `tests` and items under `#[cfg(test)]`.
"""

import subprocess
import sys

SOURCE = "crates/stiction/src"


def git(*arguments):
    return subprocess.run(["git", *arguments], capture_output=True, text=True, check=True).stdout


def lines(text):
    count, end = 0, None
    for line in text.split("\n"):
        code = line.strip()
        if end is not None:  # within an item of tests, up to its last line
            if end == "" and not code.startswith("#["):
                end = None if code.endswith(";") else line[: len(line) - len(line.lstrip())] + "}"
            elif line == end:
                end = None
        elif code == "#[cfg(test)]":
            end = ""
        else:
            count += bool(code) and not code.startswith("//")
    return count


for commit in sys.argv[1:] or ["HEAD"]:
    names = git("ls-tree", "-r", "--name-only", commit, SOURCE).split()
    names = [n for n in names if n.endswith(".rs") and not n.endswith("tests.rs") and "/tests/" not in n]
    print(commit, sum(lines(git("show", f"{commit}:{name}")) for name in names))
