// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/eigen_symmetric3.h"

#include "eigen_kernel.h"

namespace ladar_perception {

EigenSymmetric3 eigenSymmetric3(const SymmetricMatrix3& a) {
  const eigen_kernel::Result<double> r = eigen_kernel::solve(a.xx, a.xy, a.xz, a.yy, a.yz, a.zz);
  return {r.l0, r.l1, r.l2, {r.e0.x, r.e0.y, r.e0.z}, {r.e2.x, r.e2.y, r.e2.z}};
}

}  // namespace ladar_perception
