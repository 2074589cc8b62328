// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <stdexcept>

#include "ladar_perception/slam/graph_covariance.h"
#include "slam_cases.h"

namespace ladar_perception {
namespace {

using test::addDrive;
using test::makeConstraint;
using test::normal6;
using test::randomCovariance;
using test::squareDrive;
using test::TestRandom;

constexpr ConstraintKind kOdometry = ConstraintKind::kOdometry;
constexpr ConstraintKind kRegistration = ConstraintKind::kRegistration;

/// Two laps with constraints of odd covariances between them.
PoseGraph twoLaps(TestRandom* random) {
  const auto truth = squareDrive(5, 2, 1.0);
  PoseGraph graph;
  addDrive(truth, 0.02, 0.005, random, &graph);
  const int lap = graph.size() / 2;
  for (int i = 0; i < lap; i += 3) {
    const Matrix6d covariance = randomCovariance(random, 0.01);
    const Matrix6d root = covariance.llt().matrixL();
    graph.addConstraint(makeConstraint(
        i, i + lap,
        plus(truth[i].inverse(Eigen::Isometry) * truth[i + lap], root * normal6(random, 1.0, 1.0)),
        covariance, kRegistration));
  }
  graph.optimize();
  return graph;
}

/// The inverse of the whole information, assembled from derivatives by differences.
Eigen::MatrixXd denseCovariance(const PoseGraph& graph) {
  const int rows = 6 * graph.size();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(rows, rows);
  for (const PoseConstraint& constraint : graph.constraints()) {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6, rows);
    for (const int pose : {constraint.from, constraint.to}) {
      for (int k = 0; k < 6; ++k) {
        const auto error = [&](double h) {
          Eigen::Isometry3d T_from = graph.pose(constraint.from);
          Eigen::Isometry3d T_to = graph.pose(constraint.to);
          Eigen::Isometry3d& moved = pose == constraint.from ? T_from : T_to;
          moved = plus(moved, h * Vector6d::Unit(k));
          return minus(T_from.inverse(Eigen::Isometry) * T_to, constraint.T_from_to);
        };
        J.col(6 * pose + k) = (error(1e-6) - error(-1e-6)) / 2e-6;
      }
    }
    information += graph.robustWeight(constraint) * J.transpose() * constraint.information * J;
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(rows, rows);
  covariance.bottomRightCorner(rows - 6, rows - 6) =
      information.bottomRightCorner(rows - 6, rows - 6).inverse();
  return covariance;
}

double relativeDifference(const Matrix6d& a, const Matrix6d& b) {
  return (a - b).norm() / (1e-12 + b.norm());
}

TEST(SlamGraphCovariance, AgreesWithTheDenseInverse) {
  TestRandom random(1);
  const PoseGraph graph = twoLaps(&random);
  const GraphCovariance covariance(graph);
  const Eigen::MatrixXd dense = denseCovariance(graph);
  const auto marginals = covariance.marginals();
  for (int a = 0; a < graph.size(); a += 3) {
    for (int b = 0; b < graph.size(); b += 5) {
      EXPECT_LT(relativeDifference(covariance.joint(a, b), dense.block<6, 6>(6 * a, 6 * b)), 1e-5);
    }
  }
  ASSERT_EQ(static_cast<int>(marginals.size()), graph.size());
  for (int a = 0; a < graph.size(); ++a) {
    EXPECT_LT(relativeDifference(marginals[a], dense.block<6, 6>(6 * a, 6 * a)), 1e-5) << a;
  }
}

TEST(SlamGraphCovariance, RelativeCovarianceDoesNotDependOnThePoseHeld) {
  TestRandom random(2);
  const PoseGraph graph = twoLaps(&random);
  // The same graph with poses in another order, so that another one is held.
  const int shift = 13;
  const auto moved = [&](int pose) { return (pose + shift) % graph.size(); };
  PoseGraph other;
  for (int i = 0; i < graph.size(); ++i) {
    other.addPose(graph.pose((i + graph.size() - shift) % graph.size()));
  }
  for (PoseConstraint constraint : graph.constraints()) {
    constraint.from = moved(constraint.from);
    constraint.to = moved(constraint.to);
    other.addConstraint(constraint);
  }
  const GraphCovariance covariance(graph);
  const GraphCovariance other_covariance(other);
  for (const auto& [from, to] : {std::pair{0, 7}, {3, 4}, {30, 5}, {39, 0}}) {
    EXPECT_LT(relativeDifference(covariance.relative(from, to),
                                 other_covariance.relative(moved(from), moved(to))),
              1e-8);
  }
}

TEST(SlamGraphCovariance, OfAChainIsTheCompoundOfItsSteps) {
  TestRandom random(3);
  PoseGraph graph;
  addDrive(squareDrive(5, 1, 2.0), 0.05, 0.01, &random, &graph);
  const GraphCovariance covariance(graph);
  const auto tree = graph.treeFrom(4);
  for (int i = 0; i < graph.size(); ++i) {
    EXPECT_LT(relativeDifference(tree[i].covariance, covariance.relative(4, i)), 1e-8) << i;
  }
  EXPECT_TRUE(covariance.joint(0, 5).isZero());
}

TEST(SlamGraphCovariance, TreeIsNeverMoreCertainThanAllConstraints) {
  TestRandom random(4);
  const PoseGraph graph = twoLaps(&random);
  const GraphCovariance covariance(graph);
  for (const int root : {0, 10, 27}) {
    const auto tree = graph.treeFrom(root);
    for (int i = 0; i < graph.size(); ++i) {
      // Robust weights enlarge exact covariances: at most by what the constraint is off.
      const Matrix6d excess = tree[i].covariance - 0.6 * covariance.relative(root, i);
      const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(excess, Eigen::EigenvaluesOnly);
      EXPECT_GT(solver.eigenvalues()(0), -1e-9) << root << " " << i;
    }
  }
}

/// The spread of estimates over noise drawn anew is what the covariance says.
TEST(SlamGraphCovariance, AgreesWithMonteCarlo) {
  TestRandom random(5);
  const auto truth = squareDrive(4, 1, 2.0);
  const int last = static_cast<int>(truth.size()) - 1;
  const int runs = 1500;
  Matrix6d spread = Matrix6d::Zero();
  Matrix6d relative_spread = Matrix6d::Zero();
  Matrix6d predicted;
  Matrix6d relative_predicted;
  for (int run = 0; run < runs; ++run) {
    PoseGraph graph;
    addDrive(truth, 0.02, 0.01, &random, &graph);
    graph.addConstraint(makeConstraint(
        0, last,
        plus(truth[0].inverse(Eigen::Isometry) * truth[last], normal6(&random, 0.01, 0.005)),
        diagonalCovariance(0.01, 0.005), kOdometry));
    graph.optimizeAround({0}, 100);
    const Vector6d d = minus(graph.pose(8), truth[8]);
    const Vector6d d_relative =
        minus(graph.relative(4, 11), truth[4].inverse(Eigen::Isometry) * truth[11]);
    spread += d * d.transpose() / runs;
    relative_spread += d_relative * d_relative.transpose() / runs;
    if (run > 0) continue;
    const GraphCovariance covariance(graph);
    predicted = covariance.marginals()[8];
    relative_predicted = covariance.relative(4, 11);
  }
  for (int i = 0; i < 6; ++i) {
    // A variance of 1500 samples is within 3.7 % one time of two thirds; four times that.
    EXPECT_NEAR(spread(i, i) / predicted(i, i), 1.0, 0.15) << i;
    EXPECT_NEAR(relative_spread(i, i) / relative_predicted(i, i), 1.0, 0.15) << i;
  }
  EXPECT_LT((spread - predicted).norm() / predicted.norm(), 0.15);
}

TEST(SlamGraphCovariance, RetiredConstraintsDoNotCount) {
  TestRandom random(6);
  PoseGraph graph;
  addDrive(squareDrive(3, 1, 1.0), 0.02, 0.01, &random, &graph);
  const Matrix6d before = GraphCovariance(graph).marginals()[9];
  const int closing = graph.addConstraint(
      makeConstraint(0, 9, graph.relative(0, 9), diagonalCovariance(0.001, 0.001), kRegistration));
  EXPECT_LT(GraphCovariance(graph).marginals()[9].trace(), 0.1 * before.trace());
  graph.setEnabled(closing, false);
  EXPECT_EQ(GraphCovariance(graph).marginals()[9], before);
}

TEST(SlamGraphCovariance, SaysWhenPosesAreNotDetermined) {
  PoseGraph graph;
  graph.addPose(Eigen::Isometry3d::Identity());
  EXPECT_TRUE(GraphCovariance(graph).marginals().at(0).isZero());
  graph.addPose(Eigen::Isometry3d::Identity());
  EXPECT_THROW(GraphCovariance{graph}, std::runtime_error);
  PoseConstraint half =
      makeConstraint(0, 1, Eigen::Isometry3d::Identity(), Matrix6d::Identity(), kOdometry);
  half.information(3, 3) = 0.0;
  graph.addConstraint(half);
  EXPECT_THROW(GraphCovariance{graph}, std::runtime_error);
  graph.addConstraint(
      makeConstraint(0, 1, Eigen::Isometry3d::Identity(), Matrix6d::Identity(), kOdometry));
  EXPECT_NO_THROW(GraphCovariance{graph});
}

}  // namespace
}  // namespace ladar_perception
