// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "ladar_perception/classify/classifier_model.h"
#include "ladar_perception/classify/posterior_sums.h"
#include "ladar_perception/saliency/box_sums.h"
#include "map_oracle.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using test::TestRandom;

constexpr int kClasses = 4;
using Record = PosteriorRecord<kClasses>;
using Sum = PosteriorSum<kClasses>;

Record randomRecord(TestRandom* random) {
  Record record;
  for (uint16_t& part : record.part) part = static_cast<uint16_t>(random->integer(0, 65535));
  return record;
}

bool same(const Sum& a, const Sum& b) {
  for (int c = 0; c < kClasses; ++c) {
    if (a.part[c] != b.part[c]) return false;
  }
  return true;
}

TEST(PosteriorSum, StartsEmpty) {
  EXPECT_EQ(Sum().count(), 0U);
  Sum sum;
  sum += Record();
  EXPECT_EQ(sum.count(), 0U) << "of unknown voxels nothing is known";
}

TEST(PosteriorSum, AddsClassByClassAndTakesOut) {
  TestRandom random(1);
  std::vector<Record> records;
  Sum sum;
  uint64_t expected[kClasses] = {};
  for (int i = 0; i < 1000; ++i) {
    records.push_back(randomRecord(&random));
    sum += records.back();
    for (int c = 0; c < kClasses; ++c) expected[c] += records.back().part[c];
  }
  uint64_t total = 0;
  for (int c = 0; c < kClasses; ++c) {
    EXPECT_EQ(sum.part[c], expected[c]);
    total += expected[c];
  }
  EXPECT_EQ(sum.count(), total);
  Sum half;
  for (int i = 0; i < 500; ++i) half += records[i];
  Sum rest = sum;
  rest -= half;
  for (int i = 0; i < 500; ++i) sum -= records[i];
  EXPECT_TRUE(same(sum, rest));
  rest += half;
  for (const Record& record : records) rest -= record;
  EXPECT_TRUE(same(rest, Sum()));
}

TEST(PosteriorSum, DifferencesOfRunningSumsAreExactEvenWhenTheyOverflow) {
  // As along a tall column: what lies below does not matter.
  Record full;
  for (uint16_t& part : full.part) part = 65535;
  Sum below;
  for (int i = 0; i < 100000; ++i) below += full;
  EXPECT_LT(below.part[0], 65535U * 100000ULL) << "it has overflowed";
  Sum above = below;
  Record one;
  one.part[2] = 7;
  above += one;
  above -= below;
  EXPECT_EQ(above.part[0], 0U);
  EXPECT_EQ(above.part[2], 7U);
  EXPECT_EQ(above.count(), 7U);
}

TEST(PosteriorSum, OfTheWidestCubeFitsASignedNumber) {
  constexpr int kSide = 2 * Calibration::kMaxSmoothingRadius + 1;
  // Every part is rounded, by half a unit at most.
  constexpr uint64_t kMostOfAVoxel = kPosteriorUnit + kMaxClasses / 2;
  EXPECT_LT(kMostOfAVoxel * kSide * kSide * kSide, uint64_t{1} << 31);
}

TEST(PosteriorField, IsTheMapWithOtherRecords) {
  TestRandom random(2);
  VoxelMap map({11, 9, 70}, 1000);
  map.scrollTo({-4, 3, -20});
  for (int i = 0; i < 400; ++i) {
    CellId cell = 0;
    const auto x = static_cast<int32_t>(random.integer(-4, 6));
    const auto y = static_cast<int32_t>(random.integer(3, 11));
    map.insert(test::pointIn({x, y, static_cast<int32_t>(random.integer(-20, 49))}), &cell);
  }
  std::vector<Record> records(map.slotBound());
  for (Record& record : records) record = randomRecord(&random);
  const PosteriorField<kClasses> field(map, records.data());
  EXPECT_EQ(field.maskWords(), map.maskWords());
  EXPECT_EQ(field.shape().nz, 70);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 11; ++x) {
      const int column = field.columnAt(x, y);
      ASSERT_EQ(column, map.columnAt(x, y));
      ASSERT_EQ(field.mask(column), map.mask(column));
      ASSERT_EQ(field.recordCount(column), map.recordCount(column));
      ASSERT_EQ(field.firstSlot(column), map.firstSlot(column));
      ASSERT_EQ(field.records(column), records.data() + map.firstSlot(column));
      for (int i = 0; i < field.recordCount(column); ++i) {
        ASSERT_EQ(&field.record(field.firstSlot(column) + i), field.records(column) + i);
      }
    }
  }
}

}  // namespace
}  // namespace ladar_perception
