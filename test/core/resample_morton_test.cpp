// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <set>

#include "ladar_perception/resample/morton.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

constexpr uint32_t kLast = (1U << morton::kBitsPerAxis) - 1;

/// Bit by bit.
uint64_t interleave(uint32_t x, uint32_t y, uint32_t z) {
  uint64_t key = 0;
  for (int bit = 0; bit < morton::kBitsPerAxis; ++bit) {
    key |= uint64_t{x >> bit & 1U} << 3 * bit;
    key |= uint64_t{y >> bit & 1U} << (3 * bit + 1);
    key |= uint64_t{z >> bit & 1U} << (3 * bit + 2);
  }
  return key;
}

TEST(Morton, KnownKeys) {
  static_assert(morton::encode(0, 0, 0) == 0, "");
  static_assert(morton::encode(1, 0, 0) == 1, "");
  static_assert(morton::encode(0, 1, 0) == 2, "");
  static_assert(morton::encode(0, 0, 1) == 4, "");
  static_assert(morton::encode(3, 0, 0) == 9, "");
  EXPECT_EQ(morton::encode(kLast, kLast, kLast), ~uint64_t{0} >> 1);
  EXPECT_EQ(morton::kAxisX | morton::kAxisY | morton::kAxisZ, ~uint64_t{0} >> 1);
  EXPECT_EQ(morton::kAxisX & morton::kAxisY, 0u);
  EXPECT_EQ(morton::kAxisX & morton::kAxisZ, 0u);
  EXPECT_EQ(morton::kAxisY & morton::kAxisZ, 0u);
}

TEST(Morton, KeysAreInterleavedBitsAndGiveTheCoordinatesBack) {
  test::TestRandom random(1);
  for (int i = 0; i < 100000; ++i) {
    // Of all magnitudes.
    std::array<uint32_t, 3> at;
    for (uint32_t& value : at) {
      value = static_cast<uint32_t>(random.integer(0, kLast)) >> random.integer(0, 20);
    }
    const uint64_t key = morton::encode(at[0], at[1], at[2]);
    ASSERT_EQ(key, interleave(at[0], at[1], at[2]));
    ASSERT_EQ(morton::x(key), at[0]);
    ASSERT_EQ(morton::y(key), at[1]);
    ASSERT_EQ(morton::z(key), at[2]);
  }
}

TEST(Morton, SingleBitsGoToEveryThirdPlace) {
  for (int bit = 0; bit < morton::kBitsPerAxis; ++bit) {
    EXPECT_EQ(morton::spread(uint64_t{1} << bit), uint64_t{1} << 3 * bit);
    EXPECT_EQ(morton::compact(uint64_t{1} << 3 * bit), 1U << bit);
  }
  EXPECT_EQ(morton::spread(uint64_t{1} << morton::kBitsPerAxis), 0u);  // beyond the lowest 21 bits
  EXPECT_EQ(morton::compact(~morton::kAxisX), 0u);                     // other axes do not matter
}

TEST(Morton, StepsAlongOneAxisWrapAtTheEnds) {
  test::TestRandom random(2);
  const std::array<uint64_t, 3> masks = {morton::kAxisX, morton::kAxisY, morton::kAxisZ};
  for (int i = 0; i < 20000; ++i) {
    std::array<uint32_t, 3> at;
    for (uint32_t& value : at) {
      const int64_t draw = random.integer(0, 9);
      value = draw == 0 ? 0 : draw == 1 ? kLast : static_cast<uint32_t>(random.integer(0, kLast));
    }
    const uint64_t key = morton::encode(at[0], at[1], at[2]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::array<uint32_t, 3> on = at;
      std::array<uint32_t, 3> back = at;
      on[axis] = at[axis] == kLast ? 0 : at[axis] + 1;
      back[axis] = at[axis] == 0 ? kLast : at[axis] - 1;
      ASSERT_EQ(morton::next(key, masks[axis]), morton::encode(on[0], on[1], on[2]));
      ASSERT_EQ(morton::previous(key, masks[axis]), morton::encode(back[0], back[1], back[2]));
      ASSERT_EQ(morton::step(key, masks[axis], 1), morton::next(key, masks[axis]));
      ASSERT_EQ(morton::step(key, masks[axis], -1), morton::previous(key, masks[axis]));
      ASSERT_EQ(morton::step(key, masks[axis], 0), key);
      uint64_t ahead = key;
      uint64_t behind = key;
      for (int steps = 0; steps <= 9; ++steps) {
        ASSERT_EQ(morton::jump(key, masks[axis], steps), ahead) << steps;
        ASSERT_EQ(morton::jump(key, masks[axis], -steps), behind) << steps;
        ahead = morton::next(ahead, masks[axis]);
        behind = morton::previous(behind, masks[axis]);
      }
    }
  }
}

TEST(Morton, CellsOfACubeAreARunOfKeys) {
  constexpr uint32_t kEdge = 8;
  std::set<uint64_t> keys;
  for (uint32_t z = 0; z < kEdge; ++z) {
    for (uint32_t y = 0; y < kEdge; ++y) {
      for (uint32_t x = 0; x < kEdge; ++x) keys.insert(morton::encode(40 + x, 16 + y, 88 + z));
    }
  }
  ASSERT_EQ(keys.size(), 512u);
  EXPECT_EQ(*keys.begin(), morton::encode(40, 16, 88));
  EXPECT_EQ(*keys.rbegin(), *keys.begin() + 511);
  // The cube's own key is its cells' without the lowest bits.
  EXPECT_EQ(*keys.begin() >> 9, morton::encode(5, 2, 11));
}

TEST(Morton, AroundACellAreTwentySevenPlacesXFastest) {
  const uint64_t key = morton::encode(100, 203, 31);
  int place = 0;
  for (uint32_t z = 30; z <= 32; ++z) {
    for (uint32_t y = 202; y <= 204; ++y) {
      for (uint32_t x = 99; x <= 101; ++x)
        EXPECT_EQ(morton::around(key, place++), morton::encode(x, y, z));
    }
  }
  EXPECT_EQ(morton::around(key, 13), key);
}

}  // namespace
}  // namespace ladar_perception
