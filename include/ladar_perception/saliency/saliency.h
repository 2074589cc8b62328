// SPDX-License-Identifier: BSD-3-Clause
// Saliency features of a support volume, from its summed moments.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "ladar_perception/map/moments.h"
#include "ladar_perception/saliency/eigen_symmetric3.h"

namespace ladar_perception {

/// Shape of the points in a support volume, after Lalonde, Vandapel and Hebert 2005.
struct Saliency {
  uint32_t points = 0;   ///< in the support volume
  bool defined = false;  ///< false when the points span nothing (fewer than 3, or all equal)
  // l0 <= l1 <= l2: eigenvalues of the scatter matrix C = 1/N sum (p - mean)(p - mean)^T, in m^2.
  double scatter = 0.0;  ///< l0
  double surface = 0.0;  ///< l1 - l0
  double linear = 0.0;   ///< l2 - l1
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();   ///< eigenvector of l0, z >= 0
  Eigen::Vector3d tangent = Eigen::Vector3d::Zero();  ///< eigenvector of l2, z >= 0
};

/// Scatter matrix (covariance, divided by N) in m^2, exact up to the last division. Zero for N = 0.
SymmetricMatrix3 scatterMatrix(const CenteredMoments& moments, double step_m);

/// Saliency from moments about any point near the support volume; `step_m` is the quantisation
/// step, voxel size / kStepsPerVoxel.
Saliency saliencyOf(const CenteredMoments& moments, double step_m);

/// Support volumes that are worked on together.
constexpr int kSaliencyBlock = 64;
/// The same, bit by bit, for `count` <= kSaliencyBlock volumes, several at a time.
void saliencyOfBlock(const CenteredMoments* moments, int count, double step_m, Saliency* result);

}  // namespace ladar_perception
