// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "cloud_builder.h"
#include "ladar_perception/resample/pose_keeper.h"
#include "test_random.h"

namespace ladar_perception::test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr uint64_t kStart_ns = 1600000000000000000;  // as large as stamps of today
constexpr uint64_t kPeriod_ns = 100000000;

Isometry3d pose(const Vector3d& translation, double angle_rad = 0.0,
                const Vector3d& axis = Vector3d::UnitZ()) {
  Isometry3d T = Isometry3d::Identity();
  T.translation() = translation;
  T.rotate(AngleAxisd(angle_rad, axis));
  return T;
}

const Isometry3d T_vehicle_sensor = pose({0.5, 0.1, 1.2}, 0.3, Vector3d::UnitY());

/// A scan that owns what PlacedScan refers to.
class TestScan {
 public:
  TestScan(CloudBuilder cloud, const Isometry3d& T_map_vehicle, uint64_t stamp_ns)
      : cloud_(std::move(cloud)),
        view_(cloud_.view()),
        motion_(T_map_vehicle * T_vehicle_sensor),
        T_map_vehicle_(T_map_vehicle),
        stamp_ns_(stamp_ns) {
    std::string error;
    const auto fields = findPointFields(view_, &error);
    EXPECT_TRUE(fields) << error;
    fields_ = *fields;
  }
  TestScan(const TestScan&) = delete;
  TestScan& operator=(const TestScan&) = delete;

  void move(SensorMotion motion, std::vector<float> offsets_s) {
    motion_ = std::move(motion);
    offsets_s_ = std::move(offsets_s);
  }
  PlacedScan placed() const {
    return {view_, fields_, offsets_s_, motion_, T_map_vehicle_, stamp_ns_};
  }

 private:
  CloudBuilder cloud_;
  CloudView view_;
  PointFields fields_;
  std::vector<float> offsets_s_;
  SensorMotion motion_;
  Isometry3d T_map_vehicle_;
  uint64_t stamp_ns_;
};

const std::vector<Vector3d> kPoints = {{3, 0, 0}, {4, 1, 0}, {5, -1, 1}};

struct Kept {
  ScanUse use;
  std::vector<KeptPose> complete;
};

Kept addTo(PoseKeeper* keeper, const TestScan& scan) {
  Kept kept;
  kept.use = keeper->add(scan.placed(), &kept.complete);
  return kept;
}

Kept addAt(PoseKeeper* keeper, const Isometry3d& T_map_vehicle, int i = 0) {
  return addTo(keeper, TestScan(xyzCloud(kPoints), T_map_vehicle, kStart_ns + i * kPeriod_ns));
}

/// Which of the scans joined.
std::vector<int> joinedOf(const PoseKeeperConfig& config, const std::vector<Isometry3d>& poses) {
  PoseKeeper keeper(config);
  std::vector<int> joined;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (addAt(&keeper, poses[i], static_cast<int>(i)).use.joined) {
      joined.push_back(static_cast<int>(i));
    }
  }
  return joined;
}

PoseKeeperConfig onlyBy(double distance_m, double angle_deg, double period_s) {
  PoseKeeperConfig config;
  config.pose_distance_m = distance_m;
  config.pose_angle_deg = angle_deg;
  config.pose_period_s = period_s;
  return config;
}

TEST(PoseKeeperJoin, ByDistanceFromTheLastPose) {
  std::vector<Isometry3d> poses;
  for (const double x : {0.0, 0.4, 0.8, 1.2, 1.6, 2.0, 2.1, 2.25, 1.3, 0.9}) {
    // Upwards counts as well.
    poses.push_back(pose({0.6 * x, 0.0, 0.8 * x}));
  }
  EXPECT_EQ(joinedOf(onlyBy(1.0, 0, 0), poses), (std::vector<int>{0, 3, 7, 9}));
  EXPECT_EQ(joinedOf(onlyBy(0.0, 0, 1e4), poses), (std::vector<int>{0}))
      << "0 is never, not always";
}

TEST(PoseKeeperJoin, ByAngleAboutAnyAxis) {
  const double degree = M_PI / 180.0;
  for (const Vector3d& axis :
       {Vector3d(0, 0, 1), Vector3d(0, 1, 0), Vector3d(1, 2, 3).normalized().eval()}) {
    std::vector<Isometry3d> poses;
    for (const double angle : {0.0, 14.0, 15.1, 25.0, 0.0, -14.0, -16.0, 344.0, 180.0}) {
      poses.push_back(pose({0, 0, 0}, angle * degree, axis));
    }
    // From 15.1 to 0 is 15.1 back, -16 and 344 are the same.
    EXPECT_EQ(joinedOf(onlyBy(0, 15, 0), poses), (std::vector<int>{0, 2, 4, 6, 8}));
  }
}

TEST(PoseKeeperJoin, ByTime) {
  const std::vector<Isometry3d> standing(12, pose({7, 7, 7}));
  EXPECT_EQ(joinedOf(onlyBy(0, 0, 0.5), standing), (std::vector<int>{0, 5, 10}));
  EXPECT_EQ(joinedOf(onlyBy(1, 15, 0), standing), (std::vector<int>{0}))
      << "a vehicle that stands makes no poses";
}

TEST(PoseKeeperJoin, ByWhicheverComesFirst) {
  const std::vector<Isometry3d> poses = {pose({0, 0, 0}),        pose({0.5, 0, 0}),
                                         pose({1.1, 0, 0}),      pose({1.2, 0, 0}, 0.5),
                                         pose({1.2, 0, 0}, 0.5), pose({1.2, 0, 0}, 0.5)};
  EXPECT_EQ(joinedOf(onlyBy(1.0, 20, 0.2), poses), (std::vector<int>{0, 2, 3, 5}));
}

TEST(PoseKeeperJoin, EveryScan) {
  PoseKeeperConfig config;
  config.join = "every_scan";
  EXPECT_EQ(joinedOf(config, std::vector<Isometry3d>(4, pose({0, 0, 0}))),
            (std::vector<int>{0, 1, 2, 3}));
}

TEST(PoseKeeperJoin, OnRequestAloneAndOnce) {
  PoseKeeperConfig config;
  config.join = "on_request";
  PoseKeeper keeper(config);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(addAt(&keeper, pose({10.0 * i, 0, 0}), i).use.joined);
  keeper.request();
  keeper.request();
  EXPECT_TRUE(addAt(&keeper, pose({0, 0, 0}), 3).use.joined);
  EXPECT_FALSE(addAt(&keeper, pose({50, 0, 0}), 4).use.joined);
  EXPECT_EQ(keeper.joined(), 1U);
}

TEST(PoseKeeperJoin, RequestsWorkInEveryModeAndCountAsTheLastPose) {
  PoseKeeper keeper(onlyBy(1.0, 0, 0));
  EXPECT_TRUE(addAt(&keeper, pose({0, 0, 0}), 0).use.joined);
  keeper.request();
  EXPECT_TRUE(addAt(&keeper, pose({0.5, 0, 0}), 1).use.joined);
  EXPECT_FALSE(addAt(&keeper, pose({1.2, 0, 0}), 2).use.joined) << "0.7 m from the requested one";
  EXPECT_TRUE(addAt(&keeper, pose({1.6, 0, 0}), 3).use.joined);
}

TEST(PoseKeeperJoin, AScanWithoutUsablePointsMakesNoPose) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  PoseKeeperConfig config;
  config.join = "on_request";
  PoseKeeper keeper(config);
  keeper.request();
  const Kept none = addTo(
      &keeper, TestScan(xyzCloud({{kNaN, 0, 0}, {0, 0, 0}, {1e3, 0, 0}}), pose({0, 0, 0}), 1));
  EXPECT_FALSE(none.use.joined);
  EXPECT_FALSE(none.use.taken);
  EXPECT_NE(none.use.refused, "");
  EXPECT_TRUE(addAt(&keeper, pose({0, 0, 0})).use.joined) << "the request was for the next one";
}

TEST(PoseKeeperJoin, StartsAnewWhenTheLastPoseIsForgotten) {
  PoseKeeper keeper(onlyBy(1.0, 0, 0));
  addAt(&keeper, pose({0, 0, 0}));
  EXPECT_FALSE(addAt(&keeper, pose({0, 0, 0})).use.joined);
  keeper.forgetLastPose();
  const Kept kept = addAt(&keeper, pose({0, 0, 0}));
  EXPECT_TRUE(kept.use.joined);
  ASSERT_EQ(kept.complete.size(), 1U);
  EXPECT_EQ(kept.complete[0].id, 1U) << "ids are not used again";
}

TEST(PoseKeeperGather, AScanIsTheCloudOfItsPose) {
  PoseKeeper keeper(onlyBy(1.0, 0, 0));
  const Isometry3d T_map_vehicle = pose({100, -50, 3}, 0.7);
  const Kept kept = addAt(&keeper, T_map_vehicle);
  ASSERT_EQ(kept.complete.size(), 1U);
  const KeptPose& complete = kept.complete[0];
  EXPECT_EQ(complete.id, 0U);
  EXPECT_EQ(complete.stamp_ns, kStart_ns);
  EXPECT_EQ(complete.last_stamp_ns, kStart_ns);
  EXPECT_EQ(complete.scans, 1U);
  EXPECT_TRUE(complete.T_map_vehicle.isApprox(T_map_vehicle, 0.0));
  EXPECT_TRUE(complete.points.sensor_m.isApprox(T_vehicle_sensor.translation(), 1e-12));
  ASSERT_EQ(complete.points.positions_m.size(), kPoints.size());
  for (std::size_t i = 0; i < kPoints.size(); ++i) {
    EXPECT_LT((complete.points.positions_m[i] - T_vehicle_sensor * kPoints[i]).norm(), 1e-9);
  }
  EXPECT_TRUE(complete.points.labels.empty());
  EXPECT_TRUE(complete.points.rgb.empty());
  EXPECT_FALSE(keeper.gathering());

  const Kept between = addAt(&keeper, T_map_vehicle, 1);
  EXPECT_FALSE(between.use.taken);
  EXPECT_EQ(between.use.refused, "");
  EXPECT_EQ(between.use.dropped[static_cast<int>(GatherDrop::kBetween)], kPoints.size());
}

PoseKeeperConfig untilNext(double distance_m) {
  PoseKeeperConfig config = onlyBy(distance_m, 0, 0);
  config.gather = "until_next";
  return config;
}

TEST(PoseKeeperGather, ScansUntilTheNextPoseAreMovedIntoItsFrame) {
  // World-fixed points, seen from every pose of a turning drive, fall on one another again. The
  // second drive is a thousand kilometres out.
  for (const double far_m : {0.0, 1e6}) {
    PoseKeeper keeper(untilNext(2.0));
    TestRandom random(5);
    const Vector3d origin(far_m, -far_m, 0.0);
    std::vector<Vector3d> p_world;
    for (int i = 0; i < 40; ++i) {
      p_world.push_back(origin +
                        Vector3d(random.real(5, 20), random.real(-9, 9), random.real(0, 3)));
    }
    std::vector<KeptPose> complete;
    for (int i = 0; i < 9; ++i) {  // joins with 0, 4, 8
      const Isometry3d T_map_vehicle = pose(origin + Vector3d(0.5 * i, 0.1 * i, 0), 0.1 * i);
      const Isometry3d T_sensor_map = (T_map_vehicle * T_vehicle_sensor).inverse();
      std::vector<Vector3d> p_sensor;
      for (const Vector3d& p : p_world) p_sensor.push_back(T_sensor_map * p);
      const TestScan scan(xyzCloud(p_sensor), T_map_vehicle, kStart_ns + i * kPeriod_ns);
      const ScanUse use = keeper.add(scan.placed(), &complete);
      EXPECT_EQ(use.joined, i % 4 == 0) << i;
      EXPECT_TRUE(use.taken);
    }
    ASSERT_EQ(complete.size(), 2U);
    EXPECT_TRUE(keeper.gathering());
    complete.push_back(*keeper.close());
    EXPECT_FALSE(keeper.close().has_value());
    uint64_t id = 0;
    for (const KeptPose& kept : complete) {
      EXPECT_EQ(kept.scans, kept.id == 2 ? 1U : 4U);
      EXPECT_EQ(kept.id, id++);
      EXPECT_EQ(kept.last_stamp_ns, kept.stamp_ns + (kept.scans - 1) * kPeriod_ns);
      ASSERT_EQ(kept.points.positions_m.size(), kept.scans * p_world.size());
      EXPECT_EQ(kept.layout.pointCount(), kept.points.positions_m.size());
      for (std::size_t i = 0; i < kept.points.positions_m.size(); ++i) {
        const Vector3d expected = kept.T_map_vehicle.inverse() * p_world[i % p_world.size()];
        EXPECT_LT((kept.points.positions_m[i] - expected).norm(), 5e-6);
      }
    }
  }
}

TEST(PoseKeeperGather, PointsArePlacedByThePoseAtTheirOwnTime) {
  PoseKeeper keeper(onlyBy(1.0, 0, 0));
  // 10 m/s while turning: without compensation points would be up to a metre off.
  const auto T_map_sensor = [](double t) { return pose({5 + 10 * t, 2, 1}, 0.5 * t); };
  std::vector<SensorMotion::Knot> knots;
  for (int i = 0; i <= 10; ++i) knots.push_back({0.01 * i, T_map_sensor(0.01 * i)});
  const Isometry3d T_map_vehicle = pose({4, 2, 0}, 0.2);
  std::vector<Vector3d> p_world, p_sensor;
  std::vector<float> offsets_s;
  for (int i = 0; i < 50; ++i) {
    p_world.emplace_back(20.0 + 0.3 * i, 3.0 - 0.1 * i, 0.5);
    offsets_s.push_back(0.002F * static_cast<float>(i));
    p_sensor.push_back(T_map_sensor(static_cast<double>(offsets_s.back())).inverse() *
                       p_world.back());
  }
  TestScan scan(xyzCloud(p_sensor), T_map_vehicle, kStart_ns);
  scan.move(SensorMotion(knots), offsets_s);
  const Kept kept = addTo(&keeper, scan);
  ASSERT_EQ(kept.complete.size(), 1U);
  const PoseCloudData& points = kept.complete[0].points;
  EXPECT_LT((points.sensor_m - T_map_vehicle.inverse() * T_map_sensor(0).translation()).norm(),
            1e-9);
  for (std::size_t i = 0; i < p_world.size(); ++i) {
    // Half a step of MotionTable at 10 m/s and 0.5 rad/s times 20 m.
    EXPECT_LT((points.positions_m[i] - T_map_vehicle.inverse() * p_world[i]).norm(), 1.2e-3) << i;
  }
}

/// Rows with padding, a label and the colours of camera and class.
CloudBuilder richCloud(std::size_t rows, std::size_t columns) {
  CloudBuilder cloud;
  for (const char* name : {"x", "y", "z"}) cloud.layout.append(name, ScalarType::kFloat32);
  cloud.layout.append("label", ScalarType::kFloat32);
  for (const char* name : {"rgb_input", "rgb", "confidence"}) {
    cloud.layout.append(name, ScalarType::kFloat32);
  }
  cloud.layout.point_step += 5;
  cloud.layout.width = static_cast<uint32_t>(columns);
  cloud.layout.height = static_cast<uint32_t>(rows);
  cloud.layout.row_step = cloud.layout.width * cloud.layout.point_step + 7;
  cloud.allocate();
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t col = 0; col < columns; ++col) {
      const std::size_t i = row * columns + col;
      cloud.set(row, col, "x", 2.0 + static_cast<double>(i));
      cloud.set(row, col, "y", 0.0);
      cloud.set(row, col, "z", 0.0);
      cloud.set(row, col, "label", static_cast<double>(i % 4));
      cloud.setBits(row, col, "rgb_input", 0xff000000U + static_cast<uint32_t>(i));
      cloud.setBits(row, col, "rgb", 0x00ff00U);
      cloud.set(row, col, "confidence", 0.5);
    }
  }
  return cloud;
}

TEST(PoseKeeperGather, KeepsEveryByteOfUsablePointsAndCountsTheOthers) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  CloudBuilder cloud = richCloud(3, 4);
  cloud.set(0, 1, "y", std::numeric_limits<double>::quiet_NaN());
  cloud.set(1, 0, "z", -kInf);
  cloud.set(1, 2, "x", 0.3);
  cloud.set(2, 3, "x", 500.0);
  const std::set<std::size_t> bad = {1, 4, 6, 11};
  const CloudBuilder before = cloud;
  PoseKeeper keeper(onlyBy(1.0, 0, 0));
  const Kept kept = addTo(&keeper, TestScan(std::move(cloud), pose({0, 0, 0}), kStart_ns));
  const auto dropped = [&](GatherDrop reason) {
    return kept.use.dropped[static_cast<int>(reason)];
  };
  EXPECT_EQ(kept.use.points_kept, 8U);
  EXPECT_EQ(dropped(GatherDrop::kNotFinite), 2U);
  EXPECT_EQ(dropped(GatherDrop::kTooNear), 1U);
  EXPECT_EQ(dropped(GatherDrop::kTooFar), 1U);
  EXPECT_EQ(dropped(GatherDrop::kBetween), 0U);
  ASSERT_EQ(kept.complete.size(), 1U);
  const KeptPose& complete = kept.complete[0];
  EXPECT_EQ(layoutError(complete.view()), "");
  EXPECT_EQ(complete.layout.describeFields(), before.layout.describeFields());
  std::size_t k = 0;
  for (std::size_t i = 0; i < 12; ++i) {
    if (bad.count(i) != 0) continue;
    const uint8_t* original = before.view().point(i / 4, i % 4);
    EXPECT_TRUE(
        std::equal(original, original + before.layout.point_step, complete.view().point(0, k)))
        << i;
    EXPECT_EQ(complete.points.labels[k], i % 4);
    EXPECT_EQ(complete.points.rgb[k], i) << "the camera's colour, not the class's";
    ++k;
  }
  EXPECT_EQ(complete.points.positions_m.size(), k);
  EXPECT_EQ(complete.points.labels.size(), k);
  EXPECT_EQ(complete.points.rgb.size(), k);
}

TEST(PoseKeeperGather, LabelsThatAreNoneAreUnknown) {
  CloudBuilder cloud = richCloud(1, 4);
  cloud.set(0, 0, "label", std::numeric_limits<double>::quiet_NaN());
  cloud.set(0, 1, "label", -1.0);
  cloud.set(0, 2, "label", 256.0);
  cloud.set(0, 3, "label", 255.0);
  PoseKeeper keeper(onlyBy(1.0, 0, 0));
  const Kept kept = addTo(&keeper, TestScan(std::move(cloud), pose({0, 0, 0}), kStart_ns));
  ASSERT_EQ(kept.complete.size(), 1U);
  EXPECT_EQ(kept.complete[0].points.labels, (std::vector<uint8_t>{0, 0, 0, 255}));
}

TEST(PoseKeeperGather, AScanWithOtherFieldsIsRefusedUntilItMakesAPose) {
  PoseKeeper keeper(untilNext(1.0));
  addAt(&keeper, pose({0, 0, 0}));
  const Kept refused =
      addTo(&keeper, TestScan(richCloud(1, 4), pose({0.5, 0, 0}), kStart_ns + kPeriod_ns));
  EXPECT_FALSE(refused.use.taken);
  EXPECT_NE(refused.use.refused.find("label"), std::string::npos) << refused.use.refused;
  EXPECT_TRUE(refused.complete.empty());
  EXPECT_TRUE(keeper.gathering());
  const Kept joined =
      addTo(&keeper, TestScan(richCloud(1, 4), pose({1.5, 0, 0}), kStart_ns + 2 * kPeriod_ns));
  EXPECT_TRUE(joined.use.joined);
  ASSERT_EQ(joined.complete.size(), 1U);
  EXPECT_EQ(joined.complete[0].scans, 1U);
  EXPECT_TRUE(joined.complete[0].points.labels.empty());
  EXPECT_EQ(keeper.close()->points.labels.size(), 4U);
}

TEST(PoseKeeperGather, AVehicleThatStandsDoesNotGatherForEver) {
  PoseKeeperConfig config = untilNext(1.0);
  config.gather_max_points = 3 * static_cast<int>(kPoints.size()) - 1;
  PoseKeeper keeper(config);
  std::vector<std::size_t> completed;
  int taken = 0;
  for (int i = 0; i < 10; ++i) {
    const Kept kept = addAt(&keeper, pose({0, 0, 0}), i);
    taken += kept.use.taken ? 1 : 0;
    for (const KeptPose& complete : kept.complete) {
      completed.push_back(complete.points.positions_m.size());
    }
  }
  EXPECT_EQ(taken, 3);
  EXPECT_EQ(completed, (std::vector<std::size_t>{3 * kPoints.size()}));
  EXPECT_TRUE(addAt(&keeper, pose({2, 0, 0}), 11).use.joined);
}

TEST(PoseKeeperGather, EveryPointIsAccountedFor) {
  for (const char* gather : {"scan", "until_next"}) {
    PoseKeeperConfig config = onlyBy(1.0, 20.0, 0.7);
    config.gather = gather;
    config.gather_max_points = 100;
    PoseKeeper keeper(config);
    TestRandom random(11);
    std::vector<KeptPose> complete;
    uint64_t kept_points = 0, joined = 0;
    Vector3d at(0, 0, 0);
    for (int i = 0; i < 200; ++i) {
      std::vector<Vector3d> points;
      for (int k = static_cast<int>(random.real(0, 30)); k >= 0; --k) {
        points.emplace_back(random.real(-0.6, 0.6), random.real(-0.6, 120), 0.0);
      }
      at.x() += random.real(0, 0.4);
      const TestScan scan(xyzCloud(points), pose(at, 0.1 * random.normal()),
                          kStart_ns + i * kPeriod_ns);
      const ScanUse use = keeper.add(scan.placed(), &complete);
      joined += use.joined ? 1 : 0;
      if (!use.refused.empty()) continue;
      uint64_t sum = use.points_kept;
      for (const uint64_t count : use.dropped) sum += count;
      EXPECT_EQ(sum, points.size());
      kept_points += use.points_kept;
    }
    if (auto last = keeper.close()) complete.push_back(*last);
    EXPECT_EQ(joined, complete.size());
    EXPECT_EQ(joined, keeper.joined());
    EXPECT_GT(joined, 20U);
    uint64_t points = 0;
    for (std::size_t i = 0; i < complete.size(); ++i) {
      EXPECT_EQ(complete[i].id, i) << "in order, none left out";
      points += complete[i].points.positions_m.size();
    }
    EXPECT_EQ(points, kept_points);
  }
}

TEST(PoseKeeperConfig, ViolationsAreTold) {
  EXPECT_TRUE(PoseKeeperConfig().validate().empty());
  EXPECT_EQ(onlyBy(0, 0, 0).validate().size(), 1U);
  PoseKeeperConfig config = onlyBy(0, 0, 0);
  config.join = "every_scan";
  EXPECT_TRUE(config.validate().empty()) << "the limits are for motion";
  config.join = "sometimes";
  config.gather = "all";
  config.min_range_m = 200.0;
  EXPECT_EQ(config.validate().size(), 3U);
  EXPECT_THROW(PoseKeeper{config}, std::invalid_argument);
}

TEST(PoseKeeperConfig, EveryParameterIsInTheTable) {
  PoseKeeperConfig config;
  ParamTable table;
  config.addTo(&table);
  EXPECT_EQ(table.specs().size(), 8U);
  EXPECT_TRUE(table.apply({{"join", std::string("every_scan")}, {"pose_distance_m", 3.5}}).empty());
  EXPECT_EQ(config.join, "every_scan");
  EXPECT_EQ(config.pose_distance_m, 3.5);
  EXPECT_EQ(table.apply({{"pose_angle_deg", 181.0}}).size(), 1U);
}

}  // namespace
}  // namespace ladar_perception::test
