// SPDX-License-Identifier: BSD-3-Clause
// Exact covariances of the estimate, from a sparse Cholesky factor of its information.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "ladar_perception/slam/pose_graph.h"

namespace ladar_perception {

/// Linearised at the present estimate with pose 0 held, robust weights included; constraints that
/// are retired do not count. Making one takes time in proportion to the poses, as does joint().
class GraphCovariance {
 public:
  /// Throws std::runtime_error if constraints do not determine every pose.
  explicit GraphCovariance(const PoseGraph& graph);

  /// Cross-covariance of the perturbations of two poses; the pose's own if they are the same.
  Matrix6d joint(int a, int b) const;
  /// Covariance of T_from_to.
  Matrix6d relative(int from, int to) const;
  /// Of every pose, from those entries of the inverse that the factor has, too (Takahashi's
  /// equations): much cheaper than joint() for each.
  std::vector<Matrix6d> marginals() const;

 private:
  using Sparse = Eigen::SparseMatrix<double>;

  /// The six columns of the inverse that belong to a pose.
  Eigen::MatrixXd columns(int pose) const;

  const PoseGraph& graph_;
  Eigen::SimplicialLDLT<Sparse> factor_;
};

}  // namespace ladar_perception
