// SPDX-License-Identifier: BSD-3-Clause
// Temporal re-use with features of several supports and of columns, and with labels smoothed over
// neighbours near and far: as in terrain_reuse_test.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "random_drive.h"
#include "wide_model.h"

namespace ladar_perception {
namespace {

using test::DriveCase;
using test::randomModel;
using test::smallMap;
using test::wideFeatures;

/// The map of the other drives, and what is asked of it.
struct Question {
  std::vector<std::string> features = wideFeatures();
  int classes = 3;
  std::vector<int> smoothing_radii;  // none: labels are not smoothed
  int threads = 1;
  int support_radius = 4;
  std::string kernel = "box";
  double map_size_z_m = 2.0;
  int forget_after_scans = 0;
};

DriveCase driveCase(const std::string& name, const Question& question) {
  DriveCase drive;
  drive.name = name;
  drive.config = smallMap();
  drive.config.threads = question.threads;
  drive.config.support_radius_voxels = question.support_radius;
  drive.config.support_kernel = question.kernel;
  drive.config.map_size_z_m = question.map_size_z_m;
  drive.config.forget_after_scans = question.forget_after_scans;
  drive.config.smooth_labels = !question.smoothing_radii.empty();
  drive.model = randomModel(drive.config, question.features, question.classes);
  drive.model.calibration.temperature = 1.5;
  Calibration::Smoothing& smoothing = drive.model.calibration.smoothing;
  smoothing.radii_voxels = question.smoothing_radii;
  smoothing.exponents = {0.375};
  for (std::size_t i = 0; i < question.smoothing_radii.size(); ++i) {
    smoothing.exponents.push_back(0.75 / static_cast<double>(i + 1));
  }
  for (int c = 0; c < question.classes; ++c) {
    drive.model.calibration.offsets.push_back(0.2 - 0.1 * c);
    smoothing.offsets.push_back(0.07 * c - 0.1);
  }
  // Layers of columns as wide as half the map carry changes far.
  drive.reuses = false;
  drive.scans = 300;
  return drive;
}

template <typename Change>
DriveCase driveCase(const std::string& name, const Change& change) {
  Question question;
  change(&question);
  return driveCase(name, question);
}

std::vector<DriveCase> driveCases() {
  std::vector<DriveCase> cases;
  const auto add = [&](const std::string& name, auto&& change) {
    cases.push_back(driveCase(name, change));
  };
  add("wide", [](Question* /*q*/) {});
  add("wide_smoothed", [](Question* q) { q->smoothing_radii = {5}; });
  add("wide_kernel", [](Question* q) { q->kernel = "gaussian"; });
  add("wide_kernel_smoothed_threads", [](Question* q) {
    q->kernel = "gaussian";
    q->smoothing_radii = {3, 5};
    q->threads = 2;
  });
  add("wide_smoothed_forgets_threads", [](Question* q) {
    q->smoothing_radii = {2};
    q->forget_after_scans = 25;
    q->threads = 4;
    q->classes = 5;
  });
  add("wide_tall_smoothed", [](Question* q) {
    q->smoothing_radii = {4, 1, 7};
    q->map_size_z_m = 7.0;
    q->classes = 9;
    q->threads = 5;
  });
  // What left the window counts for labels farther than for features, and a changed support
  // reaches farther than the configured one.
  add("smoothed_beyond_the_support", [](Question* q) {
    q->features = {"cbrt_scatter", "cbrt_linear", "normal_angle"};
    q->support_radius = 1;
    q->smoothing_radii = {2, 8};
    q->classes = 3;
  });
  cases.back().scans = 600;
  add("one_wide_support", [](Question* q) {
    q->features = {"spread_angle@8", "log_points@8", "cbrt_surface@1"};
    q->support_radius = 1;
    q->threads = 3;
  });
  add("columns_alone", [](Question* q) {
    q->features = {"log_height@12", "log_ground_height@6", "log_fill@1"};
    q->support_radius = 1;
    q->smoothing_radii = {1};
  });
  return cases;
}

class ReuseOfFeatures : public testing::TestWithParam<DriveCase> {};

TEST_P(ReuseOfFeatures, WhatIsKnownIsWhatComputingAllAnewGives) {
  test::expectRightAllTheWay(GetParam());
}

INSTANTIATE_TEST_SUITE_P(Drives, ReuseOfFeatures, testing::ValuesIn(driveCases()),
                         [](const auto& drive) { return drive.param.name; });

}  // namespace
}  // namespace ladar_perception
