// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/slam/graph_covariance.h"

#include <stdexcept>
#include <string>

namespace ladar_perception {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

// Of the information's largest entry: a smaller pivot is rounding, not knowledge.
constexpr double kLeastPivot = 1e-13;

/// Pose 0 is held and has no rows.
int rowOf(int pose) { return 6 * (pose - 1); }

void addBlock(int a, int b, const Matrix6d& block, Triplets* triplets) {
  if (a == 0 || b == 0) return;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) triplets->emplace_back(rowOf(a) + i, rowOf(b) + j, block(i, j));
  }
}

Sparse informationOf(const PoseGraph& graph) {
  Triplets triplets;
  for (const PoseConstraint& constraint : graph.constraints()) {
    const double weight = graph.robustWeight(constraint);
    if (weight <= 0.0) continue;
    const int a = constraint.from;
    const int b = constraint.to;
    const ConstraintResidual residual =
        constraintResidual(constraint, graph.pose(a), graph.pose(b));
    const Matrix6d W = weight * constraint.information;
    const Matrix6d cross = residual.by_from.transpose() * W * residual.by_to;
    addBlock(a, a, residual.by_from.transpose() * W * residual.by_from, &triplets);
    addBlock(b, b, residual.by_to.transpose() * W * residual.by_to, &triplets);
    addBlock(a, b, cross, &triplets);
    addBlock(b, a, cross.transpose(), &triplets);
  }
  const int rows = 6 * (graph.size() - 1);
  Sparse information(rows, rows);
  information.setFromTriplets(triplets.begin(), triplets.end());
  return information;
}

/// The entries of (L D L^T)^-1 where L has entries, by Takahashi's equations from the last column
/// to the first. L is unit lower triangular with its diagonal stored.
Sparse inverseOnPattern(const Sparse& L, const Eigen::VectorXd& D) {
  Sparse Z = L;
  const auto n = static_cast<int>(L.cols());
  const int* outer = L.outerIndexPtr();
  const int* inner = L.innerIndexPtr();
  const double* l = L.valuePtr();
  double* z = Z.valuePtr();
  std::vector<int> place(n, -1);  // of a row in the column at hand
  std::vector<double> sums;
  for (int j = n - 1; j >= 0; --j) {
    const int first = outer[j] + 1;  // after the diagonal
    const int end = outer[j + 1];
    sums.assign(end - first, 0.0);
    for (int e = first; e < end; ++e) place[inner[e]] = e - first;
    // sums = Z(rows, rows) * l, of which the lower triangle is in the columns done before.
    for (int e = first; e < end; ++e) {
      const int k = inner[e];
      sums[e - first] += z[outer[k]] * l[e];
      for (int f = outer[k] + 1; f < outer[k + 1]; ++f) {
        const int i = place[inner[f]];
        if (i < 0) continue;
        sums[i] += z[f] * l[e];
        sums[e - first] += z[f] * l[first + i];
      }
    }
    double diagonal = 1.0 / D(j);
    for (int e = first; e < end; ++e) {
      z[e] = -sums[e - first];
      diagonal -= l[e] * z[e];
      place[inner[e]] = -1;
    }
    z[outer[j]] = diagonal;
  }
  return Z;
}

}  // namespace

GraphCovariance::GraphCovariance(const PoseGraph& graph) : graph_(graph) {
  if (graph.size() < 2) return;
  const Sparse information = informationOf(graph);
  factor_.compute(information);
  const double least = kLeastPivot * Eigen::VectorXd(information.diagonal()).maxCoeff();
  if (factor_.info() != Eigen::Success || !(factor_.vectorD().minCoeff() > least)) {
    throw std::runtime_error("the constraints do not determine every one of the " +
                             std::to_string(graph.size()) + " poses");
  }
}

Eigen::MatrixXd GraphCovariance::columns(int pose) const {
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(rowOf(graph_.size()), 6);
  unit.middleRows<6>(rowOf(pose)).setIdentity();
  return factor_.solve(unit);
}

Matrix6d GraphCovariance::joint(int a, int b) const {
  if (a == 0 || b == 0) return Matrix6d::Zero();
  return columns(b).middleRows<6>(rowOf(a));
}

Matrix6d GraphCovariance::relative(int from, int to) const {
  if (from == to) return Matrix6d::Zero();
  Matrix6d from_from = Matrix6d::Zero();
  Matrix6d from_to = Matrix6d::Zero();
  Matrix6d to_to = Matrix6d::Zero();
  if (from != 0) from_from = columns(from).middleRows<6>(rowOf(from));
  if (to != 0) {
    const Eigen::MatrixXd column = columns(to);
    to_to = column.middleRows<6>(rowOf(to));
    if (from != 0) from_to = column.middleRows<6>(rowOf(from));
  }
  // The perturbation of T_from_to is that of `to` less that of `from`, carried along to `to`.
  const Matrix6d F = transportMatrix(graph_.relative(from, to));
  const Matrix6d cross = F * from_to;
  return F * from_from * F.transpose() - cross - cross.transpose() + to_to;
}

std::vector<Matrix6d> GraphCovariance::marginals() const {
  std::vector<Matrix6d> result(graph_.size(), Matrix6d::Zero());
  if (graph_.size() < 2) return result;
  const Sparse L = factor_.matrixL();
  const Sparse Z = inverseOnPattern(L, factor_.vectorD());
  const auto& order = factor_.permutationP().indices();  // of rows in the factor
  for (int pose = 1; pose < graph_.size(); ++pose) {
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        const int a = order(rowOf(pose) + i);
        const int b = order(rowOf(pose) + j);
        result[pose](i, j) = Z.coeff(std::max(a, b), std::min(a, b));
      }
    }
  }
  return result;
}

}  // namespace ladar_perception
