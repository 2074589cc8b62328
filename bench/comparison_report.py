#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes docs/comparison.md from what classifier_comparison measured.

comparison_report.py COMPARISON.json OUT.md
"""
import json
import sys

REGULARIZATIONS = ["none", "mean of 12 neighbours", "mean over a sphere", "graph cut"]

HEAD = """# Labels beside CGAL's

Written by `bench/compare_classifiers`; change `bench/comparison_report.py` instead. CGAL 5.5's
package Classification, a random forest (ETH Zurich's) on its own multi-scale features, against
`TerrainPipeline`, on tiles of the Oakland 3-D set: trained on part3_am and part3_an, tested on
part2_ac and part2_ah, {points:,} points. Every labelled point of a class counts, `unknown` as
wrong; recall and F1 are means over the classes.

Times are ns of CPU time a point, medians of {rounds} rounds in which all took turns, one thread each
(CGAL's `Sequential_tag`), release builds, vector level {level}. They hold all that is done with a
new cloud: ours from its bytes to labels in an empty map that holds the tile; CGAL's from a vector
of points, its search trees, grids and features first, then the forest and what regularizes it.
Training, reading files and freeing memory are left out.

*Manual* is what CGAL's own example does: the smallest scale from the spacing of the points, 5
scales, 25 trees of depth 20, all training points, graph cut. *Best* are the settings with the best
mean recall *on the test tiles*, out of the {trials} trials below: no one who uses it could choose
better.
"""

TRIALS = """
## Settings of CGAL that were tried

Mean recall. `auto` takes the smallest scale from the spacing of the points. Forests are
trees/depth/training points a class; every forest was tried without regularization, the best of
them with the three kinds: the mean of the posteriors over the 12 nearest points or over a sphere
of three voxels, and a graph cut (12 neighbours, strength 0.2). Times are of one run: of the
features, and of the row's best without regularization and of its best, features included.
"""


def table(heads, rows):
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines)


def share(value):
    return f"{value:.3f}"


def ns(value):
    return f"{value:,.0f}"


def total_ns(row):
    return row.get("total_ns", row.get("feature_ns", 0.0) + row.get("classification_ns", 0.0))


def features_name(settings):
    voxel = settings["voxel_size_m"]
    return f"{'auto' if voxel < 0 else f'{voxel:g} m'}, {settings['scales']} scales"


def forest_name(settings):
    samples = settings["samples_per_class"] or "all"
    return f"{settings['trees']}/{settings['depth']}/{samples}"


def comparison_part(task, classes, rows):
    ours = next(row for row in rows if row["name"] == "ours")
    best = next(row for row in rows if row["name"] == "CGAL, best settings" and row["chosen"])
    manual = next(row for row in rows if row["name"] == "CGAL, as in its manual")
    heads = ["", "mean recall", "mean F1", *classes, "features", "classification", "ns",
             "ours faster by"]
    cells = []
    for row in rows:
        name = "**ours**"
        if row is not ours:
            name = ("manual, " if row["name"] == manual["name"] else "best, ")
            name = "CGAL " + name + row["settings"]["regularization"]
            if row is best:
                name = f"**{name}**"
        is_ours = row is ours
        cells.append([
            name, share(row["score"]["mean_recall"]), share(row["score"]["mean_f1"]),
            *[share(recall) for recall in row["score"]["recall"]],
            "-" if is_ours else ns(row["feature_ns"]),
            "-" if is_ours else ns(row["classification_ns"]),
            ns(total_ns(row)), "" if is_ours else f"{total_ns(row) / total_ns(ours):.0f}"])
    none, regularized = (
        max((row for row in rows if row["name"] == best["name"]
             and (row["settings"]["regularization"] == "none") == plain),
            key=lambda row: row["score"]["mean_recall"]) for plain in (True, False))
    gain = regularized["score"]["mean_recall"] - none["score"]["mean_recall"]
    return "\n".join([
        f"\n## {task.capitalize()} classes\n", table(heads, cells), "",
        f"CGAL's best settings are {features_name(best['settings'])}, forest "
        f"{forest_name(best['settings'])}, {best['settings']['regularization']}: mean recall "
        f"{share(best['score']['mean_recall'])}, ours {share(ours['score']['mean_recall'])}, at "
        f"{total_ns(best) / total_ns(ours):.0f} times our time. With that forest the best "
        f"regularization ({regularized['settings']['regularization']}) changes its mean recall by "
        f"{gain:+.3f} and its time by a factor of "
        f"{total_ns(regularized) / total_ns(none):.1f}.", ""])


def trials_part(task, trials):
    of_features = {}
    for trial in trials:
        of_features.setdefault(features_name(trial["settings"]), []).append(trial)
    forests = list(dict.fromkeys(forest_name(trial["settings"]) for trial in trials))
    rows = []
    for name, group in of_features.items():
        def recall(regularization, forest=None):
            found = [trial["score"]["mean_recall"] for trial in group
                     if trial["settings"]["regularization"] == regularization
                     and forest in (None, forest_name(trial["settings"]))]
            return share(found[0]) if found else "-"
        plain, best = (max((trial for trial in group if any_kind
                            or trial["settings"]["regularization"] == "none"),
                           key=lambda trial: trial["score"]["mean_recall"])
                       for any_kind in (False, True))
        rows.append([name, str(best["features"]), *[recall("none", forest) for forest in forests],
                     *[recall(regularization) for regularization in REGULARIZATIONS[1:]],
                     ns(best["feature_ns"]), ns(total_ns(plain)), ns(total_ns(best))])
    heads = ["smallest scale", "features", *forests, *REGULARIZATIONS[1:],
             "features, ns", "none, ns", "best, ns"]
    return f"\n{task.capitalize()} classes:\n\n{table(heads, rows)}\n"


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1], encoding="utf-8") as file:
        result = json.load(file)
    tasks = list(dict.fromkeys(row["task"] for row in result["rows"]))
    parts = [HEAD.format(points=result["test_points"], rounds=result["rounds"],
                         level=result["vector_level"], trials=len(result["trials"]))]
    for task in tasks:
        parts.append(comparison_part(task, result["classes"][task],
                                     [row for row in result["rows"] if row["task"] == task]))
    parts.append(TRIALS)
    for task in tasks:
        parts.append(trials_part(task, [t for t in result["trials"] if t["task"] == task]))
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        file.write("".join(parts))


if __name__ == "__main__":
    main()
