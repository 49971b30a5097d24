"""A case of `bench/assemblies` as a deck for CalculiX: the same meshes, loads, bolts, contacts and load steps.

    python3 bench/external/calculix.py CASE.toml DECK.inp

Contact is "surface to surface" with a linear penalty of 20 times the largest modulus per millimetre, friction with a stick slope of a
hundredth of it; bolts are pre-tension sections. It knows what the assemblies use, no more.
"""

import math
import os
import sys
import tomllib

import gmsh
import numpy as np

# Nodes of the faces of a tetrahedron, counted as CalculiX does.
FACES = [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)]
# Points and weights of the six-point rule on a triangle, exact for polynomials of degree four.
A, B, V, W = 0.445948490915965, 0.091576213509771, 0.223381589678011, 0.109951743655322
POINTS = [(A, A, V), (A, 1 - 2 * A, V), (1 - 2 * A, A, V), (B, B, W), (B, 1 - 2 * B, W), (1 - 2 * B, B, W)]


def value(expression, t, x=0.0, y=0.0, z=0.0):
    if not isinstance(expression, str):
        return float(expression)
    names = {"t": t, "x": x, "y": y, "z": z, "max": max, "min": min, "abs": abs, "sqrt": math.sqrt, "pi": math.pi}
    return float(eval(expression.replace("^", "**"), {"__builtins__": {}}, names))


def names(region):
    return [region] if isinstance(region, str) else region


def placed(x, part):
    """Scaled, turned and moved as the case file says."""
    x = x * part.get("scale", 1.0)
    if "turn" in part:
        axis = np.array(part["turn"]["axis"], float)
        axis /= np.linalg.norm(axis)
        a, point = math.radians(part["turn"]["degrees"]), np.array(part["turn"].get("point", [0, 0, 0]), float)
        r = x - point
        along = np.outer(r @ axis, axis)
        x = point + along + math.cos(a) * (r - along) + math.sin(a) * np.cross(axis, r)
    return x + np.array(part.get("move", [0, 0, 0]), float)


class Mesh:
    """All parts together: nodes and tetrahedra from one on, groups of cells and of triangles by `part.group`."""

    def __init__(self, case, folder):
        self.x, self.cells, self.of, self.triangles = [], [], {}, {}
        nodes = cells = 0
        for name, part in case["mesh"]["parts"].items():
            gmsh.initialize(interruptible=False)
            gmsh.option.setNumber("General.Terminal", 0)
            gmsh.open(os.path.join(folder, part["file"]))
            tags, x, _ = gmsh.model.mesh.getNodes()
            number = np.zeros(int(tags.max()) + 1, int)
            number[tags] = np.arange(nodes + 1, nodes + len(tags) + 1)
            self.x.append(placed(x.reshape(-1, 3), part))
            begin = cells
            for d, tag in gmsh.model.getPhysicalGroups():
                group, kind = f"{name}.{gmsh.model.getPhysicalName(d, tag)}", {2: 9, 3: 11}[d]
                found = []
                for entity in gmsh.model.getEntitiesForPhysicalGroup(d, tag):
                    found.append(number[gmsh.model.mesh.getElementsByType(kind, entity)[1]].reshape(-1, {2: 6, 3: 10}[d]))
                found = np.concatenate(found)
                if d == 2:
                    self.triangles[group] = found
                else:
                    # Gmsh has the last two middles the other way round.
                    self.cells.append(found[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]])
                    self.of[group] = (cells + 1, cells + len(found))
                    cells += len(found)
            self.of[name] = (begin + 1, cells)
            nodes += len(tags)
            gmsh.finalize()
        self.x, self.cells = np.concatenate(self.x), np.concatenate(self.cells)
        used = np.zeros(len(self.x) + 1, bool)
        used[self.cells] = True
        self.used = used
        self.face = {}
        for s, corners in enumerate(FACES):
            for cell, key in enumerate(np.sort(self.cells[:, corners], axis=1).tolist()):
                self.face.setdefault(tuple(key), []).append((cell + 1, s + 1))

    def faces(self, group):
        """Element and face of each triangle; of the two sides of a section the one in the cell that comes first."""
        return [min(self.face[tuple(sorted(t[:3]))]) for t in self.triangles[group].tolist()]

    def side(self, group, axis):
        """The faces of a section that belong to the cells behind it along the axis."""
        found = []
        for t in self.triangles[group].tolist():
            middle = self.x[np.array(t[:3]) - 1].mean(axis=0)
            for cell, s in self.face[tuple(sorted(t[:3]))]:
                if (self.x[self.cells[cell - 1, :4] - 1].mean(axis=0) - middle) @ axis < 0:
                    found.append((cell, s))
        return found

    def points(self, triangles):
        """Nodes, their shape functions, place and normal times weight at the points of the rule, outwards or not."""
        X = self.x[triangles - 1]
        for r, s, w in POINTS:
            l = 1 - r - s
            N = np.array([l * (2 * l - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * l * r, 4 * r * s, 4 * s * l])
            dr = np.array([1 - 4 * l, 4 * r - 1, 0, 4 * (l - r), 4 * s, -4 * s])
            ds = np.array([1 - 4 * l, 0, 4 * s - 1, -4 * r, 4 * r, 4 * (l - s)])
            place = np.einsum("k,ekd->ed", N, X)
            normal = np.cross(np.einsum("k,ekd->ed", dr, X), np.einsum("k,ekd->ed", ds, X)) * w / 2
            yield N, place, normal

    def shift(self, groups, distance):
        """Moves a surface outwards: an interference as a part that is too large."""
        triangles = np.concatenate([self.triangles[g] for g in groups])
        sign, normals = self.outwards(triangles), np.zeros_like(self.x)
        for N, _, normal in self.points(triangles):
            for k in range(6):
                np.add.at(normals, triangles[:, k] - 1, abs(N[k]) * sign[:, None] * normal)
        nodes = np.unique(triangles) - 1
        self.x[nodes] += distance * normals[nodes] / np.linalg.norm(normals[nodes], axis=1)[:, None]

    def outwards(self, triangles):
        """The sign that turns the normals of triangles out of their cells."""
        sign = []
        for t in triangles.tolist():
            cell = self.face[tuple(sorted(t[:3]))][0][0]
            a, b, c = self.x[np.array(t[:3]) - 1]
            sign.append(np.sign(np.cross(b - a, c - a) @ (a - self.x[self.cells[cell - 1, :4] - 1].mean(axis=0))))
        return np.array(sign)


def forces(mesh, load, t):
    """Nodal forces of a load at the time t, spread as the program spreads them."""
    triangles = np.concatenate([mesh.triangles[g] for g in names(load["on"])])
    F = np.zeros_like(mesh.x)
    rule = list(mesh.points(triangles))
    weight = [np.linalg.norm(n, axis=1) for _, _, n in rule]
    if "pressure" in load:
        sign = mesh.outwards(triangles)
        tractions = []
        for _, place, normal in rule:
            p = np.array([value(load["pressure"], t, *x) for x in place])
            tractions.append(-p[:, None] * sign[:, None] * normal)
    else:
        area = sum(w.sum() for w in weight)
        centre = sum((w[:, None] * p).sum(axis=0) for w, (_, p, _) in zip(weight, rule)) / area
        inertia = np.zeros((3, 3))
        for w, (_, p, _) in zip(weight, rule):
            r = p - centre
            inertia += np.einsum("e,e,ij->ij", w, (r * r).sum(axis=1), np.eye(3)) - np.einsum("e,ei,ej->ij", w, r, r)
        a = np.array([value(v, t) for v in load.get("force", [0, 0, 0])]) / area
        b = np.linalg.solve(inertia, np.array([value(v, t) for v in load.get("moment", [0, 0, 0])]))
        tractions = [w[:, None] * (a + np.cross(b, p - centre)) for w, (_, p, _) in zip(weight, rule)]
    for (N, _, _), traction in zip(rule, tractions):
        for k in range(6):
            np.add.at(F, triangles[:, k] - 1, N[k] * traction)
    return F


def lines(items, count=8):
    items = [str(i) for i in items]
    return "\n".join(", ".join(items[i : i + count]) for i in range(0, len(items), count))


def times(case):
    """The end of each increment, with the name of its step."""
    begin, found = 0.0, []
    for step in case.get("step", [{"until": 1}]):
        n = step.get("increments", 1)
        found += [(begin + (step["until"] - begin) * (i + 1) / n, step.get("name")) for i in range(n)]
        begin = step["until"]
    return found


def deck(case, folder, file):
    mesh = Mesh(case, folder)
    write = lambda *text: print(*text, sep="\n", file=file)
    for contact in case["contact"]:
        if isinstance(contact.get("gap"), (int, float)):
            mesh.shift(names(contact["on"]), -contact["gap"])
    write("*NODE, NSET=ALL")
    for i, x in enumerate(mesh.x):
        if mesh.used[i + 1]:
            write(f"{i + 1}, {x[0]:.10g}, {x[1]:.10g}, {x[2]:.10g}")
    write("*ELEMENT, TYPE=C3D10, ELSET=CELLS")
    for i, cell in enumerate(mesh.cells):
        write(f"{i + 1}, " + ", ".join(map(str, cell)))
    stiffest = max(m["young"] for m in case["materials"].values())
    for i, material in enumerate(case["materials"].values()):
        write(f"*ELSET, ELSET=M{i}, GENERATE")
        for name in names(material.get("on", list(case["mesh"]["parts"]))):
            write("{}, {}, 1".format(*mesh.of[name]))
        write(f"*MATERIAL, NAME=M{i}", "*ELASTIC", f"{material['young']}, {material['poisson']}")
        write(f"*SOLID SECTION, ELSET=M{i}, MATERIAL=M{i}")
    for i, contact in enumerate(case["contact"]):
        for side, region in (("S", contact["on"]), ("T", contact["against"])):
            write(f"*SURFACE, NAME={side}{i}, TYPE=ELEMENT")
            for name in names(region):
                write(*(f"{cell}, S{s}" for cell, s in mesh.faces(name)))
        write(f"*SURFACE INTERACTION, NAME=I{i}", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR")
        write(f"{20 * stiffest:.6g}, 1e-3, 1e-4")
        write("*FRICTION", f"{contact['friction']['coulomb']}, {0.2 * stiffest:.6g}")
        write(f"*CONTACT PAIR, INTERACTION=I{i}, TYPE=SURFACE TO SURFACE", f"S{i}, T{i}")
    bolts = case.get("bolt", [])
    for i, bolt in enumerate(bolts):
        triangles = mesh.triangles[bolt["on"]]
        axis = sum(normal.sum(axis=0) for _, _, normal in mesh.points(triangles[:1]))
        axis /= np.linalg.norm(axis)
        node = len(mesh.x) + 1 + i
        write("*NODE", f"{node}, " + ", ".join(f"{c:.10g}" for c in mesh.x[triangles[0, 0] - 1]))
        write(f"*SURFACE, NAME=B{i}, TYPE=ELEMENT", *(f"{cell}, S{s}" for cell, s in mesh.side(bolt["on"], axis)))
        write(f"*PRE-TENSION SECTION, SURFACE=B{i}, NODE={node}", ", ".join(f"{c:.10g}" for c in axis))
    locked, frozen = set(), set()
    for k, (t, name) in enumerate(times(case)):
        write("*STEP, INC=200", "*STATIC", "0.25, 1.0, 1e-6, 1.0")
        for i in locked - frozen:
            write("*BOUNDARY, FIXED", f"{len(mesh.x) + 1 + i}, 1, 1")
        frozen |= locked
        moving = [fix for fix in case["fix"] if k == 0 or any(isinstance(v, str) for v in fix.get("value", []))]
        if moving:
            write("*BOUNDARY")
        for fix in moving:
            nodes = np.unique(np.concatenate([mesh.triangles[g] for g in names(fix["on"])]))
            for c in fix.get("components", "xyz"):
                d = "xyz".index(c)
                for node in nodes:
                    u = value(fix["value"][d], t, *mesh.x[node - 1]) if "value" in fix else 0
                    write(f"{node}, {d + 1}, {d + 1}, {u:.10g}")
        F = sum((forces(mesh, load, t) for load in case.get("load", [])), np.zeros_like(mesh.x))
        write("*CLOAD, OP=MOD")
        for node in np.flatnonzero(np.abs(F).max(axis=1) > 0):
            write(*(f"{node + 1}, {d + 1}, {F[node, d]:.10g}" for d in range(3)))
        for i, bolt in enumerate(bolts):
            if i not in locked:
                write(f"{len(mesh.x) + 1 + i}, 1, {value(bolt['force'], t):.10g}")
        write("*NODE FILE, FREQUENCY=1000", "U", "*NODE PRINT, NSET=ALL, TOTALS=ONLY, FREQUENCY=1000", "RF")
        write("*END STEP")
        last = k + 1 == len(times(case)) or times(case)[k + 1][1] != name
        for i, bolt in enumerate(bolts):
            if last and bolt.get("lock") == name and i not in locked:
                locked.add(i)


def main():
    path, out = sys.argv[1:]
    with open(path, "rb") as file:
        case = tomllib.load(file)
    with open(out, "w") as file:
        deck(case, os.path.dirname(os.path.abspath(path)), file)


if __name__ == "__main__":
    main()
