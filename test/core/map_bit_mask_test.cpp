// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <vector>

#include "ladar_perception/map/bit_mask.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using test::TestRandom;

using Bits = std::vector<bool>;
using Words = std::vector<uint64_t>;

Words wordsOf(const Bits& bits) {
  Words words(bits.size() / 64, 0);
  for (std::size_t i = 0; i < bits.size(); ++i) {
    if (bits[i]) words[i / 64] |= uint64_t{1} << (i % 64);
  }
  return words;
}

Bits randomBits(TestRandom* random, int words) {
  const double density = random->real(0.0, 1.0);
  Bits bits(64 * words);
  for (std::size_t i = 0; i < bits.size(); ++i) bits[i] = random->real(0.0, 1.0) < density;
  return bits;
}

/// Masks from empty to full, of one to three words.
class BitMask : public testing::TestWithParam<int> {
 protected:
  std::vector<Bits> samples() const {
    TestRandom random(GetParam());
    std::vector<Bits> all = {Bits(64 * GetParam(), false), Bits(64 * GetParam(), true)};
    for (int i = 0; i < 20; ++i) all.push_back(randomBits(&random, GetParam()));
    return all;
  }
};

TEST_P(BitMask, TestsAndCounts) {
  for (const Bits& bits : samples()) {
    const Words words = wordsOf(bits);
    int below = 0;
    for (int z = 0; z <= 64 * GetParam(); ++z) {
      EXPECT_EQ(bit_mask::countBelow(words.data(), z), below);
      if (z == 64 * GetParam()) break;
      EXPECT_EQ(bit_mask::test(words.data(), z), bits[z]);
      below += bits[z] ? 1 : 0;
    }
  }
}

TEST_P(BitMask, ShiftsByAnyDistance) {
  const int size = 64 * GetParam();
  for (const Bits& bits : samples()) {
    for (int distance = -size - 3; distance <= size + 3; ++distance) {
      Bits expected(size, false);
      for (int z = 0; z < size; ++z) {
        const int from = z - distance;
        if (from >= 0 && from < size) expected[z] = bits[from];
      }
      Words words = wordsOf(bits);
      bit_mask::shift(words.data(), GetParam(), distance);
      EXPECT_EQ(words, wordsOf(expected)) << distance;
    }
  }
}

TEST_P(BitMask, ClearsFromAnyPosition) {
  const int size = 64 * GetParam();
  for (const Bits& bits : samples()) {
    for (int z = 0; z <= size; ++z) {
      Bits expected = bits;
      for (int i = z; i < size; ++i) expected[i] = false;
      Words words = wordsOf(bits);
      bit_mask::clearFrom(words.data(), GetParam(), z);
      EXPECT_EQ(words, wordsOf(expected)) << z;
    }
  }
}

TEST_P(BitMask, VisitsSetBitsInOrder) {
  for (const Bits& bits : samples()) {
    std::vector<int> expected;
    for (std::size_t z = 0; z < bits.size(); ++z) {
      if (bits[z]) expected.push_back(static_cast<int>(z));
    }
    std::vector<int> visited;
    const Words words = wordsOf(bits);
    bit_mask::forEachSet(words.data(), GetParam(), [&](int z) { visited.push_back(z); });
    EXPECT_EQ(visited, expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Words, BitMask, testing::Values(1, 2, 3));

}  // namespace
}  // namespace ladar_perception
