#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Gives the points of a cloud the colours of the camera pictures they are seen in.

    color_cloud.py CLOUD.npz META OUT.ply

CLOUD has an array `cloud` with fields x y z in the sensor's frame. META holds camera_NAME.yaml
(camera_matrix, distortion_coefficients of the plumb-bob model), pictures *_camera_NAME.png, and
transformations.yaml with T_base_link__camera_NAME and T_base_link__SENSOR (--sensor, os_sensor).
Points that no camera sees, that another point hides, or that are not finite are left out.
"""
import argparse
import glob
import os
import re

import matplotlib.image
import numpy as np

BLOCK = 12  # pixels over which a near point hides far ones
HIDDEN = 1.06  # ratio of depths from which on it does


def numbers(text, name):
    """The list `data` of a matrix in YAML, in either of its styles; no YAML library needed."""
    body = text[re.search(rf"^{name}:", text, re.M).end():]
    body = body[body.index("data:") + 5:]
    inline = re.match(r"\s*\[(.*?)\]", body, re.S)
    if inline:
        return np.array([float(part) for part in inline.group(1).split(",")])
    lines = re.match(r"((?:\s*-\s*'?[-\d.e]+'?\n)+)", body)
    return np.array([float(part) for part in re.findall(r"-\s*'?(-?[\d.]+)'?", lines.group(1))])


def project(points, matrix, distortion):
    """Pixels (plumb bob)."""
    x, y = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
    k1, k2, p1, p2, k3 = distortion
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    # Beyond this the polynomial folds back into the picture.
    sane = (r2 < 1.2) & (radial > 0)
    return u * matrix[0, 0] + matrix[0, 2], v * matrix[1, 1] + matrix[1, 2], sane


def seen(points, u, v, inside):
    """Points that no much nearer one hides."""
    keys = (v // BLOCK).astype(int) * 100000 + (u // BLOCK).astype(int)
    nearest = {}
    depths = points[:, 2]
    for i in np.flatnonzero(inside):
        nearest[keys[i]] = min(nearest.get(keys[i], np.inf), depths[i])
    return np.array([ok and depths[i] < HIDDEN * nearest[keys[i]] for i, ok in enumerate(inside)])


def write_ply(path, points, colors):
    record = np.dtype([("p", "<f4", 3), ("c", "u1", 3)])
    data = np.zeros(len(points), record)
    data["p"], data["c"] = points, colors
    with open(path, "wb") as out:
        out.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n".encode())
        for axis in "xyz":
            out.write(f"property float {axis}\n".encode())
        for part in ("red", "green", "blue"):
            out.write(f"property uchar {part}\n".encode())
        out.write(b"end_header\n" + data.tobytes())


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("cloud")
    parser.add_argument("meta")
    parser.add_argument("out")
    parser.add_argument("--sensor", default="os_sensor")
    parser.add_argument("--min-range", type=float, default=1.0, help="m; nearer is the vehicle")
    options = parser.parse_args()
    cloud = np.load(options.cloud)["cloud"]
    points = np.stack([cloud[axis] for axis in "xyz"], -1).astype(float)
    points = points[np.isfinite(points).all(-1)]
    points = points[np.linalg.norm(points, axis=1) > options.min_range]
    with open(os.path.join(options.meta, "transformations.yaml")) as file:
        transformations = file.read()
    base_sensor = numbers(transformations, f"T_base_link__{options.sensor}").reshape(4, 4)
    colors = np.zeros((len(points), 3), np.uint8)
    colored = np.zeros(len(points), bool)
    for picture in sorted(glob.glob(os.path.join(options.meta, "*_camera_*.png"))):
        name = re.search(r"camera_\w+", os.path.basename(picture)).group(0)
        with open(os.path.join(options.meta, name + ".yaml")) as file:
            camera = file.read()
        base_camera = numbers(transformations, "T_base_link__" + name).reshape(4, 4)
        transform = np.linalg.inv(base_camera) @ base_sensor
        local = points @ transform[:3, :3].T + transform[:3, 3]
        image = matplotlib.image.imread(picture)
        image = (255 * image[..., :3]).astype(np.uint8) if image.dtype != np.uint8 else image
        local[local[:, 2] < 0.1] = (0, 0, -1)
        u, v, sane = project(local, numbers(camera, "camera_matrix").reshape(3, 3),
                             numbers(camera, "distortion_coefficients"))
        inside = (local[:, 2] > 0) & sane & (u >= 0) & (u < image.shape[1] - 1)
        inside &= (v >= 0) & (v < image.shape[0] - 1)
        fresh = seen(local, np.where(inside, u, 0), np.where(inside, v, 0), inside) & ~colored
        colors[fresh] = image[v[fresh].astype(int), u[fresh].astype(int), :3]
        colored |= fresh
    if not colored.any():
        raise SystemExit("color_cloud.py: no point lies in a picture")
    write_ply(options.out, points[colored], colors[colored])
    print(f"{options.out}: {colored.sum()} of {len(points)} points have a colour")


if __name__ == "__main__":
    main()
