// SPDX-License-Identifier: BSD-3-Clause
// Readers of PCD and PLY files; PCL does the decoding, these check what PCL does not.
#pragma once

#include <string>

#include "ladar_perception/io/scan.h"

namespace ladar_perception {

/// Scan with every field of a PCD file (ascii, binary or binary_compressed) but padding. 64-bit
/// integers, which a PointCloud2 cannot carry, become float64. Throws std::runtime_error that
/// names the file and what is wrong; a file that ends early is an error. VIEWPOINT is not applied.
Scan readPcdScan(const std::string& path);

/// Scan with every scalar property of the vertices of a PLY file (ascii or binary); red, green and
/// blue become one rgb field, nx ny nz become normal_x normal_y normal_z. Errors as above.
Scan readPlyScan(const std::string& path);

}  // namespace ladar_perception
