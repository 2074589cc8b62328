// SPDX-License-Identifier: BSD-3-Clause
// An independent check of scatter matrices and eigen-solvers: the features that the lab of the
// method published for one of its tiles. Skipped where there are no data (see LADAR_DATA).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nanoflann.hpp>
#include <utility>

#include "io_test_files.h"
#include "ladar_perception/io/text_reader.h"
#include "ladar_perception/saliency/saliency.h"

namespace ladar_perception {
namespace {

constexpr double kRadius_m = 0.6;
/// The tile is given in whole centimetres: with such steps, moments are those of the file exactly.
constexpr double kStep_m = 0.01;
constexpr double kTolerance = 1e-3;
constexpr double kShare = 0.998;
/// What six digits, as they are published, tell at the least.
constexpr double kPrinted = 5.1e-6;
/// What rounding may do to eigenvalues, of the greatest, above the tolerance. In doubles it counts
/// only where l0 is 0 and what was published is 1e-17 m^2 or less.
constexpr double kRoundingOfDouble = 1e-13;
constexpr double kRoundingOfFloat = 4e-7;  // as saliencyOfBlock promises

constexpr std::size_t kFeatures = 7;
using Features = std::array<double, kFeatures>;  // f1 to f7

/// Points of a file, in whole centimetres.
std::vector<FixedPoint> readCentimetres(const Scan& scan) {
  std::array<std::vector<int64_t>, 3> axes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double value : readColumn(scan, std::string(1, "xyz"[axis]))) {
      const int64_t steps = std::llround(value / kStep_m);
      // What is left is the reader's float32.
      EXPECT_NEAR(static_cast<double>(steps) * kStep_m, value, 2e-5);
      axes[axis].push_back(steps);
    }
  }
  std::vector<FixedPoint> points;
  for (std::size_t i = 0; i < axes[0].size(); ++i) {
    points.push_back({axes[0][i], axes[1][i], axes[2][i]});
  }
  return points;
}

/// The published features, point by point.
std::vector<Features> readFeatures(const Scan& scan) {
  std::vector<Features> features;
  for (std::size_t f = 0; f < kFeatures; ++f) {
    const std::vector<double> column = readColumn(scan, "f" + std::to_string(f + 1));
    features.resize(column.size());
    for (std::size_t i = 0; i < column.size(); ++i) features[i][f] = column[i];
  }
  return features;
}

/// Points for nanoflann, in metres: the double nearest to the number in the file.
struct PointSource {
  explicit PointSource(const std::vector<FixedPoint>& points) {
    for (const FixedPoint& q : points) positions_m.push_back(positionOf(q));
  }
  static std::array<double, 3> positionOf(const FixedPoint& q) {
    return {static_cast<double>(q.x) / 100.0, static_cast<double>(q.y) / 100.0,
            static_cast<double>(q.z) / 100.0};
  }
  std::size_t kdtree_get_point_count() const { return positions_m.size(); }
  double kdtree_get_pt(std::size_t index, std::size_t axis) const {
    return positions_m[index][axis];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }

  std::vector<std::array<double, 3>> positions_m;
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointSource>,
                                                 PointSource, 3, std::size_t>;

/// f1 to f7 by their definition from the outcome of either eigen-solver.
template <typename Scalar>
Features featuresOf(const BasicSaliency<Scalar>& s) {
  const double f1 = s.surface;
  const double f2 = s.linear;
  const double f3 = s.scatter;
  const double greatest = std::max({f1, f2, f3});
  const auto horizontal = [](const auto& direction) {
    return static_cast<double>(std::hypot(direction.x(), direction.y()));
  };
  return {f1,
          f2,
          f3,
          std::abs(s.tangent.z()) * f2 / greatest,
          horizontal(s.tangent) * f2 / greatest,
          std::abs(s.normal.z()) * f1 / greatest,
          horizontal(s.normal) * f1 / greatest};
}

class CmuFeatures : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string folder = dataFolder() + "/oakland/";
    if (dataFolder().empty()) GTEST_SKIP() << "no data: set LADAR_DATA to its folder";
    const std::string features_file = folder + "oakland_part3_am_rf.node_features";
    const std::string tile_file = folder + "tiles/oakland_part3_am.xyz_label_conf";
    for (const std::string& file : {features_file, tile_file}) {
      if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    }
    tile_ = readCentimetres(readOaklandScan(tile_file));
    const Scan scan = readTextScan(features_file, {"x", "y", "z", "_", "_", "f1", "f2", "f3", "f4",
                                                   "f5", "f6", "f7", "_", "_", "_"});
    queries_ = readCentimetres(scan);
    published_ = readFeatures(scan);
    ASSERT_EQ(queries_.size(), 89822U);
  }

  /// f1 to f7 of the ball around each query, which `compute(q, moments)` makes of its moments.
  template <typename Compute>
  std::vector<Features> featuresOfBalls(Compute&& compute) const {
    const PointSource source(tile_);
    Tree tree(3, source, nanoflann::KDTreeSingleIndexAdaptorParams(10));
    tree.buildIndex();
    const nanoflann::SearchParams unsorted(32, 0.0F, false);
    std::vector<std::pair<std::size_t, double>> matches;
    std::vector<Features> result;
    for (const FixedPoint& q : queries_) {
      // Neighbours at 0.6 m exactly, which 2.5 % of the points have on this grid, are in or out as
      // rounding has it in doubles, coordinates in metres: all agree with "<", as nanoflann has it,
      // and 0.3 % of the points do not with "<=".
      tree.radiusSearch(PointSource::positionOf(q).data(), kRadius_m * kRadius_m, matches,
                        unsorted);
      Moments moments;
      for (const auto& match : matches) moments.add(tile_[match.first]);
      result.push_back(compute(q, moments));
    }
    return result;
  }

  /// What rounding may cost each feature of a point. A direction is off by the rounding over the
  /// gap between its eigenvalue and the next, and its features are weighted with that gap.
  static Features allowanceOf(const Features& f, double rounding) {
    const double l2 = f[0] + f[1] + f[2];
    const double values = rounding * l2;
    const double directions = values / std::max({f[0], f[1], f[2]});
    return {values, values, values, directions, directions, directions, directions};
  }

  /// Each feature of `ours` is within the tolerance of the published one at the share of points
  /// asked for, and nowhere off by more than kPrinted.
  void expectAgreement(const std::vector<Features>& ours, double rounding) const {
    ASSERT_EQ(ours.size(), published_.size());
    for (std::size_t f = 0; f < kFeatures; ++f) {
      std::size_t agree = 0;
      double worst = 0.0;
      for (std::size_t i = 0; i < ours.size(); ++i) {
        const double difference = std::abs(ours[i][f] - published_[i][f]);
        const double excess = difference - allowanceOf(published_[i], rounding)[f];
        const double error = excess > 0.0 ? excess / std::abs(published_[i][f]) : 0.0;
        // A number that is none does not agree.
        agree += difference >= 0.0 && error <= kTolerance ? 1 : 0;
        worst = std::max(worst, error);
      }
      const double share = static_cast<double>(agree) / static_cast<double>(ours.size());
      std::printf("f%zu: %.5f of %zu points within %g, the worst off by %.2g\n", f + 1, share,
                  ours.size(), kTolerance, worst);
      EXPECT_GE(share, kShare) << "f" << f + 1;
      EXPECT_LE(worst, kPrinted) << "f" << f + 1;
    }
  }

  std::vector<FixedPoint> tile_;
  std::vector<FixedPoint> queries_;
  std::vector<Features> published_;
};

TEST_F(CmuFeatures, AreReproducedInDouble) {
  expectAgreement(featuresOfBalls([](const FixedPoint& q, const Moments& moments) {
                    const Saliency saliency = saliencyOf(moments.about(q), kStep_m);
                    EXPECT_TRUE(saliency.defined);
                    return featuresOf(saliency);
                  }),
                  kRoundingOfDouble);
}

/// The way of the pipeline: blocks in float32, good to 4e-7 of l2.
TEST_F(CmuFeatures, AreReproducedInBlocksOfFloat32) {
  expectAgreement(featuresOfBalls([](const FixedPoint& q, const Moments& moments) {
                    SaliencyBlock block;
                    const VoxelIndex voxel = voxelOf(q);
                    saliencyOfBlock(&moments, &voxel, 1, kStep_m, &block);
                    EXPECT_EQ(block.defined[0], 1U);
                    return featuresOf(block.at(0));
                  }),
                  kRoundingOfFloat);
}

}  // namespace
}  // namespace ladar_perception
