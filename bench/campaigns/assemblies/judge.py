"""Judges answers to random assemblies by code that shares nothing with the program: its own K, f and obstacle rows, its own
measures. Rows between bodies are read, and held against geometry. See README.md."""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from scipy import sparse

from assembly import Assembly

POSED = 1e-10       # the posed problem, in its own largest terms
ANSWER = 1e-6       # a measure above this is a false success
BATCH = 200
NONE, GIVEN, COULOMB, BONDED, LIMITED = range(5)


def csr(file, name, columns):
    start = file[f"{name}_start"]
    return sparse.csr_matrix((file[f"{name}_value"], file[f"{name}_column"], start), (len(start) - 1, columns))


def ratio(error, scale):
    error = float(np.max(np.abs(error), initial=0.0))
    return 0.0 if error == 0.0 else error / max(float(scale), 1e-300)


def convex_overlap(a, b):
    """Area in which two convex polygons with counterclockwise corners overlap."""
    for p, q in zip(b, np.roll(b, -1, 0)):
        side = (q[0] - p[0]) * (a[:, 1] - p[1]) - (q[1] - p[1]) * (a[:, 0] - p[0])
        kept = []
        for i in range(len(a)):
            j = (i + 1) % len(a)
            if side[i] >= 0:
                kept.append(a[i])
            if side[i] * side[j] < 0:
                kept.append(a[i] + side[i] / (side[i] - side[j]) * (a[j] - a[i]))
        if len(kept) < 3:
            return 0.0
        a = np.array(kept)
    x, y = (a - a[0]).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def outline(x):
    """The corners of a rectangle of nodes in the plane, counterclockwise."""
    middle = 0.5 * (x[0] + x[-1])
    centred = x - middle
    # The first and the last node are opposite corners, and the nodes farthest from their line the other two.
    far = centred[0]
    other = centred[np.argmax(np.abs(far[0] * centred[:, 1] - far[1] * centred[:, 0]))]
    corners = np.array([far, other, -far, -other])
    corners = corners[np.argsort(np.arctan2(corners[:, 1], corners[:, 0]))]
    return corners + middle


class Judge:
    def __init__(self, text):
        self.own = Assembly(text)
        self.slid = None

    def obstacle_rows(self, contact, d):
        """Nodes that may touch, with distance, unit normal towards the obstacle and area."""
        faces = self.own.side(contact["on"])
        nodes = np.unique(faces)
        x, area = self.own.x[nodes], self.own.areas(faces)[nodes]
        if plane := contact["against"].get("plane"):
            away = np.tile(np.array(plane["normal"], float) / np.linalg.norm(plane["normal"]), (len(nodes), 1))
            distance = np.einsum("ij,ij->i", x - plane["point"], away)
        else:
            sphere = contact["against"]["sphere"]
            arm = x - np.array(sphere["center"], float)
            length = np.linalg.norm(arm, axis=1)
            away, distance = arm / length[:, None], length - sphere["radius"]
        free = np.isnan(d.reshape(-1, 3)[nodes])
        keep = np.linalg.norm(np.where(free, away, 0), axis=1) >= 1e-8
        return nodes[keep], distance[keep], -away[keep], area[keep]

    def posed(self, file, t):
        """Differences between the posed problem and our own, and the problem over all degrees of freedom."""
        own, errors = self.own, {}
        d = own.prescribed(t)
        free, fixed = np.flatnonzero(np.isnan(d)), np.flatnonzero(~np.isnan(d))
        n, m = len(free), len(file["gap"])
        d = np.nan_to_num(d)
        if len(file["f"]) != n:
            return {"unknowns": 1.0}, None
        errors["nodes"] = float(np.any(file["node_of"] != free // 3))
        lower = csr(file, "K_lower", n)
        K = lower + lower.T - sparse.diags(lower.diagonal())
        ours = own.K[free][:, free]
        scale = sparse.diags(1 / np.sqrt(ours.diagonal()))
        difference = scale @ (K - ours) @ scale
        errors["K"] = float(np.max(np.abs(difference.data), initial=0.0))
        external = own.forces(t)
        demanded = own.K[free][:, fixed] @ d[fixed]
        f = external[free] - demanded
        terms = np.abs(own.K[free][:, fixed]) @ np.abs(d[fixed])
        errors["f"] = ratio(file["f"] - f, max(np.max(np.abs(external), initial=0), np.max(terms, initial=0)))

        # Rows over all degrees of freedom.
        all_rows = sparse.lil_matrix((3 * m, 3 * len(own.x)))
        all_rows[:, free] = csr(file, "B", n)
        held = csr(file, "support_B", len(fixed)) if "support_B_start" in file else sparse.csr_matrix((3 * m, len(fixed)))
        all_rows[:, fixed] = held
        B = all_rows.tocsr()
        imposed = held @ d[fixed]
        rows = B.toarray().reshape(3, m, len(own.x), 3)
        extent = np.ptp(own.x, axis=0).max()
        bound, law, across = file["friction_value"], file["friction_law"], file.get("friction_across", np.ones(m))
        pairs, begin = bytes(file["pair_names"]).decode().split("\n"), 0
        contacts = {c["on"]: c for c in own.case["contact"]}
        worst = dict.fromkeys(["rows", "gap", "law", "resultant", "moment", "area"], 0.0)
        ranges = []
        for name, end in zip(pairs, file["pair_ends"]):
            contact = contacts[name.removesuffix("-held")]
            span, begin = slice(begin, int(end)), int(end)
            touched = np.abs(R0).sum(2) > 0 if (R0 := rows[0, span]).size else np.zeros((0, len(own.x)), bool)
            ranges.append((touched, span, contact))
            gap = file["gap"][span] + imposed[:m][span]     # before any displacement
            R, area = rows[:, span], file["area"][span]
            if isinstance(contact["against"], dict):
                self.judge_obstacle(contact, R, gap, area, law[span], own.prescribed(t), worst, extent)
            else:
                self.judge_bodies(contact, R, gap, law[span], worst, extent)
            self.judge_law(contact, law[span], bound[span], file["friction_limit"][span], across[span], area, R, worst)
        for contact in contacts.values():
            if isinstance(contact["against"], str):
                self.judge_area(contact, ranges, file, worst)
        errors.update(worst)
        # The slip starts where the last step ended, less what is imposed now.
        reference = -imposed[m:] if self.slid is None else self.slid - imposed[m:]
        errors["slip_reference"] = ratio(file["slip_reference"] - reference, np.abs(reference).max(initial=0) + extent * 1e-6)
        return errors, (ours, f, B, free, fixed, d, imposed)

    def judge_obstacle(self, contact, R, gap, area, law, d, worst, extent):
        nodes, distance, normal, own_area = self.obstacle_rows(contact, d)
        if len(nodes) != R.shape[1]:
            worst["rows"] = 1.0
            return
        at = R[:, np.arange(len(nodes)), nodes]     # (3, points, 3)
        left = np.abs(R).sum() - np.abs(at).sum()
        worst["rows"] = max(worst["rows"], abs(left) / len(nodes))
        worst["area"] = max(worst["area"], ratio(area - own_area, own_area.max()))
        expected = np.where(law == BONDED, 0.0, distance)
        worst["gap"] = max(worst["gap"], ratio(gap - expected, extent))
        free = np.isnan(d.reshape(-1, 3)[nodes])
        for j in range(len(nodes)):
            n, tangents = at[0, j], at[1:, j]
            within = np.where(free[j], normal[j], 0)
            # What is prescribed has its part in the normal row as well.
            error = np.abs(n - normal[j])[free[j]].max()
            projector = tangents.T @ tangents
            if free[j].all():
                expected = np.eye(3) - np.outer(normal[j], normal[j])
            else:
                basis = np.eye(3)[free[j]]
                tangential = basis - np.outer(basis @ within, within) / (within @ within)
                u, s, vt = np.linalg.svd(tangential)
                vt = vt[: int((s > 1e-9).sum())]
                expected = vt.T @ vt
            error = max(error, np.abs((projector - expected)[np.ix_(free[j], free[j])]).max())
            worst["rows"] = max(worst["rows"], error)

    def judge_bodies(self, contact, R, gap, law, worst, extent):
        """Sums over the two bodies of each row: as much on one as on the other, and at the same place but for the gap."""
        own = self.own
        slave_like = own.body == list(own.parts).index(contact["on"].split(".")[0])
        for k in range(3):
            on, off = R[k][:, slave_like], R[k][:, ~slave_like]
            size = np.abs(R[k]).sum((1, 2)).max(initial=0)
            sums = on.sum(1) + off.sum(1)
            worst["resultant"] = max(worst["resultant"], ratio(sums, size))
            moment = np.cross(own.x[slave_like], on).sum(1) + np.cross(own.x[~slave_like], off).sum(1)
            # The pair of forces has an arm along the normal as long as the surfaces are apart.
            total = on.sum(1)
            squares = np.maximum(np.einsum("jc,jc->j", total, total), 1e-300)
            height = lambda x, part: np.einsum("i,jic,jc->j", x[:, 2], part, total) / squares
            apart = height(own.x[slave_like], on) + height(own.x[~slave_like], off)
            arm = np.zeros_like(moment)
            arm[:, 2] = apart
            expected = np.cross(arm, total)
            worst["moment"] = max(worst["moment"], ratio(moment - expected, size * extent))
            if k == 0:
                as_meshed = contact.get("gap", "as-meshed")
                expected = {"as-meshed": apart * np.linalg.norm(total, axis=1), "closed": 0 * gap}.get(as_meshed)
                expected = float(as_meshed) * np.linalg.norm(total, axis=1) if expected is None else expected
                expected = np.where(law == BONDED, 0.0, expected)
                worst["gap"] = max(worst["gap"], ratio(gap - expected, extent))

    def judge_law(self, contact, law, bound, limit, across, area, R, worst):
        friction = contact["friction"]
        if isinstance(friction, str):
            worst["law"] = max(worst["law"], float(np.any(law != {"none": NONE, "bonded": BONDED}[friction])))
            return
        guided = np.abs(R[2]).sum((1, 2)) == 0
        if "tresca" in friction:
            errors = np.where(law == GIVEN, bound - friction["tresca"] * area, np.inf)
            scale = max(friction["tresca"] * area.max(initial=0), 1e-300)
        elif isinstance(friction["coulomb"], list):
            large, small = max(friction["coulomb"]), min(friction["coulomb"])
            errors = np.where(guided, 0, np.abs(bound - large) + np.abs(across - small / large))
            direction = np.array(friction["direction"], float)
            for j in np.flatnonzero(~guided):
                # The second tangent, along which friction is small, is along or across the direction.
                n, t = R[0][j].sum(0), R[1 if friction["coulomb"][0] >= friction["coulomb"][1] else 2][j]
                t = t[np.argmax(np.linalg.norm(t, axis=1))]
                n = R[0][j][np.argmax(np.linalg.norm(R[0][j], axis=1))]
                n = n / np.linalg.norm(n)
                along = direction - direction @ n * n
                errors[j] += 1 - abs(t @ along) / np.linalg.norm(t) / np.linalg.norm(along)
            scale = 1.0
        else:
            kind = LIMITED if "limit" in friction else COULOMB
            errors = np.where(law == kind, bound - friction["coulomb"], np.inf)
            if kind == LIMITED:
                errors = np.abs(errors) + np.abs(limit / np.maximum(area, 1e-300) / friction["limit"] - 1)
            scale = 1.0
        worst["law"] = max(worst["law"], ratio(errors, scale))

    def judge_area(self, contact, ranges, file, worst):
        """Contact points of a pair stand for no more than the area in which its surfaces overlap: nodes that are held or
        covered by a part only are left out. All nodes of a surface that is covered as a whole stand for all of it."""
        own = self.own
        a, b = (np.unique(own.side(contact[key])) for key in ("on", "against"))
        overlap = convex_overlap(outline(own.x[a][:, :2]), outline(own.x[b][:, :2]))
        spans = [span for _, span, of in ranges if of is contact]
        area = sum(file["area"][span].sum() for span in spans)
        covered = False
        for key, nodes in (("on", a), ("against", b)):
            # The surface with the points has one node of its own in each row.
            on = np.concatenate([touched[:, nodes] for touched, _, of in ranges if of is contact])
            slave = len(on) == len(nodes) and (on.sum(1) == 1).all() and (on.sum(0) == 1).all()
            covered |= slave and abs(overlap / own.areas(own.side(contact[key])).sum() - 1) < 1e-12
        error = (area - overlap) / overlap
        worst["area"] = max(worst["area"], abs(error) if covered else max(error, 0.0))

    def measures(self, file, solution, posed):
        """Own measures of an answer, in the largest forces and lengths of the problem."""
        K, f, B, free, fixed, d, imposed = posed
        u, lam = solution["u"], solution["lambda"]
        m = len(file["gap"])
        full = d.copy()
        full[free] = u
        jump = B @ full - imposed
        normal, t1, t2 = lam[:m], lam[m : 2 * m], lam[2 * m :]
        s1, s2 = jump[m : 2 * m] - file["slip_reference"][:m], jump[2 * m :] - file["slip_reference"][m:]
        opening = file["gap"] - jump[:m]
        law, bound = file["friction_law"], file["friction_value"].copy()
        across = file.get("friction_across", np.ones(m))
        positive = np.maximum(normal, 0)
        bound = np.select([law == NONE, law == GIVEN, law == COULOMB, law == LIMITED],
                          [0, bound, bound * positive, np.minimum(bound * positive, file["friction_limit"])], 0.0)
        contact = B[:, free].T @ lam
        force = np.sqrt(normal**2 + t1**2 + t2**2).max(initial=0)
        compliance = np.sqrt(np.asarray(B[:m, free].multiply(B[:m, free]) @ (1 / K.diagonal())).ravel() + 0)
        length = max(np.abs(u).max(initial=0), np.maximum(-file["gap"], 0).max(initial=0), np.max(force * compliance**2, initial=0))
        # The motion along the contact is known to the rounding of K u only.
        tied, loose = law == BONDED, law != BONDED
        slip = np.hypot(s1, across * s2)
        held = np.hypot(t1, t2 / np.maximum(across, 1e-300))
        work = max(force * length, 1e-300)
        result = {}
        # Where nothing but rounding is carried there is nothing to be measured in: 1e-14 of the terms of K u, of a bound
        # and of the displacements is no error.
        internal = np.abs(K) @ np.abs(u)
        rounding, least = 1e-15 * np.linalg.norm(internal), 1e-14 * internal.max(initial=0)
        idle = (least + 1e-14 * bound.max(initial=0)) * length
        load = max(np.linalg.norm(f), np.linalg.norm(contact))
        left = f - K @ u - contact
        result["equilibrium"] = max(np.linalg.norm(left) - 30 * rounding, 0) / max(load, 1e-300)
        if m:
            # What contact carries may be little beside the loads: there it is measured by itself.
            left = left[np.asarray(abs(B[:, free]).sum(0)).ravel() > 0]
            result["contact forces"] = max(np.linalg.norm(left) - 30 * rounding, 0) / max(np.linalg.norm(contact), 1e-300)
            result["penetration"] = ratio(np.maximum(-opening, 0)[loose], length)
            result["tie"] = ratio(np.concatenate([opening[tied], s1[tied], s2[tied]]), length)
            result["tension"] = ratio(np.maximum(-normal - least, 0)[loose], force)
            result["cone"] = ratio(np.maximum(held - bound - least, 0)[loose], force)
            result["complementarity"] = ratio(np.maximum(np.abs(normal * opening) - idle, 0)[loose], work)
            result["sliding"] = ratio(np.maximum(np.abs(bound * slip - t1 * s1 - t2 * s2) - idle, 0)[loose], work)
        self.slid = jump[m:] + imposed[m:]
        return result


def main():
    program, first, last = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    counts = dict.fromkeys(["cases", "solved", "left", "unsolved", "answers judged", "posed otherwise", "false successes"], 0)
    worst = {}
    # In batches: the program runs ahead of the judge, and the disk holds what is in between.
    for begin in range(first, last, BATCH):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            run = subprocess.Popen([program, str(folder), str(begin), str(min(begin + BATCH, last))], stdout=subprocess.PIPE, text=True)
            answers = []
            for line in run.stdout:
                kind, name, rest = line.rstrip("\n").split(" ", 2)
                if kind == "answer":
                    answers.append((name, *rest.split(" ")))
                    continue
                counts["cases"] += 1
                leaves = "resists a motion" in rest or rest.startswith("NoEquilibrium")
                counts["solved" if rest == "Solved" else "left" if leaves else "unsolved"] += 1
                text = (folder / f"{name}.toml").read_text()
                judge, past = Judge(text), 0.0
                for answer, t, status in answers:
                    if float(t) <= past:    # from its first step again, with a larger search
                        judge.slid = None
                    past = float(t)
                    with np.load(folder / f"{answer}-problem.npz") as file:
                        file = dict(file)
                    with np.load(folder / f"{answer}-solution.npz") as solution:
                        solution = dict(solution)
                    errors, posed = judge.posed(file, float(t))
                    counts["answers judged"] += 1
                    if max(errors.values()) > POSED:
                        counts["posed otherwise"] += 1
                        print(f"POSED OTHERWISE {answer} t = {t}:", {k: f"{v:.1e}" for k, v in errors.items() if v > POSED})
                    measured = judge.measures(file, solution, posed) if posed else {"unknowns": 1.0}
                    if status == "Solved":
                        for key, error in [*errors.items(), *measured.items()]:
                            worst[key] = max(worst.get(key, 0.0), error)
                        if max(measured.values()) > ANSWER:
                            counts["false successes"] += 1
                            print(f"FALSE SUCCESS {answer} t = {t}:", {k: f"{v:.1e}" for k, v in measured.items() if v > ANSWER})
                answers = []
                for path in [folder / f"{name}.toml", *folder.glob(f"{name}-*")]:
                    path.unlink()
            if run.wait() != 0:
                sys.exit("the program ended with an error")
    print(", ".join(f"{number} {what}" for what, number in counts.items()))
    print("worst of all answers called solved:", ", ".join(f"{k} {v:.1e}" for k, v in worst.items()))
    good = counts["cases"] == last - first and counts["answers judged"] > 0
    sys.exit(0 if good and counts["false successes"] == 0 and counts["posed otherwise"] == 0 else 1)


if __name__ == "__main__":
    main()
