"""The verification manual: every shipped case with what it must give, from where that is known, and what was obtained.

The numbers are those that the test `shipped` keeps (crates/stiction-cli/tests/commands/shipped.rs)."""

import json
import math
import re
import tomllib

from .pages import relinked
from .place import ROOT, WORK, Failure, fence, figure, insert, pictures, run, write as write_page

OBTAINED = ROOT / "target" / "tmp" / "obtained"
CASES = ROOT / "cases"
MOST_PICTURES = 4


def write():
    described = descriptions()
    folders = sorted(p.name for p in CASES.iterdir() if p.is_dir())
    if set(described) != set(folders):
        raise Failure(f"cases/README.md describes {sorted(set(described) ^ set(folders))} that are no folders, or leaves them out")
    rows, total = [], 0
    for name in described:
        record = json.loads((OBTAINED / f"{name}.json").read_text())
        if record["expect"] != (CASES / name / "expect.toml").read_text():
            raise Failure(f"{name} was not run since its expectations changed: cargo test -p stiction-cli --test commands shipped")
        values = [value for one in record["runs"] for value in one["values"]]
        shares = [share for share in (used(v) for v in values) if share is not None]
        total += len(values)
        title = case(name, described[name], record)
        worst = f"{100 * max(shares):.0f} %" if shares else ""
        unknowns = record["runs"][0]["facts"]["dofs"]
        reference = tomllib.loads(record["expect"])["reference"]
        rows.append(f"| [{escape(title)}](verification/{name}.md) | {unknowns} | {len(record['runs'])} | {len(values)} | {worst} | {escape(reference)} |")
    table = [
        f"{len(rows)} cases, {total} numbers. *Used* is the largest part of its tolerance that a number takes.",
        "", "| case | unknowns | runs | numbers | used | reference |", "|---|--:|--:|--:|--:|---|", *rows, "",
        "```{toctree}", ":hidden:", *(f"verification/{name}" for name in described), "```", "",
    ]  # fmt: skip
    insert("verification", "cases", "\n".join(table))


def descriptions():
    """What cases/README.md says of each case, in its order."""
    text = (CASES / "README.md").read_text()
    parts = re.split(r"^\*\*(\w+)\*\* — ", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2]))


def case(name, described, record):
    """Writes the page of a case; returns its title."""
    folder = WORK / "verification"
    folder.mkdir(parents=True, exist_ok=True)
    file = CASES / name / f"{name}.toml"
    run(["stiction", "solve", str(file), "-o", name, "--progress", "none", "--no-report"], folder)
    run(["stiction", "check", name], folder)
    found = {p.name for p in (folder / name).glob("*.png")}
    order = [n for kind in ("deformed", "pressure", "shear", "status") for n in sorted(found) if n.startswith(kind)]
    shown = [n for n in order if not n.startswith("shear") or len(found) < 12][:MOST_PICTURES]
    figures = [figure(path, caption(n)) for path, n in zip(pictures(folder / name, f"verification/{name}", shown), shown)]
    text = file.read_text()
    title = tomllib.loads(text)["title"]
    # The commands of the README are its indented blocks.
    prose = re.sub(r"((?:^    .*\n?)+)", lambda m: fence(re.sub(r"^    ", "", m[1], flags=re.MULTILINE), "sh"), described, flags=re.MULTILINE)
    page = [
        f"# {title}", "", f"`cases/{name}/{name}.toml`", "", figures[0] if figures else "",
        relinked(prose, CASES / "README.md", f"verification/{name}"), "", *figures[1:],
        "## What it gives", "", *(table(one, remark) for one, remark in zip(record["runs"], remarks(record["expect"]))),
        "## The case file", "", fence(text, "toml"),
    ]  # fmt: skip
    write_page(f"verification/{name}", "\n".join(page))
    return title


def caption(name):
    kind = name.split(".")[0]
    what = {"deformed": "Displacements, exaggerated", "pressure": "Pressure", "shear": "Shear traction", "status": "Open, sticking and sliding points"}
    first, _, surface = kind.partition("-")
    return what[first] + (f" of {surface.replace('_', ' ')}" if surface else "") + "."


def remarks(expect):
    """The comments behind the headings of the runs."""
    found = re.findall(r"^\[\[run\]\](?: *# *(.*))?$", expect, re.MULTILINE)
    return [remark[:1].upper() + remark[1:] for remark in found]


def table(one, remark):
    changed = "".join(f"\n{fence(s, 'text')}" for s in one["set"])
    facts = one["facts"]
    path = {"multigrid": "multigrid", "dense": "a factor", "solves": "a factor"}.get(facts["path"], facts["path"])
    head = (remark or ("With changes" if one["set"] else "As shipped")).rstrip(".")
    lines = [f"### {head}", ""]
    lines += ["Set on the command line (`--set`):", changed] if one["set"] else []
    lines += [f"{facts['dofs']} unknown displacements, {facts['dual_dofs']} contact forces, solved by {path}.", ""]
    lines += ["| quantity | obtained | reference | tolerance | used | source |", "|---|--:|--:|--:|--:|---|"]
    for value in one["values"]:
        expect, found = value["expect"], value["found"]
        if "value" in expect:
            reference, tolerance = shown(expect["value"], expect), limit(expect)
        else:
            bounds = [f"> {expect['above']:g}"] if "above" in expect else []
            bounds += [f"< {expect['below']:g}"] if "below" in expect else []
            reference, tolerance = " and ".join(bounds), ""
        share = used(value)
        part = "" if share is None else "0 %" if share < 5e-4 else f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"
        lines.append(f"| {quantity(expect)} | {shown(found, expect)} | {escape(reference)} | {tolerance} | {part} | {escape(expect['source'])} |")
    return "\n".join(lines) + "\n"


def allowed(expect):
    """The largest distance from the reference, or none where bounds are given."""
    if "value" not in expect:
        return None
    return expect["rel"] * abs(expect["value"]) if "rel" in expect else expect.get("abs", 0)


def used(value):
    """The part of its tolerance that a number takes; none for counts and bounds."""
    bound = allowed(value["expect"])
    return abs(value["found"] - value["expect"]["value"]) / bound if bound else None


def limit(expect):
    if "rel" in expect:
        return f"{expect['rel']:g} relative"
    return f"{expect['abs']:g}" if "abs" in expect else "exact"


def shown(number, expect):
    """A number to as many digits as its tolerance asks for, and two more."""
    bound, size = allowed(expect), abs(expect.get("value", number)) or abs(number)
    if bound == 0 and float(number).is_integer():
        return f"{number:.0f}"
    if expect.get("value") == 0:
        return "0" if number == 0 else f"{number:.2g}"
    digits = 4 if bound is None else min(15, max(4, math.ceil(math.log10(size / bound)) + 2))
    return f"{number:.{digits}g}"


def quantity(expect):
    step = f" after step {expect['step']}" if "step" in expect else ""
    for measure in ("hertz", "line", "mindlin", "cattaneo", "cone"):
        if measure in expect:
            return f"{MEASURES[measure, expect[measure]]}{step}"
    if "key" in expect:
        text = f"`{expect['key']}`"
        text += f" + `{expect['plus']}`" if "plus" in expect else ""
        return f"({text}) / `{expect['per']}`" if "plus" in expect and "per" in expect else text + (f" / `{expect['per']}`" if "per" in expect else "")
    at = "(" + ", ".join(f"{x:g}" for x in expect["at"]) + ")"
    return f"{expect['field']}{' along ' + 'xyz'[expect['component']] if 'component' in expect else ''} at {at}"


# What the measures of the test are, in words.
MEASURES = {
    ("hertz", "radius_error"): "contact radius from the second moment of the pressure, relative error",
    ("hertz", "centre_error"): "pressure on the axis, relative error",
    ("hertz", "peak_error"): "peak of the nearest semi-ellipsoid of pressure, relative error",
    ("hertz", "area_error"): "contact radius from the area in contact, relative error",
    ("hertz", "mises_error"): "largest stress of von Mises on the axis, relative error",
    ("line", "half_width"): "half width of contact",
    ("line", "width_error"): "half width of contact, relative error",
    ("line", "peak_error"): "largest pressure, relative error",
    ("mindlin", "load"): "tangential force over its limit",
    ("mindlin", "stick_radius"): "radius that sticks over that of contact",
    ("mindlin", "stick_area"): "the same from the points that stick",
    ("mindlin", "traction_error"): "shear traction, relative error in L2",
    ("mindlin", "loop_error"): "energy dissipated in the cycle, relative error",
    ("cattaneo", "half_width"): "half width of contact",
    ("cattaneo", "load"): "tangential force over its limit",
    ("cattaneo", "stick"): "strip that sticks over that of contact",
    ("cattaneo", "traction_error"): "shear traction, relative error in L2",
    ("cattaneo", "loop_error"): "energy dissipated in the cycle, relative error",
    ("cone", "mean_error"): "mean pressure, relative error",
    ("cone", "pressure_error"): "pressure beside the tip, relative error in L2",
}


def escape(text):
    return re.sub(r"([|*_<>\[\]$\\])", r"\\\1", text)
