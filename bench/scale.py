#!/usr/bin/env python3
"""How far `stiction-mpi` would scale: a model from counts, with its table and its chart.

    python3 bench/scale.py measure PROGRAM   # bricks on 1 to 125 ranks on this machine: bench/results/2026-11-30-ranks.json
    python3 bench/scale.py                   # docs/scale.md (its tables) and docs/scale.png; needs matplotlib

What is counted (nodes and entries of the levels, ghosts, exchanges, bytes, sums) does not depend on the machine. What is
assumed stands in MACHINES and COST, each with its source.
"""

import json
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COUNTS = ROOT / "bench" / "results" / "2026-11-30-ranks.json"
PAGE = ROOT / "docs" / "scale.md"
CHART = ROOT / "docs" / "scale.png"

# Bandwidth of a node into the network (bytes/s), ranks on a node. The latency (s) and what a message costs its sender (s) are
# round numbers for such networks and no measurements of these; the table says what ten times as much would do.
MACHINES = {
    "LUMI-C": {"bandwidth": 25e9, "latency": 2e-6, "message": 0.3e-6, "node": 128, "memory": 256e9},
    "100 Gbit/s InfiniBand": {"bandwidth": 12.5e9, "latency": 1.5e-6, "message": 0.3e-6, "node": 48, "memory": 192e9},
}
# Seconds of a core for a cycle and a million unknowns, and for the set-up: 20 cycles of the brick of 2 million unknowns,
# docs/notes/2026-11-25-ranks.md and 2026-11-23-multigrid-trials.md, a virtual machine of 2.5 GHz.
COST = {"cycle": 0.20, "set-up": 5.8, "cycles": 20}
# Bytes a node that rank 0 holds while it poses what it has of the mesh, of a mesh made by ranks the cells at the boundary: two layers
# of nodes on a brick of 3 x 1 x 1. Bytes an unknown of a rank: 10 million on two, docs/notes/2026-11-26-made-by-ranks.md. Fewest nodes of a
# level for each rank that has some, most nodes of a level that goes on one rank in any case.
POSED, UNKNOWN, NODES_PER_RANK, ONE_RANK, COARSEST, INDEX = 400, 1720, 256, 300, 50, 3


def measure(program):
    runs = []
    for element, cells in (("hex8", [90, 30, 30]), ("tet4", [72, 24, 24])):
        for ranks in (1, 2, 4, 8, 16, 32, 64):
            runs.append(run(program, element, cells, ranks))
    # The same number of nodes for each rank.
    for ranks, cells in ((1, [39, 13, 13]), (8, [78, 26, 26]), (27, [117, 39, 39]), (64, [156, 52, 52]), (125, [195, 65, 65])):
        runs.append({**run(program, "tet4", cells, ranks), "weak": True})
    COUNTS.write_text(json.dumps(runs, indent=1) + "\n")


def run(program, element, cells, ranks):
    block = f'mesh.block={{ size = [3, 1, 1], cells = {cells}, element = "{element}" }}'
    with tempfile.TemporaryDirectory() as folder:
        command = ["mpirun", "-n", str(ranks), program, "solve", str(ROOT / "cases/brick/brick.toml"), "-o", folder, "--set", block]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        summary = json.loads((Path(folder) / "summary.json").read_text())
    most = {key: max(rank[key] for rank in summary["ranks"]) for key in summary["ranks"][0] if key != "peak_memory_bytes"}
    most["peak_memory_bytes"] = summary["peak_memory_bytes"]
    print(element, cells, ranks, summary["counts"]["cycles"], most, flush=True)
    return {"element": element, "cells": cells, "ranks": ranks, "unknowns": summary["dofs"], "levels": summary["levels"],
            "cycles": summary["counts"]["cycles"], "most": most}


def levels_of(unknowns, shape):
    """Nodes and entries of each level, by the ratios of the measured hierarchy; the last ratio goes on."""
    nodes, levels = unknowns / 3, []
    first = [count for count, _ in shape]
    ratios = [b / a for a, b in zip(first, first[1:]) if b > 300]
    each = [entries / count for count, entries in shape]
    while nodes > COARSEST:
        k = len(levels)
        levels.append((nodes, nodes * each[min(k, len(ratios))]))
        nodes *= ratios[min(k, len(ratios) - 1)]
    levels.append((nodes, nodes * nodes * 36))
    return levels


def visits_of(levels, ranks):
    """How often a cycle visits each level: as `affordable_cycle_index` has it, by what the busiest rank has of each
    level. No rank here has so few entries that the rule counts more (`WORK_OF_RANK`)."""
    on = holders_of(levels, ranks)
    visits, all_visits, budget = 1, [1, 1], levels[0][1] / ranks
    for k in range(1, len(levels) - 1):
        coarsest = levels[-1][1] if k + 2 == len(levels) else 0
        index = min(max(int(budget / (visits * (levels[k + 1][1] / on[k + 1] + coarsest))), 1), INDEX)
        visits *= index
        all_visits.append(visits)
    return all_visits[: len(levels)]


def holders_of(levels, ranks):
    """How many ranks have nodes of each level; never more than of the finer one."""
    on = [ranks]
    for nodes, _ in levels[1:]:
        on.append(min(on[-1], holders(nodes, ranks)))
    return on


def holders(nodes, ranks):
    """How many ranks have nodes of a coarse level: as `agglomerated` has it."""
    most = 1 if nodes <= ONE_RANK else max(int(nodes / NODES_PER_RANK), 1)
    group = 2 ** math.ceil(math.log2(math.ceil(ranks / most)))
    return math.ceil(ranks / group)


class Model:
    def __init__(self, runs, machine):
        self.machine = MACHINES[machine]
        largest = max((r for r in runs if r["element"] == "tet4" and r["ranks"] == 1), key=lambda r: r["unknowns"])
        # The largest hierarchy that one rank has made.
        self.shape = largest["levels"]
        divided = [r for r in runs if r["ranks"] >= 8 and r["element"] == "tet4"]
        # Ghosts of a part grow with its surface.
        self.surface = max(r["most"]["ghosts"] / r["most"]["nodes"] ** (2 / 3) for r in divided)
        self.sums = math.ceil(max(r["most"]["sums_per_cycle"] for r in divided))
        reference = levels_of(2e6, self.shape)
        work = sum(v * e for v, (_, e) in zip(visits_of(reference, 1), reference))
        self.second = COST["cycle"] * 2 / work

    def exchange(self, size, ranks, more=0):
        """Lengths and then values between up to 26 neighbours and `more`, all ranks of a node at a time."""
        m = self.machine
        neighbours = min(ranks - 1, 26) + more
        return 2 * (m["latency"] + neighbours * m["message"]) + size * min(ranks, m["node"]) / m["bandwidth"]

    def tree(self, size, ranks):
        m = self.machine
        return math.ceil(math.log2(ranks)) * (2 * m["latency"] + size / m["bandwidth"])

    def cycle(self, unknowns, ranks):
        """Seconds of a cycle by part."""
        levels = levels_of(unknowns, self.shape)
        visits = visits_of(levels, ranks)
        parts = dict.fromkeys(("levels of all ranks", "agglomerated levels", "halos", "sums"), 0.0)
        above, visits_above = ranks, 1
        for k, ((nodes, entries), count, here) in enumerate(zip(levels, visits, holders_of(levels, ranks))):
            parts["levels of all ranks" if here == ranks else "agglomerated levels"] += self.second * count * entries / here
            if ranks > 1:
                ghosts = self.surface * (nodes / here) ** (2 / 3) if here > 1 else 0
                if k == 0:
                    parts["halos"] += self.exchange(24 * ghosts, ranks) + 2 * self.exchange(12 * ghosts, ranks)
                else:
                    # Three exchanges a visit; restriction and prolongation with the ranks of the level above, each of
                    # which needs its part of this one and the ghosts around that.
                    parts["halos"] += 3 * count * self.exchange(24 * ghosts, here) if here > 1 else 0
                    given, part = above / here, nodes / above
                    size = 24 * given * (self.surface * part ** (2 / 3) + (part if given > 1 else 0))
                    parts["halos"] += 2 * visits_above * self.exchange(size, here, math.ceil(given) - 1)
            above, visits_above = here, count
        if ranks > 1:
            parts["sums"] = self.sums * 2 * self.tree(32, ranks)
        return parts

    def efficiency(self, unknowns, ranks):
        parts = self.cycle(unknowns, ranks)
        return sum(self.cycle(unknowns, 1).values()) / ranks / sum(parts.values())

    def memory(self, unknowns, ranks):
        """Bytes of a rank, and of rank 0 while it poses the boundary of a mesh that the ranks make."""
        levels = levels_of(unknowns, self.shape)
        held = max((e / holders(n, ranks) for n, e in levels[1:] if holders(n, ranks) < ranks), default=0)
        return UNKNOWN * unknowns / ranks + 8 * held, POSED * 2 * 14 * (unknowns / 9) ** (2 / 3)


def seconds(value):
    return f"{value:.1f}" if value >= 1 else f"{value:.3f}" if value >= 1e-3 else "< 0.001"


def tables(runs):
    lines = ["## A cycle, seconds", ""]
    names = ["levels of all ranks", "agglomerated levels", "halos", "sums"]
    lines.append("| unknowns | ranks | " + " | ".join(names) + " | all | efficiency | 20 cycles and set-up | memory of a rank | of rank 0 at the start |")
    lines.append("|" + "---|" * 11)
    for machine in MACHINES:
        lines.append(f"| **{machine}** |" + " |" * 10)
        model = Model(runs, machine)
        for unknowns in (1e8, 1e9):
            for ranks in (100, 1000):
                parts = model.cycle(unknowns, ranks)
                whole = sum(parts.values())
                total = COST["cycles"] * whole + COST["set-up"] * unknowns / 1e6 / ranks
                rank, root = model.memory(unknowns, ranks)
                lines.append(f"| 1e{round(math.log10(unknowns))} | {ranks} | " + " | ".join(seconds(parts[n]) for n in names)
                             + f" | {seconds(whole)} | {100 * model.efficiency(unknowns, ranks):.0f} % | {total:.0f} | "
                             f"{rank / 1e9:.1f} GB | {root / 1e9:.0f} GB |")
    lines += ["", "## What was counted", "",
              "| brick | unknowns | ranks | cycles | ghosts | halo exchanges a cycle | kB sent | messages | sums | MB |", "|" + "---|" * 10]
    for run in runs:
        most = run["most"]
        lines.append(f"| {run['element']}{', weak' if run.get('weak') else ''} | {run['unknowns']} | {run['ranks']} | {run['cycles']} | {most['ghosts']} | "
                     f"{most['exchanges_per_cycle']:.0f} | {most['bytes_per_cycle'] / 1e3:.0f} | {most['messages_per_cycle']:.0f} | "
                     f"{most['sums_per_cycle']:.1f} | {most['peak_memory_bytes'] / 1e6:.0f} |")
    return "\n".join(lines)


def chart(runs):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    ranks = sorted({round(10 ** (k / 12)) for k in range(0, 49)})
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), dpi=130)
    colors = {1e8: "#1f5fa8", 1e9: "#c0562a"}
    for machine, style in zip(MACHINES, ("-", "--")):
        model = Model(runs, machine)
        for unknowns, color in colors.items():
            label = f"1e{round(math.log10(unknowns))} unknowns, {machine}"
            left.plot(ranks, [100 * model.efficiency(unknowns, r) for r in ranks], style, color=color, label=label)
    left.set(xscale="log", ylim=(0, 105), xlabel="ranks", ylabel="efficiency of a cycle, %", title="Model: efficiency")
    left.legend(fontsize=7, loc="lower left")
    model = Model(runs, "LUMI-C")
    by_rank = [model.cycle(1e9, r) for r in ranks]
    for name in by_rank[0]:
        values = [parts[name] or float("nan") for parts in by_rank]
        right.plot(ranks, values, label=name)
    right.plot(ranks, [sum(parts.values()) for parts in by_rank], "k", linewidth=2, label="all")
    right.set(xscale="log", yscale="log", ylim=(1e-5, 1e4), xlabel="ranks", ylabel="seconds", title="Model: a cycle of 1e9 unknowns, LUMI-C")
    right.legend(fontsize=7, loc="upper right", ncol=2)
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    figure.savefig(CHART)


def main():
    if sys.argv[1:2] == ["measure"]:
        return measure(sys.argv[2])
    runs = json.loads(COUNTS.read_text())
    text = PAGE.read_text()
    begin, end = "<!-- tables: bench/scale.py -->", "<!-- end -->"
    PAGE.write_text(re.sub(f"{begin}.*{end}", lambda _: f"{begin}\n\n{tables(runs)}\n\n{end}", text, flags=re.S))
    chart(runs)
    print(tables(runs))


if __name__ == "__main__":
    main()
