// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/saliency.h"

#include <algorithm>
#include <cassert>

#include "eigen_kernel.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {
namespace {

constexpr int kSize = SaliencyBlock::kSize;

/// Entry of the scatter matrix from sum(ab), sum(a), sum(b) about a place within the support
/// volume. There a mean is below 128 k steps and the least variance that quantising leaves is 1/12:
/// the difference loses nothing that counts. Both terms are the same number when all points are
/// one.
LADAR_INLINE double scatterEntry(double n, double ab, double a, double b, double by_n_squared) {
  return (n * ab - a * b) * by_n_squared;
}

Eigen::Vector3d pointingUp(const Eigen::Vector3d& direction) {
  return direction.z() < 0.0 ? Eigen::Vector3d(-direction) : direction;
}

/// Moments of a block's volumes about their voxels' centres, in steps.
struct MomentBlock {
  double n[kSize];
  double x[kSize], y[kSize], z[kSize];
  double xx[kSize], xy[kSize], xz[kSize], yy[kSize], yz[kSize], zz[kSize];
};

LADAR_INLINE void centerMoments(const Moments* sums, const VoxelIndex* voxels, int count,
                                MomentBlock* __restrict__ block, uint32_t* __restrict__ points) {
  for (int i = 0; i < kSize; ++i) {
    const CenteredMoments m = i < count ? sums[i].about(centerOf(voxels[i])) : CenteredMoments();
    points[i] = static_cast<uint32_t>(m.n);
    block->n[i] = static_cast<double>(m.n);
    block->x[i] = static_cast<double>(m.x);
    block->y[i] = static_cast<double>(m.y);
    block->z[i] = static_cast<double>(m.z);
    block->xx[i] = static_cast<double>(m.xx);
    block->xy[i] = static_cast<double>(m.xy);
    block->xz[i] = static_cast<double>(m.xz);
    block->yy[i] = static_cast<double>(m.yy);
    block->yz[i] = static_cast<double>(m.yz);
    block->zz[i] = static_cast<double>(m.zz);
  }
}

LADAR_INLINE void scatterOf(const MomentBlock& m, double step_m, ScatterBlock* __restrict__ scatter,
                            float (*__restrict__ mean)[kSize]) {
  for (int i = 0; i < kSize; ++i) {
    const double by_n = step_m / std::max(m.n[i], 1.0);
    mean[0][i] = static_cast<float>(m.x[i] * by_n);
    mean[1][i] = static_cast<float>(m.y[i] * by_n);
    mean[2][i] = static_cast<float>(m.z[i] * by_n);
    const auto entry = [&](double ab, double a, double b) LADAR_INLINE_LAMBDA {
      return static_cast<float>(scatterEntry(m.n[i], ab, a, b, by_n * by_n));
    };
    scatter->xx[i] = entry(m.xx[i], m.x[i], m.x[i]);
    scatter->xy[i] = entry(m.xy[i], m.x[i], m.y[i]);
    scatter->xz[i] = entry(m.xz[i], m.x[i], m.z[i]);
    scatter->yy[i] = entry(m.yy[i], m.y[i], m.y[i]);
    scatter->yz[i] = entry(m.yz[i], m.y[i], m.z[i]);
    scatter->zz[i] = entry(m.zz[i], m.z[i], m.z[i]);
  }
}

LADAR_INLINE void solveBlock(const ScatterBlock& c, SaliencyBlock* __restrict__ out) {
  for (int i = 0; i < kSize; ++i) {
    const auto r = eigen_kernel::solve<float>(c.xx[i], c.xy[i], c.xz[i], c.yy[i], c.yz[i], c.zz[i]);
    // Rounding can leave a negative number where the exact value is 0.
    const float scatter = std::max(r.l0, 0.0F);
    out->scatter[i] = scatter;
    out->surface[i] = std::max(r.l1 - scatter, 0.0F);
    out->linear[i] = std::max(r.l2 - r.l1, 0.0F);
    const float normal_up = r.e0.z < 0.0F ? -1.0F : 1.0F;
    out->normal[0][i] = normal_up * r.e0.x;
    out->normal[1][i] = normal_up * r.e0.y;
    out->normal[2][i] = normal_up * r.e0.z;
    const float tangent_up = r.e2.z < 0.0F ? -1.0F : 1.0F;
    out->tangent[0][i] = tangent_up * r.e2.x;
    out->tangent[1][i] = tangent_up * r.e2.y;
    out->tangent[2][i] = tangent_up * r.e2.z;
  }
}

/// Undefined saliency is all zeros. A trace of 0 is exact: all points are one.
LADAR_INLINE void clearUndefined(const ScatterBlock& c, SaliencyBlock* __restrict__ out) {
  for (int i = 0; i < kSize; ++i) {
    const uint32_t enough = out->points[i] >= 3U ? 1U : 0U;
    const uint32_t spread = c.xx[i] + c.yy[i] + c.zz[i] > 0.0F ? 1U : 0U;
    out->defined[i] = enough & spread;
    const auto keep = static_cast<float>(static_cast<int32_t>(enough & spread));
    out->scatter[i] *= keep;
    out->surface[i] *= keep;
    out->linear[i] *= keep;
    for (int axis = 0; axis < 3; ++axis) {
      out->normal[axis][i] *= keep;
      out->tangent[axis][i] *= keep;
    }
  }
}

}  // namespace

SymmetricMatrix3 scatterMatrix(const CenteredMoments& m, double step_m) {
  if (m.n == 0) return {};
  const auto n = static_cast<double>(m.n);
  const double by_n = step_m / n;
  const auto entry = [&](int64_t ab, int64_t a, int64_t b) {
    return scatterEntry(n, static_cast<double>(ab), static_cast<double>(a), static_cast<double>(b),
                        by_n * by_n);
  };
  return {entry(m.xx, m.x, m.x), entry(m.xy, m.x, m.y), entry(m.xz, m.x, m.z),
          entry(m.yy, m.y, m.y), entry(m.yz, m.y, m.z), entry(m.zz, m.z, m.z)};
}

Saliency saliencyOf(const CenteredMoments& moments, double step_m) {
  Saliency result;
  result.points = static_cast<uint32_t>(moments.n);
  const EigenSymmetric3 eigen = eigenSymmetric3(scatterMatrix(moments, step_m));
  if (moments.n < 3 || !(eigen.l2 > 0.0)) return result;
  result.defined = true;
  result.scatter = std::max(eigen.l0, 0.0);
  result.surface = std::max(eigen.l1 - result.scatter, 0.0);
  result.linear = std::max(eigen.l2 - eigen.l1, 0.0);
  result.normal = pointingUp(eigen.e0);
  result.tangent = pointingUp(eigen.e2);
  return result;
}

void saliencyOfBlock(const Moments* sums, const VoxelIndex* voxels, int count, double step_m,
                     SaliencyBlock* block) {
  assert(count <= kSize);
  MomentBlock moments;
  dispatch([&]() LADAR_INLINE_LAMBDA {
    centerMoments(sums, voxels, count, &moments, block->points);
    scatterOf(moments, step_m, &block->matrix, block->mean);
    solveBlock(block->matrix, block);
    clearUndefined(block->matrix, block);
  });
}

}  // namespace ladar_perception
