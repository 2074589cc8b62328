// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/saliency.h"

#include <algorithm>
#include <cassert>

#include "eigen_kernel.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {
namespace {

Eigen::Vector3d pointingUp(const Eigen::Vector3d& direction) {
  return direction.z() < 0.0 ? Eigen::Vector3d(-direction) : direction;
}

Saliency makeSaliency(int64_t points, const EigenSymmetric3& eigen) {
  Saliency result;
  result.points = static_cast<uint32_t>(points);
  if (points < 3 || !(eigen.l2 > 0.0)) return result;
  result.defined = true;
  // Rounding can leave -1e-17 where the exact value is 0.
  result.scatter = std::max(eigen.l0, 0.0);
  result.surface = std::max(eigen.l1 - result.scatter, 0.0);
  result.linear = std::max(eigen.l2 - eigen.l1, 0.0);
  result.normal = pointingUp(eigen.e0);
  result.tangent = pointingUp(eigen.e2);
  return result;
}

struct MatrixBlock {
  double xx[kSaliencyBlock] = {}, xy[kSaliencyBlock] = {}, xz[kSaliencyBlock] = {};
  double yy[kSaliencyBlock] = {}, yz[kSaliencyBlock] = {}, zz[kSaliencyBlock] = {};
};

struct EigenBlock {
  double l0[kSaliencyBlock], l1[kSaliencyBlock], l2[kSaliencyBlock];
  double e0x[kSaliencyBlock], e0y[kSaliencyBlock], e0z[kSaliencyBlock];
  double e2x[kSaliencyBlock], e2y[kSaliencyBlock], e2z[kSaliencyBlock];
};

LADAR_VECTOR_DISPATCH
void solveBlock(const MatrixBlock& a, EigenBlock* __restrict__ out) {
  for (int i = 0; i < kSaliencyBlock; ++i) {
    const eigen_kernel::Result r =
        eigen_kernel::solve(a.xx[i], a.xy[i], a.xz[i], a.yy[i], a.yz[i], a.zz[i]);
    out->l0[i] = r.l0;
    out->l1[i] = r.l1;
    out->l2[i] = r.l2;
    out->e0x[i] = r.e0.x;
    out->e0y[i] = r.e0.y;
    out->e0z[i] = r.e0.z;
    out->e2x[i] = r.e2.x;
    out->e2y[i] = r.e2.y;
    out->e2z[i] = r.e2.z;
  }
}

}  // namespace

SymmetricMatrix3 scatterMatrix(const CenteredMoments& m, double step_m) {
  if (m.n == 0) return {};
  // N sum(ab) - sum(a) sum(b) is an exact integer below 2^63 (see maxPointsPerVoxel): no
  // cancellation, whatever the distance of the points from the reference.
  const double n = static_cast<double>(m.n);
  const double scale = step_m * step_m / (n * n);
  const auto entry = [&](int64_t ab, int64_t a, int64_t b) {
    return static_cast<double>(m.n * ab - a * b) * scale;
  };
  return {entry(m.xx, m.x, m.x), entry(m.xy, m.x, m.y), entry(m.xz, m.x, m.z),
          entry(m.yy, m.y, m.y), entry(m.yz, m.y, m.z), entry(m.zz, m.z, m.z)};
}

Saliency saliencyOf(const CenteredMoments& moments, double step_m) {
  const EigenSymmetric3 eigen = eigenSymmetric3(scatterMatrix(moments, step_m));
  return makeSaliency(moments.n, eigen);
}

void saliencyOfBlock(const CenteredMoments* moments, int count, double step_m, Saliency* result) {
  assert(count <= kSaliencyBlock);
  MatrixBlock matrices;
  for (int i = 0; i < count; ++i) {
    const SymmetricMatrix3 c = scatterMatrix(moments[i], step_m);
    matrices.xx[i] = c.xx;
    matrices.xy[i] = c.xy;
    matrices.xz[i] = c.xz;
    matrices.yy[i] = c.yy;
    matrices.yz[i] = c.yz;
    matrices.zz[i] = c.zz;
  }
  EigenBlock eigen;
  solveBlock(matrices, &eigen);
  for (int i = 0; i < count; ++i) {
    result[i] = makeSaliency(moments[i].n, {eigen.l0[i],
                                            eigen.l1[i],
                                            eigen.l2[i],
                                            {eigen.e0x[i], eigen.e0y[i], eigen.e0z[i]},
                                            {eigen.e2x[i], eigen.e2y[i], eigen.e2z[i]}});
  }
}

}  // namespace ladar_perception
