// SPDX-License-Identifier: BSD-3-Clause
// The header of a PLY file, as far as it says how long the file must be.
#pragma once

#include <cstddef>

#include "text_table.h"

namespace ladar_perception {

struct PlyHeader {
  bool ascii = true;
  std::size_t vertices = 0;
  std::size_t properties = 0;    ///< of a vertex
  std::size_t vertex_bytes = 0;  ///< in binary files
  std::size_t bytes = 0;         ///< of the header
};

/// Reads up to `end_header`; the vertices must come first and have no lists. Throws
/// std::runtime_error that names the line.
PlyHeader readPlyHeader(LineReader& lines);

}  // namespace ladar_perception
