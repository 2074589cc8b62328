// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <stdexcept>

#include "ladar_perception/slam/delayed_state.h"
#include "slam_stand_in.h"

namespace ladar_perception {
namespace {

using test::driftingOdometry;
using test::rmsPositionError;
using test::samplesOf;
using test::SpoilOutcome;
using test::squareDrive;
using test::standIn;
using test::statePose;

using Drive = std::vector<Eigen::Isometry3d>;

/// A state that has driven along `odometry`; the reports of all poses.
struct Driven {
  Driven(const Drive& truth, const Drive& odometry, const DelayedStateConfig& config = {},
         const SpoilOutcome& spoil = {})
      : state(config, standIn(truth, spoil)) {
    for (std::size_t i = 0; i < odometry.size(); ++i) {
      reports.push_back(state.add(statePose(static_cast<int>(i), odometry[i])));
    }
  }
  DelayedState state;
  std::vector<AddReport> reports;
};

double rmsError(const Drive& poses, const Drive& truth) {
  PoseGraph graph;
  for (const Eigen::Isometry3d& pose : poses) graph.addPose(pose);
  return rmsPositionError(graph, truth);
}

/// 100 m round a square and on over its beginning, odometry 2 % and 8 degrees per 100 m off.
Drive loopTruth() {
  Drive truth = squareDrive(25, 2, 1.0);
  truth.resize(115);
  return truth;
}

TEST(SlamDelayedState, SaysWhatIsWrongWithTheConfiguration) {
  DelayedStateConfig config;
  config.loop_hops = 100;
  EXPECT_THROW(DelayedState(config, standIn({})), std::invalid_argument);
  EXPECT_THROW(DelayedState({}, nullptr), std::invalid_argument);
}

TEST(SlamDelayedState, FollowsTheOdometryWhereThereIsNothingToRegister) {
  const Drive odometry = squareDrive(5, 1, 1.0);
  DelayedState state({}, standIn(odometry));
  EXPECT_TRUE(state.T_map_odom().isApprox(Eigen::Isometry3d::Identity()));
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    StatePose pose = statePose(static_cast<int>(i), odometry[i]);
    pose.samples = i % 2 == 0 ? nullptr : std::make_shared<PoseSamples>();
    state.add(pose);
  }
  ASSERT_EQ(state.size(), 20);
  EXPECT_EQ(state.counts().tried, 0u);
  EXPECT_EQ(state.graph().constraints().size(), 19u);
  EXPECT_LT(minus(state.graph().pose(19), odometry[19]).norm(), 1e-12);
  EXPECT_LT(minus(state.T_map_odom(), Eigen::Isometry3d::Identity()).norm(), 1e-12);
}

TEST(SlamDelayedState, RefusesPosesThatMeanNothing) {
  DelayedState state({}, standIn({}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](StatePose pose) {
    try {
      state.add(pose);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  StatePose pose{5.0, Eigen::Isometry3d::Identity(), nullptr, std::nullopt};
  for (int first = 1; first >= 0; --first) {
    StatePose bad = pose;
    bad.T_odom_pose.translation().x() = nan;
    EXPECT_NE(refused(bad).find("not finite"), std::string::npos);
    bad = pose;
    bad.T_odom_pose.linear() *= 2.0;
    EXPECT_NE(refused(bad).find("no rotation"), std::string::npos);
    bad = pose;
    bad.stamp_s = nan;
    EXPECT_NE(refused(bad).find("stamp"), std::string::npos);
    bad = pose;
    bad.step_covariance = Matrix6d::Constant(nan);
    EXPECT_NE(refused(bad).find("covariance"), std::string::npos);
    auto samples = std::make_shared<PoseSamples>();
    samples->positions_m.resize(3);
    bad = pose;
    bad.samples = samples;
    EXPECT_NE(refused(bad).find("normals"), std::string::npos);
    EXPECT_EQ(state.size(), 1 - first) << "nothing was added";
    EXPECT_EQ(first == 1 ? refused(pose) : "", "");
    pose.stamp_s = 6.0;
  }
  pose.stamp_s = 5.0;
  EXPECT_EQ(refused(pose), "pose 1: the stamp 5.000000 is not after the one before");
}

TEST(SlamDelayedState, ClosesALoopAfterDrift) {
  const Drive truth = loopTruth();
  const Drive odometry = driftingOdometry(truth, 1.002, 0.2);
  // No registration to the pose before: all the drift is left for the loop.
  const SpoilOutcome lost = [](int from, int to, RegistrationOutcome* outcome) {
    if (to - from < 50) outcome->overlap = 0.0;
  };
  DelayedStateConfig config;
  config.drift_deg_per_100_m = 20.0;
  Driven drive(truth, odometry, config, lost);
  const double odometry_error = rmsError(odometry, truth);
  EXPECT_GT(odometry_error, 2.0);
  EXPECT_LT(rmsPositionError(drive.state.graph(), truth), odometry_error / 5.0);
  const bool closed = std::any_of(drive.reports.begin(), drive.reports.end(),
                                  [](const AddReport& report) { return report.closed_loop; });
  EXPECT_TRUE(closed);
  EXPECT_LT(minus(drive.state.T_map_odom() * odometry.back(), truth.back()).head<3>().norm(), 0.1);
}

TEST(SlamDelayedState, RegistrationsToThePoseBeforeKeepDriftAway) {
  const Drive truth = loopTruth();
  const Drive odometry = driftingOdometry(truth, 1.02, 0.08);
  Driven drive(truth, odometry);
  EXPECT_LT(rmsPositionError(drive.state.graph(), truth), rmsError(odometry, truth) / 20.0);
  const ConstraintCounts& counts = drive.state.counts();
  EXPECT_EQ(counts.tried, counts.accepted + counts.rejected() + counts.waiting);
  EXPECT_GE(counts.accepted, 114u);
  EXPECT_LE(counts.inconsistent, counts.tried / 100) << "the gate leaves right ones in";
}

TEST(SlamDelayedState, TheGateRefusesWrongRegistrations) {
  const Drive truth = loopTruth();
  const Drive odometry = driftingOdometry(truth, 1.02, 0.02);
  int wrong = 0;
  const SpoilOutcome spoil = [&](int from, int to, RegistrationOutcome* outcome) {
    if ((from + to) % 7 != 0) return;
    outcome->T_from_to.translation() += Eigen::Vector3d(2.0, -1.0, 0.3);
    ++wrong;
  };
  Driven right(truth, odometry);
  Driven drive(truth, odometry, {}, spoil);
  EXPECT_GT(wrong, 15);
  EXPECT_GE(static_cast<int>(drive.state.counts().inconsistent), wrong);
  for (const PoseConstraint& constraint : drive.state.graph().constraints()) {
    EXPECT_LT(constraintChi2(constraint, truth[constraint.from], truth[constraint.to]), 100.0);
  }
  EXPECT_LT(rmsPositionError(drive.state.graph(), truth),
            2.0 * rmsPositionError(right.state.graph(), truth) + 0.05);
}

TEST(SlamDelayedState, WhereTheGateIsWideTwoMustAgree) {
  const Drive truth = loopTruth();
  const Drive odometry = driftingOdometry(truth, 1.02, 0.02);
  DelayedStateConfig config;
  config.drift_m_per_100_m = 5.0;
  // Only odometry up to the loop, and there a single registration, which is wrong by 3 m.
  const SpoilOutcome one = [](int from, int to, RegistrationOutcome* outcome) {
    if (to != 103 || from > 20) outcome->overlap = 0.0;
    outcome->T_from_to.translation().x() += 3.0;
  };
  // Its overlaps allow candidates that are no neighbours: each of one cloud, so none confirms.
  Driven alone(truth, odometry, config, one);
  EXPECT_EQ(alone.state.counts().accepted, 0u);
  EXPECT_GT(alone.state.counts().waiting, 0u);
  // Right ones of several clouds agree, and the first then comes in, too.
  const SpoilOutcome several = [](int from, int to, RegistrationOutcome* outcome) {
    if (to < 101 || from > 20) outcome->overlap = 0.0;
  };
  Driven agreed(truth, odometry, config, several);
  EXPECT_GT(agreed.state.counts().accepted, 5u);
  // Wrong ones that differ from each other wait in vain.
  const SpoilOutcome differ = [](int from, int to, RegistrationOutcome* outcome) {
    if (to < 101 || from > 20) outcome->overlap = 0.0;
    test::TestRandom random(static_cast<uint64_t>(to));
    outcome->T_from_to.translation() += 8.0 * random.normal3();
  };
  config.confirm_poses = 3;
  Driven differing(truth, odometry, config, differ);
  EXPECT_LE(differing.state.counts().accepted, 2u);
  EXPECT_GT(differing.state.counts().unconfirmed, 0u);
}

TEST(SlamDelayedState, CountsWhyRegistrationsAreRefused) {
  const Drive truth = squareDrive(10, 1, 1.0);
  DelayedStateConfig config;
  config.max_candidates = 0;
  const auto countsWith = [&](const std::function<void(RegistrationOutcome*)>& spoil) {
    Driven drive(truth, truth, config,
                 [&](int, int, RegistrationOutcome* outcome) { spoil(outcome); });
    return drive.state.counts();
  };
  const auto diverged = countsWith([](auto* o) { o->verdict = RegistrationVerdict::kDiverged; });
  EXPECT_EQ(diverged.tried, 39u);
  EXPECT_EQ(diverged.diverged, 39u);
  EXPECT_EQ(countsWith([](auto* o) { o->overlap = 0.29; }).low_overlap, 39u);
  EXPECT_EQ(countsWith([](auto* o) { o->covariance(0, 0) = NAN; }).diverged, 39u);
  EXPECT_EQ(countsWith([](auto* o) { o->T_from_to.translation().z() += 2.0; }).inconsistent, 39u);
  // Along the direction that is not determined, too, if it is far.
  const auto degenerateBy = [&](double slide_m) {
    return countsWith([&](RegistrationOutcome* o) {
      o->verdict = RegistrationVerdict::kDegenerate;
      o->covariance(0, 0) = 100.0;
      o->T_from_to.translation().x() += slide_m;
    });
  };
  EXPECT_EQ(degenerateBy(0.1).accepted, 39u);
  EXPECT_EQ(degenerateBy(2.0).inconsistent, 39u);
}

TEST(SlamDelayedState, SearchesByEstimateAndCovariance) {
  Drive truth(3, Eigen::Isometry3d::Identity());
  truth[1].translation().x() = 100.0;
  truth[2].translation().x() = 21.0;
  const auto candidatesWith = [&](double drift_m_per_100_m) {
    DelayedStateConfig config;
    config.drift_m_per_100_m = drift_m_per_100_m;
    config.drift_deg_per_100_m = 0.0;
    Driven drive(truth, truth, config,
                 [](int, int, RegistrationOutcome* outcome) { outcome->overlap = 0.0; });
    return drive.state.candidates(2);
  };
  // 15 m of overlap and 6 m to spare, after 179 m.
  EXPECT_TRUE(candidatesWith(0.5).empty());
  const auto found = candidatesWith(2.0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].from, 0);
  EXPECT_EQ(found[0].to, 2);
  EXPECT_EQ(found[0].hops, 2);
  EXPECT_NEAR(std::sqrt(found[0].covariance(0, 0)), 2.0 * std::sqrt(1.79), 0.7);
}

TEST(SlamDelayedState, LeavesPosesAloneThatAreKnownWell) {
  // Standing still: after the first registrations others tell nothing new.
  const Drive truth(30, Eigen::Isometry3d::Identity());
  DelayedStateConfig config;
  config.odometry_floor_m = 0.001;
  config.odometry_floor_deg = 0.01;
  Driven drive(truth, truth, config);
  EXPECT_LT(drive.state.counts().tried, 40u);
}

TEST(SlamDelayedState, TheSameBitsForAnyNumberOfThreads) {
  const Drive truth = loopTruth();
  const Drive odometry = driftingOdometry(truth, 1.02, 0.05);
  DelayedStateConfig config;
  Driven one(truth, odometry, config);
  config.threads = 4;
  Driven four(truth, odometry, config);
  ASSERT_EQ(one.state.graph().constraints().size(), four.state.graph().constraints().size());
  for (int i = 0; i < one.state.size(); ++i) {
    EXPECT_EQ(one.state.graph().pose(i).matrix(), four.state.graph().pose(i).matrix());
  }
}

TEST(SlamDelayedState, ResetForgetsEverything) {
  const Drive truth = squareDrive(5, 2, 1.0);
  Driven drive(truth, truth);
  EXPECT_GT(drive.state.cloudBytes(), 0u);
  drive.state.reset();
  EXPECT_EQ(drive.state.size(), 0);
  EXPECT_EQ(drive.state.counts().tried, 0u);
  EXPECT_EQ(drive.state.cloudBytes(), 0u);
  drive.state.add(statePose(0, truth[0]));
  EXPECT_EQ(drive.state.size(), 1);
}

TEST(SlamDelayedState, MemoryIsThatOfTheSamples) {
  const Drive truth = squareDrive(5, 1, 1.0);
  Driven drive(truth, truth);
  EXPECT_EQ(drive.state.cloudBytes(), 20u * 2u * (12 + 12 + 4 + 1));
}

/// Processor time of this thread: other programs do not count.
double cpuMs() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// What the last 20 of `poses` cost: the median time, the most evaluations.
struct Cost {
  std::vector<double> ms;
  int64_t evaluations = 0;
  double median() {
    std::sort(ms.begin(), ms.end());
    return ms[ms.size() / 2];
  }
};

TEST(SlamDelayedState, OneMorePoseCostsTheSameAtAThousandPoses) {
  // Laps that keep coming back, so that poses have as many constraints early as late.
  const Drive truth = squareDrive(5, 50, 2.0);
  DelayedStateConfig config;
  config.window_poses = 30;
  config.max_candidates = 2;
  DelayedState state(config, standIn(truth));
  Cost at_100;
  Cost at_1000;
  for (int i = 0; i < 1000; ++i) {
    const double begin_ms = cpuMs();
    const AddReport report = state.add(statePose(i, truth[i]));
    if (i % 900 < 80 || i % 900 >= 100) continue;
    Cost& cost = i < 100 ? at_100 : at_1000;
    cost.ms.push_back(cpuMs() - begin_ms);
    cost.evaluations = std::max(cost.evaluations, report.residual_evaluations);
    EXPECT_FALSE(report.optimized_everything);
  }
  ASSERT_EQ(at_1000.ms.size(), 20u);
  EXPECT_GT(at_100.evaluations, 0);
  EXPECT_LE(at_1000.evaluations, 2 * at_100.evaluations);
  // For people: times are not asserted, machines are busy.
  std::printf("one more pose: %.2f ms at 100 poses, %.2f ms at 1,000\n", at_100.median(),
              at_1000.median());
}

}  // namespace
}  // namespace ladar_perception
