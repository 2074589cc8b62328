// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "ladar_perception/resample/voronoi_vertex.h"
#include "test_crusts.h"

namespace ladar_perception::test {
namespace {

class ResampleVoronoiVertex : public testing::Test {
 protected:
  ResampleVoronoiVertex() : crust_(gridCrust(21, 21)), field_(crust_), fronts_(&field_) {}

  void sampleAt(float x, float y) {
    fronts_.insert(cellNear(crust_, Eigen::Vector3d(x, y, 0)), Eigen::Vector3f(x, y, 0));
  }
  VoronoiVertex vertexAt(float x, float y) {
    return findVertex(field_, cellNear(crust_, Eigen::Vector3d(x, y, 0)));
  }

  Crust crust_;
  FrontField field_;
  Fronts<FastMarching> fronts_;
};

TEST_F(ResampleVoronoiVertex, IsTheCircumcentre) {
  // All at the distance 5 from (10.3, 9.8).
  for (const double angle : {0.3, 2.2, 4.4}) {
    sampleAt(10.3F + 5.0F * static_cast<float>(std::cos(angle)),
             9.8F + 5.0F * static_cast<float>(std::sin(angle)));
  }
  const VoronoiVertex vertex = vertexAt(10, 10);
  EXPECT_NEAR(vertex.position.x(), 10.3F, 0.01F);
  EXPECT_NEAR(vertex.position.y(), 9.8F, 0.01F);
  EXPECT_NEAR(vertex.time, 5.0F, 0.01F);
}

TEST_F(ResampleVoronoiVertex, IsTheCellItselfBetweenTwoSamples) {
  sampleAt(5, 10);
  sampleAt(15, 10);
  const VoronoiVertex vertex = vertexAt(10, 10);
  EXPECT_EQ(vertex.position, Eigen::Vector3f(10, 10, 0));
  EXPECT_NEAR(vertex.time, 5.0F, 0.01F);
}

/// As on two sheets, where they are the same in the plane of the cell.
TEST_F(ResampleVoronoiVertex, IsTheCellItselfWhereTwoSamplesLieOneAboveTheOther) {
  sampleAt(10, 4);
  const uint32_t cell = cellNear(crust_, Eigen::Vector3d(10, 10, 0));
  const auto ownedBy = [&](uint32_t owner, const Eigen::Vector3f& p, uint32_t owned) {
    field_.samples[owner] = {p.x(), p.y(), p.z(), 1.0F};
    field_.arrivals[owned].owner = owner;
  };
  const uint32_t first = crust_.first_neighbor[cell];
  ownedBy(0, {10, 4, 3}, crust_.neighbors[first]);
  ownedBy(1, {18, 13, 0}, crust_.neighbors[first + 1]);
  const VoronoiVertex vertex = findVertex(field_, cell);
  EXPECT_EQ(vertex.position, Eigen::Vector3f(10, 10, 0));
  EXPECT_EQ(vertex.time, field_.arrivals[cell].time);
}

TEST_F(ResampleVoronoiVertex, StaysNearItsCellAndIsNeverEarlier) {
  sampleAt(3.2F, 4);
  sampleAt(15, 5.1F);
  sampleAt(9, 16.7F);
  sampleAt(17, 18);
  for (uint32_t cell = 0; cell < crust_.size(); ++cell) {
    const VoronoiVertex vertex = findVertex(field_, cell);
    EXPECT_LE((vertex.position - crust_.positions[cell]).norm(), 0.751F);
    EXPECT_GE(vertex.time, field_.arrivals[cell].time);
  }
}

TEST_F(ResampleVoronoiVertex, TheLatestHaveNoLaterNeighbour) {
  sampleAt(10, 10);
  int latest = 0;
  for (uint32_t cell = 0; cell < crust_.size(); ++cell) {
    if (!isLatest(field_, cell)) continue;
    ++latest;
    const Eigen::Vector3f& p = crust_.positions[cell];
    EXPECT_EQ(std::abs(p.x() - 10.0F), 10.0F);
    EXPECT_EQ(std::abs(p.y() - 10.0F), 10.0F);
  }
  EXPECT_EQ(latest, 4);
}

/// Where no front has come all are equally late: the least number counts.
TEST_F(ResampleVoronoiVertex, OneOfEqualsIsTheLatest) {
  EXPECT_TRUE(isLatest(field_, 0));
  for (uint32_t cell = 0; cell < crust_.size(); ++cell) {
    bool least = true;
    for (uint32_t k = crust_.first_neighbor[cell]; k < crust_.first_neighbor[cell + 1]; ++k) {
      least = least && crust_.neighbors[k] > cell;
    }
    EXPECT_EQ(isLatest(field_, cell), least);
  }
}

TEST(ResampleVoronoiVertexOfOneCell, IsThere) {
  const Crust crust = gridCrust(1, 1);
  const FrontField field(crust);
  EXPECT_TRUE(isLatest(field, 0));
  EXPECT_EQ(findVertex(field, 0).position, crust.positions[0]);
}

}  // namespace
}  // namespace ladar_perception::test
