// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/saliency.h"

#include <algorithm>

namespace ladar_perception {
namespace {

Eigen::Vector3d pointingUp(const Eigen::Vector3d& direction) {
  return direction.z() < 0.0 ? Eigen::Vector3d(-direction) : direction;
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
  Saliency result;
  result.points = static_cast<uint32_t>(moments.n);
  if (moments.n < 3) return result;
  const EigenSymmetric3 eigen = eigenSymmetric3(scatterMatrix(moments, step_m));
  if (!(eigen.l2 > 0.0)) return result;
  result.defined = true;
  // Rounding can leave -1e-17 where the exact value is 0.
  result.scatter = std::max(eigen.l0, 0.0);
  result.surface = std::max(eigen.l1 - result.scatter, 0.0);
  result.linear = std::max(eigen.l2 - eigen.l1, 0.0);
  result.normal = pointingUp(eigen.e0);
  result.tangent = pointingUp(eigen.e2);
  return result;
}

}  // namespace ladar_perception
