// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/sample_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ladar_perception {
namespace {

constexpr float kChosen = -1.0F;
// Places of a bucket, and nodes below one: as many as are worked on at once.
constexpr std::size_t kWidth = 16;
using Row = Eigen::Array<float, kWidth, 1>;

/// Squared distances of places to the chosen ones, in a tree of boxes with the greatest of each.
class Buckets {
 public:
  explicit Buckets(const std::vector<WeightedPlace>& places) {
    makeRows(places);
    for (std::size_t below = rows_.size(); levels_.empty() || below > 1;) {
      levels_.emplace_back((below + kWidth - 1) / kWidth);
      for (std::size_t i = 0; i < below; ++i) {
        if (levels_.size() == 1) {
          levels_[0].include(i, rows_[i]);
        } else {
          levels_.back().include(i, levels_[levels_.size() - 2].rows[i]);
        }
      }
      below = levels_.back().rows.size();
    }
  }

  /// 0 if all places are chosen.
  float greatest() const {
    return std::sqrt(std::max(levels_.back().rows[0].greatest.maxCoeff(), 0.0F));
  }

  std::size_t farthest() const {
    std::size_t row = 0;
    for (std::size_t level = levels_.size(); level-- > 0;) {
      row = row * kWidth + indexOfGreatest(levels_[level].rows[row].greatest);
    }
    return row * kWidth + indexOfGreatest(rows_[row].greatest);
  }

  void choose(std::size_t place) {
    std::size_t row = place / kWidth;
    rows_[row].greatest[static_cast<int>(place % kWidth)] = kChosen;
    float greatest = rows_[row].greatest.maxCoeff();
    for (Level& level : levels_) {
      Boxes& boxes = level.rows[row / kWidth];
      boxes.greatest[static_cast<int>(row % kWidth)] = greatest;
      greatest = boxes.greatest.maxCoeff();
      row /= kWidth;
    }
  }

  void approach(const WeightedPlace& chosen) { approach(levels_.size() - 1, 0, chosen); }

 private:
  /// Places side by side; `greatest` is the one squared distance of each, kChosen if it is chosen.
  struct Places {
    std::array<Row, 3> axes;
    Row slowness = Row::Zero();
    Row greatest = Row::Constant(kChosen);
    Places() { axes.fill(Row::Zero()); }
  };
  /// Boxes around rows of the level below, and the greatest squared distance in each.
  struct Boxes {
    std::array<Row, 3> low;
    std::array<Row, 3> high;
    Row slowness = Row::Constant(std::numeric_limits<float>::max());
    Row greatest = Row::Constant(kChosen);
    Boxes() {
      low.fill(Row::Constant(std::numeric_limits<float>::max()));
      high.fill(Row::Constant(std::numeric_limits<float>::lowest()));
    }
  };
  struct Level {
    std::vector<Boxes> rows;
    explicit Level(std::size_t size) : rows(size) {}

    void include(std::size_t i, const Places& places) {
      Boxes& boxes = rows[i / kWidth];
      const auto at = static_cast<int>(i % kWidth);
      for (int k = 0; k < static_cast<int>(kWidth); ++k) {
        if (places.greatest[k] == kChosen) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          boxes.low[axis][at] = std::min(boxes.low[axis][at], places.axes[axis][k]);
          boxes.high[axis][at] = std::max(boxes.high[axis][at], places.axes[axis][k]);
        }
        boxes.slowness[at] = std::min(boxes.slowness[at], places.slowness[k]);
      }
      boxes.greatest[at] = places.greatest.maxCoeff();
    }
    void include(std::size_t i, const Boxes& below) {
      Boxes& boxes = rows[i / kWidth];
      const auto at = static_cast<int>(i % kWidth);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        boxes.low[axis][at] = below.low[axis].minCoeff();
        boxes.high[axis][at] = below.high[axis].maxCoeff();
      }
      boxes.slowness[at] = below.slowness.minCoeff();
      boxes.greatest[at] = below.greatest.maxCoeff();
    }
  };

  static std::size_t indexOfGreatest(const Row& row) {
    Eigen::Index index = 0;
    row.maxCoeff(&index);
    return static_cast<std::size_t>(index);
  }

  void makeRows(const std::vector<WeightedPlace>& places) {
    rows_.resize(std::max<std::size_t>((places.size() + kWidth - 1) / kWidth, 1));
    for (std::size_t i = 0; i < places.size(); ++i) {
      Places& row = rows_[i / kWidth];
      const auto at = static_cast<int>(i % kWidth);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        row.axes[axis][at] = places[i].position[static_cast<int>(axis)];
      }
      row.slowness[at] = places[i].slowness;
      row.greatest[at] = std::numeric_limits<float>::max();
    }
  }

  /// Lowers the distances below a row of boxes.
  void approach(std::size_t level, std::size_t row, const WeightedPlace& chosen) {
    Boxes& boxes = levels_[level].rows[row];
    Row distance2 = Row::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float p = chosen.position[static_cast<int>(axis)];
      distance2 += (boxes.low[axis] - p).max(p - boxes.high[axis]).max(0.0F).square();
    }
    const Row least = distance2 * (0.5F * (boxes.slowness + chosen.slowness)).square();
    for (std::size_t i = 0; i < kWidth; ++i) {
      const auto at = static_cast<int>(i);
      if (least[at] >= boxes.greatest[at]) continue;
      const std::size_t below = row * kWidth + i;
      if (level > 0) {
        approach(level - 1, below, chosen);
        boxes.greatest[at] = levels_[level - 1].rows[below].greatest.maxCoeff();
      } else {
        boxes.greatest[at] = measure(&rows_[below], chosen);
      }
    }
  }

  static float measure(Places* places, const WeightedPlace& chosen) {
    const Row distance2 = (places->axes[0] - chosen.position.x()).square() +
                          (places->axes[1] - chosen.position.y()).square() +
                          (places->axes[2] - chosen.position.z()).square();
    places->greatest =
        places->greatest.min(distance2 * (0.5F * (places->slowness + chosen.slowness)).square());
    return places->greatest.maxCoeff();
  }

  std::vector<Places> rows_;
  std::vector<Level> levels_;  // the last has one row
};

}  // namespace

PlaceOrder orderFarthestFirst(const std::vector<WeightedPlace>& places,
                              const std::vector<WeightedPlace>& witnesses,
                              const std::vector<WeightedPlace>& before) {
  PlaceOrder result;
  Buckets open(places);
  Buckets watched(witnesses);
  const auto cover = [&](const WeightedPlace& place) {
    open.approach(place);
    watched.approach(place);
    return std::max(open.greatest(), watched.greatest());
  };
  for (const WeightedPlace& place : before) result.covering_before.push_back(cover(place));
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::size_t next = i == 0 && before.empty() ? places.size() / 2 : open.farthest();
    open.choose(next);
    result.order.push_back(static_cast<uint32_t>(next));
    result.covering.push_back(cover(places[next]));
  }
  return result;
}

}  // namespace ladar_perception
