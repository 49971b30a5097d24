"""Runs what the pages show.

Blocks of code with a mark behind their language are run in a folder of the page, in their order:

    ```console run            commands behind `$ `, each followed by what it prints; `...` stands for any text
    ```console run exit=2     the same where the last command ends with another exit code
    ```console run needs=X    shown only where the program X cannot be called, which is said
    ```toml file=case.toml    a file, written
    ```python run             a program; blocks of a page share their names
    ```text output            what the program before it prints

A page whose programs do otherwise than it says is an error.
"""

import contextlib
import io
import os
import re
import subprocess
import textwrap

from .place import SOURCE, WORK, Failure, run

OPENING = re.compile(r"^```(\w+) +(run|file|output)(?:=(\S+))?(?: +exit=(\d+))?(?: +needs=(\w+))?$")


def run_page(text, page, name):
    """The text of a page with plain blocks, once everything in it was run."""
    lines, kept, folder, names, printed = text.split("\n"), [], WORK / page, {"__name__": "__main__"}, ""
    at = 0
    while at < len(lines):
        opening = OPENING.match(lines[at])
        if not opening:
            kept.append(lines[at])
            at += 1
            continue
        folder.mkdir(parents=True, exist_ok=True)
        end = lines.index("```", at)
        block, place = "\n".join(lines[at + 1 : end]) + "\n", f"{name}:{at + 1}"
        kind, what, file, status, program = opening.groups()
        if program and not callable_here(program):
            print(f"not run: {place} needs {program}, which is not there")
        elif what == "file":
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            (folder / file).write_text(block)
        elif what == "output":
            compare(block, printed, place)
        elif kind == "console":
            console(block, folder, place, int(status or 0))
        elif kind == "python":
            printed = python(block, folder, place, names)
        else:
            raise Failure(f"{place}: {kind} cannot be run")
        kept += [f"```{kind}", *lines[at + 1 : end + 1]]
        at = end + 1
    for picture in folder.rglob("*.png") if folder.exists() else []:
        target = SOURCE / "made" / page / picture.relative_to(folder)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(picture.read_bytes())
    return "\n".join(kept)


def callable_here(program):
    """Whether it can be started: a package may be there without the libraries it needs."""
    try:
        return subprocess.run([program, "--version"], capture_output=True).returncode == 0
    except OSError:
        return False


def console(block, folder, place, status):
    commands = re.split(r"^\$ ", block, flags=re.MULTILINE)
    if commands[0].strip():
        raise Failure(f"{place}: a session begins with `$ `")
    for number, text in enumerate(commands[1:], 2):
        command, shown = re.match(r"((?:[^\n]*\\\n)*[^\n]*\n?)(.*)", text, re.DOTALL).groups()
        try:
            printed = run(command, folder, status if number == len(commands) else 0)
        except Failure as failure:
            raise Failure(f"{place}: {failure}") from None
        compare(shown, printed, f"{place}: {command.strip()}")


def compare(shown, printed, place):
    """Holds what a page shows against what was printed; `...` stands for anything, spaces at ends do not count."""
    plain = lambda text: "\n".join(line.rstrip() for line in text.strip().split("\n"))
    pattern = ".*?".join(re.escape(part) for part in plain(shown).split("..."))
    if not re.fullmatch(pattern, plain(printed), re.DOTALL):
        raise Failure(f"{place} prints\n{textwrap.indent(printed, '  ')}\nand the page shows\n{textwrap.indent(shown, '  ')}")


def python(block, folder, place, names):
    before, printed = os.getcwd(), io.StringIO()
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(printed):
            exec(compile(block, str(place), "exec"), names)
    except Exception as error:
        raise Failure(f"{place}: {type(error).__name__}: {error}") from error
    finally:
        os.chdir(before)
    return printed.getvalue()
