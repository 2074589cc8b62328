// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "ladar_perception/slam/pose_graph.h"
#include "slam_cases.h"

namespace ladar_perception {
namespace {

using test::addDrive;
using test::makeConstraint;
using test::normal6;
using test::randomPose;
using test::rmsPositionError;
using test::squareDrive;
using test::TestRandom;

constexpr ConstraintKind kOdometry = ConstraintKind::kOdometry;
constexpr ConstraintKind kRegistration = ConstraintKind::kRegistration;
const Eigen::Isometry3d kOrigin = Eigen::Isometry3d::Identity();

TEST(SlamPoseGraph, NoneAndOnePoseAreOptimal) {
  PoseGraph graph;
  EXPECT_EQ(graph.optimize().poses, 0);
  graph.addPose(kOrigin);
  EXPECT_EQ(graph.optimize().poses, 0);
  EXPECT_EQ(graph.optimizeAround({0}, 10).poses, 0);
  EXPECT_EQ(graph.treeFrom(0)[0].hops, 0);
}

TEST(SlamPoseGraph, TwoPosesMeetTheirConstraintExactly) {
  TestRandom random(1);
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Isometry3d T_01 = randomPose(&random, 5.0, 0.8);
    PoseGraph graph;
    graph.addPose(randomPose(&random, 100.0, 1.0));
    graph.addPose(graph.pose(0) * plus(T_01, normal6(&random, 1.0, 0.5)));
    graph.addConstraint(makeConstraint(0, 1, T_01, diagonalCovariance(0.1, 0.01), kOdometry));
    const OptimizeReport report = graph.optimize();
    EXPECT_TRUE(report.converged);
    EXPECT_LT(report.iterations, 12) << "Gauss-Newton with right derivatives is fast";
    EXPECT_LT(minus(graph.relative(0, 1), T_01).norm(), 1e-7);
  }
}

TEST(SlamPoseGraph, TwoMeasurementsAreWeighedByTheirInformation) {
  PoseGraph graph;
  graph.addPose(kOrigin);
  graph.addPose(kOrigin);
  Eigen::Isometry3d near = kOrigin;
  Eigen::Isometry3d far = kOrigin;
  near.translation().x() = 1.0;
  far.translation().x() = 2.0;
  graph.addConstraint(makeConstraint(0, 1, near, diagonalCovariance(0.1, 0.1), kOdometry));
  graph.addConstraint(makeConstraint(0, 1, far, diagonalCovariance(0.2, 0.1), kOdometry));
  graph.optimize();
  // Variances 1 : 4.
  EXPECT_NEAR(graph.pose(1).translation().x(), 1.2, 1e-8);
}

TEST(SlamPoseGraph, SingularInformationSaysNothingAlongItsNullSpace) {
  PoseGraph graph;
  graph.addPose(kOrigin);
  graph.addPose(kOrigin);
  Eigen::Isometry3d there = kOrigin;
  there.translation() << 1.0, 1.0, 0.0;
  graph.addConstraint(makeConstraint(0, 1, kOrigin, diagonalCovariance(1.0, 0.1), kOdometry));
  PoseConstraint corridor =
      makeConstraint(0, 1, there, diagonalCovariance(0.001, 0.001), kRegistration);
  corridor.information(0, 0) = 0.0;
  graph.addConstraint(corridor);
  graph.optimize();
  EXPECT_NEAR(graph.pose(1).translation().x(), 0.0, 1e-9);
  EXPECT_NEAR(graph.pose(1).translation().y(), 1.0, 1e-3);
}

TEST(SlamPoseGraph, RefusesConstraintsThatMeanNothing) {
  PoseGraph graph;
  graph.addPose(kOrigin);
  graph.addPose(kOrigin);
  const auto refused = [&](int from, int to) {
    try {
      graph.addConstraint(makeConstraint(from, to, kOrigin, Matrix6d::Identity(), kOdometry));
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refused(0, 1), "");
  EXPECT_EQ(refused(0, 2), "constraint from pose 0 to pose 2: there is no such pose");
  EXPECT_EQ(refused(-1, 1), "constraint from pose -1 to pose 1: there is no such pose");
  EXPECT_EQ(refused(1, 1), "constraint from pose 1 to pose 1: both ends are the same pose");
  EXPECT_EQ(graph.constraints().size(), 1u);
}

/// A drive around a square of 25 m with a drift of half a degree a metre, closed by one constraint.
TEST(SlamPoseGraph, ClosingASquareRemovesItsDrift) {
  TestRandom random(2);
  const auto truth = squareDrive(25, 1, 1.0);
  PoseGraph graph;
  graph.addPose(truth.front());
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const auto to = static_cast<int>(i);
    Vector6d drift = normal6(&random, 0.002, 0.0002);
    drift(5) += 0.5 * M_PI / 180.0;
    const Eigen::Isometry3d step = plus(truth[i - 1].inverse(Eigen::Isometry) * truth[i], drift);
    graph.addPose(graph.pose(to - 1) * step);
    graph.addConstraint(
        makeConstraint(to - 1, to, step, diagonalCovariance(0.01, 0.01), kOdometry));
  }
  const double before = rmsPositionError(graph, truth);
  const int last = graph.size() - 1;
  graph.addConstraint(makeConstraint(0, last, truth[0].inverse(Eigen::Isometry) * truth[last],
                                     diagonalCovariance(0.01, 0.001), kRegistration));
  const OptimizeReport report = graph.optimize();
  EXPECT_GT(before, 5.0);
  EXPECT_LT(rmsPositionError(graph, truth), before / 10.0);
  EXPECT_EQ(report.retired, 0);
  EXPECT_LT(report.final_cost, report.initial_cost);
}

/// Two laps with constraints between them, of which some are wrong by metres.
PoseGraph lapsWithWrongConstraints(const std::vector<Eigen::Isometry3d>& truth, int wrong) {
  TestRandom random(3);
  PoseGraph graph;
  addDrive(truth, 0.02, 0.002, &random, &graph);
  const int lap = graph.size() / 2;
  for (int i = 0; i < lap; i += 2) {
    const bool is_wrong = i / 2 < wrong;
    const Eigen::Isometry3d measured =
        plus(truth[i].inverse(Eigen::Isometry) * truth[i + lap],
             is_wrong ? normal6(&random, 3.0, 0.2) : normal6(&random, 0.01, 0.001));
    graph.addConstraint(
        makeConstraint(i, i + lap, measured, diagonalCovariance(0.01, 0.001), kRegistration));
  }
  return graph;
}

TEST(SlamPoseGraph, AFewWrongConstraintsAreRetired) {
  const auto truth = squareDrive(20, 2, 1.0);
  PoseGraph right = lapsWithWrongConstraints(truth, 0);
  right.optimize();
  PoseGraph mixed = lapsWithWrongConstraints(truth, 6);
  const OptimizeReport report = mixed.optimize();
  EXPECT_EQ(report.retired, 6);
  for (std::size_t i = 0; i < mixed.constraints().size(); ++i) {
    const PoseConstraint& constraint = mixed.constraints()[i];
    const bool is_wrong = constraint.kind == kRegistration && constraint.from < 12;
    EXPECT_EQ(constraint.enabled, !is_wrong) << i;
    EXPECT_EQ(mixed.robustWeight(constraint) == 0.0, is_wrong) << i;
  }
  EXPECT_LT(rmsPositionError(mixed, truth), 1.5 * rmsPositionError(right, truth));
}

TEST(SlamPoseGraph, RetiredConstraintsComeBackWhenTheyAgree) {
  TestRandom random(6);
  const auto truth = squareDrive(5, 1, 1.0);
  PoseGraph graph;
  addDrive(truth, 0.002, 0.0002, &random, &graph);
  const Eigen::Isometry3d measured = truth[2].inverse(Eigen::Isometry) * truth[6];
  const int right = graph.addConstraint(
      makeConstraint(2, 6, measured, diagonalCovariance(0.05, 0.005), kRegistration));
  graph.setEnabled(right, false);
  EXPECT_EQ(graph.optimize().retired, 0);
  EXPECT_TRUE(graph.constraints()[right].enabled);
}

TEST(SlamPoseGraph, TheSameBitsEveryTime) {
  const auto truth = squareDrive(20, 2, 1.0);
  PoseGraph a = lapsWithWrongConstraints(truth, 4);
  PoseGraph b = lapsWithWrongConstraints(truth, 4);
  a.optimize();
  b.optimize();
  for (int i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.pose(i).matrix(), b.pose(i).matrix());
  }
}

TEST(SlamPoseGraph, AWindowMovesOnlyItself) {
  TestRandom random(4);
  PoseGraph graph;
  addDrive(squareDrive(10, 1, 1.0), 0.02, 0.002, &random, &graph);
  const Eigen::Isometry3d measured = plus(graph.relative(28, 30), normal6(&random, 0.02, 0.002));
  graph.addConstraint(
      makeConstraint(28, 30, measured, diagonalCovariance(0.005, 0.0005), kRegistration));
  const PoseGraph before = graph;
  const std::vector<int> window = graph.around({30, 28}, 6);
  EXPECT_EQ(window, (std::vector<int>{30, 28, 29, 31, 27, 32}));
  const OptimizeReport report = graph.optimizeAround({30, 28}, 6);
  EXPECT_EQ(report.poses, 6);
  EXPECT_EQ(report.constraints, 8);  // 26-27 up to 32-33, and the new one
  for (int i = 0; i < graph.size(); ++i) {
    const bool inside = i >= 27 && i <= 32;
    EXPECT_EQ(graph.pose(i).matrix() == before.pose(i).matrix(), !inside) << i;
  }
}

TEST(SlamPoseGraph, AWindowOfEverythingIsTheWholeGraph) {
  const auto truth = squareDrive(10, 2, 1.0);
  PoseGraph window = lapsWithWrongConstraints(truth, 0);
  PoseGraph whole = window;
  EXPECT_EQ(window.optimizeAround({40}, 1000).poses, window.size() - 1);
  whole.optimize();
  for (int i = 0; i < whole.size(); ++i) {
    EXPECT_LT(minus(whole.pose(i), window.pose(i)).norm(), 1e-7);
  }
}

/// Residuals evaluated when one more pose joins `poses` that drive round and round.
int64_t evaluationsOfOneMore(int poses) {
  TestRandom random(5);
  const auto truth = squareDrive(5, poses / 20 + 1, 1.0);
  PoseGraph graph;
  const auto constrain = [&](int from, int to, double sigma_m, ConstraintKind kind) {
    const Eigen::Isometry3d measured = plus(truth[from].inverse(Eigen::Isometry) * truth[to],
                                            normal6(&random, sigma_m, 0.1 * sigma_m));
    graph.addConstraint(
        makeConstraint(from, to, measured, diagonalCovariance(sigma_m, 0.1 * sigma_m), kind));
  };
  for (int i = 0; i < poses; ++i) {
    graph.addPose(truth[i]);
    if (i > 0) constrain(i - 1, i, 0.02, kOdometry);
  }
  const auto close = [&](int to) {
    for (const int from : {to - 20, to - 40}) {
      if (from >= 0) constrain(from, to, 0.01, kRegistration);
    }
  };
  for (int to = 20; to + 1 < poses; ++to) close(to);
  close(poses - 1);
  return graph.optimizeAround({poses - 1}, 40).residual_evaluations;
}

TEST(SlamPoseGraph, OneMorePoseCostsTheSameAtAThousandPoses) {
  const int64_t at_100 = evaluationsOfOneMore(100);
  const int64_t at_1000 = evaluationsOfOneMore(1000);
  EXPECT_GT(at_100, 0);
  EXPECT_LE(at_1000, 2 * at_100);
}

TEST(SlamPoseGraph, TreeCompoundsCovarianceAlongTheDrive) {
  PoseGraph graph;
  for (int i = 0; i < 4; ++i) {
    Eigen::Isometry3d T = kOrigin;
    T.translation().x() = 10.0 * i;
    graph.addPose(T);
  }
  for (int i = 0; i < 3; ++i) {
    graph.addConstraint(makeConstraint(i, i + 1, graph.relative(i, i + 1),
                                       diagonalCovariance(0.1, 0.01), kOdometry));
  }
  const auto tree = graph.treeFrom(0);
  EXPECT_EQ(tree[3].parent, 2);
  EXPECT_EQ(tree[3].hops, 3);
  const Matrix6d& covariance = tree[3].covariance;
  EXPECT_NEAR(covariance(0, 0), 3 * 0.01, 1e-12);
  // Angles at 0, 1 and 2 steps before the end, with levers of 0, 10 and 20 m.
  EXPECT_NEAR(covariance(1, 1), 3 * 0.01 + 1e-4 * (100.0 + 400.0), 1e-12);
  EXPECT_NEAR(covariance(5, 5), 3 * 1e-4, 1e-12);
  // Seen from the other end, the drive is the same.
  const auto back = graph.treeFrom(3);
  EXPECT_EQ(back[0].hops, 3);
  EXPECT_TRUE(
      invertedCovariance(graph.relative(3, 0), back[0].covariance).isApprox(covariance, 1e-9));
}

TEST(SlamPoseGraph, TreeTakesTheBetterPathAndNothingRetired) {
  PoseGraph graph;
  for (int i = 0; i < 5; ++i) graph.addPose(kOrigin);
  for (int i = 0; i < 3; ++i) {
    graph.addConstraint(
        makeConstraint(i, i + 1, kOrigin, diagonalCovariance(0.1, 0.01), kOdometry));
  }
  const int shortcut = graph.addConstraint(
      makeConstraint(3, 0, kOrigin, diagonalCovariance(0.05, 0.005), kRegistration));
  EXPECT_EQ(graph.treeFrom(0)[3].parent, 0);
  EXPECT_EQ(graph.treeFrom(0)[2].parent, 3);
  graph.setEnabled(shortcut, false);
  EXPECT_EQ(graph.treeFrom(0)[3].parent, 2);
  EXPECT_EQ(graph.treeFrom(0)[4].hops, -1) << "nothing leads there";
}

}  // namespace
}  // namespace ladar_perception
