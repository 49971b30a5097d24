"""One page for each case that `stiction new` offers: made, solved and drawn."""

import re
import shutil
import tomllib

from .place import OUT, WORK, fence, figure, insert, pictures, run, write as write_page

# Lines of a run that hold times or memory, or speak of this machine.
TIMES = re.compile(r"^  (time|memory|work|files|  reading).*\n?", re.MULTILINE)


def write():
    listed = re.findall(r"^(\S+) +(.*)$", run(["stiction", "new", "--list"], OUT), re.MULTILINE)
    rows = []
    for name, description in listed:
        title, image = recipe(name, description)
        rows.append(f"| `{name}` | [{title}](recipes/{name}.md): {description} | ![{title}]({image}) |")
    table = "\n".join(["| name | case | |", "|---|---|---|", *rows, ""])
    toctree = "```{toctree}\n:hidden:\n" + "".join(f"recipes/{name}\n" for name, _ in listed) + "```\n"
    insert("how-to/recipes", "recipes", table + "\n" + toctree)


def recipe(name, description):
    """Writes the page; returns its title and its first picture."""
    folder = WORK / "recipes"
    folder.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(folder / name, ignore_errors=True)
    run(["stiction", "new", name, "--from", name], folder)
    results = f"{name}/results"
    printed = run(["stiction", "solve", f"{name}/case.toml", "-o", results, "--progress", "plain"], folder)
    verdict = TIMES.sub("", printed[printed.index("  status") :])
    case = (folder / name / "case.toml").read_text()
    head, title = re.match(r"(?:#.*\n)*", case)[0], tomllib.loads(case)["title"]
    shown = [n for n in ("deformed.png", *sorted(p.name for p in (folder / results).glob("pressure*.png"))[:2], "history.png") if (folder / results / n).exists()]
    paths = pictures(folder / results, f"recipes/{name}", shown)
    captions = {"deformed.png": "Displacements, exaggerated.", "history.png": "Forces and energies over time."}
    figures = [figure(path, captions.get(n, "Pressure over the contact surface.")) for path, n in zip(paths, shown)]
    session = f"$ stiction new {name} --from {name}\n$ stiction solve {name}/case.toml -o {results}\n...\n{verdict.rstrip()}"
    others = sorted(p.name for p in (folder / name).iterdir() if p.is_file() and p.name != "case.toml")
    beside = f"\n`stiction new` also writes {', '.join(f'`{o}`' for o in others)} beside the case.\n" if others else ""
    page = [
        f"# {title}", "", description[0].upper() + description[1:] + ".", "",
        figures[0], comment(head), "", fence(session, "console"), *figures[1:], "## The case file", "", beside,
        fence(case[len(head) :].lstrip("\n"), "toml"),
    ]  # fmt: skip
    write_page(f"how-to/recipes/{name}", "\n".join(page))
    return title, paths[0]


def comment(head):
    """The comment at the head of a case as paragraphs; indented lines are formulas."""
    lines = [line.removeprefix("#").removeprefix(" ") for line in head.splitlines()]
    parts, inside = [], False
    for line in lines:
        formula = line.startswith("  ")
        if formula != inside:
            parts.append("```" if inside else "\n```text")
            inside = formula
        parts.append(line if formula else plain(line))
    return "\n".join(parts + (["```"] if inside else []))


def plain(line):
    """Marks of Markdown that a comment does not mean."""
    spans = line.split("`")
    spans[::2] = [re.sub(r"([*_<>\[\]$|])", r"\\\1", part) for part in spans[::2]]
    line = "`".join(spans)
    # A result or a remark at the start of a line is neither a list nor a heading.
    line = re.sub(r"^([=\-+#])", r"\\\1", line)
    return re.sub(r"(--set .*)$", r"`\1`", line) if "`" not in line else line
