"""CalculiX's own decks with contact pairs through `stiction solve` and through `ccx`: what is read, and how far the answers agree.

    python3 bench/external/decks.py FOLDER_OF_DECKS [--stiction target/release/stiction] [--only NAME ..] [--jobs-seconds 300]

FOLDER_OF_DECKS holds `.inp` or `.inp.gz`, for instance those of Debian's package calculix-ccx-test. They are copied to a temporary
folder; the copies get `*NODE FILE` with `U` and `*CONTACT PRINT` with `CF` in each step, so that CalculiX writes what is compared.

A row is a deck. `u` is the difference of the displacements over the largest of CalculiX, at the node where it is largest, at the end of
the last step, once with the deck as it is and once without NLGEOM (`small`), as this program has small displacements only; `mean` the same as root of the mean square. `p/K` is the overlap that CalculiX's linear law adds at the largest pressure, over
the same displacement, and `force` the difference of the normal contact forces. `mesh` is the
square of the estimated discretisation error in the energy norm, by which displacements of two kinds of elements may differ. A deck
"differs" where `u` and `mean` exceed 1 % and what law and mesh explain. Needs nothing beside Python and `ccx`.
"""

import argparse
import gzip
import json
import os
import re
import struct
import subprocess
import sys
import tempfile
import zlib
import xml.etree.ElementTree as ElementTree

# Agreement where no penalty enters.
AGREES = 0.01
PLANE_OR_SOLID = r"(?:C3D|CP[ES]|CAX)(\d+)"


def text_of(path):
    opened = gzip.open(path, "rt", errors="replace") if path.endswith(".gz") else open(path, errors="replace")
    with opened as file:
        return file.read()


def cards(text):
    """Keyword, parameters, lines of data."""
    found, continued = [], False
    for line in text.splitlines():
        stripped = line.strip()
        if not stripped or stripped.startswith("**"):
            continue
        if stripped.startswith("*"):
            found.append([stripped, []])
            continued = stripped.endswith(",")
        elif continued:
            found[-1][0] += stripped
            continued = stripped.endswith(",")
        elif found:
            found[-1][1].append(stripped)
    result = []
    for head, data in found:
        words = [word.strip() for word in head.split(",")]
        parameters = {}
        for word in words[1:]:
            key, _, value = word.partition("=")
            parameters[re.sub(r"\s", "", key).upper()] = value.strip()
        result.append((re.sub(r"[\s*]", "", words[0]).upper(), parameters, data))
    return result


def solid_nodes(deck):
    """Labels of the nodes of solid and plane elements in the order of the file: the first points of result.vtu."""
    labels, used = [], set()
    for name, parameters, data in deck:
        if name == "NODE":
            labels += [int(line.split(",")[0]) for line in data]
        elif name == "ELEMENT" and re.match(PLANE_OR_SOLID, parameters.get("TYPE", "").upper()):
            numbers = [int(word) for line in data for word in line.split(",") if word.strip()]
            size = int(re.match(PLANE_OR_SOLID, parameters["TYPE"].upper()).group(1)) + 1
            for i in range(0, len(numbers), size):
                used.update(numbers[i + 1 : i + size])
    return [label for label in labels if label in used]


def cut_nodes(deck):
    """Nodes of the sections of bolts: of the two sides of a cut each program keeps another under the number of the deck."""
    surfaces = {p.get("SURFACE", "").upper() for name, p, _ in deck if name == "PRE-TENSIONSECTION"}
    sides = [line for name, p, data in deck if name == "SURFACE" and p.get("NAME", "").upper() in surfaces for line in data]
    elements, sets, found = {}, {}, set()
    for name, p, data in deck:
        numbers = [word.strip() for line in data for word in line.split(",") if word.strip()]
        if name == "ELEMENT":
            size = int(re.sub(r"\D+", " ", p["TYPE"]).split()[-1]) + 1
            here = [int(numbers[i]) for i in range(0, len(numbers), size)]
            elements |= {label: [int(n) for n in numbers[size * k + 1 : size * k + size]] for k, label in enumerate(here)}
            sets.setdefault(p.get("ELSET", "").upper(), []).extend(here)
        elif name == "ELSET" and "GENERATE" not in p:
            sets.setdefault(p["ELSET"].upper(), []).extend(int(word) for word in numbers if word.isdigit())
    for line in sides:
        of = line.split(",")[0].strip()
        for element in [int(of)] if of.isdigit() else sets.get(of.upper(), []):
            found.update(elements.get(element, []))
    return found


def asking(text, deck):
    """The deck that asks CalculiX for displacements and contact forces."""
    pairs = [line.split(",")[:2] for name, p, data in deck if name == "CONTACTPAIR" and "SURFACE TO" in p.get("TYPE", "").upper()
             for line in data]
    # CalculiX ends where it is asked for the forces of a pair that is taken out.
    out, asked = set(), []
    for name, parameters, data in deck:
        if name == "MODELCHANGE":
            changed = {tuple(word.strip().upper() for word in line.split(",")[:2]) for line in data}
            out = out - changed if "ADD" in parameters else out | changed
        if name == "ENDSTEP":
            asked.append("*NODE FILE\nU\n")
            for slave, master in pairs:
                if (slave.strip().upper(), master.strip().upper()) not in out:
                    asked[-1] += f"*CONTACT PRINT,SLAVE={slave.strip()},MASTER={master.strip()}\nCF\n"
    more = iter(asked)
    return re.sub(r"(?im)^\s*\*\s*end\s*step", lambda m: next(more) + m.group(0), text)


def harder(text, factor):
    """The deck with the stiffness of its linear laws and its stick slopes times a factor."""
    def scaled(place):
        def one(match):
            fields = match.group(2).split(",")
            if len(fields) > place and fields[place].strip():
                fields[place] = repr(float(fields[place]) * factor)
            return match.group(1) + ",".join(fields)
        return one
    text = re.sub(r"(?im)(^\s*\*\s*surface\s*behavior[^\n]*linear[^\n]*\n)([^\n]*)", scaled(0), text)
    return re.sub(r"(?im)(^\s*\*\s*friction[^\n]*\n)([^\n]*)", scaled(1), text)


def displacements_of_ccx(path):
    """Displacements at the end of the last step, by label."""
    found, now = {}, None
    with open(path, errors="replace") as file:
        for line in file:
            if line.startswith(" -4"):
                now = {} if line[5:9] == "DISP" else None
            elif line.startswith(" -1") and now is not None:
                now[int(line[3:13])] = [float(line[13 + 12 * i : 25 + 12 * i]) for i in range(3)]
            elif line.startswith(" -3") and now:
                found, now = now, None
    return found


def ccx(job, text, folder, seconds):
    """Displacements that CalculiX finds; nothing where it finds none."""
    with open(os.path.join(folder, job + ".inp"), "w") as file:
        file.write(text)
    try:
        with open(os.path.join(folder, job + ".log"), "w") as log:
            subprocess.run(["ccx", job], cwd=folder, stdout=log, stderr=log, timeout=seconds)
        return displacements_of_ccx(os.path.join(folder, job + ".frd"))
    except (subprocess.TimeoutExpired, OSError):
        return {}


def forces_of_ccx(path):
    """Sizes of the normal forces of the last step, added over the pairs; None where it writes none."""
    total, lines = None, open(path, errors="replace").read().splitlines()
    blocks = [i for i, line in enumerate(lines) if "statistics for slave set" in line]
    times = [re.search(r"time\s+(\S+)", lines[i]).group(1) for i in blocks]
    for i, time in zip(blocks, times):
        if time != times[-1]:
            continue
        k = next(k for k in range(i, len(lines)) if re.search(r"area,\s+normal force", lines[k]))
        total = (total or 0.0) + abs(float(lines[k + 2].split()[1]))
    return total


def array(path, name):
    """An array of points of a .vtu of this program: compressed, appended, raw."""
    data = open(path, "rb").read()
    start = data.index(b'<AppendedData encoding="raw">')
    head = ElementTree.fromstring(data[:start] + b"</VTKFile>")
    raw = data[data.index(b"_", start) + 1 :]
    for item in head.iter("DataArray"):
        if item.get("Name") == name:
            at = int(item.get("offset"))
            blocks, size, last = struct.unpack_from("<3Q", raw, at)
            sizes = struct.unpack_from(f"<{blocks}Q", raw, at + 24)
            at, out = at + 24 + 8 * blocks, b""
            for length in sizes:
                out += zlib.decompress(raw[at : at + length])
                at += length
            kind = {"Float64": "d", "Float32": "f"}[item.get("type")]
            values = struct.unpack(f"<{len(out) // struct.calcsize(kind)}{kind}", out)
            count = int(item.get("NumberOfComponents", "1"))
            return [values[i : i + count] for i in range(0, len(values), count)]
    raise KeyError(name)


def last_result(folder):
    found = sorted(name for name in os.listdir(folder) if re.fullmatch(r"result(-\d+)?\.vtu", name))
    return os.path.join(folder, found[-1])


def stiffness(deck):
    """The smallest K of a linear law; None where contact is hard."""
    found = []
    for name, parameters, data in deck:
        if name == "SURFACEBEHAVIOR" and parameters.get("PRESSURE-OVERCLOSURE", "").upper() == "LINEAR" and data:
            found.append(float(data[0].split(",")[0]))
    return min(found) if found else None


def compare(name, text, arguments, folder):
    """Status and what else the table says of a deck."""
    deck = cards(text)
    path = os.path.join(folder, name + ".inp")
    with open(path, "w") as file:
        file.write(text)
    results = os.path.join(folder, name + "-results")
    command = [arguments.stiction, "solve", path, "-o", results, "--no-report", "--no-pictures", "--progress", "none"]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=arguments.seconds)
    except subprocess.TimeoutExpired:
        return "too long", f"more than {arguments.seconds} s"
    said = run.stderr.strip().splitlines()
    if run.returncode == 2:
        line = next((line for line in said if line.startswith("error: ")), said[0] if said else "")
        return "refused", re.sub(r"^error: \S*?\.inp, ", "", line)
    if run.returncode != 0:
        warned = next((line for line in said if line.startswith("warning: ")), "")
        return "unsolved", warned[:120] or f"exit code {run.returncode}"
    ours = dict(zip(solid_nodes(deck), array(last_result(results), "displacement")))
    cut, ties = cut_nodes(deck), {p.get("NAME", "tie").upper() for card, p, _ in deck if card == "TIE"}
    asked, size, said, agreement = asking(text, deck), None, [], None
    straight = re.sub(r"(?i),\s*nlgeom(\s*=\s*yes)?", "", asked)
    variants = [("u", asked)]
    if straight != asked:
        variants.append(("small", straight))
    if arguments.harder and stiffness(deck):
        variants.append((f"K x {arguments.harder:g}", harder(straight, arguments.harder)))
    for number, (what, text) in enumerate(variants):
        job = f"{name}_ccx" + (f"_{number}" if number else "")
        theirs = ccx(job, text, folder, arguments.seconds)
        if not theirs:
            said.append(f"{what}: ccx has no answer")
            continue
        common = [label for label in ours if label in theirs and label not in cut]
        size = max(sum(x * x for x in theirs[label]) ** 0.5 for label in common)
        differences = [sum((a - b) ** 2 for a, b in zip(ours[label], theirs[label])) ** 0.5 for label in common]
        worst, mean = max(differences) / size, (sum(d * d for d in differences) / len(differences)) ** 0.5 / size
        said.append(f"{what} {100 * worst:.2f} %, mean {100 * mean:.2f} %")
        agreement = min(worst, mean) if agreement is None else min(agreement, worst, mean)
    if agreement is None:
        return "solved", "; ".join(said)
    with open(os.path.join(results, "summary.json")) as file:
        summary = json.load(file)
    pairs = summary.get("pairs") or []
    pressure = max((pair.get("max_pressure") or 0.0 for pair in pairs), default=0.0)
    force = sum(pair["normal_force"] for pair in pairs if pair["name"].upper() not in ties)
    theirs_force = forces_of_ccx(os.path.join(folder, name + "_ccx.dat"))
    K = stiffness(deck)
    law = pressure / K / size if K else 0.0
    mesh = (summary.get("discretisation_error") or 0.0) ** 2
    said.append(f"mesh {100 * mesh:.2f} %")
    if K:
        said.append(f"p/K {100 * law:.2f} %")
    # Those of plane stress are forces of a thin layer; a force that is not a number is none.
    if theirs_force and theirs_force == theirs_force and not re.search(r"(?i)type\s*=\s*CPS", text):
        said.append(f"force {force:.5g} ({100 * (force / theirs_force - 1):+.2f} %)")
    return ("solved" if agreement <= AGREES + law + mesh else "differs"), "; ".join(said)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder")
    parser.add_argument("--stiction", default="target/release/stiction")
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--seconds", type=float, default=300)
    parser.add_argument("--harder", type=float, help="a column for CalculiX with linear laws so many times as stiff")
    parser.add_argument("--keep", help="folder for decks and results; a temporary one if absent")
    arguments = parser.parse_args()
    arguments.stiction = os.path.abspath(arguments.stiction)
    folder = arguments.keep or tempfile.mkdtemp()
    os.makedirs(folder, exist_ok=True)
    counts = {}
    print(f"| {'deck':<20} | {'':<8} | |\n|---|---|---|")
    for file in sorted(os.listdir(arguments.folder)):
        name = re.sub(r"\.inp(\.gz)?$", "", file)
        if name == file or arguments.only and name not in arguments.only:
            continue
        text = text_of(os.path.join(arguments.folder, file))
        if not re.search(r"(?im)^\s*\*\s*contact\s*pair", text):
            continue
        status, said = compare(name, text, arguments, folder)
        counts[status] = counts.get(status, 0) + 1
        print(f"| {name:<20} | {status:<8} | {said} |", flush=True)
    print("\n" + ", ".join(f"{count} {status}" for status, count in sorted(counts.items())))
    return 1 if counts.get("differs") else 0


if __name__ == "__main__":
    sys.exit(main())
