// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>

#include "ladar_perception/slam/surface_registration.h"
#include "slam_cases.h"

namespace ladar_perception {
namespace {

using test::TestRandom;

/// Samples of a room of 20 x 14 x 4 m with a box in it, seen from inside, in a pose's frame.
std::shared_ptr<const PoseSamples> roomFrom(const Eigen::Isometry3d& T_map_pose, uint64_t seed) {
  TestRandom random(seed);
  auto samples = std::make_shared<PoseSamples>();
  const auto add = [&](const Eigen::Vector3d& p_map, const Eigen::Vector3d& n_map) {
    samples->positions_m.push_back((T_map_pose.inverse(Eigen::Isometry) * p_map).cast<float>());
    samples->normals.push_back((T_map_pose.linear().transpose() * n_map).cast<float>());
  };
  const Eigen::Vector3d half(10.0, 7.0, 2.0);
  const Eigen::Vector3d box(1.0, 2.0, 1.0);
  for (int i = 0; i < 3000; ++i) {
    const auto axis = static_cast<int>(random.integer(0, 2));
    const double side = random.integer(0, 1) == 0 ? -1.0 : 1.0;
    const bool on_box = i % 6 == 0;
    Eigen::Vector3d p;
    for (int k = 0; k < 3; ++k) p(k) = random.real(-1.0, 1.0);
    p(axis) = side;
    p = p.cwiseProduct(on_box ? box : half);
    if (on_box) p += Eigen::Vector3d(4.0, -2.0, -1.0);
    add(p + 0.005 * random.normal3(), (on_box ? side : -side) * Eigen::Vector3d::Unit(axis));
  }
  return samples;
}

TEST(SlamSurfaceRegistration, LaysTwoViewsOfARoomOnEachOther) {
  Eigen::Isometry3d T_map_from = Eigen::Isometry3d::Identity();
  T_map_from.translation() << -2.0, 1.0, 0.0;
  Eigen::Isometry3d T_map_to = Eigen::Isometry3d::Identity();
  T_map_to.translation() << 0.5, -1.0, 0.1;
  T_map_to.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()));
  const Eigen::Isometry3d truth = T_map_from.inverse(Eigen::Isometry) * T_map_to;
  const RegistrationFunction align = surfaceRegistration({});
  for (const double sigma_m : {0.02, 0.5}) {
    Vector6d off;
    off << sigma_m, -sigma_m, 0.2 * sigma_m, 0.0, 0.0, 0.1 * sigma_m;
    RegistrationRequest request;
    request.from = roomFrom(T_map_from, 1);
    request.to = roomFrom(T_map_to, 2);
    request.T_from_to = plus(truth, off);
    request.covariance = diagonalCovariance(sigma_m, 0.1 * sigma_m);
    const RegistrationOutcome outcome = align(request);
    EXPECT_EQ(outcome.verdict, RegistrationVerdict::kConverged) << sigma_m;
    const Vector6d error = minus(outcome.T_from_to, truth);
    EXPECT_LT(error.head<3>().norm(), 0.01) << sigma_m;
    EXPECT_LT(error.tail<3>().norm(), 0.002) << sigma_m;
    EXPECT_GT(outcome.overlap, 0.6);
    EXPECT_LT(outcome.residual_m, 0.05);
    // Positions first, in metres: of these it knows less than of angles, in radians.
    const double position_m2 = outcome.covariance.topLeftCorner<3, 3>().trace();
    const double angle_rad2 = outcome.covariance.bottomRightCorner<3, 3>().trace();
    EXPECT_GT(position_m2, angle_rad2);
    EXPECT_LT(position_m2, 0.01 * 0.01);
  }
}

TEST(SlamSurfaceRegistration, TooFewPointsDiverge) {
  auto two = std::make_shared<PoseSamples>();
  two->positions_m = {{1, 0, 0}, {2, 0, 0}};
  two->normals = {{0, 0, 1}, {0, 0, 1}};
  RegistrationRequest request;
  request.covariance = diagonalCovariance(0.1, 0.1);
  for (const auto& cloud : {std::make_shared<PoseSamples>(), two}) {
    request.from = cloud;
    request.to = cloud;
    EXPECT_EQ(surfaceRegistration({})(request).verdict, RegistrationVerdict::kDiverged);
  }
}

TEST(SlamSurfaceRegistration, RefusesAWrongConfiguration) {
  RegistrationConfig config;
  config.solver = "quick";
  EXPECT_THROW(surfaceRegistration(config), std::invalid_argument);
}

}  // namespace
}  // namespace ladar_perception
