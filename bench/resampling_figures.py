# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of re-sampled clouds, as the sensor sees them: azimuth to the right, elevation up."""
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

# Control volumes of the campus, m in the world: (low, high) in x, y, z. The window is in the brick
# building across the street, with the bricks around it.
VOLUMES = {
    "floor": ((-24.94, -21.64), (40.98, 42.08), (-0.3, 0.1)),
    "foliage": ((-29.94, -24.94), (55.48, 60.48), (2.6, 8.6)),
    "bicycles": ((-21.44, -18.04), (40.88, 43.18), (0.15, 1.3)),
    "wall": ((-13.59, -12.19), (49.58, 50.18), (1.2, 9.6)),
    "window": ((-24.44, -18.44), (12.88, 14.08), (3.5, 6.8)),
}
COLORS = {"floor": "red", "foliage": "lime", "bicycles": "blue", "wall": "cyan",
          "window": "magenta"}
# Axes of the vehicle in those of the sensor of the real cloud, and volumes in the vehicle's.
REAL_AXES = np.array([[-0.704, 0.655, 0.274], [-0.682, -0.732, -0.001], [0.200, -0.187, 0.962]])
REAL_VOLUMES = {
    "ground": ((0.9, 2.6), (0.0, 1.8), (-1.2, -0.2)),
    "leaves": ((1.0, 4.6), (-4.0, -0.4), (-0.9, 2.5)),
    "wall": ((5.2, 9.5), (-9.0, -1.0), (-0.5, 4.0)),
}


def load(folder, name, columns):
    return np.fromfile(os.path.join(folder, name + ".bin"), "<f4").reshape(-1, columns)


def inside(points, box):
    low = np.array([side[0] for side in box])
    high = np.array([side[1] for side in box])
    return ((points >= low) & (points <= high)).all(-1)


def rgb(values):
    bits = values.astype(np.uint32)
    return np.stack([bits >> 16 & 255, bits >> 8 & 255, bits & 255], -1) / 255.0


def angles(points):
    azimuth = np.degrees(np.arctan2(points[:, 1], points[:, 0]))
    elevation = np.degrees(np.arcsin(points[:, 2] / np.linalg.norm(points, axis=1)))
    return -azimuth, elevation


def panel(axes, points, colors, size, title, limits=((-180, 180), (-50, 46)), **options):
    """Points far away first, so that near ones lie on top."""
    order = np.argsort(-np.linalg.norm(points[:, :3], axis=1), kind="stable")
    u, v = angles(points[order, :3])
    size = size[order] if np.ndim(size) else size
    drawn = axes.scatter(u, v, s=size, c=colors[order], linewidths=0, rasterized=True, **options)
    axes.set_xlim(*limits[0])
    axes.set_ylim(*limits[1])
    axes.set_title(title, fontsize=10)
    axes.set_xticks([])
    axes.set_yticks([])
    return drawn


def fronts(folder, stages, path):
    """Arrival times and Voronoi regions after few and many samples."""
    figure, axes = plt.subplots(len(stages), 2, figsize=(17, 4.6 * len(stages)))
    for row, stage in enumerate(stages):
        cells = load(folder, stage["name"], 5)
        reached = cells[np.isfinite(cells[:, 3]) & (cells[:, 4] >= 0)]
        # Near cells look larger.
        size = np.clip((9 / np.linalg.norm(reached[:, :3], axis=1)) ** 2, 0.8, 60)
        title = f"arrival times, {stage['samples']:,} samples, none farther than"
        drawn = panel(axes[row, 0], reached, reached[:, 3], size,
                      f"{title} {stage['radius_m']:g} m", cmap="turbo", vmin=0,
                      vmax=stage["radius_m"])
        figure.colorbar(drawn, ax=axes[row, 0], label="m", fraction=0.03)
        colors = np.random.default_rng(1).uniform(0.1, 1, (100003, 3))[reached[:, 4].astype(int)]
        panel(axes[row, 1], reached, colors, size, "regions of the samples")
    save(figure, path)


def outline(axes, box, color):
    """The edges of a control volume."""
    corners = np.array([[box[0][i], box[1][j], box[2][k]] for i in (0, 1) for j in (0, 1)
                        for k in (0, 1)])
    for a in range(8):
        for bit in (1, 2, 4):
            if a & bit:
                continue
            edge = corners[a] + np.linspace(0, 1, 20)[:, None] * (corners[a | bit] - corners[a])
            axes.plot(*angles(edge), color=color, linewidth=0.9)


def moved(box, sensor):
    """A box of the world as seen from the sensor."""
    return tuple((side[0] - at, side[1] - at) for side, at in zip(box, sensor))


def volumes(folder, sensor, path):
    figure, axes = plt.subplots(3, 1, figsize=(15, 15))
    for axis, name, title, size in ((axes[0], "raw", "raw", 0.6),
                                    (axes[1], "uniform", "uniform", 3),
                                    (axes[2], "normals", "normals, variation inhibited", 3)):
        cloud = load(folder, name, 5)
        panel(axis, cloud, rgb(cloud[:, 3]), size, f"{title}: {len(cloud):,} points")
        for volume, world_box in VOLUMES.items():
            box = moved(world_box, sensor)
            outline(axis, box, COLORS[volume])
            points = int(inside(cloud[:, :3], box).sum())
            u, v = angles(np.array([[side[1] for side in box]]))
            axis.text(u[0] + 1, v[0] + 1, f"{volume} {points:,}", color="white", fontsize=8,
                      bbox={"facecolor": "black", "alpha": 0.8, "pad": 1})
    save(figure, path)


def weighted(folder, name, path):
    figure, axes = plt.subplots(3, 1, figsize=(15, 15))
    raw = load(folder, "raw", 5)
    if name == "color":
        panel(axes[0], raw, rgb(raw[:, 3]), 0.6, "colours")
    else:
        palette = np.array([[0.6, 0.6, 0.6], [0.75, 0.55, 0.3], [0.2, 0.7, 0.2], [0.2, 0.3, 0.8]])
        panel(axes[0], raw, palette[raw[:, 4].astype(int)], 0.6,
              "classes: floor brown, foliage green, other blue")
    weights = load(folder, name + "_weights", 4)
    low, high = np.percentile(weights[:, 3], (1, 99))
    drawn = panel(axes[1], weights, weights[:, 3], 0.6, "weights", cmap="turbo",
                  norm=matplotlib.colors.LogNorm(max(low, 1e-3), max(high, 2e-3)))
    figure.colorbar(drawn, ax=axes[1], fraction=0.02)
    samples = load(folder, name, 5)
    panel(axes[2], samples, rgb(samples[:, 3]), 3, f"samples: {len(samples):,}")
    save(figure, path)


def real(clouds, names, path):
    figure, axes = plt.subplots(1 + len(names), 1, figsize=(13, 4.2 * (1 + len(names))))
    for axis, cloud, name in zip(axes, clouds, ["raw"] + names):
        colors = np.clip(1.5 * rgb(cloud[:, 3]), 0, 1)
        panel(axis, cloud, colors, 2.5 if name == "raw" else 8, f"{name}: {len(cloud):,} points",
              limits=((-182, 60), (-36, 32)))
        for volume, box in REAL_VOLUMES.items():
            outline(axis, box, {"ground": "red", "leaves": "lime", "wall": "cyan"}[volume])
    save(figure, path)


def save(figure, path):
    figure.tight_layout()
    figure.savefig(path, dpi=75, facecolor="white")
    plt.close(figure)
    # A palette is enough and makes the files a third as large.
    try:
        from PIL import Image
    except ImportError:
        return
    Image.open(path).convert("RGB").quantize(192).save(path, optimize=True)
