"""Own assembly of K, f and the contact rows on obstacles of a case with tet4 and hex8 blocks, from its text alone."""

import math
import tomllib

import numpy as np
from scipy import sparse

FIVE = [[[1, 2, 4, 7], [0, 1, 2, 4], [3, 2, 1, 7], [5, 1, 4, 7], [6, 4, 2, 7]],
        [[0, 5, 3, 6], [1, 3, 0, 5], [2, 0, 3, 6], [4, 5, 0, 6], [7, 3, 5, 6]]]
SIGNS = np.array([[2 * (b & 1) - 1, 2 * (b >> 1 & 1) - 1, 2 * (b >> 2) - 1] for b in range(8)], float)
AXES = {"x": 0, "y": 1, "z": 2}


def value(expression, t):
    """A number, or an expression in t."""
    if not isinstance(expression, str):
        return float(expression)
    names = {"t": t, "min": min, "max": max, "sin": math.sin, "pi": math.pi}
    return float(eval(expression, {"__builtins__": {}}, names))


def axis(low, size, n, grading):
    """Places of the nodes along one axis, whose last cell is `grading` times as long as the first."""
    ratio = grading ** (1 / (n - 1)) if n > 1 else 1.0
    lengths = ratio ** np.arange(n)
    return low + size * np.concatenate([[0], np.cumsum(lengths) / lengths.sum()])


class Part:
    """Nodes, cells and faces of a block; node numbers begin with `first`."""

    def __init__(self, spec, first):
        block = spec["block"]
        n, low, size = block["cells"], block.get("origin", [0, 0, 0]), block["size"]
        axes = [axis(low[c], size[c], n[c], block.get("grading", [1, 1, 1])[c]) for c in range(3)]
        z, y, x = np.meshgrid(axes[2], axes[1], axes[0], indexing="ij")
        index = np.stack(np.meshgrid(*[np.arange(n[c] + 1) for c in (2, 1, 0)], indexing="ij"), -1).reshape(-1, 3)[:, ::-1]
        self.nodes = np.stack([x, y, z], -1).reshape(-1, 3)
        self.tets = block["element"] == "tet4"
        corner = lambda i, j, k, b: i + (b & 1) + (n[0] + 1) * (j + (b >> 1 & 1) + (n[1] + 1) * (k + (b >> 2)))
        cells, sides = [], {}
        for k in range(n[2]):
            for j in range(n[1]):
                for i in range(n[0]):
                    pieces = FIVE[(i + j + k) % 2] if self.tets else [range(8)]
                    cells += [[corner(i, j, k, b) for b in piece] for piece in pieces]
        self.cells = np.array(cells)
        for c, name in enumerate("xyz"):
            for end, at in (("min", 0), ("max", n[c])):
                on = index[:, c] == at
                faces = []
                for cell in self.cells[on[self.cells].sum(1) >= (3 if self.tets else 4)]:
                    faces.append([node for node in cell if on[node]])
                sides[f"{name}-{end}"] = np.array(faces) + first
        self.sides = sides
        if turn := spec.get("turn"):
            a, point = math.radians(turn["degrees"]), np.array(turn["point"], float)
            rotation = np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])
            self.nodes = (self.nodes - point) @ rotation.T + point
        self.first = first


def stiffness(x, young, poisson, tets):
    """Stiffness of cells with corners `x` (cells, nodes, 3), and their volumes."""
    lame, shear = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))
    if tets:
        inverse = np.linalg.inv(np.concatenate([np.ones((*x.shape[:2], 1)), x], 2))
        points = [(inverse[:, 1:, :].transpose(0, 2, 1), np.abs(np.linalg.det(x[:, 1:] - x[:, :1])) / 6)]
    else:
        points = []
        for s in SIGNS / math.sqrt(3):
            factors = 1 + SIGNS * s
            slope = SIGNS / 8 * np.stack([factors[:, 1] * factors[:, 2], factors[:, 0] * factors[:, 2],
                                          factors[:, 0] * factors[:, 1]], 1)
            jacobian = np.einsum("na,cnb->cab", slope, x)
            points.append((np.einsum("na,cba->cnb", slope, np.linalg.inv(jacobian)), np.linalg.det(jacobian)))
    nodes = x.shape[1]
    K, volume = np.zeros((len(x), nodes, 3, nodes, 3)), np.zeros(len(x))
    for g, w in points:
        volume += w
        K += lame * np.einsum("c,cia,cjb->ciajb", w, g, g) + shear * np.einsum("c,cib,cja->ciajb", w, g, g)
        K += shear * np.einsum("c,cij,ab->ciajb", w, np.einsum("cik,cjk->cij", g, g), np.eye(3))
    return K.reshape(len(x), 3 * nodes, 3 * nodes), volume


def face_area(x):
    """Area of a triangle or of a parallelogram whose corners are in the order of a grid."""
    area = np.linalg.norm(np.cross(x[1] - x[0], x[2] - x[0]))
    return area / 2 if len(x) == 3 else area


class Assembly:
    """The whole body without contact at time `t`: K and f over all degrees of freedom, and what is prescribed."""

    def __init__(self, text):
        self.case = tomllib.loads(text)
        self.parts, first = {}, 0
        for name, spec in self.case["mesh"]["parts"].items():
            self.parts[name] = Part(spec, first)
            first += len(self.parts[name].nodes)
        self.x = np.concatenate([part.nodes for part in self.parts.values()])
        self.body = np.repeat(np.arange(len(self.parts)), [len(part.nodes) for part in self.parts.values()])
        rows, columns, values = [], [], []
        self.weight = np.zeros(len(self.x))
        for name, part in self.parts.items():
            material = self.case["materials"][name]
            K, volume = stiffness(part.nodes[part.cells], material["young"], material["poisson"], part.tets)
            cells = part.cells + part.first
            dofs = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), -1)
            rows.append(np.repeat(dofs, dofs.shape[1], 1).ravel())
            columns.append(np.tile(dofs, (1, dofs.shape[1])).ravel())
            values.append(K.ravel())
            share = material.get("density", 0) * volume / cells.shape[1]
            np.add.at(self.weight, cells, np.repeat(share[:, None], cells.shape[1], 1))
        for spring in self.case.get("spring", []):
            faces = self.side(spring["on"])
            for face in faces:
                x = self.x[face]
                normal = np.cross(x[1] - x[0], x[2] - x[0])
                normal /= np.linalg.norm(normal)
                along = np.outer(normal, normal)
                per_area = spring.get("normal", 0) * along + spring.get("tangential", 0) * (np.eye(3) - along)
                if len(face) == 3:
                    mass = (np.ones((3, 3)) + np.eye(3)) / 12
                else:
                    line = np.array([[2, 1], [1, 2]]) / 6
                    mass = np.kron(line, line)
                block = np.einsum("ij,ab->iajb", face_area(x) * mass, per_area).reshape(3 * len(face), -1)
                dofs = (3 * face[:, None] + np.arange(3)).ravel()
                rows.append(np.repeat(dofs, len(dofs)))
                columns.append(np.tile(dofs, len(dofs)))
                values.append(block.ravel())
        size = 3 * len(self.x)
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        self.K = sparse.csr_matrix(entries, (size, size))

    def side(self, group):
        part, side = group.split(".")
        return self.parts[part].sides[side]

    def areas(self, faces):
        """What each node of flat faces stands for."""
        area = np.zeros(len(self.x))
        for face in faces:
            area[face] += face_area(self.x[face]) / len(face)
        return area

    def forces(self, t):
        f = np.zeros((len(self.x), 3))
        for load in self.case.get("load", []):
            if "gravity" in load:
                f += self.weight[:, None] * np.array([value(g, t) for g in load["gravity"]])
                continue
            areas = self.areas(self.side(load["on"]))[:, None]
            if "pressure" in load:
                f += areas * np.array([0, 0, -value(load["pressure"], t)])
            else:
                f += areas * np.array([value(v, t) for v in load["traction"]])
        return f.ravel()

    def prescribed(self, t):
        """Values of the degrees of freedom that are prescribed, NaN elsewhere."""
        d = np.full(3 * len(self.x), np.nan)
        for fix in self.case.get("fix", []):
            components = fix.get("components", "xyz")
            values = fix.get("value", [0] * len(components))
            for c, v in zip(components, values):
                d[3 * np.unique(self.side(fix["on"])) + AXES[c]] = value(v, t)
        return d
