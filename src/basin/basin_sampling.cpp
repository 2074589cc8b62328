// SPDX-License-Identifier: BSD-3-Clause
#include "basin_sampling.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <random>
#include <sstream>
#include <stdexcept>

#include "ladar_perception/register/surface_points.h"
#include "ladar_perception/resample/cloud_resampler.h"

namespace ladar_perception {
namespace {

using Positions = std::vector<Eigen::Vector3d>;

constexpr double kCrop_m = 25.0;
const std::array<const char*, 5> kPlainMethods = {"raw", "voxel_grid", "voxel_grid_25m", "random",
                                                  "fps"};

bool isPlain(const std::string& method) {
  return std::find(kPlainMethods.begin(), kPlainMethods.end(), method) != kPlainMethods.end();
}

Policies policiesOf(const std::string& method) {
  Policies policies;
  std::istringstream parts(method);
  for (std::string part; std::getline(parts, part, '+');) policies.push_back(makePolicy(part));
  return policies;
}

/// In random order, so that the first ones are a sampling too; the same for every standard library.
void shuffle(Positions* points, uint64_t seed) {
  std::mt19937_64 engine(seed);
  for (std::size_t i = points->size(); i > 1; --i)
    std::swap((*points)[i - 1], (*points)[engine() % i]);
}

Positions within(const Positions& points_m, const Eigen::Vector3d& sensor_m, double range_m) {
  Positions near;
  for (const Eigen::Vector3d& p : points_m) {
    if ((p - sensor_m).norm() <= range_m) near.push_back(p);
  }
  return near;
}

Positions plainSamples(const PoseCloudData& cloud, const Sampling& sampling) {
  const auto count = static_cast<std::size_t>(sampling.count);
  Positions samples;
  if (sampling.method == "fps") return pclFarthestPoints(cloud.positions_m, count);
  if (sampling.method == "voxel_grid") {
    samples = pclVoxelGrid(cloud.positions_m, count);
  } else if (sampling.method == "voxel_grid_25m") {
    samples = pclVoxelGrid(within(cloud.positions_m, cloud.sensor_m, kCrop_m), count);
  } else {
    samples = cloud.positions_m;
  }
  shuffle(&samples, sampling.seed);
  if (sampling.method == "random" && samples.size() > count) samples.resize(count);
  return samples;
}

Positions policySamples(const PoseCloudData& cloud, const Sampling& sampling) {
  ResampleConfig config;
  config.count = sampling.count;
  // What is registered ends against points of the scan: samples on a surface blended from few points
  // would end beside it.
  config.nearest_original = true;
  return CloudResampler(config).resample(cloud, policiesOf(sampling.method)).positions_m;
}

}  // namespace

void checkMethod(const std::string& method) {
  if (isPlain(method)) return;
  try {
    policiesOf(method);
  } catch (const std::invalid_argument& error) {
    std::string names;
    for (const char* name : kPlainMethods) names += std::string(names.empty() ? "" : ", ") + name;
    throw std::invalid_argument("'" + method + "' is none of " + names +
                                ", and as a policy: " + error.what());
  }
}

std::vector<std::string> splitMethods(const std::string& list) {
  std::vector<std::string> methods;
  std::istringstream parts(list);
  for (std::string part; std::getline(parts, part, ',');) {
    const bool continues = part.find('=') != std::string::npos &&
                           part.find(':') == std::string::npos && !methods.empty();
    if (continues) {
      methods.back() += "," + part;
    } else if (!part.empty()) {
      methods.push_back(part);
    }
  }
  return methods;
}

SampledCloud sampleCloud(const BasinCloud& cloud, const Sampling& sampling) {
  const auto begin = std::chrono::steady_clock::now();
  const Positions samples = isPlain(sampling.method) ? plainSamples(cloud.points, sampling)
                                                     : policySamples(cloud.points, sampling);
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - begin;
  return {withNormalsOf(cloud.surface, samples), elapsed.count()};
}

}  // namespace ladar_perception
