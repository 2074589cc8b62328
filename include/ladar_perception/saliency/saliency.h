// SPDX-License-Identifier: BSD-3-Clause
// Saliency features of a support volume, from its summed moments.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "ladar_perception/map/moments.h"
#include "ladar_perception/saliency/eigen_symmetric3.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {

/// Shape of the points in a support volume, after Lalonde, Vandapel and Hebert 2005.
template <typename Scalar>
struct BasicSaliency {
  using Vector3 = Eigen::Matrix<Scalar, 3, 1>;

  uint32_t points = 0;   ///< in the support volume
  bool defined = false;  ///< false when the points span nothing (fewer than 3, or all equal)
  // l0 <= l1 <= l2: eigenvalues of the scatter matrix C = 1/N sum (p - mean)(p - mean)^T, in m^2.
  Scalar scatter = 0;                 ///< l0
  Scalar surface = 0;                 ///< l1 - l0
  Scalar linear = 0;                  ///< l2 - l1
  Vector3 normal = Vector3::Zero();   ///< eigenvector of l0, z >= 0
  Vector3 tangent = Vector3::Zero();  ///< eigenvector of l2, z >= 0
};

using Saliency = BasicSaliency<double>;
using SaliencyF = BasicSaliency<float>;

/// Scatter matrix (covariance, divided by N) in m^2. Zero for N = 0.
SymmetricMatrix3 scatterMatrix(const CenteredMoments& moments, double step_m);

/// Saliency from moments about any point near the support volume; `step_m` is the quantisation
/// step, voxel size / kStepsPerVoxel.
Saliency saliencyOf(const CenteredMoments& moments, double step_m);

/// Support volumes that are worked on together.
constexpr int kSaliencyBlock = 64;

/// Upper triangles of a block's scatter matrices, in m^2.
struct ScatterBlock {
  float xx[kSaliencyBlock], xy[kSaliencyBlock], xz[kSaliencyBlock];
  float yy[kSaliencyBlock], yz[kSaliencyBlock], zz[kSaliencyBlock];
};

/// Saliencies of a block of support volumes, quantity by quantity, for loops over many at a time.
struct SaliencyBlock {
  static constexpr int kSize = kSaliencyBlock;

  float scatter[kSize];
  float surface[kSize];
  float linear[kSize];
  float normal[3][kSize];
  float tangent[3][kSize];
  uint32_t points[kSize];
  uint32_t defined[kSize];  ///< 1 or 0
  ScatterBlock matrix;
  float mean[3][kSize];  ///< of the points, from the voxel's centre, in m

  LADAR_INLINE void get(int i, SaliencyF* saliency) const {
    saliency->points = points[i];
    saliency->defined = defined[i] != 0;
    saliency->scatter = scatter[i];
    saliency->surface = surface[i];
    saliency->linear = linear[i];
    for (int axis = 0; axis < 3; ++axis) {
      saliency->normal[axis] = normal[axis][i];
      saliency->tangent[axis] = tangent[axis][i];
    }
  }
  SaliencyF at(int i) const {
    SaliencyF saliency;
    get(i, &saliency);
    return saliency;
  }
};

/// Saliencies of `count` <= kSaliencyBlock voxels from the sums over their support volumes; the
/// rest of the block is undefined saliency. Scatter matrices are exact to double precision, then
/// all is float32: eigenvalues are good to 4e-7 of l2. The same bits on every vector level and for
/// every place in a block.
void saliencyOfBlock(const Moments* sums, const VoxelIndex* voxels, int count, double step_m,
                     SaliencyBlock* block);

}  // namespace ladar_perception
