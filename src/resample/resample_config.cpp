// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/resample_config.h"

namespace ladar_perception {

void ResampleConfig::addTo(ParamTable* table) {
  table->add("engine", &engine,
             "arrival times by fast_marching, along the surface, or flood, straight, a bit faster");
  table->add("crust", &crust,
             "surfels, one cell deep and fast, or ellipsoids around every point, as in the paper");
  table->add("count", &count, 0, 100000000, "samples",
             "stop at exactly this many; 0: no such stop");
  table->add("radius_m", &radius_m, 0.0, 100.0, "m",
             "stop when no place of the surface is farther from a sample; 0: no such stop");
  table->add("time_budget_s", &time_budget_s, 0.0, 3600.0, "s",
             "stop after this time; 0: no such stop");
  table->add("cell_size_m", &cell_size_m, 0.0, 10.0, "m",
             "edge of the finest cells; 0 chooses it from the samples wanted");
  table->add("min_component_points", &min_component_points, 1, 100000, "points",
             "islands of fewer points, such as mixed pixels, get no samples; above 1 nor do lone "
             "points");
  table->add("nearest_original", &nearest_original,
             "give the original points nearest to the samples, not the samples themselves");
  table->add("threads", &threads, 1, 64, "threads", "results are the same bits for any number");
}

std::vector<std::string> ResampleConfig::validate() const {
  std::vector<std::string> violations;
  if (engine != "fast_marching" && engine != "flood") {
    violations.push_back("engine: '" + engine + "', expected fast_marching or flood");
  }
  if (crust != "surfels" && crust != "ellipsoids") {
    violations.push_back("crust: '" + crust + "', expected surfels or ellipsoids");
  }
  if (count == 0 && radius_m == 0.0 && time_budget_s == 0.0) {
    violations.emplace_back(
        "count, radius_m, time_budget_s: one of them at least must be greater than 0");
  }
  return violations;
}

}  // namespace ladar_perception
