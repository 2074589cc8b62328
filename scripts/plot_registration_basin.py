#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws the pictures of a run of registration_basin, beside its basin.json.

  plot_registration_basin.py FOLDER

basin_curves.png: residual at termination and time against perturbations of x, y and yaw, as in
figure 8 of Cole, Harrison, Newman. basin_success.png: shares of random starts that found the truth,
and how far the others ended from it.
"""
import json
import os
import sys

try:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError as error:
    print(f"plot_registration_basin.py: {error}: apt-get install python3-matplotlib",
          file=sys.stderr)
    sys.exit(3)

plt.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3,
                     "axes.axisbelow": True, "savefig.dpi": 110, "savefig.bbox": "tight"})
COLORS = plt.rcParams["axes.prop_cycle"].by_key()["color"]
FAMILIES = (("x", "x (m)"), ("y", "y (m)"), ("yaw", "yaw (degrees)"))


def title_of(report):
    names = [os.path.basename(report[key]) for key in ("cloud_a", "cloud_b")]
    return f"{names[1]} on {names[0]}, {report['solver']}, {report['count']} samples"


def draw_curves(folder, report):
    methods = {name: one for name, one in report["methods"].items() if one["curves"]}
    if not methods:
        return
    rows = (("residual_m", "residual at termination (m)", False), ("error_m", "error (m)", True),
            ("ms", "time (ms)", True))
    figure, all_axes = plt.subplots(3, 3, figsize=(12.0, 8.4), sharey="row", sharex="col")
    for row, (key, label, logarithmic) in enumerate(rows):
        for axes, (family, name) in zip(all_axes[row], FAMILIES):
            for i, (method, one) in enumerate(methods.items()):
                curve = one["curves"].get(family)
                if curve:
                    axes.plot(curve["amount"], curve[key], "o-", markersize=3, linewidth=1,
                              color=COLORS[i % len(COLORS)], label=method)
            if logarithmic:
                axes.set_yscale("log")
            if row == 2:
                axes.set_xlabel("perturbation of " + name)
        all_axes[row][0].set_ylabel(label)
        if key == "error_m":
            for axes in all_axes[row]:
                axes.axhline(report["success_m"], color="0.3", linestyle=":", linewidth=1)
    figure.suptitle(title_of(report))
    figure.tight_layout()
    handles, labels = all_axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncol=min(len(labels), 7), frameon=False,
                  bbox_to_anchor=(0.5, 0.0))
    figure.savefig(os.path.join(folder, "basin_curves.png"))
    plt.close(figure)


def draw_success(folder, report):
    methods = report["methods"]
    figure, (shares, errors) = plt.subplots(
        1, 2, figsize=(11.0, 1.6 + 0.36 * len(methods)), gridspec_kw={"width_ratios": (2, 3)})
    for i, (method, one) in enumerate(methods.items()):
        low, high = one["interval"]
        color = COLORS[i % len(COLORS)]
        shares.plot([100 * low, 100 * high], [i, i], color=color, linewidth=2)
        shares.plot([100 * one["success"]], [i], "o", color=color)
        ends = sorted(max(start["error_m"], 1e-4) for start in one["random"])
        if ends:
            errors.plot(ends, [100 * (k + 1) / len(ends) for k in range(len(ends))], color=color,
                        label=method)
    shares.set_yticks(range(len(methods)), list(methods))
    shares.invert_yaxis()
    shares.set_xlabel("starts that found the truth (%), 95 % interval")
    errors.set_xscale("log")
    errors.axvline(report["success_m"], color="0.3", linestyle=":", linewidth=1)
    errors.set_xlabel("error at the end (m)")
    errors.set_ylabel("starts up to there (%)")
    figure.suptitle(title_of(report) + f", starts to {report['max_translation_m']:g} m and "
                    f"{report['max_rotation_deg']:g} degrees")
    figure.tight_layout()
    figure.savefig(os.path.join(folder, "basin_success.png"))
    plt.close(figure)


def main():
    if len(sys.argv) != 2 or sys.argv[1] in ("-h", "--help"):
        print(__doc__)
        return 0 if len(sys.argv) == 2 else 2
    folder = sys.argv[1]
    try:
        with open(os.path.join(folder, "basin.json"), encoding="utf-8") as file:
            report = json.load(file)
        draw_curves(folder, report)
        draw_success(folder, report)
    except (OSError, ValueError, KeyError) as problem:
        print(f"plot_registration_basin.py: {folder}: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
