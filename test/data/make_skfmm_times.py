#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes skfmm_times.txt beside it: arrival times of scikit-fmm (Debian's python3-scikit-fmm).

An oracle that is independent of this package. The tests that read the file need neither Python nor
Debian's python3-scikit-fmm, which this does.
"""
import os

import numpy
import skfmm

HEAD = """\
# Arrival times in s of scikit-fmm's travel_time, made by make_skfmm_times.py with scikit-fmm {version}.
# For each field: its cells along x, y, z and their spacing in m; the cells where the time is 0;
# speeds in m/s; then times with differences of first and of second order. A line has the cells
# along x, the next line is the next y, then comes the next z.
"""

# name: cells along x, y, z; spacing; sources; speed at (x, y, z) in m
FIELDS = {
    "plane_uniform": ((25, 21, 1), 0.05, [(12, 10, 0)], lambda x, y, z: 1.0 + 0.0 * x),
    "plane_two_sources": ((25, 21, 1), 0.05, [(3, 4, 0), (19, 15, 0)],
                          lambda x, y, z: 0.5 + 0.0 * x),
    "plane_linear": ((25, 21, 1), 0.05, [(4, 10, 0)], lambda x, y, z: 0.5 + 1.5 * x),
    "plane_waves": ((25, 21, 1), 0.05, [(3, 4, 0)],
                    lambda x, y, z: 1.0 + 0.6 * numpy.sin(7.0 * x) * numpy.cos(5.0 * y)),
    "space_uniform": ((9, 8, 7), 0.1, [(4, 3, 3)], lambda x, y, z: 1.0 + 0.0 * x),
    "space_waves": ((9, 8, 7), 0.1, [(1, 2, 3)],
                    lambda x, y, z: 1.0 + 0.5 * numpy.sin(6.0 * x + 4.0 * y) * numpy.cos(5.0 * z)),
}


def rows(values, digits):
    """Lines of a field that is indexed [z, y, x]."""
    return "\n".join(" ".join(f"{value:.{digits}f}" for value in row)
                     for row in values.reshape(-1, values.shape[-1]))


def field_text(name, shape, spacing, sources, speed_at):
    z, y, x = numpy.meshgrid(*(spacing * numpy.arange(n) for n in reversed(shape)), indexing="ij")
    speed = numpy.round(speed_at(x, y, z), 4)  # as they are written
    phi = numpy.ones(speed.shape)
    for i, j, k in sources:
        phi[k, j, i] = 0.0
    # An axis of one cell has no differences, so it is dropped.
    flat_phi, flat_speed = numpy.squeeze(phi), numpy.squeeze(speed)
    lines = [f"field {name} {shape[0]} {shape[1]} {shape[2]} {spacing}",
             f"sources {len(sources)} " + "  ".join(f"{i} {j} {k}" for i, j, k in sources),
             "speeds", rows(speed, 4)]
    for order in (1, 2):
        times = skfmm.travel_time(flat_phi, flat_speed, dx=spacing, order=order)
        lines += [f"times {order}", rows(numpy.asarray(times).reshape(speed.shape), 8)]
    return "\n".join(lines) + "\n"


def main():
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "skfmm_times.txt")
    with open(path, "w", encoding="utf-8") as file:
        file.write(HEAD.format(version=skfmm.__version__))
        for name, (shape, spacing, sources, speed_at) in FIELDS.items():
            file.write(field_text(name, shape, spacing, sources, speed_at))


if __name__ == "__main__":
    main()
