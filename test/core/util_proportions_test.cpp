// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "ladar_perception/util/proportions.h"

namespace ladar_perception {
namespace {

TEST(WilsonInterval, IsThatOfTheTextbooks) {
  // Newcombe, Statistics in Medicine 17 (1998), table I, method 3.
  const Interval a = wilsonInterval(81, 263);
  EXPECT_NEAR(a.low, 0.2553, 5e-5);
  EXPECT_NEAR(a.high, 0.3662, 5e-5);
  const Interval b = wilsonInterval(15, 148);
  EXPECT_NEAR(b.low, 0.0624, 5e-5);
  EXPECT_NEAR(b.high, 0.1605, 5e-5);
  const Interval c = wilsonInterval(0, 20);
  EXPECT_EQ(c.low, 0.0);
  EXPECT_NEAR(c.high, 0.1611, 5e-5);
  const Interval d = wilsonInterval(29, 29);
  EXPECT_NEAR(d.low, 0.8830, 5e-5);
  EXPECT_EQ(d.high, 1.0);
}

TEST(WilsonInterval, KnowsNothingWithoutTrials) {
  const Interval all = wilsonInterval(0, 0);
  EXPECT_EQ(all.low, 0.0);
  EXPECT_EQ(all.high, 1.0);
}

/// `only_a`, `only_b` disagreements among agreements of both kinds.
PairedComparison compared(std::size_t only_a, std::size_t only_b) {
  std::vector<bool> a = {true, false, true};
  std::vector<bool> b = {true, false, true};
  a.insert(a.end(), only_a, true);
  b.insert(b.end(), only_a, false);
  a.insert(a.end(), only_b, false);
  b.insert(b.end(), only_b, true);
  return mcnemar(a, b);
}

TEST(McNemar, CountsDisagreements) {
  const PairedComparison pair = compared(4, 7);
  EXPECT_EQ(pair.only_a, 4U);
  EXPECT_EQ(pair.only_b, 7U);
}

TEST(McNemar, IsTheExactTest) {
  // Two-sided tails of a fair coin, counted by hand.
  EXPECT_NEAR(compared(0, 1).p_value, 1.0, 1e-12);
  EXPECT_NEAR(compared(0, 5).p_value, 2.0 / 32.0, 1e-12);
  EXPECT_NEAR(compared(1, 6).p_value, 2.0 * 8.0 / 128.0, 1e-12);
  EXPECT_NEAR(compared(6, 1).p_value, 2.0 * 8.0 / 128.0, 1e-12);
  EXPECT_NEAR(compared(2, 10).p_value, 2.0 * 79.0 / 4096.0, 1e-12);
}

TEST(McNemar, SeesNoDifferenceWhereThereIsNone) {
  EXPECT_EQ(compared(0, 0).p_value, 1.0);
  EXPECT_EQ(compared(500, 500).p_value, 1.0);
  EXPECT_EQ(mcnemar({}, {}).p_value, 1.0);
}

TEST(McNemar, HoldsForManyTrials) {
  const double p = compared(2000, 2300).p_value;
  EXPECT_GT(p, 1e-6);  // 4.6 standard deviations
  EXPECT_LT(p, 1e-5);
}

}  // namespace
}  // namespace ladar_perception
