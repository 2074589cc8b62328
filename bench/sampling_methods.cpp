// SPDX-License-Identifier: BSD-3-Clause
#include "sampling_methods.h"

#include <cmath>
#include <memory>
#include <utility>

#include "ladar_perception/sim/random.h"

namespace ladar_perception::bench {

namespace {

std::map<std::string, double> stagesOf(const ResampledCloud& samples) {
  const ResampleTimes& times = samples.times_ms;
  return {{"ms_voxels", times.voxels},   {"ms_attributes", times.attributes},
          {"ms_crust", times.crust},     {"ms_fronts", times.fronts},
          {"ms_samples", times.samples}, {"cells", static_cast<double>(samples.cells)}};
}

}  // namespace

SamplingMethod ourSampling(const ResampleConfig& config, const Policies& policies,
                           const PoseCloudData& cloud) {
  auto resampler = std::make_shared<CloudResampler>(config);
  auto samples = std::make_shared<ResampledCloud>();
  return {[=, &cloud] { *samples = resampler->resample(cloud, policies); },
          [=] { return samples->positions_m; }, [=] { return stagesOf(*samples); }};
}

SamplingMethod ourExtension(const ResampleConfig& config, const PoseCloudData& first,
                            const PoseCloudData& more) {
  auto resampler = std::make_shared<CloudResampler>(config);
  auto samples = std::make_shared<ResampledCloud>();
  return {[=] { *samples = resampler->extend(more); }, [=] { return samples->positions_m; },
          [=] { return stagesOf(*samples); }, [=] { resampler->resample(first, {}, true); }};
}

SamplingMethod randomSampling(const Points& points, std::size_t count) {
  auto chosen = std::make_shared<Points>();
  const auto run = [=, &points] {
    // The first steps of a Fisher-Yates shuffle.
    sim::Random random(1);
    std::vector<std::size_t> order(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    chosen->clear();
    for (std::size_t i = 0; i < count && i < order.size(); ++i) {
      std::swap(
          order[i],
          order[i + static_cast<std::size_t>(random.below(static_cast<int>(order.size() - i)))]);
      chosen->push_back(points[order[i]]);
    }
  };
  return {run, [=] { return *chosen; }};
}

void tuneCellEdge(std::size_t count, const std::function<std::size_t(double)>& points_at) {
  double low_m = 1e-3;
  double high_m = 10.0;
  constexpr int kSteps = 40;
  for (int step = 0; step < kSteps; ++step) {
    const double edge_m = std::sqrt(low_m * high_m);
    const auto found = static_cast<double>(points_at(edge_m));
    const auto wanted = static_cast<double>(count);
    if (std::abs(found - wanted) < 0.01 * wanted) return;
    (found > wanted ? low_m : high_m) = edge_m;
  }
}

}  // namespace ladar_perception::bench
