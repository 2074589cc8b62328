# SPDX-License-Identifier: BSD-3-Clause
"""The figures of Lalonde, Vandapel and Hebert 2005, drawn from the numbers of paper_tables."""
import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

# The paper draws the original method in blue and the new one in red.
STYLES = {
    "hash_brute": ("original: brute force on a hash map", "tab:blue", "o"),
    "dense_brute": ("brute force on a dense array", "tab:cyan", "s"),
    "naive_scan": ("naive ordered scan", "tab:gray", "v"),
    "paper_reuse": ("new: Algorithm 1 of the paper", "tab:red", "D"),
    "sliding": ("ours: sliding sums", "tab:green", "^"),
}
TITLES = {"flat_ground": "flat ground", "forest": "forest", "tall_grass": "tall grass"}
K = 9

plt.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3,
                     "axes.axisbelow": True, "savefig.dpi": 110, "savefig.bbox": "tight"})


def save(figure, folder, name):
    figure.savefig(f"{folder}/{name}.png")
    plt.close(figure)


def draw_curve(axes, curve, strategies):
    """ms per occupied voxel against radius."""
    for name in strategies:
        label, color, marker = STYLES[name]
        axes.plot([point["radius_m"] for point in curve],
                  [point["ns"][name] * 1e-6 for point in curve],
                  label=label, color=color, marker=marker, markersize=4)
    axes.set_yscale("log")
    axes.set_xlabel("radius r (m)")
    axes.set_ylabel("ms per occupied voxel")


def panels(parts, title, strategies):
    """One panel of times against radius per part, all on the same axes."""
    figure, all_axes = plt.subplots(1, len(parts), figsize=(3.6 * len(parts), 3.1), sharey=True)
    for axes, part in zip(all_axes, parts):
        draw_curve(axes, part["curve"], strategies)
        axes.set_title(title(part), fontsize=9)
        axes.set_xlim(left=0.0)
    for axes in all_axes[1:]:
        axes.set_ylabel("")
    handles, labels = all_axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=len(labels), frameon=False,
                  bbox_to_anchor=(0.5, -0.08))
    figure.tight_layout()
    return figure


def visits(point):
    """Voxels visited per occupied voxel: equations 1 and 3, with the d and P that were measured."""
    brute = K ** 3
    reuse = (2 * point["d"] * K ** 2 - K ** 3) * point["p"] + K ** 3 + 1 / point["density"]
    return brute, reuse


def bound(points):
    """The density from which equation 4 holds, between two that were measured; None if beyond."""
    def slack(point):
        return point["density"] - 1 / ((K ** 3 - 2 * point["d"] * K ** 2) * point["p"])
    for low, high in zip(points, points[1:]):
        if slack(low) < 0 <= slack(high):
            share = -slack(low) / (slack(high) - slack(low))
            return low["density"] + share * (high["density"] - low["density"])
    return None


def figure_6(data, folder):
    points = data["figure_6"]
    density = [100 * point["density"] for point in points]
    limit = bound(points)
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(11.5, 3.2))
    left.plot(density, [visits(point)[0] for point in points], color="tab:blue", marker="o",
              markersize=4, label="brute force, eq. 1")
    left.plot(density, [visits(point)[1] for point in points], color="tab:red", marker="D",
              markersize=4, label="Algorithm 1, eq. 3")
    left.set_ylabel("visits per occupied voxel")
    left.set_title("predicted from d and P", fontsize=9)
    left.set_ylim(bottom=0.0)
    left.legend(fontsize=8, frameon=False)
    for name in ("hash_brute", "dense_brute", "paper_reuse", "sliding"):
        label, color, marker = STYLES[name]
        middle.plot(density, [point["ns"][name] * 1e-6 for point in points], color=color,
                    marker=marker, markersize=4, label=label)
    middle.set_yscale("log")
    middle.set_ylabel("ms per occupied voxel")
    middle.set_title("measured", fontsize=9)
    for name in ("hash_brute", "dense_brute"):
        label, color, marker = STYLES[name]
        right.plot(density, [point["ns"][name] / point["ns"]["paper_reuse"] for point in points],
                   color=color, marker=marker, markersize=4, label=f"over {label.split(': ')[-1]}")
    right.axhline(1.0, color="black", linewidth=0.8)
    right.set_yscale("log")
    right.set_ylabel("speed-up of Algorithm 1")
    right.set_title("measured", fontsize=9)
    right.legend(fontsize=8, loc="center", bbox_to_anchor=(0.6, 0.25))
    for axes in (left, middle, right):
        axes.set_xlabel("point density (% of the voxels)")
        axes.set_xlim(left=0.0)
        if limit is not None:
            axes.axvline(100 * limit, color="black", linestyle="--", linewidth=1)
    handles, labels = middle.get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=4, frameon=False,
                  bbox_to_anchor=(0.5, -0.08))
    figure.tight_layout()
    save(figure, folder, "figure_6")


def figure_7(data, folder):
    names = {1: "raw data", 10: "1 point in 10", 100: "1 point in 100"}
    figure = panels(data["figure_7"],
                    lambda part: f"{names[part['step']]}: {part['occupied']:,} occupied voxels",
                    ("hash_brute", "paper_reuse", "sliding"))
    save(figure, folder, "figure_7")


def figure_8(data, folder):
    figure = panels(data["figure_8"],
                    lambda part: f"voxels of {100 * part['voxel_size_m']:.0f} cm: "
                                 f"{part['occupied']:,} occupied",
                    ("hash_brute", "paper_reuse", "sliding"))
    save(figure, folder, "figure_8")


def draw_cloud(figure, position, voxels):
    axes = figure.add_axes(position, projection="3d")
    x, y, z = (voxels[:, i] * 0.1 for i in range(3))
    points = axes.scatter(x, y, z, c=z, cmap="jet", s=1.6, linewidths=0)
    axes.set_box_aspect((np.ptp(x), np.ptp(y), np.ptp(z)), zoom=1.12)
    axes.view_init(elev=38, azim=-58)
    axes.set_axis_off()
    return points


def figure_9_clouds(data, folder):
    figure = plt.figure(figsize=(13.0, 4.2))
    for i, part in enumerate(data["figure_9"]):
        voxels = np.loadtxt(f"{data['folder']}/{part['scene']}.csv", delimiter=",")
        left = i / 3
        points = draw_cloud(figure, (left - 0.01, 0.02, 0.31, 0.95), voxels)
        scale = figure.add_axes((left + 0.295, 0.3, 0.006, 0.4))
        figure.colorbar(points, cax=scale).set_label("height (m)", fontsize=8)
        scale.tick_params(labelsize=8)
        figure.text(left + 0.15, 0.93, TITLES[part["scene"]], ha="center", fontsize=10)
    save(figure, folder, "figure_9_clouds")


def figure_9_histograms(data, folder):
    axes_names = ("best", "x", "y", "z")
    shown = 12  # farther ones together with none at all
    parts = data["figure_9"]
    figure, grid = plt.subplots(len(parts), 4, figsize=(11.5, 2.2 * len(parts)), sharex=True,
                                sharey=True)
    for row, part in zip(grid, parts):
        for axes, name in zip(row, axes_names):
            histogram = np.array(part["histograms"][name], dtype=float)
            share = histogram / histogram.sum()
            bars = np.append(share[1:shown + 1], share[shown + 1:].sum())
            colors = ["tab:red" if 2 * (i + 1) < K else "tab:gray" for i in range(len(bars))]
            axes.bar(range(1, len(bars) + 1), 100 * bars, color=colors, width=0.8)
            axes.set_ylim(0, 100)
            axes.text(0.95, 0.9, f"P = {share[:(K + 1) // 2].sum():.4f}",
                      transform=axes.transAxes, ha="right", va="top", fontsize=8)
            axes.set_xticks([1, 4, 8, 12, 13])
            axes.set_xticklabels(["1", "4", "8", "", "far"])
    for axes, name in zip(grid[0], axes_names):
        axes.set_title("best of three" if name == "best" else f"along {name}", fontsize=9)
    for axes in grid[-1]:
        axes.set_xlabel("distance X (voxels)")
    for row, part in zip(grid, parts):
        row[0].set_ylabel(f"{TITLES[part['scene']]}\n% of occupied voxels")
    figure.tight_layout()
    save(figure, folder, "figure_9_histograms")


def figure_9_times(data, folder):
    figure = panels(data["figure_9"], lambda part: TITLES[part["scene"]], tuple(STYLES))
    figure.legends[0].remove()
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=3, frameon=False,
                  bbox_to_anchor=(0.5, -0.14))
    save(figure, folder, "figure_9_times")


def draw_all(data, folder):
    for draw in (figure_6, figure_7, figure_8, figure_9_clouds, figure_9_histograms,
                 figure_9_times):
        draw(data, folder)
