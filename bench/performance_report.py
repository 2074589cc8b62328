#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes docs/performance.md from what bench_saliency and bench_pipeline measured.

performance_report.py RESULTS OUT.md: RESULTS holds saliency.json and pipeline.json.
"""
import os
import re
import sys

from report_tables import load, number, table

SCENES = ["flat_ground", "forest", "tall_grass", "oakland", "kitti"]
KS = [3, 5, 7, 9, 11, 13]

HEAD = """# Performance

Written by `bench/measure_performance`; change `bench/performance_report.py` instead. Every number is
a median over {repetitions} rounds in which all variants took turns in random order, on {cpus} CPUs
at {mhz} MHz (nominal), vector level {level} where nothing else is said. The scenes are those of
[the reproduction](reproduction/README.md), and `oakland` and `kitti` where real data are present: a
crop of a tile, 0.6 per cent of its voxels occupied, and six scans in one map.

"""

SUMS = """## Sums over the support volume, ns per occupied voxel

k = 9, one thread unless it says two. All strategies give the same bits.

{table}

| ours | {heads} |
|---|{lines}
| over the paper's Algorithm 1 | {over_paper} |
| over brute force on a hash map | {over_hash} |
| two threads over one | {over_one} |
| k = 13 over k = 3 | {growth} |

The prototypes this package started from put Algorithm 1 at 536 to 650 ns, and from there 25 times
and 600 times (against the hash map) were hoped for. They are out of reach against rivals as careful
as ours, not because the sliding sums are slower than the prototypes' 16 to 25 ns but because the rivals
here are faster than theirs: Algorithm 1 has 64 instead of 80 bytes a voxel, unrolled loops over a
padded grid and the vector unit, and takes those slices that are in the cache; the hash map is kept
sparse. What limits the sliding sums is memory traffic and branches. A record is loaded, and an entry
of the plane read and written, twice for the rows (entering, leaving); each of the entries of a row's
plane is read twice and a profile written for the columns; a sum is two reads and a write: some 15
cache lines for a voxel on the ground, at about 1 ns each on this machine. Records that are much
smaller would not be exact. Where single passes take turns with strategies that sweep 80 MB of dense
array, as in the reproduction, the map falls out of the cache between them and they take longer than
here. `oakland` has several columns to walk over for every voxel it holds.

"""

LABELS = """## Sums to labels, ns per voxel

Everything that `labeled_map` is made of, for all voxels of a full map: box sums at k = 9,
eigenvalues and two eigenvectors, five features, three mixtures of five Gaussians, confidence.

{table}

At AVX2 about a third are box sums, a quarter the mixtures, a fifth the scatter matrices and their
eigenvectors, a tenth storing the results where the map keeps them.

"""

INSERT = """## Insertion, million points per second

From positions in metres in scan order into an empty map, one thread. `octomap` is an
`octomap::OcTree` with occupied leaves, lazy updates and no ray casting; it stops at leaves that are
sure already, so a point costs it little more than finding the leaf.

{table}

Thirty million a second were hoped for, and 15 times OctoMap's rate; the second is out of reach at
what a descent of its tree costs here, because ours has a 64-byte record to fetch and nine sums to
add to.

| memory of the layout, MB | {heads} |
|---|{lines}
{memory}

"""

RIVALS = """## Normals by other libraries, ns per query

PCL's `NormalEstimation` and nanoflann with Eigen, on the same points, in a ball of 0.45 m, which has
52 per cent of our box's volume, with their trees already built (ours is a voxel's share of a whole
map, labels included; it answers for all points of the voxel at once).

{table}

"""

PIPELINE = """## The whole pipeline, per scan

`bench_pipeline`: from the bytes of a cloud to the bytes of the labelled cloud, simulated forest at
5 m/s, second half of 2 s. `ring` turns at 10 Hz and sees all around, `patch` looks ahead at 20 Hz.
What a row does not vary is at 1.3 M points/s, 20 x 20 x 3 m, 10 cm, k = 9, one thread. *Updated* is
the share of the voxels that had to be computed anew.

{table}

Cost follows the points (insertion, labels) and the occupied voxels v that are updated (sums to
labels); the volume n costs only a glance at every column, and k little: the sums themselves hardly
know it, but a larger support is more often touched by a scan. Without re-use (`reuse:off`) all v are
computed anew at every scan.
"""


def sums_part(runs, scenes):
    def ns(strategy, scene, k=9):
        run = runs.get(f"box_sums/{strategy}/{scene}/k:{k}")
        return run["ns_per_voxel"] if run else None

    def ratios(above, below):
        cells = []
        for scene in scenes:
            a, b = above(scene), below(scene)
            cells.append(number(a / b, 1 if a / b < 100 else 0) if a and b else "-")
        return " | ".join(cells)

    strategies = ["hash_brute", "dense_brute", "naive_scan", "paper_reuse", "sliding",
                  "sliding_2_threads"]
    rows = [(f"`{s}`", [number(ns(s, scene), 1 if s.startswith("sliding") else 0)
                        for scene in scenes]) for s in strategies]
    return SUMS.format(
        table=table("strategy", scenes, rows), heads=" | ".join(scenes),
        lines="---|" * len(scenes),
        over_paper=ratios(lambda s: ns("paper_reuse", s), lambda s: ns("sliding", s)),
        over_hash=ratios(lambda s: ns("hash_brute", s), lambda s: ns("sliding", s)),
        over_one=ratios(lambda s: ns("sliding", s), lambda s: ns("sliding_2_threads", s)),
        growth=ratios(lambda s: ns("sliding", s, KS[-1]), lambda s: ns("sliding", s, KS[0])))


def by_layout(runs, family, counter, scenes, scale, digits):
    names = []
    for name in runs:
        parts = name.split("/")
        if parts[0] == family and parts[1] not in names:
            names.append(parts[1])
    rows = []
    for name in sorted(names):
        cells = []
        for scene in scenes:
            value = runs.get(f"{family}/{name}/{scene}", {}).get(counter)
            cells.append(number(value * scale if value else None, digits))
        rows.append((f"`{name}`", cells))
    return rows


def pipeline_part(runs):
    def order(name):
        what, _, value = name.partition(":")
        digits = re.sub(r"[^0-9.]", "", value)
        return what, float(digits) if digits else 0.0

    rows = []
    for name in sorted(runs, key=order):
        run = runs[name]
        _, sensor, what = name.split("/")[:3]
        rows.append((f"`{sensor}/{what}`",
                     [number(run["points"]), number(run["voxels"]), number(run["updated"], 2),
                      number(run["p50_ms"], 1), number(run["p99_ms"], 1),
                      number(run["memory_mb"], 1)]))
    return PIPELINE.format(table=table(
        "variant", ["points", "voxels", "updated", "p50 ms", "p99 ms", "MB"], rows))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    results, out = sys.argv[1:]
    runs, context = load(os.path.join(results, "saliency.json"))
    pipeline, _ = load(os.path.join(results, "pipeline.json"))
    scenes = [s for s in SCENES if f"box_sums/sliding/{s}/k:9" in runs]
    some = next(iter(runs.values()))
    parts = [HEAD.format(repetitions=some["repetitions"], cpus=context["num_cpus"],
                         mhz=context["mhz_per_cpu"], level=context["vector_level"]),
             sums_part(runs, scenes)]
    parts.append(LABELS.format(table=table(
        "vector level", scenes,
        by_layout(runs, "sums_to_labels", "ns_per_voxel", scenes, 1, 0))))
    memory = by_layout(runs, "insert", "memory_bytes", scenes, 1e-6, 1)
    parts.append(INSERT.format(
        table=table("layout", scenes,
                    by_layout(runs, "insert", "points_per_second", scenes, 1e-6, 1)),
        heads=" | ".join(scenes), lines="---|" * len(scenes),
        memory="\n".join("| " + name + " | " + " | ".join(cells) + " |"
                         for name, cells in memory)))
    rivals = by_layout(runs, "neighbourhood", "ns_per_query", scenes, 1, 0)
    best = by_layout(runs, "sums_to_labels", "ns_per_voxel", scenes, 1, 0)
    rivals += [(f"ours, {name.strip('`')}", cells) for name, cells in best
               if name.strip("`") == context["vector_level"]]
    parts.append(RIVALS.format(table=table("library", scenes, rivals)))
    parts.append(pipeline_part(pipeline))
    with open(out, "w", encoding="utf-8") as file:
        file.write("".join(parts))


if __name__ == "__main__":
    main()
