// SPDX-License-Identifier: BSD-3-Clause
// Clouds made like those of the paper's Table I. Their numbers of points are the paper's exactly;
// occupied voxels, d and P[X < k/2] at k = 9 are within 2 per cent of the paper's.
#pragma once

#include "bench_scenes.h"

namespace ladar_perception::bench {

/// Gravel trail, bordered by a jersey barrier with a rough bank behind, a concertina wire across.
Scene makeFlatGround();
/// Large trunks on rough terrain with short grass and debris.
Scene makeForest();
/// Side slope under dense waist-high grass, with some large poles.
Scene makeTallGrass();

}  // namespace ladar_perception::bench
