// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "ladar_perception/register/registrar.h"
#include "ladar_perception/register/twist.h"
#include "register_scenes.h"

namespace ladar_perception {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using test::angleDeg;
using test::motion;

constexpr double kNoise_m = 0.01;

RegistrationConfig withSolver(const std::string& solver, const std::string& cost) {
  RegistrationConfig config;
  config.solver = solver;
  config.cost = cost;
  return config;
}

/// Two samplings of a place from two poses.
struct PlacePair {
  RegistrationCloud a;
  RegistrationCloud b;
  Isometry3d T_a_b;
};

PlacePair pairOf(const std::vector<test::Face>& faces, const Isometry3d& T_a_b,
                 const Isometry3d& T_place_a = Isometry3d::Identity(), std::size_t count = 2000,
                 double noise_m = kNoise_m, uint64_t seed = 1) {
  const OrientedPoints a = test::pointsOn(faces, count, noise_m, 2 * seed);
  const OrientedPoints b = test::pointsOn(faces, count, noise_m, 2 * seed + 1);
  return {RegistrationCloud(test::moved(T_place_a, a)),
          RegistrationCloud(test::moved(T_a_b.inverse() * T_place_a, b)), T_a_b};
}

void expectFound(const PlacePair& pair, const RegistrationResult& result, double error_m,
                 double error_deg) {
  const Isometry3d error = pair.T_a_b.inverse() * result.T_a_b;
  EXPECT_LT(error.translation().norm(), error_m);
  EXPECT_LT(angleDeg(error), error_deg);
  EXPECT_EQ(result.verdict, Verdict::kConverged) << result.reason;
  EXPECT_EQ(result.reason, "");
}

TEST(SurfaceRegistrar, FindsTheTransformFromFarAway) {
  const PlacePair pair = pairOf(test::roomFaces(), motion({0.4, -0.3, 0.1}, 12.0, {0.1, 0.2, 1.0}));
  for (const char* cost : {"point_to_plane", "generalized"}) {
    const SurfaceRegistrar registrar(withSolver("annealed", cost));
    const Isometry3d guess = pair.T_a_b * motion({1.5, 1.0, -0.5}, 20.0, {0.3, -0.2, 1.0});
    const RegistrationResult result = registrar.align(pair.a, pair.b, guess);
    expectFound(pair, result, 0.005, 0.1);
    EXPECT_GT(result.overlap, 0.9);
    EXPECT_LT(result.residual_m, 2.0 * kNoise_m);
    EXPECT_EQ(result.weak_directions, 0);
  }
}

TEST(SurfaceRegistrar, PlainOneFindsItFromNearby) {
  const PlacePair pair = pairOf(test::roomFaces(), motion({0.4, -0.3, 0.1}, 12.0));
  RegistrationConfig config = withSolver("plain", "point_to_plane");
  config.initial_radius_m = 1.0;
  const Isometry3d guess = pair.T_a_b * motion({0.1, -0.1, 0.05}, 2.0);
  const RegistrationResult result = SurfaceRegistrar(config).align(pair.a, pair.b, guess);
  EXPECT_LT((pair.T_a_b.inverse() * result.T_a_b).translation().norm(), 0.03);
}

TEST(SurfaceRegistrar, UsesTheFinestPointsThereAre) {
  const auto faces = test::roomFaces();
  const OrientedPoints few = test::pointsOn(faces, 300, 0.03, 3);
  const OrientedPoints many = test::pointsOn(faces, 20000, 0.0, 4);
  const RegistrationCloud b(test::pointsOn(faces, 300, 0.0, 5));
  const SurfaceRegistrar registrar((RegistrationConfig()));
  const Isometry3d guess = motion({0.3, 0.2, 0.1}, 4.0);
  const double coarse =
      registrar.align(RegistrationCloud(few), b, guess).T_a_b.translation().norm();
  const double fine =
      registrar.align(RegistrationCloud(few, many), b, guess).T_a_b.translation().norm();
  EXPECT_LT(fine, 0.3 * coarse);
  EXPECT_LT(fine, 2e-4);
}

TEST(SurfaceRegistrar, FinishesWithMorePointsThanItsSamples) {
  const auto faces = test::roomFaces();
  RegistrationConfig config;
  double before_m = 0.0;
  double after_m = 0.0;
  for (uint64_t seed = 0; seed < 10; ++seed) {
    const RegistrationCloud a(test::pointsOn(faces, 300, 0.03, 20 + seed),
                              test::pointsOn(faces, 20000, 0.01, 40 + seed));
    const RegistrationCloud b(test::pointsOn(faces, 300, 0.03, 60 + seed),
                              test::pointsOn(faces, 20000, 0.01, 80 + seed));
    const Isometry3d guess = motion({0.3, 0.2, 0.1}, 4.0);
    config.finish_points = 0;
    before_m += SurfaceRegistrar(config).align(a, b, guess).T_a_b.translation().norm();
    config.finish_points = 5000;
    const RegistrationResult finished = SurfaceRegistrar(config).align(a, b, guess);
    EXPECT_EQ(finished.verdict, Verdict::kConverged) << finished.reason;
    after_m += finished.T_a_b.translation().norm();
  }
  std::printf("[   NUMBER ] errors %.2f mm, finished %.2f mm\n", 100.0 * before_m, 100.0 * after_m);
  EXPECT_LT(after_m, 0.3 * before_m);
}

TEST(SurfaceRegistrar, FinishesWithItsSamplesWhereThereAreNoOthers) {
  const PlacePair pair = pairOf(test::roomFaces(), motion({0.4, -0.3, 0.1}, 12.0));
  RegistrationConfig config;
  config.finish_points = 1000000;  // more than there are
  const RegistrationResult result =
      SurfaceRegistrar(config).align(pair.a, pair.b, pair.T_a_b * motion({0.5, 0.5, 0.0}, 8.0));
  expectFound(pair, result, 0.005, 0.1);
}

TEST(SurfaceRegistrar, IsAsGoodAKilometreFromTheOrigin) {
  const Isometry3d T_a_b = motion({0.4, -0.3, 0.1}, 12.0);
  const Isometry3d far = motion({1000.0, -700.0, 50.0}, 30.0);
  const PlacePair near = pairOf(test::roomFaces(), T_a_b);
  // The same motion of the place, seen from an origin far away.
  const PlacePair distant = pairOf(test::roomFaces(), far * T_a_b * far.inverse(), far);
  const SurfaceRegistrar registrar((RegistrationConfig()));
  const Isometry3d off = motion({0.5, 0.5, 0.0}, 8.0);
  const RegistrationResult here = registrar.align(near.a, near.b, T_a_b * off);
  const RegistrationResult there =
      registrar.align(distant.a, distant.b, far * T_a_b * off * far.inverse());
  ASSERT_EQ(there.verdict, Verdict::kConverged) << there.reason;
  const Isometry3d brought_back = far.inverse() * there.T_a_b * far;
  EXPECT_LT((brought_back.translation() - here.T_a_b.translation()).norm(), 1e-4);
  EXPECT_LT(angleDeg(brought_back.inverse() * here.T_a_b), 1e-3);
  EXPECT_NEAR(there.overlap, here.overlap, 0.002);
  EXPECT_LT((there.information - here.information).norm(), 1e-3);
  const Vector3d center = far.inverse() * there.center_m;
  EXPECT_LT((center - here.center_m).norm(), 1e-2);
}

TEST(SurfaceRegistrar, GivesTheSameBitsEveryTime) {
  const PlacePair pair = pairOf(test::roomFaces(), motion({0.4, -0.3, 0.1}, 12.0));
  const SurfaceRegistrar registrar((RegistrationConfig()));
  const Isometry3d guess = pair.T_a_b * motion({1.0, 1.0, 0.0}, 10.0);
  const RegistrationResult first = registrar.align(pair.a, pair.b, guess);
  const PlacePair again = pairOf(test::roomFaces(), motion({0.4, -0.3, 0.1}, 12.0));
  const RegistrationResult second = registrar.align(again.a, again.b, guess);
  EXPECT_EQ(first.T_a_b.matrix(), second.T_a_b.matrix());
  EXPECT_EQ(first.covariance, second.covariance);
  EXPECT_EQ(first.iterations, second.iterations);
}

TEST(SurfaceRegistrar, LaysACloudOnItself) {
  const OrientedPoints points = test::pointsOn(test::roomFaces(), 2000, kNoise_m, 7);
  const RegistrationCloud cloud(points);
  const SurfaceRegistrar registrar((RegistrationConfig()));
  for (const double shift_m : {0.0, 0.5}) {
    const RegistrationResult result =
        registrar.align(cloud, cloud, motion({shift_m, 0.0, 0.0}, 10.0 * shift_m));
    EXPECT_EQ(result.verdict, Verdict::kConverged) << result.reason;
    EXPECT_LT(result.T_a_b.translation().norm(), 1e-4);
    EXPECT_LT(result.residual_m, 1e-4);
    EXPECT_GT(result.overlap, 0.999);
    // Never certain beyond what a ladar can measure.
    const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(result.covariance);
    EXPECT_GT(solver.eigenvalues().minCoeff(), 1e-11);
  }
}

// -------------------------------------------------------------------------------------- verdicts

std::vector<test::Face> corridorFaces() {
  std::vector<test::Face> faces = test::boxFaces({-20.0, -1.2, 0.0}, {20.0, 1.2, 2.5}, true);
  faces.erase(faces.begin(), faces.begin() + 2);  // without ends
  return faces;
}

TEST(SurfaceRegistrar, KnowsThatACorridorHidesItsLength) {
  const PlacePair pair = pairOf(corridorFaces(), motion({0.3, 0.1, 0.05}, 3.0));
  const SurfaceRegistrar registrar((RegistrationConfig()));
  const RegistrationResult result =
      registrar.align(pair.a, pair.b, pair.T_a_b * motion({0.5, 0.2, 0.1}, 3.0));
  EXPECT_EQ(result.verdict, Verdict::kDegenerate) << result.reason;
  ASSERT_EQ(result.weak_directions, 1);
  // Along a's x axis, without any turn.
  const Vector6d weak = result.directions.col(0);
  EXPECT_GT(std::abs(weak[3]), 0.999);
  EXPECT_LT(weak.head<3>().norm(), 1e-2);
  // Right across, unknown along.
  const Isometry3d error = result.T_a_b * pair.T_a_b.inverse();
  EXPECT_LT(error.translation().tail<2>().norm(), 0.01);
  EXPECT_LT(angleDeg(error), 0.1);
  const Vector3d along_b = pair.T_a_b.linear().transpose() * Vector3d::UnitX();
  const Eigen::Matrix3d spread = result.covariance.bottomRightCorner<3, 3>();
  EXPECT_NEAR(std::sqrt(along_b.dot(spread * along_b)), kWeakSigma_m, 0.1);
  EXPECT_LT(spread(2, 2), 1e-4);
}

TEST(SurfaceRegistrar, KnowsThatAPlaneHidesThreeDirections) {
  std::vector<test::Face> faces = test::boxFaces({-5.0, -5.0, 0.0}, {5.0, 5.0, 3.0}, true);
  const PlacePair pair = pairOf({faces[4]}, motion({0.1, 0.1, 0.1}, 2.0));
  const SurfaceRegistrar registrar((RegistrationConfig()));
  const RegistrationResult result = registrar.align(pair.a, pair.b, Isometry3d::Identity());
  EXPECT_EQ(result.verdict, Verdict::kDegenerate) << result.reason;
  EXPECT_EQ(result.weak_directions, 3);
  EXPECT_NE(result.reason.find('3'), std::string::npos) << result.reason;
  EXPECT_LT(std::abs((result.T_a_b * pair.b.origin_m()).z()), 0.1);
  EXPECT_TRUE(result.covariance.allFinite());
}

TEST(SurfaceRegistrar, SaysDivergedWithoutOverlap) {
  const PlacePair pair = pairOf(test::roomFaces(), Isometry3d::Identity());
  const SurfaceRegistrar registrar((RegistrationConfig()));
  const RegistrationResult far = registrar.align(pair.a, pair.b, motion({100.0, 0.0, 0.0}, 0.0));
  EXPECT_EQ(far.verdict, Verdict::kDiverged);
  EXPECT_NE(far.reason.find("pairs"), std::string::npos) << far.reason;
  EXPECT_EQ(far.overlap, 0.0);
  EXPECT_EQ(far.covariance, Matrix6d(Matrix6d::Zero()));
  EXPECT_TRUE(far.T_a_b.matrix().allFinite());
}

/// Points in a ball, each with a normal of its own: nothing that fits anything.
OrientedPoints cluttered(std::size_t count, uint64_t seed) {
  test::TestRandom random(seed);
  OrientedPoints points;
  while (points.size() < count) {
    const Vector3d p(random.real(-4, 4), random.real(-4, 4), random.real(-4, 4));
    points.positions_m.push_back(p);
    points.normals.push_back(random.normal3().normalized().cast<float>());
  }
  return points;
}

TEST(SurfaceRegistrar, SaysDivergedOfAnotherPlace) {
  const RegistrationCloud room(test::pointsOn(test::roomFaces(), 2000, kNoise_m, 8));
  const RegistrationCloud clutter(cluttered(2000, 9));
  RegistrationConfig config;
  config.finish_points = 1000;
  const SurfaceRegistrar registrar(config);
  for (const double shift_m : {0.0, 1.0, 2.0}) {
    const Isometry3d guess = motion({shift_m, 0.0, 1.0}, 10.0);
    EXPECT_EQ(registrar.align(room, clutter, guess).verdict, Verdict::kDiverged) << shift_m;
    EXPECT_EQ(registrar.align(clutter, room, guess).verdict, Verdict::kDiverged) << shift_m;
  }
}

TEST(SurfaceRegistrar, SaysDivergedOfTinyClouds) {
  const OrientedPoints points = test::pointsOn(test::roomFaces(), 2000, kNoise_m, 10);
  const RegistrationCloud whole(points);
  for (const char* solver : {"annealed", "plain"}) {
    const SurfaceRegistrar registrar(withSolver(solver, "point_to_plane"));
    for (std::size_t count = 0; count <= 3; ++count) {
      OrientedPoints few = points;
      few.positions_m.resize(count);
      few.normals.resize(count);
      const RegistrationCloud tiny(few);
      EXPECT_EQ(tiny.size(), count);
      for (const RegistrationResult& result :
           {registrar.align(whole, tiny, Isometry3d::Identity()),
            registrar.align(tiny, whole, Isometry3d::Identity()),
            registrar.align(tiny, tiny, Isometry3d::Identity())}) {
        EXPECT_EQ(result.verdict, Verdict::kDiverged) << count;
        EXPECT_NE(result.reason, "");
        EXPECT_TRUE(result.T_a_b.matrix().allFinite());
        EXPECT_TRUE(result.information.allFinite());
      }
    }
  }
}

TEST(SurfaceRegistrar, LeavesOutPointsThatAreNotFiniteOrHaveNoNormal) {
  OrientedPoints points = test::pointsOn(test::roomFaces(), 1000, kNoise_m, 11);
  const RegistrationCloud clean(points);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  points.positions_m.insert(points.positions_m.begin() + 3, {nan, 0.0, 0.0});
  points.normals.insert(points.normals.begin() + 3, Eigen::Vector3f::UnitX());
  points.positions_m.emplace_back(0.0, std::numeric_limits<double>::infinity(), 0.0);
  points.normals.push_back(Eigen::Vector3f::UnitX());
  points.positions_m.emplace_back(1.0, 1.0, 1.0);
  points.normals.push_back(Eigen::Vector3f::Zero());
  points.positions_m.emplace_back(1.0, 1.0, 1.0);
  points.normals.emplace_back(std::numeric_limits<float>::quiet_NaN(), 0.0F, 1.0F);
  const RegistrationCloud cloud(points, points);
  EXPECT_EQ(cloud.size(), 1000U);
  EXPECT_EQ(cloud.dropped(), 4U);
  const SurfaceRegistrar registrar((RegistrationConfig()));
  const Isometry3d guess = motion({0.3, 0.2, 0.1}, 5.0);
  EXPECT_EQ(registrar.align(cloud, cloud, guess).T_a_b.matrix(),
            registrar.align(clean, clean, guess).T_a_b.matrix());
}

TEST(SurfaceRegistrar, SaysDivergedOfAGuessThatIsNotFinite) {
  const RegistrationCloud cloud(test::pointsOn(test::roomFaces(), 500, kNoise_m, 12));
  Isometry3d guess = Isometry3d::Identity();
  guess.translation().x() = std::numeric_limits<double>::quiet_NaN();
  const RegistrationResult result =
      SurfaceRegistrar(RegistrationConfig()).align(cloud, cloud, guess);
  EXPECT_EQ(result.verdict, Verdict::kDiverged);
  EXPECT_NE(result.reason.find("guess"), std::string::npos);
}

TEST(SurfaceRegistrar, StandsManyEqualPoints) {
  OrientedPoints points = test::pointsOn(test::roomFaces(), 200, 0.0, 13);
  const std::size_t once = points.size();
  for (std::size_t i = 0; i < 20 * once; ++i) {
    points.positions_m.push_back(points.positions_m[i % once]);
    points.normals.push_back(points.normals[i % once]);
  }
  const RegistrationCloud cloud(points);
  EXPECT_EQ(cloud.spacing_m(), 0.0);
  const RegistrationResult result =
      SurfaceRegistrar(RegistrationConfig()).align(cloud, cloud, motion({0.1, 0.1, 0.0}, 1.0));
  EXPECT_LT(result.T_a_b.translation().norm(), 1e-3);
}

// ------------------------------------------------------------------------------------ covariance

/// Mean of squared errors, each in units of its covariance: 6 if the covariances are right.
TEST(SurfaceRegistrar, CovarianceIsThatOfManyTrials) {
  RegistrationConfig plane = withSolver("annealed", "point_to_plane");
  RegistrationConfig generalized = withSolver("annealed", "generalized");
  RegistrationConfig finished = plane;
  finished.finish_points = 600;
  for (const RegistrationConfig& config : {plane, generalized, finished}) {
    const SurfaceRegistrar registrar(config);
    const Isometry3d T_a_b = motion({0.4, -0.3, 0.1}, 12.0);
    constexpr int kTrials = 100;
    double sum = 0.0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const PlacePair pair = pairOf(test::roomFaces(), T_a_b, Isometry3d::Identity(), 800, 0.02,
                                    static_cast<uint64_t>(trial + 1));
      const RegistrationResult result = registrar.align(pair.a, pair.b, T_a_b);
      ASSERT_EQ(result.verdict, Verdict::kConverged) << result.reason;
      const Vector6d error = logTwist(result.T_a_b.inverse() * T_a_b);
      sum += error.dot(result.covariance.ldlt().solve(error));
    }
    const double mean = sum / kTrials;
    std::printf("[   NUMBER ] %s, %d points: squared errors are %.2f of 6\n", config.cost.c_str(),
                config.finish_points, mean);
    EXPECT_GT(mean, 3.0) << config.cost << config.finish_points;
    EXPECT_LT(mean, 12.0) << config.cost << config.finish_points;
  }
}

TEST(SurfaceRegistrar, StartsAgainWhereItDiverged) {
  const PlacePair pair = pairOf(test::roomFaces(), Isometry3d::Identity());
  RegistrationConfig config;
  config.initial_radius_m = 0.6;  // too little for this guess
  const Isometry3d guess = motion({0.9, 0.9, 0.9}, 0.0);
  config.restarts = 0;
  const RegistrationResult once = SurfaceRegistrar(config).align(pair.a, pair.b, guess);
  EXPECT_EQ(once.verdict, Verdict::kDiverged);
  config.restarts = RegistrationConfig::kMaxRestarts;
  const RegistrationResult again = SurfaceRegistrar(config).align(pair.a, pair.b, guess);
  EXPECT_GT(again.overlap, once.overlap);
  EXPECT_GT(again.iterations, once.iterations);
  expectFound(pair, again, 0.01, 0.2);
}

TEST(SurfaceRegistrar, StartsAgainWhereTheOverlapIsNotGood) {
  const PlacePair room = pairOf(test::roomFaces(), Isometry3d::Identity());
  RegistrationConfig config;
  config.initial_radius_m = 0.6;
  config.min_overlap = 0.0;  // nothing is called diverged for it
  config.good_overlap = 0.0;
  const Isometry3d guess = motion({0.9, 0.9, 0.9}, 0.0);
  const RegistrationResult first = SurfaceRegistrar(config).align(room.a, room.b, guess);
  ASSERT_LT(first.overlap, 0.5);
  config.good_overlap = 0.5;
  config.restarts = RegistrationConfig::kMaxRestarts;
  const RegistrationResult again = SurfaceRegistrar(config).align(room.a, room.b, guess);
  EXPECT_GT(again.iterations, first.iterations);
  expectFound(room, again, 0.01, 0.2);
  config.good_overlap = 1.0;  // never reached: all attempts are made, the best is the result
  const RegistrationResult all = SurfaceRegistrar(config).align(room.a, room.b, guess);
  EXPECT_GT(all.iterations, again.iterations);
  expectFound(room, all, 0.01, 0.2);
}

/// Most samples are of one wall, which fits in many false poses.
TEST(SurfaceRegistrar, TellsTheOverlapBySurfaceNotOnlyBySamples) {
  const std::vector<test::Face> faces = test::roomFaces();
  const OrientedPoints wall = test::pointsOn({faces[0]}, 1900, 0.0, 14);
  OrientedPoints samples = test::pointsOn(faces, 100, 0.0, 15);
  samples.positions_m.insert(samples.positions_m.end(), wall.positions_m.begin(),
                             wall.positions_m.end());
  samples.normals.insert(samples.normals.end(), wall.normals.begin(), wall.normals.end());
  const OrientedPoints surface = test::pointsOn(faces, 20000, 0.0, 16);
  const RegistrationCloud room(surface, surface);
  RegistrationConfig config;
  config.restarts = 0;
  config.initial_radius_m = 0.5;
  // Along the wall.
  const Isometry3d guess = motion({0.0, 1.5, 0.0}, 0.0);
  const RegistrationResult by_samples =
      SurfaceRegistrar(config).align(room, RegistrationCloud(samples), guess);
  const RegistrationResult by_surface =
      SurfaceRegistrar(config).align(room, RegistrationCloud(samples, surface), guess);
  ASSERT_GT(by_samples.T_a_b.translation().norm(), 0.5);
  EXPECT_LT(by_surface.overlap, by_samples.overlap - 0.1);
}

TEST(SurfaceRegistrar, RefusesBadConfigurations) {
  RegistrationConfig config;
  config.solver = "magic";
  config.cost = "none";
  config.initial_radius_m = 0.1;
  try {
    SurfaceRegistrar registrar(config);
    FAIL() << "no error";
  } catch (const std::invalid_argument& error) {
    for (const char* part : {"solver", "magic", "annealed", "cost", "initial_radius_m"}) {
      EXPECT_NE(std::strstr(error.what(), part), nullptr) << part << ": " << error.what();
    }
  }
}

}  // namespace
}  // namespace ladar_perception
