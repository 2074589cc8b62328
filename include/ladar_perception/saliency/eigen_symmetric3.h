// SPDX-License-Identifier: BSD-3-Clause
// Eigenvalues and outer eigenvectors of a symmetric 3 x 3 matrix, for scatter matrices of any rank.
#pragma once

#include <Eigen/Core>

namespace ladar_perception {

/// Upper triangle of a symmetric 3 x 3 matrix.
struct SymmetricMatrix3 {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
};

/// Eigenvalues in ascending order with unit eigenvectors of the least and the greatest. Where an
/// eigenvalue is double or triple, the vector is one of its eigenspace (any one).
struct EigenSymmetric3 {
  double l0 = 0, l1 = 0, l2 = 0;
  Eigen::Vector3d e0 = Eigen::Vector3d::UnitZ();  ///< of l0: the normal of a surface
  Eigen::Vector3d e2 = Eigen::Vector3d::UnitX();  ///< of l2: the tangent of a line
};

/// Finds the root of the characteristic polynomial that is farthest from the two others, then its
/// eigenvector, and solves the 2 x 2 problem in the plane across it. The usual closed form by the
/// cosine loses half of the digits where two eigenvalues meet, which is on every plane and wire;
/// this keeps errors near 1e-15 of the greatest eigenvalue for rank 0, 1, 2 and 3.
EigenSymmetric3 eigenSymmetric3(const SymmetricMatrix3& matrix);

}  // namespace ladar_perception
