// SPDX-License-Identifier: BSD-3-Clause
// The file of a saved delayed state, version 1, little-endian:
//   8 bytes   "LADARDS1"
//   uint64    bytes of the payload
//   payload
//   uint64    64-bit FNV-1a of the payload
// Payload:
//   uint32 poses; each: float64 stamp; pose in odom; pose in map; uint8 has a step covariance, then
//     36 float64; 4 x uint32 lengths of positions, normals, rgb, labels; float32 x y z of positions
//     and of normals; uint32 rgb; uint8 labels
//   uint32 constraints; each: int32 from, int32 to; transform; 36 float64 of the information; uint8
//     kind; uint8 enabled
//   uint32 waiting constraints; each: as above; int32 hops
//   7 x uint64 counts: tried, accepted, diverged, low overlap, inconsistent, unconfirmed, waiting
// Poses and transforms are 12 float64, the 3x4 matrix by rows.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "ladar_perception/slam/delayed_state.h"

namespace ladar_perception {

struct StateContents {
  std::vector<StatePose> poses;
  PoseGraph graph;
  std::vector<std::pair<PoseConstraint, int>> waiting;  ///< with the hops they span
  ConstraintCounts counts;
};

/// Throws std::runtime_error that names the path. The file appears when it is complete.
void writeStateFile(const std::string& path, const StateContents& contents);
/// Throws std::runtime_error that names the path and what is wrong: no such file, no saved state,
/// another version, cut off, damaged, contradictory.
StateContents readStateFile(const std::string& path, const PoseGraphOptions& options);

}  // namespace ladar_perception
