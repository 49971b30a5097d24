"""The pages of `docs` and of the repository: links led to their places in the book, programs run."""

import re
from pathlib import Path

from . import session
from .place import DOCS, ROOT, SOURCE, Failure

# Files of the repository that are pages of the book, and where.
ELSEWHERE = {
    "README.md": "index.md",
    "docs/README.md": "index.md",
    "ARCHITECTURE.md": "project/architecture.md",
    "CONTRIBUTING.md": "project/contributing.md",
    "CHANGELOG.md": "project/changelog.md",
    "bench/README.md": "project/benchmarks.md",
    "cases/README.md": "verification.md",
}
# Headings of pages that the book puts together otherwise.
HEADINGS = {"docs/README.md#working-on-the-program": "project/notes.md"}
COPIED = ["ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "bench/README.md"]

LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")


def write():
    sources = [p for p in sorted(DOCS.rglob("*.md")) if p.name != "README.md" and "book" not in p.relative_to(DOCS).parts]
    for source in sources:
        page = source.relative_to(DOCS).with_suffix("").as_posix()
        stage(source, page)
    for name in COPIED:
        stage(ROOT / name, ELSEWHERE[name].removesuffix(".md"))


def stage(source, page):
    """Writes one page, its programs run and its links led to the pages of the book."""
    text = session.run_page(source.read_text(), page, source.relative_to(ROOT))
    path = SOURCE / f"{page}.md"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(relinked(text, source, page))


def relinked(text, source, page):
    """The text of the file `source` as the page `page`, with links and images that lead from there."""
    parts, inside = [[]], None
    for line in text.split("\n"):
        mark = re.match(r"\s*(```+)", line)
        if mark and inside is None:
            parts.append([])
            inside = mark[1]
        parts[-1].append(line)
        if mark and len(parts[-1]) > 1 and inside and mark[1].startswith(inside):
            parts.append([])
            inside = None
    # Blocks of code are every second part; the text of a link may go over the end of a line.
    whole = ["\n".join(part) for part in parts]
    whole[::2] = [LINK.sub(lambda m: link(m, source, page), part) for part in whole[::2]]
    return "\n".join(part for part, lines in zip(whole, parts) if lines)


def link(match, source, page):
    image, text, target = match.groups()
    if "://" in target or target.startswith("#"):
        return match[0]
    file, _, heading = target.partition("#")
    path = (source.parent / file).resolve()
    if not path.is_relative_to(ROOT) or not path.exists():
        raise Failure(f"{source.relative_to(ROOT)}: {target} leads nowhere")
    name = path.relative_to(ROOT).as_posix()
    if image:
        copy = SOURCE / "images" / path.name
        copy.parent.mkdir(exist_ok=True)
        copy.write_bytes(path.read_bytes())
        return f"![{text}](/images/{path.name})"
    if f"{name}#{heading}" in HEADINGS:
        return f"[{text}](/{HEADINGS[f'{name}#{heading}']})"
    if name in ELSEWHERE:
        # Cases have pages of their own.
        heading = "" if name in ("cases/README.md", "docs/README.md", "README.md") else heading
        return f"[{text}](/{ELSEWHERE[name]}{'#' + heading if heading else ''})"
    if name.startswith("examples/python/") and name.endswith(".py"):
        return f"[{text}](/how-to/examples.md#{Path(name).stem.replace('_', '-')})"
    if name.startswith("docs/") and name.endswith(".md"):
        return f"[{text}](/{name.removeprefix('docs/')}{'#' + heading if heading else ''})"
    # A file of the repository that is no page.
    return f"{text} (`{name}`)" if text.strip("`") not in (name, path.name) else f"`{name}`"
