#!/usr/bin/env python3
"""Sets the recorder's counts beside the profiler's: `table.py STAGES HW.csv SOURCE.csv LAUNCH.txt > profiler.md`.

STAGES is the `stages.json` of `cargo run --release --workspace --example stages FOLDER`; the others are what Nsight Compute and `launch` said of
the same stages, in their order."""
import csv
import json
import sys


def rows(path):
    """The kernels of a page of Nsight Compute; its first row has the units."""
    with open(path) as file:
        lines = [line for line in file if line.startswith('"')]
    return [row for row in csv.DictReader(lines) if row["ID"]]


def number(row, name):
    names = [key for key in row if key == name or key == name + ".sum"]
    return float(row[names[0]].replace(",", "")) if names and row[names[0]] else 0.0


def ranks(values):
    """Ranks, those of equal values their mean."""
    order = sorted(values)
    return [order.index(v) + (order.count(v) - 1) / 2 for v in values]


def correlation(a, b):
    """Spearman's."""
    a, b = ranks(a), ranks(b)
    mean = sum(a) / len(a)
    above = sum((x - mean) * (y - mean) for x, y in zip(a, b))
    return above / (sum((x - mean) ** 2 for x in a) * sum((y - mean) ** 2 for y in b)) ** 0.5


def short(value):
    for unit, size in (("M", 1e6), ("k", 1e3)):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value:.0f}"


stages_path, hw_path, source_path, launch_path = sys.argv[1:]
with open(stages_path) as file:
    stages = json.load(file)
hw, source = rows(hw_path), rows(source_path)
with open(launch_path) as file:
    launched = [line for line in file if ":" in line]
assert len(stages) == len(hw) == len(source) == len(launched), (len(stages), len(hw), len(source), len(launched))

table = []
for stage, counters, theory in zip(stages, hw, source):
    kernel = stage["kernel"]
    for row in (counters, theory):
        assert f"k_{kernel}::" in row["Kernel Name"], (kernel, row["Kernel Name"])
    of = lambda space, what: sum(number(counters, f"l1tex__t_{what}_pipe_lsu_mem_{space}_op_{op}") for op in ("ld", "st"))
    ideal = number(theory, "memory_l2_theoretical_sectors_global_ideal")
    theoretical = number(theory, "memory_l2_theoretical_sectors_global")
    mine = stage["recorder"]
    table.append({
        "kernel": kernel,
        "technique": stage["technique"],
        "requests": (mine["requests"], of("global", "requests")),
        "sectors": (mine["sectors"], of("global", "sectors")),
        "excess": (mine["excess"], theoretical - ideal),
        "local": (mine["local_loads"] + mine["local_stores"], of("local", "sectors")),
    })

searches = [row for row in table if row["requests"][0] and ("neighbours" in row["kernel"] or row["kernel"].startswith(("kd_r", "kd_near")))]
print("| kernel | technique | requests | | sectors | | excess | | local | |")
print("| --- | --- | --: | --: | --: | --: | --: | --: | --: | --: |")
print("| | | recorder | profiler | recorder | profiler | recorder | profiler | recorder (values) | profiler (sectors) |")
for row in table:
    cells = [short(value) for what in ("requests", "sectors", "excess", "local") for value in row[what]]
    print(f"| `{row['kernel']}` | {row['technique']} | " + " | ".join(cells) + " |")
print()
print("| Spearman's rank correlation | " + " | ".join(("requests", "sectors", "excess", "local")) + " |")
print("| --- | --: | --: | --: | --: |")
for name, those in ((f"all {len(table)} stages", table), (f"the {len(searches)} searches", searches)):
    values = [correlation(*zip(*(row[what] for row in those))) for what in ("requests", "sectors", "excess", "local")]
    print(f"| {name} | " + " | ".join(f"{value:.3f}" for value in values) + " |")
