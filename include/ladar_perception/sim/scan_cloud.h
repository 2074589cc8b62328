// SPDX-License-Identifier: BSD-3-Clause
// Scans as the bytes of a point cloud.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/cloud/cloud_layout.h"
#include "ladar_perception/sim/ladar.h"

namespace ladar_perception::sim {

/// Organised cloud, little endian: x y z intensity (float32), ring (uint16; row 0 is the top),
/// time (float32, seconds after the stamp), truth (uint8, see Truth), rgb (float32 that holds the
/// bits 0x00RRGGBB), label (uint16, see Label).
CloudLayout scanLayout(const LadarConfig& config);

/// Bytes of one scan in that layout.
std::vector<uint8_t> encodeScan(const Scan& scan, const LadarConfig& config);

/// What a scan contains.
struct ScanSummary {
  uint64_t beams = 0;
  uint64_t returned = 0;
  uint64_t mixed = 0;  ///< between two depths, whatever lies there
  uint64_t surface = 0;
  uint64_t scatter = 0;
  uint64_t linear = 0;

  void add(const Scan& scan);
};

}  // namespace ladar_perception::sim
