#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes docs/resampling_performance.md from what bench_resample measured.

resampling_report.py RESULTS OUT.md: RESULTS holds resample.json.
"""
import os
import re
import sys

from report_tables import load, number, table

CLOUDS = ["campus_20k", "campus_190k", "campus_380k", "kitti00", "3dtk_indoor"]
OURS = ["fast_marching", "flood"]
RIVALS = ["pcl_fps", "open3d_fps", "tree_fps", "pcl_voxel_grid", "pcl_uniform_sampling", "random"]

HEAD = """# Performance of the re-sampling

Written by `bench/measure_resampling`; change `bench/resampling_report.py` instead. Times are medians
over {repetitions} rounds in which all variants took turns in random order, each after a run that is not
timed (farthest points by PCL and Open3D: once, and at once), on {cpus} CPUs at {mhz} MHz (nominal); CPU
time of the process where a method has one thread, else the wall clock's. `campus_*` is the simulated
campus as a sensor sees it that stands on the street, with range noise of 2 cm; `kitti00` and
`3dtk_indoor` are one real scan each, where the data are present.

{cases}

"""

TIMES = """## Time, ms

One thread. `tree_fps` is our own farthest point sampling of the raw points, the same rule as PCL's and
Open3D's, with a k-d tree that leaves alone what a new sample cannot change: how fast that can be.
`pcl_voxel_grid` and `pcl_uniform_sampling` were given cells for which they return as many points
within a per cent; finding these is not in their time.

{table}

Their time over ours:

{ratios}

"""

THREADS = """## Policies and threads, ms

`range` weighs points by 1 / max(range, 3 m)^2. Two threads give the same bytes; their time is the
wall clock's, as far as the machine had two CPUs to give.

{table}

"""

EXTEND = """## More points for a cloud that is there, ms

`extend` with a sixtieth of the points, which are all in one sector of six degrees as seen from the
sensor, or come from everywhere in the cloud; and the whole cloud re-sampled at once, to the same
radius. One thread.

{table}

"""

QUALITY = """## Evenness

Of the distances from samples to their nearest neighbours: coefficient of variation, and the least over
the mean, without the samples that have no other within twice the median distance (leaves, mixed
pixels); then the 99th percentile of the distance from points of the cloud to the nearest sample, over
that mean. Least is best for the first and the last, a hexagonal lattice has 0, 1 and 0.55.

{tables}
"""

MEMORY = """## Memory, MB

Peak while it ran over what the process held before: the cloud itself is not in it.

{table}

"""

GROWTH = """## Growth

`campus` with n points to N samples, one thread.

{table}

{fits}
"""


def run_of(runs, method, cloud):
    return runs.get(f"resample/{method}/{cloud}") or runs.get(f"resample_slow/{method}/{cloud}")


def cells(runs, method, clouds, counter, digits):
    found = [run_of(runs, method, cloud) for cloud in clouds]
    return [number(run[counter] if run else None, digits) for run in found]


def ratio_rows(runs, clouds):
    rows = []
    for ours in OURS:
        for rival in RIVALS:
            row = []
            for cloud in clouds:
                mine, theirs = run_of(runs, ours, cloud), run_of(runs, rival, cloud)
                ratio = theirs["real_time"] / mine["real_time"] if mine and theirs else None
                row.append(number(ratio, 0 if ratio and ratio >= 10 else 2))
            rows.append((f"`{rival}` over `{ours}`", row))
    return rows


def policy_rows(runs, clouds):
    rows = []
    for ours in OURS:
        for policy in ("", "_range"):
            for threads in ("", "_2_threads"):
                method = ours + policy + threads
                rows.append((f"`{method}`", cells(runs, method, clouds, "real_time", 1)))
        speedups = []
        for cloud in clouds:
            one, two = run_of(runs, ours, cloud), run_of(runs, ours + "_2_threads", cloud)
            speedups.append(number(one["real_time"] / two["real_time"] if one and two else None, 2))
        rows.append((f"two threads over one, `{ours}`", speedups))
    return rows


def extend_rows(runs, clouds):
    rows = []
    for ours in OURS:
        for part in ("sector", "everywhere", "whole"):
            found = [runs.get(f"extend/{ours}/{part}/{cloud}") for cloud in clouds]
            rows.append((f"`{ours}`, {part}",
                         [number(run["real_time"] if run else None, 1) for run in found]))
    return rows


def quality_tables(runs, clouds):
    parts = []
    for cloud in clouds:
        rows = []
        for method in OURS + RIVALS:
            run = run_of(runs, method, cloud)
            if run:
                rows.append((f"`{method}`",
                             [number(run["samples"]), number(run["connected_cov"], 3),
                              number(run["connected_min"], 2), number(run["cover_p99"], 2),
                              number(run["cov"], 3), number(run["min_over_mean"], 2)]))
        heads = ["samples", "CoV", "min / mean", "cover p99", "CoV, all", "min / mean, all"]
        parts.append(table(cloud, heads, rows) + "\n")
    return "\n".join(parts)


def fit(points):
    """a, b of the least squares t = a n + b N with errors relative to t."""
    saa = sab = sbb = sat = sbt = 0.0
    for n, count, t in points:
        a, b = n / t, count / t
        saa, sab, sbb, sat, sbt = saa + a * a, sab + a * b, sbb + b * b, sat + a, sbt + b
    determinant = saa * sbb - sab * sab
    return (sat * sbb - sbt * sab) / determinant, (sbt * saa - sat * sab) / determinant


def growth_part(runs):
    times = {}
    for name, run in runs.items():
        match = re.fullmatch(r"growth/(\w+)/n:(\d+)k/N:(\d+)", name)
        if match:
            engine, n, count = match[1], 1000 * int(match[2]), int(match[3])
            times.setdefault((n, count), {})[engine] = run["real_time"]
    rows, fits = [], []
    for (n, count), by_engine in sorted(times.items()):
        row = [number(count)]
        for engine in OURS:
            t = by_engine.get(engine)
            row += [number(t, 1), number(1e6 * t / (n + count) if t else None)]
        rows.append((number(n), row))
    for engine in OURS:
        points = [(n, count, t[engine]) for (n, count), t in times.items() if engine in t]
        if len(points) > 2:
            a, b = fit(points)
            worst = max(abs(a * n + b * count - t) / t for n, count, t in points)
            fits.append(f"`{engine}`: {1e6 * a:.0f} ns a point and {1e6 * b:.0f} ns a sample fit all"
                        f" of these within {100 * worst:.0f} %.")
    heads = ["N"] + [head for engine in OURS for head in (f"`{engine}`, ms", "ns per n + N")]
    return GROWTH.format(table=table("n", heads, rows), fits="\n\n".join(fits))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    results, out = sys.argv[1:]
    runs, context = load(os.path.join(results, "resample.json"))
    clouds = [cloud for cloud in CLOUDS if run_of(runs, OURS[0], cloud)]
    sizes = [(f"`{cloud}`", [number(run_of(runs, OURS[0], cloud)[counter])
                             for counter in ("points", "samples")]) for cloud in clouds]
    repetitions = max(run["repetitions"] for run in runs.values())
    parts = [HEAD.format(repetitions=repetitions, cpus=context["num_cpus"],
                         mhz=context["mhz_per_cpu"],
                         cases=table("cloud", ["points", "samples"], sizes))]
    times = [(f"`{method}`", cells(runs, method, clouds, "real_time", 1))
             for method in OURS + RIVALS]
    parts.append(TIMES.format(table=table("method", clouds, times),
                              ratios=table("", clouds, ratio_rows(runs, clouds))))
    parts.append(THREADS.format(table=table("variant", clouds, policy_rows(runs, clouds))))
    parts.append(EXTEND.format(table=table("points", clouds, extend_rows(runs, clouds))))
    parts.append(QUALITY.format(tables=quality_tables(runs, clouds)))
    memory = [(f"`{method}`", cells(runs, method, clouds, "memory_mb", 1))
              for method in OURS + RIVALS]
    parts.append("\n" + MEMORY.format(table=table("method", clouds, memory)))
    parts.append(growth_part(runs))
    with open(out, "w", encoding="utf-8") as file:
        file.write("".join(parts))


if __name__ == "__main__":
    main()
