// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <set>

#include "ladar_perception/terrain/terrain_config.h"

namespace ladar_perception {
namespace {

TEST(TerrainConfig, DefaultsAreValidAndWithinTheirRanges) {
  TerrainConfig config;
  EXPECT_TRUE(config.validate().empty());
  ParamTable table;
  config.addTo(&table);
  for (const ParamSpec& spec : table.specs()) {
    if (auto* const* real = std::get_if<double*>(&spec.target)) {
      EXPECT_TRUE(**real >= spec.min && **real <= spec.max) << spec.name;
    } else if (auto* const* whole = std::get_if<int*>(&spec.target)) {
      EXPECT_TRUE(**whole >= spec.min && **whole <= spec.max) << spec.name;
    }
  }
}

TEST(TerrainConfig, EveryFieldIsAParameterOfItsOwn) {
  TerrainConfig config;
  ParamTable table;
  config.addTo(&table);
  std::set<std::string> names;
  std::set<const void*> targets;
  for (const ParamSpec& spec : table.specs()) {
    EXPECT_TRUE(names.insert(spec.name).second) << spec.name;
    EXPECT_FALSE(spec.meaning.empty()) << spec.name;
    const void* target =
        std::visit([](auto* p) { return static_cast<const void*>(p); }, spec.target);
    EXPECT_TRUE(targets.insert(target).second) << spec.name;
  }
  EXPECT_EQ(names.size(), 14U);
}

TEST(TerrainConfig, ValuesReachTheirFields) {
  TerrainConfig config;
  ParamTable table;
  config.addTo(&table);
  EXPECT_TRUE(table
                  .apply({{"voxel_size_m", 0.2},
                          {"map_size_x_m", 30},
                          {"map_size_y_m", 40.0},
                          {"map_size_z_m", 5.0},
                          {"map_center_height_m", -1.0},
                          {"support_radius_voxels", 3},
                          {"min_support_points", 7},
                          {"smooth_labels", false},
                          {"min_range_m", 1.0},
                          {"max_range_m", 50.0},
                          {"support_kernel", std::string("gaussian")},
                          {"forget_after_s", 12.5},
                          {"forget_after_scans", 40},
                          {"threads", 2}})
                  .empty());
  EXPECT_EQ(config.voxel_size_m, 0.2);
  EXPECT_EQ(config.map_size_x_m, 30.0);
  EXPECT_EQ(config.map_size_y_m, 40.0);
  EXPECT_EQ(config.map_size_z_m, 5.0);
  EXPECT_EQ(config.map_center_height_m, -1.0);
  EXPECT_EQ(config.support_radius_voxels, 3);
  EXPECT_EQ(config.min_support_points, 7);
  EXPECT_FALSE(config.smooth_labels);
  EXPECT_EQ(config.min_range_m, 1.0);
  EXPECT_EQ(config.max_range_m, 50.0);
  EXPECT_EQ(config.support_kernel, "gaussian");
  EXPECT_GT(config.supportStack().size(), 1U);
  EXPECT_EQ(config.forget_after_s, 12.5);
  EXPECT_EQ(config.forget_after_scans, 40);
  EXPECT_EQ(config.threads, 2);
  EXPECT_EQ(config.validate().size(), 1U) << "only one way of forgetting at a time";
  const MapShape shape = config.mapShape();
  EXPECT_EQ(shape.nx, 150);
  EXPECT_EQ(shape.ny, 200);
  EXPECT_EQ(shape.nz, 25);
}

TEST(TerrainConfig, LifetimesTooShortToCountAreRefused) {
  TerrainConfig config;
  for (const double lifetime_s : {1e-300, 1e-9, 0.0009}) {
    config.forget_after_s = lifetime_s;
    const auto violations = config.validate();
    ASSERT_EQ(violations.size(), 1U) << lifetime_s;
    EXPECT_EQ(violations[0], "forget_after_s: must be 0 or at least 0.001");
  }
  for (const double lifetime_s : {0.0, 0.001, 86400.0}) {
    config.forget_after_s = lifetime_s;
    EXPECT_TRUE(config.validate().empty()) << lifetime_s;
  }
}

TEST(TerrainConfig, UnknownKernelsAreRefused) {
  TerrainConfig config;
  config.support_kernel = "cone";
  const auto violations = config.validate();
  ASSERT_EQ(violations.size(), 1U);
  EXPECT_EQ(violations[0], "support_kernel: 'cone', expected box or gaussian");
}

TEST(TerrainConfig, OutOfRangeIsRefused) {
  for (const auto& [name, value] : {std::pair<const char*, double>{"voxel_size_m", 0.0},
                                    {"voxel_size_m", 0.005},
                                    {"map_size_x_m", 0.0},
                                    {"map_size_z_m", -1.0},
                                    {"max_range_m", 1e9}}) {
    TerrainConfig config;
    ParamTable table;
    config.addTo(&table);
    EXPECT_EQ(table.apply({{name, value}}).size(), 1U) << name;
  }
  for (const auto& [name, value] : {std::pair<const char*, int>{"threads", 0},
                                    {"support_radius_voxels", 0},
                                    {"support_radius_voxels", 7},
                                    {"min_support_points", 2}}) {
    TerrainConfig config;
    ParamTable table;
    config.addTo(&table);
    EXPECT_EQ(table.apply({{name, value}}).size(), 1U) << name;
  }
}

TEST(TerrainConfig, ShapeCoversTheSizeWithoutAVoxelTooMany) {
  TerrainConfig config;
  // 0.3 / 0.1 and 20 / 0.05 and the like are not whole in binary.
  for (const double voxel_size_m : {0.01, 0.03, 0.05, 0.07, 0.1, 0.15, 0.3}) {
    config.voxel_size_m = voxel_size_m;
    for (const int voxels : {10, 29, 57, 100, 199}) {
      config.map_size_x_m = voxels * voxel_size_m;
      EXPECT_EQ(config.mapShape().nx, voxels) << voxel_size_m;
    }
  }
  config.voxel_size_m = 0.1;
  config.map_size_y_m = 20.01;
  EXPECT_EQ(config.mapShape().ny, 201);
}

TEST(TerrainConfig, TooManyVoxelsAreNamedPerAxis) {
  TerrainConfig config;
  config.voxel_size_m = 0.01;
  config.map_size_x_m = 41.0;
  config.map_size_y_m = 1.0;
  config.map_size_z_m = 11.0;
  const auto violations = config.validate();
  ASSERT_EQ(violations.size(), 2U);
  EXPECT_EQ(violations[0].rfind("map_size_x_m", 0), 0U) << violations[0];
  EXPECT_NE(violations[0].find("4100 voxels"), std::string::npos) << violations[0];
  EXPECT_NE(violations[0].find("4096"), std::string::npos) << violations[0];
  EXPECT_EQ(violations[1].rfind("map_size_z_m", 0), 0U) << violations[1];
  config.map_size_x_m = 40.96;
  config.map_size_z_m = 10.24;
  EXPECT_TRUE(config.validate().empty());
  config.map_size_y_m = 40.96;  // 2^34 voxels: cell ids would overflow
  EXPECT_EQ(config.validate().size(), 1U);
}

TEST(TerrainConfig, RangesMustNotBeEmpty) {
  TerrainConfig config;
  config.min_range_m = config.max_range_m = 10.0;
  ASSERT_EQ(config.validate().size(), 1U);
  EXPECT_EQ(config.validate()[0].rfind("min_range_m", 0), 0U);
}

}  // namespace
}  // namespace ladar_perception
