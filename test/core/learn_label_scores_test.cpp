// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "ladar_perception/learn/label_scores.h"

namespace ladar_perception {
namespace {

constexpr CellId kCell = 5;

void addMany(LabelScores* scores, int count, std::size_t truth, uint8_t label, float confidence,
             bool in_map = true) {
  for (int i = 0; i < count; ++i) scores->add(truth, {label, confidence, 0}, in_map);
}

/// Class 1: 8 of 10 right, 1 as class 2, 1 unknown. Class 2: 3 of 4, 1 as class 1. None of class 3.
LabelScores example() {
  LabelScores scores(3);
  addMany(&scores, 8, 1, 1, 0.9F);
  addMany(&scores, 1, 1, 2, 0.6F);
  addMany(&scores, 1, 1, 0, 0.0F, false);
  addMany(&scores, 3, 2, 2, 0.9F);
  addMany(&scores, 1, 2, 1, 0.6F);
  return scores;
}

TEST(LearnLabelScores, CountsByHand) {
  const LabelScores scores = example();
  EXPECT_EQ(scores.points(), 14u);
  EXPECT_EQ(scores.pointsOutsideMap(), 1u);
  EXPECT_EQ(scores.truthCount(1), 10u);
  EXPECT_EQ(scores.count(1, 0), 1u);
  EXPECT_EQ(scores.count(1, 2), 1u);
  EXPECT_DOUBLE_EQ(*scores.recall(1), 0.8);
  EXPECT_DOUBLE_EQ(*scores.recall(2), 0.75);
  EXPECT_FALSE(scores.recall(3));
  EXPECT_DOUBLE_EQ(*scores.precision(1), 8.0 / 9.0);
  EXPECT_DOUBLE_EQ(*scores.precision(2), 0.75);
  EXPECT_FALSE(scores.precision(3));
  EXPECT_DOUBLE_EQ(*scores.f1(1), 16.0 / 19.0);
  EXPECT_DOUBLE_EQ(*scores.f1(2), 0.75);
  EXPECT_FALSE(scores.f1(3));
  EXPECT_DOUBLE_EQ(*scores.meanRecall(), (0.8 + 0.75) / 2.0);
  EXPECT_DOUBLE_EQ(*scores.meanF1(), (16.0 / 19.0 + 0.75) / 2.0);
  EXPECT_DOUBLE_EQ(*scores.meanRecallInMap(), (8.0 / 9.0 + 0.75) / 2.0);
  EXPECT_DOUBLE_EQ(*scores.overallAccuracy(), 11.0 / 14.0);
  EXPECT_DOUBLE_EQ(*scores.unknownShare(), 1.0 / 14.0);
}

TEST(LearnLabelScores, CalibrationByHand) {
  // Of 11 labels at 0.9, all are right; of 2 at 0.6, none is; unknown has no confidence.
  const Reliability plain = example().reliability(false);
  ASSERT_EQ(plain.bins.size(), 2u);
  EXPECT_NEAR(plain.bins[0].confidence, 0.6, 1e-6);
  EXPECT_DOUBLE_EQ(plain.bins[0].accuracy, 0.0);
  EXPECT_DOUBLE_EQ(plain.bins[0].share, 2.0 / 13.0);
  EXPECT_NEAR(plain.bins[1].confidence, 0.9, 1e-6);
  EXPECT_DOUBLE_EQ(plain.bins[1].accuracy, 1.0);
  EXPECT_NEAR(plain.ece, (2.0 * 0.6 + 11.0 * 0.1) / 13.0, 1e-6);
  // Every class weighs the same: 8/9 and 3/4 of it at 0.9, 1/9 and 1/4 at 0.6.
  const Reliability balanced = example().reliability(true);
  const double share_high = (8.0 / 9.0 + 0.75) / 2.0;
  EXPECT_NEAR(balanced.bins[1].share, share_high, 1e-12);
  EXPECT_NEAR(balanced.ece, share_high * 0.1 + (1.0 - share_high) * 0.6, 1e-6);
}

TEST(LearnLabelScores, ConfidencesThatAreRightHaveNoError) {
  LabelScores scores(2);
  addMany(&scores, 3, 1, 1, 0.75F);
  addMany(&scores, 1, 1, 2, 0.75F);
  addMany(&scores, 5, 2, 2, 1.0F);
  EXPECT_NEAR(scores.reliability(false).ece, 0.0, 1e-12);
}

TEST(LearnLabelScores, ScansAddUpAndOthersAreIgnored) {
  LabelScores scores(2);
  scores.add({1.0, 2.0, 0.0, 3.0, std::nan(""), 1.0},
             {{1, 0.9F, 0}, {1, 0.8F, 0}, {1, 1.0F, 0}, {1, 1.0F, 0}, {1, 1.0F, 0}, {0, 0.0F, 0}},
             {kCell, kCell, kCell, kCell, kCell, kNoCell});
  EXPECT_EQ(scores.points(), 3u);
  EXPECT_EQ(scores.pointsOutsideMap(), 1u);
  EXPECT_EQ(scores.count(1, 1), 1u);
  EXPECT_EQ(scores.count(2, 1), 1u);
  EXPECT_EQ(scores.count(1, 0), 1u);
  LabelScores sum(2);
  sum += scores;
  sum += scores;
  EXPECT_EQ(sum.points(), 6u);
  EXPECT_EQ(sum.pointsOutsideMap(), 2u);
  EXPECT_EQ(sum.count(2, 1), 2u);
  EXPECT_DOUBLE_EQ(sum.reliability(false).ece, scores.reliability(false).ece);
}

TEST(LearnLabelScores, NothingIsToldOfNothing) {
  const LabelScores scores(2);
  EXPECT_FALSE(scores.meanRecall());
  EXPECT_FALSE(scores.meanF1());
  EXPECT_FALSE(scores.overallAccuracy());
  EXPECT_FALSE(scores.unknownShare());
  EXPECT_EQ(scores.reliability(true).ece, 0.0);
  EXPECT_TRUE(scores.reliability(false).bins.empty());
}

}  // namespace
}  // namespace ladar_perception
