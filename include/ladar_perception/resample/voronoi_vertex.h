// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "ladar_perception/resample/fronts.h"

namespace ladar_perception {

/// A place the fronts reach late.
struct VoronoiVertex {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  float time = 0;  ///< of the earliest front there
};

/// Whether no neighbour of the cell is reached later (ties go to the lesser number).
bool isLatest(const FrontField& field, uint32_t cell);

/// The vertex near a cell that is the latest around: the circumcentre, in the cell's plane, of the
/// three nearest samples whose fronts meet there, if it lies in the cell and is reached later than
/// the cell's own place; else that.
VoronoiVertex findVertex(const FrontField& field, uint32_t cell);

}  // namespace ladar_perception
