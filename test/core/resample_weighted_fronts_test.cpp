// SPDX-License-Identifier: BSD-3-Clause
// Fronts where the slowness varies, against the paper's fast marching on a full grid.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "eikonal_oracle.h"
#include "ladar_perception/resample/fronts.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using namespace test;

constexpr int kSide = 61;

/// A level crust of single cells, each a neighbour of the eight around it; places are up to
/// `scatter` cells from the middles.
Crust levelCrust(const std::function<double(double)>& slowness_at_x, double scatter) {
  Crust crust;
  TestRandom random(1);
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      crust.first_neighbor.push_back(static_cast<uint32_t>(crust.neighbors.size()));
      for (int n = 0; n < 9; ++n) {
        const int x = i + n % 3 - 1;
        const int y = j + n / 3 - 1;
        const bool is_cell = n != 4 && x >= 0 && x < kSide && y >= 0 && y < kSide;
        if (is_cell) crust.neighbors.push_back(static_cast<uint32_t>(y * kSide + x));
      }
      const double x = i + scatter * random.real(-1.0, 1.0);
      const double y = j + scatter * random.real(-1.0, 1.0);
      crust.positions.push_back(Eigen::Vector3d(x, y, 0.0).cast<float>());
      crust.normals.push_back(Eigen::Vector3f::UnitZ());
      crust.slowness.push_back(static_cast<float>(slowness_at_x(i)));
      crust.levels.push_back(0);
      crust.keys.push_back(0);
    }
  }
  crust.first_neighbor.push_back(static_cast<uint32_t>(crust.neighbors.size()));
  return crust;
}

/// Greatest difference from the oracle's times over the cells from `first_x` on, relative to the
/// time and ten cells more.
double greatestDifference(const std::function<double(double)>& slowness_at_x, double scatter,
                          double first_x = 0.0) {
  const Crust crust = levelCrust(slowness_at_x, scatter);
  const RegularGrid grid{kSide, kSide, 1, 1.0};
  std::vector<double> speeds;
  for (const float slowness : crust.slowness) speeds.push_back(1.0 / slowness);
  const std::size_t source = grid.index(20, 30);
  const std::vector<double> expected = EikonalOracle(grid, speeds).march({source});

  FrontField field(crust);
  field.reset(1e9F);
  Fronts<FastMarching>(&field).insert(static_cast<uint32_t>(source), crust.positions[source]);
  double greatest = 0.0;
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const double x = grid.center(cell).x();
    if (x < first_x) continue;
    const double difference = std::abs(field.arrivals[cell].time - expected[cell]);
    greatest = std::max(greatest, difference / (expected[cell] + 10.0 * slowness_at_x(x)));
  }
  return greatest;
}

/// A front that comes from where it is fast goes on slower, however far.
TEST(ResampleWeightedFronts, ASlowerHalfIsReachedLater) {
  for (const double scatter : {0.0, 0.3}) {
    const auto slowness = [](double x) { return x < 30.0 ? 1.0 : std::sqrt(3.0); };
    EXPECT_LT(greatestDifference(slowness, scatter), 0.1) << scatter;
  }
}

/// Into a faster half and along it. In the slow half the straight way is taken where the sample is
/// in sight, though one through the fast half may be shorter.
TEST(ResampleWeightedFronts, AFasterHalfIsReachedEarlier) {
  for (const double scatter : {0.0, 0.3}) {
    const auto slowness = [](double x) { return x < 30.0 ? 1.0 : std::sqrt(1.0 / 3.0); };
    EXPECT_LT(greatestDifference(slowness, scatter, 30.0), 0.1) << scatter;
  }
}

TEST(ResampleWeightedFronts, SlownessMayChangeSmoothly) {
  for (const double scatter : {0.0, 0.3}) {
    const auto slowness = [](double x) { return 1.0 + 0.5 * std::sin(0.2 * x); };
    EXPECT_LT(greatestDifference(slowness, scatter), 0.1) << scatter;
  }
}

}  // namespace
}  // namespace ladar_perception
