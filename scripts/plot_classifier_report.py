#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws the pictures of a report of train_classifier or evaluate_classifier, beside its report.json.

  plot_classifier_report.py FOLDER

Of a training: components.png (what the number of components was chosen by) and features.png (the
features of every class with their mixtures). Of an evaluation: confusion.png, reliability.png,
features.png (pairs of features with the mixtures) and cloud_<n>.png (truth and labels side by side).
"""
import itertools
import json
import math
import os
import sys

try:
    import numpy as np
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.patches import Ellipse
except ImportError as error:
    print(f"plot_classifier_report.py: {error}: apt-get install python3-matplotlib", file=sys.stderr)
    sys.exit(3)

UNKNOWN_COLOR = "#808080"
PAIRS = 6  # scatter plots of features

plt.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3,
                     "axes.axisbelow": True, "savefig.dpi": 110, "savefig.bbox": "tight"})


def save(figure, folder, name):
    figure.savefig(os.path.join(folder, name))
    plt.close(figure)


def grid(count, columns, size):
    """A figure with `count` axes; those of an unfinished last row are hidden."""
    columns = min(columns, count)
    rows = math.ceil(count / columns)
    figure, axes = plt.subplots(rows, columns, figsize=(size[0] * columns, size[1] * rows),
                                squeeze=False)
    flat = list(axes.flat)
    for unused in flat[count:]:
        unused.set_visible(False)
    return figure, flat[:count]


# ------------------------------------------------------------------------------------- training

def draw_scores(folder, report):
    scored = [one for one in report["classes"] if one["scores"]]
    if not scored:
        return  # the number of components was given
    figure, all_axes = grid(len(scored), 3, (3.9, 3.1))
    for axes, one in zip(all_axes, scored):
        counts = [score["components"] for score in one["scores"]]
        axes.plot(counts, [score["log_likelihood"] for score in one["scores"]], "o--",
                  color="0.55", markersize=4, label="samples learned from")
        held_out = [score["held_out"] for score in one["scores"]]
        if None not in held_out:
            errors = [score["held_out_error"] for score in one["scores"]]
            axes.errorbar(counts, held_out, errors, fmt="s-", color="tab:blue", markersize=4,
                          capsize=3, label="places left out")
        twin = axes.twinx()
        twin.grid(False)
        twin.plot(counts, [score["bic"] for score in one["scores"]], "v:", color="tab:orange",
                  markersize=4, label="BIC (right axis)")
        axes.axvline(one["components"], color="tab:green", alpha=0.5)
        axes.set_title(f"{one['name']}: {one['components']} by {one['chosen_by']}", fontsize=9)
        axes.set_xlabel("components")
        axes.set_ylabel("log-likelihood per sample")
        handles, labels = axes.get_legend_handles_labels()
        more = twin.get_legend_handles_labels()
    figure.tight_layout()
    figure.legend(handles + more[0], labels + more[1], loc="upper center", ncol=3, frameon=False,
                  bbox_to_anchor=(0.5, 0.0))
    save(figure, folder, "components.png")


def marginal(mixture, feature, x):
    """Density of one feature under a mixture."""
    density = np.zeros_like(x)
    for part in mixture:
        variance = part["covariance"][feature][feature]
        density += part["weight"] * np.exp(-0.5 * (x - part["mean"][feature]) ** 2 / variance) \
            / math.sqrt(2.0 * math.pi * variance)
    return density


def draw_histograms(folder, report):
    features = report["features"]
    figure, all_axes = grid(len(features), 3, (3.9, 2.8))
    for f, (axes, feature) in enumerate(zip(all_axes, features)):
        histogram = feature["histogram"]
        edges = np.linspace(histogram["from"], histogram["to"], len(histogram["counts"][0]) + 1)
        x = np.linspace(edges[0], edges[-1], 400)
        width = edges[1] - edges[0]
        for one, counts in zip(report["classes"], histogram["counts"]):
            density = np.array(counts) / max(sum(counts), 1) / width
            axes.stairs(density, edges, fill=True, color=one["color"], alpha=0.25)
            axes.plot(x, marginal(one["mixture"], f, x), color=one["color"], label=one["name"])
        axes.set_xlabel(f"{feature['name']} ({feature['unit']})")
        axes.set_yticklabels([])
    all_axes[0].legend(fontsize=7)
    figure.suptitle("samples (filled) and what their mixtures make of them (lines)", fontsize=10)
    figure.tight_layout()
    save(figure, folder, "features.png")


# ----------------------------------------------------------------------------------- evaluation

def draw_confusion(folder, report):
    names = report["classes"]
    counts = np.column_stack([np.array(report["confusion"]), np.array(report["unknown"])])
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    size = 1.6 + 0.85 * len(names)
    figure, axes = plt.subplots(figsize=(size + 1.6, size))
    axes.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    axes.grid(False)
    axes.set_xticks(range(len(names) + 1), names + ["unknown"], rotation=30, ha="right")
    axes.set_yticks(range(len(names)), names)
    axes.set_xlabel("label")
    axes.set_ylabel("truth")
    for row, column in itertools.product(range(counts.shape[0]), range(counts.shape[1])):
        axes.text(column, row, f"{100 * shares[row, column]:.1f} %\n{counts[row, column]:,}",
                  ha="center", va="center", fontsize=8,
                  color="white" if shares[row, column] > 0.5 else "black")
    axes.set_title(f"mean recall {report['mean_recall']:.3f}, mean F1 {report['mean_f1']:.3f}")
    save(figure, folder, "confusion.png")


def draw_reliability(folder, report):
    calibration = report["calibration"]
    figure, all_axes = plt.subplots(1, 2, figsize=(8.4, 4.1), sharey=True)
    parts = (("bins", "ece", "every point alike"),
             ("class_balanced_bins", "class_balanced_ece", "every class alike"))
    for axes, (bins, error, title) in zip(all_axes, parts):
        confidence = [one["confidence"] for one in calibration[bins]]
        share = [one["share"] for one in calibration[bins]]
        axes.bar(confidence, share, width=0.04, color="0.8", label="share of the points")
        axes.plot([0, 1], [0, 1], color="0.5", linewidth=1)
        axes.plot(confidence, [one["accuracy"] for one in calibration[bins]], "o-",
                  color="tab:blue", markersize=4, label="share that is right")
        axes.set_xlim(0, 1)
        axes.set_ylim(0, 1)
        axes.set_aspect("equal")
        axes.set_xlabel("confidence")
        axes.set_title(f"{title}: expected calibration error {calibration[error]:.3f}",
                       fontsize=9)
        axes.legend(fontsize=7, loc="upper left")
    save(figure, folder, "reliability.png")


def ellipse(part, pair, **style):
    """Two standard deviations of a component in the plane of two features."""
    covariance = np.array(part["covariance"])[np.ix_(pair, pair)]
    values, vectors = np.linalg.eigh(covariance)
    angle = math.degrees(math.atan2(vectors[1, 1], vectors[0, 1]))
    width, height = 4.0 * np.sqrt(values[::-1])
    return Ellipse([part["mean"][pair[0]], part["mean"][pair[1]]], width, height, angle=angle,
                   fill=False, **style)


def telling_features(samples, count):
    """The features whose class means differ most for their spread, best first."""
    means = np.array([values.mean(axis=0) for values in samples])
    within = np.mean([values.var(axis=0) for values in samples], axis=0)
    ratio = means.var(axis=0) / np.maximum(within, 1e-12)
    return list(np.argsort(-ratio, kind="stable")[:count])


def draw_feature_pairs(folder, report, data):
    present = [(one, np.array(values["values"]), report["colors"][c], data["mixtures"][c])
               for c, (one, values) in enumerate(zip(report["classes"], data["samples"]))
               if len(values["values"]) > 1]
    if not present or len(data["features"]) < 2:
        return
    best = telling_features([values for _, values, _, _ in present], 4)
    pairs = list(itertools.combinations(best, 2))[:PAIRS]
    figure, all_axes = grid(len(pairs), 3, (4.0, 3.6))
    for axes, pair in zip(all_axes, pairs):
        everything = np.vstack([values[:, pair] for _, values, _, _ in present])
        low, high = np.percentile(everything, [0.5, 99.5], axis=0)
        room = 0.08 * np.maximum(high - low, 1e-9)
        for name, values, color, mixture in present:
            axes.scatter(values[:, pair[0]], values[:, pair[1]], s=3, alpha=0.25, color=color,
                         linewidths=0, rasterized=True)
            for part in mixture:
                axes.add_patch(ellipse(part, pair, edgecolor="black", linewidth=2.4, alpha=0.5))
                axes.add_patch(ellipse(part, pair, edgecolor=color, linewidth=1.3,
                                       alpha=0.35 + 0.65 * min(1.0, 2.0 * part["weight"])))
            axes.plot([], [], "o", color=color, label=name)
        axes.set_xlim(low[0] - room[0], high[0] + room[0])
        axes.set_ylim(low[1] - room[1], high[1] + room[1])
        axes.set_xlabel(data["features"][pair[0]])
        axes.set_ylabel(data["features"][pair[1]])
    all_axes[0].legend(fontsize=7)
    figure.suptitle("features by true class; ellipses: two deviations of the mixtures' components",
                    fontsize=10)
    figure.tight_layout()
    save(figure, folder, "features.png")


def along_main_axis(points):
    """x, y turned so that the cloud is longest along the first."""
    plane = points[:, :2] - points[:, :2].mean(axis=0)
    _, vectors = np.linalg.eigh(np.cov(plane.T))
    turned = plane @ vectors[:, ::-1]
    low = np.percentile(turned, 0, axis=0)
    return np.column_stack([turned - low, points[:, 2] - np.percentile(points[:, 2], 1)])


def draw_cloud(folder, report, cloud, name):
    rows = np.load(os.path.join(folder, cloud["file"]))
    if len(rows) < 3:
        return
    colors = np.array([UNKNOWN_COLOR] + report["colors"])
    points = along_main_axis(rows[:, :3].astype(float))
    extent = np.maximum(np.ptp(points, axis=0), 1.0)
    views = ((0, 1, 2, "from above"), (0, 2, 1, "from the side"))
    heights = [8.0 * extent[y] / extent[x] for x, y, _, _ in views]
    figure, all_axes = plt.subplots(2, 2, figsize=(16.0, max(sum(heights), 2.0) + 1.6),
                                    gridspec_kw={"height_ratios": heights})
    wrong = 100.0 * np.mean(rows[:, 3] != rows[:, 4])
    titles = ("truth", f"labels ({wrong:.1f} % of the points shown are wrong)")
    for row, (x, y, depth, view) in enumerate(views):
        # What is nearer to the eye is drawn last.
        order = np.argsort(points[:, depth] if depth == 2 else -points[:, depth], kind="stable")
        for column, axes in enumerate(all_axes[row]):
            classes = rows[order, 3 + column].astype(int)
            axes.scatter(points[order, x], points[order, y], s=1.5, c=colors[classes],
                         linewidths=0, rasterized=True)
            axes.set_aspect("equal")
            axes.grid(False)
            axes.set_title(f"{titles[column]}, {view} (m)", fontsize=10)
    handles = [plt.Line2D([], [], marker="o", linestyle="", color=color, label=label)
               for label, color in zip(["unknown"] + report["classes"], colors)]
    figure.legend(handles=handles, loc="lower center", ncol=min(len(handles), 9), frameon=False)
    figure.suptitle(os.path.basename(cloud["name"].rstrip("/")), fontsize=11)
    figure.tight_layout(rect=(0, 0.03, 1, 1))
    save(figure, folder, name)


def main():
    if len(sys.argv) != 2 or sys.argv[1] in ("-h", "--help"):
        print(__doc__)
        return 0 if len(sys.argv) == 2 else 2
    folder = sys.argv[1]
    try:
        with open(os.path.join(folder, "report.json"), encoding="utf-8") as file:
            report = json.load(file)
        if report.get("kind") == "training":
            draw_scores(folder, report)
            draw_histograms(folder, report)
            return 0
        draw_confusion(folder, report)
        draw_reliability(folder, report)
        with open(os.path.join(folder, "picture_data.json"), encoding="utf-8") as file:
            data = json.load(file)
    except (OSError, ValueError, KeyError) as problem:
        print(f"plot_classifier_report.py: {folder}: {problem}", file=sys.stderr)
        return 1
    draw_feature_pairs(folder, report, data)
    for cloud in data["clouds"]:
        draw_cloud(folder, report, cloud, os.path.splitext(cloud["file"])[0] + ".png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
