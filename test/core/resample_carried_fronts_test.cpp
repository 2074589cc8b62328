// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "ladar_perception/resample/carried_fronts.h"
#include "test_crusts.h"
#include "test_random.h"

namespace ladar_perception::test {
namespace {

FarthestPointsGoal goalOf(std::size_t count) {
  FarthestPointsGoal goal;
  goal.count = count;
  goal.first_radius = 8.0F;
  return goal;
}

template <typename Metric>
class ResampleCarriedFronts : public testing::Test {
 protected:
  /// Samples of `first`, and these on `second`, the fronts carried.
  void carry(const Crust& first, const Crust& second, std::size_t count) {
    before_.emplace(first);
    set_ = chooseFarthestPoints<Metric>(&*before_, goalOf(count), &pool_);
    ASSERT_EQ(set_.size(), count);
    field_.emplace(second);
    field_->reset(goalOf(count).first_radius);
    carried_ = carryFronts<Metric>(*before_, set_, &*field_);
  }

  /// Of the cells of the second crust those whose times are more than rounding from what fronts run
  /// anew give.
  std::vector<uint32_t> differing() const {
    FrontField anew(*field_->crust);
    anew.reset(goalOf(0).first_radius);
    Fronts<Metric> fronts(&anew);
    for (std::size_t i = 0; i < carried_.set.size(); ++i) {
      fronts.insert(carried_.set.cells[i], carried_.set.positions[i]);
    }
    std::vector<uint32_t> cells;
    for (uint32_t cell = 0; cell < field_->crust->size(); ++cell) {
      if (std::abs(anew.arrivals[cell].time - field_->arrivals[cell].time) > 1e-4F) {
        cells.push_back(cell);
      }
    }
    return cells;
  }

  /// Each time is that of a sample that is in.
  void expectOwners() const {
    const std::set<uint32_t> samples(carried_.set.cells.begin(), carried_.set.cells.end());
    for (const FrontField::Arrival& arrival : field_->arrivals) {
      if (arrival.owner == kNoIndex) continue;
      EXPECT_EQ(samples.count(arrival.owner), 1u);
      EXPECT_EQ(field_->arrivals[arrival.owner].owner, arrival.owner);
    }
  }

  ThreadPool pool_{1};
  SampleSet set_;
  std::optional<FrontField> before_;
  std::optional<FrontField> field_;
  EarlierSamples carried_;
};
using Metrics = testing::Types<FastMarching, Flood>;
TYPED_TEST_SUITE(ResampleCarriedFronts, Metrics);

TYPED_TEST(ResampleCarriedFronts, TheSameCrustKeepsAll) {
  const Crust crust = gridCrust(80, 60);
  this->carry(crust, crust, 150);
  EXPECT_TRUE(this->carried_.new_cells.empty());
  EXPECT_EQ(this->carried_.set.cells, this->set_.cells);
  const std::set<uint32_t> samples(this->set_.cells.begin(), this->set_.cells.end());
  for (std::size_t i = 0; i < crust.size(); ++i) {
    // But the fronts of samples that were chosen and left out for the count.
    if (samples.count(this->before_->arrivals[i].owner) == 0) continue;
    EXPECT_EQ(this->field_->arrivals[i].time, this->before_->arrivals[i].time);
    EXPECT_EQ(this->field_->arrivals[i].owner, this->before_->arrivals[i].owner);
    EXPECT_EQ(this->field_->in_sight[i], this->before_->in_sight[i]);
  }
}

TYPED_TEST(ResampleCarriedFronts, RunOnIntoCellsThatHaveCome) {
  const Crust first = gridCrust(80, 60, [](int x, int) { return x < 50; });
  const Crust second = gridCrust(80, 60);
  this->carry(first, second, 120);
  ASSERT_EQ(this->carried_.set.size(), 120u);
  EXPECT_EQ(this->carried_.set.positions, this->set_.positions);
  EXPECT_EQ(this->carried_.set.covering, this->set_.covering);
  EXPECT_EQ(this->carried_.new_cells.size(), 30u * 60u);
  this->expectOwners();
  EXPECT_TRUE(this->differing().empty());
  // They end at their limit.
  EXPECT_TRUE(std::any_of(this->field_->arrivals.begin(), this->field_->arrivals.end(),
                          [](const auto& arrival) { return arrival.owner == kNoIndex; }));
}

/// A gap that fronts went around is closed: those on both sides come through.
TYPED_TEST(ResampleCarriedFronts, ComeThroughAGapThatIsClosed) {
  const Crust first = gridCrust(80, 60, [](int x, int y) { return x != 40 || y > 55; });
  const Crust second = gridCrust(80, 60);
  this->carry(first, second, 60);
  this->expectOwners();
  EXPECT_TRUE(this->differing().empty());
}

TYPED_TEST(ResampleCarriedFronts, GoAroundAGapThatHasOpened) {
  const Crust first = gridCrust(80, 60);
  const Crust second = gridCrust(80, 60, [](int x, int y) { return x != 40 || y > 55; });
  this->carry(first, second, 60);
  // Samples that lay in the gap move beside it, all in cells of their own.
  EXPECT_EQ(this->carried_.set.size(), 60u);
  const std::set<uint32_t> cells(this->carried_.set.cells.begin(), this->carried_.set.cells.end());
  EXPECT_EQ(cells.size(), 60u);
  this->expectOwners();
  // Cells beyond the gap that a front reached through cells which others have taken since, if any,
  // keep its time.
  EXPECT_LT(this->differing().size(), second.size() / 200);
}

TYPED_TEST(ResampleCarriedFronts, SamplesWithoutACellNearAreGivenUp) {
  const Crust first = gridCrust(80, 60);
  const Crust second = gridCrust(80, 60, [](int x, int) { return x < 40; });
  this->carry(first, second, 100);
  std::size_t near = 0;
  for (const Eigen::Vector3f& p : this->set_.positions) near += p.x() < 41.0F ? 1 : 0;
  EXPECT_NEAR(static_cast<double>(this->carried_.set.size()), static_cast<double>(near), 8.0);
  EXPECT_LT(this->carried_.set.size(), 65u);
  this->expectOwners();
}

/// Sampling goes on from carried fronts as it would from those run anew.
TYPED_TEST(ResampleCarriedFronts, SamplingGoesOn) {
  const Crust first = gridCrust(80, 60, [](int x, int) { return x < 50; });
  const Crust second = gridCrust(80, 60);
  this->carry(first, second, 120);
  FrontField anew(second);
  anew.reset(8.0F);
  Fronts<TypeParam> fronts(&anew);
  for (std::size_t i = 0; i < 120; ++i) {
    fronts.insert(this->carried_.set.cells[i], this->carried_.set.positions[i]);
  }
  const SampleSet expected =
      chooseFarthestPoints<TypeParam>(&anew, goalOf(192), &this->pool_, this->carried_);
  const SampleSet set =
      chooseFarthestPoints<TypeParam>(&*this->field_, goalOf(192), &this->pool_, this->carried_);
  EXPECT_EQ(set.cells, expected.cells);
  EXPECT_EQ(set.positions, expected.positions);
  // New cells are as well covered as the others.
  float latest = 0.0F;
  for (const uint32_t cell : this->carried_.new_cells) {
    latest = std::max(latest, this->field_->arrivals[cell].time);
  }
  EXPECT_LT(latest, 1.3F * this->set_.covering.back() + 0.7F);
}

TEST(ResampleSameCells, AreThoseWithTheSamePlace) {
  const Crust before = gridCrust(20, 10, [](int x, int) { return x < 15; });
  Crust now = gridCrust(20, 10, [](int x, int) { return x > 3; });
  const std::vector<uint32_t> same = sameCells(now, before);
  std::size_t found = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    EXPECT_EQ(same[i] != kNoIndex, now.positions[i].x() < 14.5F);
    if (same[i] == kNoIndex) continue;
    EXPECT_EQ(before.keys[same[i]], now.keys[i]);
    ++found;
  }
  EXPECT_EQ(found, 11u * 10u);
  now.positions[5].z() += 0.1F;
  now.slowness[6] = 2.0F;
  EXPECT_EQ(sameCells(now, before)[5], kNoIndex);
  EXPECT_EQ(sameCells(now, before)[6], kNoIndex);
}

}  // namespace
}  // namespace ladar_perception::test
