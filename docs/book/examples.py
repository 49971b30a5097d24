"""The programs of `examples/python`, with what they print."""

import ast
import sys

from .place import ROOT, WORK, Failure, fence, insert, run


def write():
    folder = WORK / "examples"
    folder.mkdir(parents=True, exist_ok=True)
    parts = []
    for path in sorted((ROOT / "examples" / "python").glob("*.py")):
        text = path.read_text()
        said = ast.get_docstring(ast.parse(text))
        if not said:
            raise Failure(f"{path.relative_to(ROOT)} does not say what it shows")
        printed = run([sys.executable, str(path)], folder)
        parts += [f"## {path.stem.replace('_', ' ')}", "", said, "", fence(text, "python"), "", "It prints", "", fence(printed, "text")]
    insert("how-to/examples", "examples", "\n".join(parts))
