# SPDX-License-Identifier: BSD-3-Clause
"""What the reports of Google Benchmark's results share."""
import json


def load(path):
    """name -> counters and times, medians where there were rounds; and the context."""
    with open(path, encoding="utf-8") as file:
        content = json.load(file)
    runs = {}
    for run in content["benchmarks"]:
        once = run.get("repetitions") == 1 and "aggregate_name" not in run
        if once or run.get("aggregate_name") == "median":
            name = run["run_name"]
            for suffix in ("/iterations:", "/repeats:", "/manual_time"):
                name = name.split(suffix)[0]
            runs[name] = run
    return runs, content["context"]


def number(value, digits=0):
    return "-" if value is None else f"{value:,.{digits}f}"


def table(first, heads, rows):
    lines = ["| " + first + " | " + " | ".join(heads) + " |", "|---" * (len(heads) + 1) + "|"]
    lines += ["| " + name + " | " + " | ".join(cells) + " |" for name, cells in rows]
    return "\n".join(lines)
