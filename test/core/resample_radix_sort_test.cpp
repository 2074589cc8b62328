// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include "ladar_perception/resample/radix_sort.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using Entries = std::vector<KeyedIndex>;

/// Against std::stable_sort; indices count up, so that a swap of equal keys is seen.
void expectSorted(const std::vector<uint64_t>& keys) {
  Entries entries;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    entries.push_back({keys[i], static_cast<uint32_t>(i)});
  }
  Entries expected = entries;
  std::stable_sort(expected.begin(), expected.end(),
                   [](const KeyedIndex& a, const KeyedIndex& b) { return a.key < b.key; });
  radixSort(&entries);
  ASSERT_EQ(entries.size(), expected.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    ASSERT_EQ(entries[i].key, expected[i].key) << i;
    ASSERT_EQ(entries[i].index, expected[i].index) << i;
  }
}

TEST(RadixSort, FewEntries) {
  expectSorted({});
  expectSorted({7});
  expectSorted({7, 7});
  expectSorted({8, 7});
  expectSorted({~uint64_t{0}, 0});
  expectSorted({5, 5, 3, 5, 3});
}

TEST(RadixSort, KeysThatDifferInOneBit) {
  for (int bit = 0; bit < 64; ++bit) {
    const uint64_t one = uint64_t{1} << bit;
    expectSorted({one, 0, one, 0, 0, one});
    const uint64_t others = 0x5a5a5a5a5a5a5a5aULL & ~one;
    expectSorted({others | one, others, others | one, others});
  }
}

TEST(RadixSort, RandomKeysOfEveryWidth) {
  test::TestRandom random(3);
  for (int bits = 1; bits <= 64; ++bits) {
    std::vector<uint64_t> keys(static_cast<std::size_t>(random.integer(100, 3000)));
    for (uint64_t& key : keys) key = random.engine()() >> (64 - bits);
    expectSorted(keys);
    // The same differences far up, as keys of cells near the middle of the grid.
    if (bits > 60) continue;
    for (uint64_t& key : keys) key |= uint64_t{1} << 62;
    expectSorted(keys);
  }
}

TEST(RadixSort, DigitsThatNoKeyDiffersInAreSkippedRightly) {
  test::TestRandom random(4);
  std::vector<uint64_t> keys(5000);
  // Low and high bits differ, the digits between are the same.
  for (uint64_t& key : keys) {
    key = (random.engine()() & 0xf00000000000000fULL) | 0x0000123456789000ULL;
  }
  expectSorted(keys);
}

TEST(RadixSort, OrderThatIsThereAlready) {
  std::vector<uint64_t> keys;
  for (uint64_t i = 0; i < 10000; ++i) keys.push_back(i * i * 977);
  expectSorted(keys);
  std::reverse(keys.begin(), keys.end());
  expectSorted(keys);
}

}  // namespace
}  // namespace ladar_perception
