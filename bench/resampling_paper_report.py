#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes resampling.md and its pictures from what resampling_study measured.

    resampling_paper_report.py RESULTS OUT

Every number of ours comes from RESULTS; sentences say only what holds for any run, or choose their
words by the numbers.
"""
import json
import os
import sys

import numpy as np

import resampling_figures as figures

# Table I of the paper: raw, uniform, normals, colour, colour and class.
PAPER = {
    "floor": (29055, 1174, 2958, 1329, 562),
    "foliage": (6918, 5289, 1851, 4524, 2534),
    "bicycles": (3130, 771, 290, 453, 555),
    "wall": (2513, 315, 667, 851, 1006),
    "window": (6278, 884, 1109, 600, 1790),
}
SERIES = ("uniform", "normals", "color", "normals_class")
PAPER_POINTS = (380389, 55000)


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def count(records, box):
    return int(figures.inside(records[:, :3], box).sum())


def table_one(folder, sensor):
    clouds = [figures.load(folder, "raw", 5)]
    clouds += [figures.load(folder, name, 5) for name in SERIES]
    counts = {volume: [count(cloud, figures.moved(box, sensor)) for cloud in clouds]
              for volume, box in figures.VOLUMES.items()}
    rows = []
    for volume, ours in counts.items():
        cells = [f"{ours[0]:,} ({PAPER[volume][0]:,})", f"{ours[1]:,} ({PAPER[volume][1]:,})"]
        for mine, theirs in zip(ours[2:], PAPER[volume][2:]):
            cells.append(f"{100 * (mine / max(ours[1], 1) - 1):+.0f} % "
                         f"({100 * (theirs / PAPER[volume][1] - 1):+.0f} %)")
        rows.append([volume] + cells)
    header = ("control volume", "raw (paper)", "uniform (paper)", "normals", "colour",
              "normals and class")
    return table(header, rows), counts, [len(cloud) for cloud in clouds]


def directions(counts):
    wrong, total = [], 0
    for volume, ours in counts.items():
        for name, mine, theirs in zip(("normals", "colour", "normals and class"), ours[2:],
                                      PAPER[volume][2:]):
            total += 1
            if (mine > ours[1]) != (theirs > PAPER[volume][1]):
                wrong.append(f"{volume} with {name}")
    if not wrong:
        return f"All {total} changes against the uniform sampling have the paper's direction."
    return (f"{total - len(wrong)} of {total} changes against the uniform sampling have the paper's "
            f"direction; not so: {', '.join(wrong)}.")


def floor_text(counts, sizes):
    def fall(raw, uniform, points, samples):
        return 100 * (1 - uniform / raw), 100 * (1 - uniform / samples / (raw / points))

    ours = fall(counts["floor"][0], counts["floor"][1], sizes[0], sizes[1])
    paper = fall(PAPER["floor"][0], PAPER["floor"][1], *PAPER_POINTS)
    return (f"From raw to uniform the points on the floor fall by {ours[0]:.1f} % (paper: "
            f"{paper[0]:.1f} %), their share of all points by {ours[1]:.1f} % (paper: "
            f"{paper[1]:.1f} %).")


def quality_table(rows):
    lines = []
    for row in rows:
        flat = row["flat"]
        planes = [plane for plane in flat["planes"] if plane["samples"] >= 100]
        relative = [plane["relative"] for plane in planes]
        span = f"{min(relative):.3f} to {max(relative):.3f} ({len(planes)})" if planes else "none"
        lines.append((f"{row['points']:,} to {row['samples']:,}", row["engine"],
                      f"{100 * row['spacing_m']:.1f}", f"{row['nn_cov']:.3f}",
                      f"{row['isolated']}", f"{row['connected_cov']:.3f}",
                      f"{row['min_over_mean']:.2f}", f"{row['cover_p99_raw']:.2f}",
                      f"{row['cover_p99_true']:.2f}",
                      f"{1000 * row['error_samples_m']['mean']:.1f} / "
                      f"{1000 * row['error_samples_m']['median']:.1f}",
                      f"{1000 * row['error_raw_m']['mean']:.1f} / "
                      f"{1000 * row['error_raw_m']['median']:.1f}",
                      f"{1000 * flat['error_samples_m']['mean']:.1f}",
                      f"{1000 * flat['error_raw_m']['mean']:.1f}", span))
    return table(("points", "engine", "spacing (cm)", "nn CoV", "isolated", "CoV without", "min / mean",
                  "covering p99, raw", "true", "error, mean / median (mm)", "raw points'",
                  "on flat faces (mm)", "raw points'", "density of faces"), lines)


def planes_table(rows):
    row = rows[-2] if len(rows) > 1 else rows[-1]
    lines = []
    for plane in sorted(row["flat"]["planes"], key=lambda p: -p["area_m2"]):
        lines.append((f"{plane['distance_m']:.1f}", f"{plane['incidence']:.2f}",
                      f"{plane['area_m2']:.1f}", f"{plane['raw_per_m2']:.0f}",
                      f"{plane['samples']}", f"{plane['per_m2']:.1f}", f"{plane['relative']:.3f}",
                      f"{1000 * plane['error_samples_m']:.1f}",
                      f"{1000 * plane['error_raw_m']:.1f}"))
    title = f"{row['points']:,} points to {row['samples']:,}, {row['engine']}"
    return title, table(("distance (m)", "cosine of incidence", "area (m^2)", "raw per m^2",
                         "samples", "per m^2", "relative", "error (mm)", "raw (mm)"), lines)


def real_part(folder, out):
    if not os.path.exists(os.path.join(folder, "table.json")):
        return "The cloud was not there in this run."
    with open(os.path.join(folder, "table.json")) as file:
        data = json.load(file)
    names = [series["name"] for series in data["series"]]
    clouds = [figures.load(folder, "raw", 5)] + [figures.load(folder, name, 5) for name in names]
    clouds = [np.c_[cloud[:, :3] @ figures.REAL_AXES.T, cloud[:, 3:]] for cloud in clouds]
    rows = []
    for volume, box in figures.REAL_VOLUMES.items():
        counts = [count(cloud, box) for cloud in clouds]
        rows.append([volume, f"{counts[0]:,}", f"{counts[1]:,}"] +
                    [f"{n:,} ({100 * (n / max(counts[1], 1) - 1):+.0f} %)" for n in counts[2:]])
    rows.append(["all", f"{len(clouds[0]):,}"] + [f"{len(cloud):,}" for cloud in clouds[1:]])
    figures.real(clouds, names, os.path.join(out, "resampling_real.png"))
    return (table(["control volume", "raw"] + names, rows) +
            "\n\n![The real cloud](resampling_real.png)\n")


def main():
    results, out = sys.argv[1:3]
    campus = os.path.join(results, "campus")
    with open(os.path.join(campus, "quality.json")) as file:
        quality = json.load(file)
    with open(os.path.join(campus, "table.json")) as file:
        data = json.load(file)
    sensor = data["sensor"]
    text, counts, sizes = table_one(campus, sensor)
    title, planes = planes_table(quality)
    parts = {
        "table_1": text,
        "directions": directions(counts),
        "floor": floor_text(counts, sizes),
        "policies": table(("series", "policies", "ms"), [
            (series["name"].replace("_", " and "),
             " x ".join(f"`{policy}`" for policy in series["policies"]) or "none",
             f"{series['total_ms']:.0f}") for series in data["series"]]),
        "quality": quality_table(quality),
        "planes_title": title,
        "planes": planes,
        "real": real_part(os.path.join(results, "real"), out),
    }
    figures.fronts(campus, data["fronts"], os.path.join(out, "resampling_figure_4.png"))
    figures.volumes(campus, sensor, os.path.join(out, "resampling_figure_5.png"))
    figures.weighted(campus, "color", os.path.join(out, "resampling_figure_6.png"))
    figures.weighted(campus, "normals_class", os.path.join(out, "resampling_figure_7.png"))
    with open(os.path.join(os.path.dirname(__file__), "resampling_paper_report.md")) as file:
        report = file.read()
    for name, part in parts.items():
        report = report.replace("{{" + name + "}}", part)
    assert "{{" not in report, report[report.index("{{"):][:40]
    with open(os.path.join(out, "resampling.md"), "w") as file:
        file.write(report)


if __name__ == "__main__":
    main()
