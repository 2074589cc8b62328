// SPDX-License-Identifier: BSD-3-Clause
// The oracle of the fronts, against times in closed form and against scikit-fmm.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "eikonal_oracle.h"
#include "skfmm_times.h"

namespace ladar_perception::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

std::vector<double> uniformTimes(const RegularGrid& grid, std::size_t source, double speed = 1.0) {
  return EikonalOracle(grid, std::vector<double>(grid.size(), speed)).march({source});
}

/// Greatest error in cells of the front from the middle of a square of 2n+1 cells, speed 1, and
/// whether all times are late.
struct PlaneError {
  double greatest_cells = 0.0;
  bool never_early = true;
};
PlaneError planeError(int n) {
  const RegularGrid grid{2 * n + 1, 2 * n + 1, 1, 0.1};
  const std::size_t source = grid.index(n, n);
  const std::vector<double> times = uniformTimes(grid, source);
  PlaneError error;
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const double late_m = times[cell] - (grid.center(cell) - grid.center(source)).norm();
    error.greatest_cells = std::max(error.greatest_cells, late_m / grid.spacing_m);
    error.never_early = error.never_early && late_m > -1e-12;
  }
  return error;
}

TEST(ResampleEikonalOracle, IsExactAlongTheAxes) {
  const RegularGrid grid{9, 7, 5, 0.25};
  const std::vector<double> times = uniformTimes(grid, grid.index(4, 3, 2), 2.0);
  EXPECT_DOUBLE_EQ(times[grid.index(4, 3, 2)], 0.0);
  EXPECT_DOUBLE_EQ(times[grid.index(0, 3, 2)], 0.5);
  EXPECT_DOUBLE_EQ(times[grid.index(4, 6, 2)], 0.375);
  EXPECT_DOUBLE_EQ(times[grid.index(4, 3, 0)], 0.25);
}

/// Solved by hand: 1 + 1/sqrt(2) on the diagonal of a plane and, with that below it, on that of
/// space.
TEST(ResampleEikonalOracle, SolvesEquationSeven) {
  const RegularGrid grid{3, 3, 3, 1.0};
  const std::vector<double> times = uniformTimes(grid, grid.index(0, 0, 0));
  const double diagonal = 1.0 + 1.0 / std::sqrt(2.0);
  EXPECT_DOUBLE_EQ(times[grid.index(1, 1, 0)], diagonal);
  EXPECT_DOUBLE_EQ(times[grid.index(1, 0, 1)], diagonal);
  EXPECT_DOUBLE_EQ(times[grid.index(1, 1, 1)], diagonal + 1.0 / std::sqrt(3.0));
}

/// First-order differences are late, by a part of a cell that grows with the logarithm of the way.
TEST(ResampleEikonalOracle, HasTheErrorOfFirstOrder) {
  double before_cells = 0.0;
  for (const int n : {5, 10, 20, 40, 80}) {
    const PlaneError error = planeError(n);
    EXPECT_TRUE(error.never_early);
    if (n > 5) {
      EXPECT_NEAR(error.greatest_cells - before_cells, 0.19, 0.05) << n;
    }
    before_cells = error.greatest_cells;
  }
  EXPECT_NEAR(before_cells, 1.47, 0.01);
}

TEST(ResampleEikonalOracle, TakesTheNearestOfManySources) {
  const RegularGrid grid{11, 1, 1, 1.0};
  const std::vector<double> times =
      EikonalOracle(grid, std::vector<double>(grid.size(), 1.0)).march({0, 7});
  EXPECT_EQ(times, (std::vector<double>{0, 1, 2, 3, 3, 2, 1, 0, 1, 2, 3}));
}

TEST(ResampleEikonalOracle, GoesAroundWhatIsNotCrust) {
  // . . .      a wall of one cell, open at the top
  // s # t
  const RegularGrid grid{3, 2, 1, 1.0};
  std::vector<double> speeds(grid.size(), 1.0);
  speeds[grid.index(1, 0)] = 0.0;
  const std::vector<double> times = EikonalOracle(grid, speeds).march({grid.index(0, 0)});
  EXPECT_TRUE(std::isinf(times[grid.index(1, 0)]));
  EXPECT_DOUBLE_EQ(times[grid.index(2, 0)], 4.0);
  speeds[grid.index(1, 1)] = 0.0;
  EXPECT_TRUE(std::isinf(EikonalOracle(grid, speeds).march({0})[grid.index(2, 0)]));
}

TEST(ResampleEikonalOracle, ConvergesWhereTheSpeedVaries) {
  double before = 0.0;
  for (const int n : {20, 40, 80}) {
    const RegularGrid grid{n + 1, n + 1, 1, 1.0 / n};
    std::vector<double> speeds;
    for (std::size_t cell = 0; cell < grid.size(); ++cell) {
      speeds.push_back(0.5 + 1.5 * grid.center(cell).x());
    }
    const std::size_t source = grid.index(n / 5, n / 2);
    const std::vector<double> times = EikonalOracle(grid, speeds).march({source});
    double greatest = 0.0;
    for (std::size_t cell = 0; cell < grid.size(); ++cell) {
      const double exact = linearSpeedTime(0.5, 1.5, grid.center(source), grid.center(cell));
      greatest = std::max(greatest, std::abs(times[cell] - exact));
    }
    if (n > 20) {
      EXPECT_NEAR(greatest / before, 0.56, 0.06) << n;
    }
    before = greatest;
  }
  EXPECT_LT(before, 0.03);
}

TEST(ResampleEikonalOracle, AgreesWithScikitFmm) {
  const auto fields = readSkfmmFields(LADAR_SOURCE_DIR "/test/data/skfmm_times.txt");
  EXPECT_EQ(fields.size(), 6u);
  for (const auto& [name, field] : fields) {
    const std::vector<double> times = EikonalOracle(field.grid, field.speeds).march(field.sources);
    for (std::size_t cell = 0; cell < times.size(); ++cell) {
      ASSERT_NEAR(times[cell], field.first_order[cell], 1e-8) << name << " cell " << cell;
    }
  }
}

/// That the file's second-order times are what they are called: the error that first order leaves
/// around the source does not grow on the way.
TEST(ResampleEikonalOracle, ScikitFmmsSecondOrderIsNearer) {
  const auto fields = readSkfmmFields(LADAR_SOURCE_DIR "/test/data/skfmm_times.txt");
  const SkfmmField& field = fields.at("plane_uniform");
  const Eigen::Vector3d source = field.grid.center(field.sources.front());
  double first_m = 0.0;
  double second_m = 0.0;
  for (std::size_t cell = 0; cell < field.grid.size(); ++cell) {
    const double exact_m = (field.grid.center(cell) - source).norm();
    first_m = std::max(first_m, std::abs(field.first_order[cell] - exact_m));
    second_m = std::max(second_m, std::abs(field.second_order[cell] - exact_m));
  }
  EXPECT_NEAR(second_m, 0.33 * field.grid.spacing_m, 0.01 * field.grid.spacing_m);
  EXPECT_GT(first_m, 2.0 * second_m);
}

TEST(ResampleEikonalOracle, DistancesOnASphere) {
  const Eigen::Vector3d x = 2.0 * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(sphereDistance(2.0, x, 2.0 * Eigen::Vector3d::UnitY()), kPi, 1e-12);
  EXPECT_NEAR(sphereDistance(2.0, x, -x), 2.0 * kPi, 1e-12);
  // Where an arc cosine would have lost everything.
  const Eigen::Vector3d near(2.0, 2e-9, 0.0);
  EXPECT_NEAR(sphereDistance(2.0, x, near), 2e-9, 1e-18);
  EXPECT_EQ(sphereDistance(2.0, x, x), 0.0);
}

TEST(ResampleEikonalOracle, DistancesAroundACorner) {
  const Eigen::Vector3d floor(0.0, 3.0, 0.0);
  EXPECT_DOUBLE_EQ(cornerDistance(floor, Eigen::Vector3d(0.0, 0.0, 2.0)), 5.0);
  EXPECT_DOUBLE_EQ(cornerDistance(floor, Eigen::Vector3d(12.0, 0.0, 2.0)), 13.0);
  EXPECT_DOUBLE_EQ(cornerDistance(floor, Eigen::Vector3d(4.0, 0.0, 0.0)), 5.0);
}

/// Along the gradient the time is the integral of dx / speed.
TEST(ResampleEikonalOracle, TimesWhereTheSpeedIsLinear) {
  const Eigen::Vector3d a(0.2, 1.0, 0.0);
  EXPECT_NEAR(linearSpeedTime(0.5, 1.5, a, Eigen::Vector3d(1.4, 1.0, 0.0)),
              std::log(2.6 / 0.8) / 1.5, 1e-12);
  EXPECT_NEAR(linearSpeedTime(2.0, 1e-6, a, Eigen::Vector3d(0.2, 4.0, 4.0)), 2.5, 1e-5);
}

}  // namespace
}  // namespace ladar_perception::test
