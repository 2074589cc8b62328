// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/farthest_points.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "ladar_perception/resample/sample_order.h"
#include "ladar_perception/resample/tiles.h"
#include "ladar_perception/resample/voronoi_vertex.h"
#include "taken_cells.h"

namespace ladar_perception {
namespace {

// The radius falls by this from round to round; the last ones, by a smaller step, decide on places.
// Vertices that others near them, which are later, keep back have their turn in the next round.
constexpr float kFirstStep = 0.7F;
constexpr float kLastStep = 0.86F;
constexpr float kLastRounds = 0.35F;  // of the first radius
// The last round goes so far beyond the radius at which the count is expected.
constexpr float kBeyondCount = 0.96F;
// Every so many cells bear witness to how far the start's samples leave the surface.
constexpr std::size_t kWitnessStride = 4;
// Vertices lie up to half a cell from the cells around them, whose times are less by as much.
constexpr float kVertexSlack = 0.6F;
// Samples on two sheets of the surface this many cells apart are too near to each other; sheets
// farther apart have nothing to do with each other.
constexpr float kSheetCells = 2.5F;
// No count is reached by going on below this radius: there are no more cells.
constexpr float kLeastRadius = 0.35F;

struct Choice {
  uint32_t cell;
  float time;
};

/// Steps through [0, size) in a scrambled order.
class Scramble {
 public:
  explicit Scramble(uint32_t size) : size_(size), step_(static_cast<uint32_t>(0.618 * size) | 1U) {
    while (std::gcd(step_, size_) != 1) step_ += 2;
  }
  uint32_t next() {
    at_ = static_cast<uint32_t>((uint64_t{at_} + step_) % size_);
    return at_;
  }

 private:
  uint32_t size_;
  uint32_t step_;
  uint32_t at_ = 0;
};

/// A tile wide enough that fronts of `first_radius` and what they read stay within half of it.
int tileLevel(const Crust& crust, float first_radius) {
  float fastest = 0.0F;
  float largest = 1.0F;
  for (std::size_t i = 0; i < crust.size(); ++i) {
    fastest = std::max(fastest, 1.0F / crust.slowness[i]);
    largest = std::max(largest, crust.edge(i));
  }
  const float reach = first_radius * fastest + 3.0F * largest;
  int level = 4;
  while (static_cast<float>(1 << level) < 2.0F * reach && level < 18) ++level;
  return level;
}

template <typename Metric>
class Chooser {
 public:
  Chooser(FrontField* field, const FarthestPointsGoal& goal, ThreadPool* pool)
      : field_(field),
        goal_(goal),
        pool_(pool),
        tiles_(field->crust->keys, tileLevel(*field->crust, goal.first_radius)),
        bounds_(field->crust->size(), std::numeric_limits<float>::infinity()),
        slack_(field->crust->size()),
        taken_(*field->crust),
        chosen_(tiles_.size()),
        fronts_(static_cast<std::size_t>(pool->size()), Fronts<Metric>(field)),
        around_(fronts_.size()) {
    for (std::size_t i = 0; i < slack_.size(); ++i) {
      slack_[i] = kVertexSlack * field->crust->edge(i) * field->nodes[i].slowness;
    }
  }

  SampleSet run(const EarlierSamples& before) {
    set_ = before.set;
    if (set_.size() == 0) field_->reset(goal_.first_radius);
    for (const uint32_t cell : set_.cells) take(cell);
    start();
    std::function<void()> order = [&] { orderStart(before.new_cells); };
    float radius = goal_.first_radius;
    while (!done(radius)) {
      radius = nextRadius(radius);
      fillRound(radius, std::exchange(order, nullptr));
    }
    if (order) order();
    set_.radius_reached = std::max(latest(), left_out_);
    if (set_.size() > 0) set_.covering.back() = set_.radius_reached;
    // A place that a round found later than others, or left to the next, was as far before.
    for (std::size_t i = set_.size(); i > 1; --i) {
      set_.covering[i - 2] = std::max(set_.covering[i - 2], set_.covering[i - 1]);
    }
    return std::move(set_);
  }

 private:
  void insert(Fronts<Metric>* fronts, uint32_t cell, const Eigen::Vector3f& position) {
    fronts->insert(cell, position);
    take(cell);
  }

  void take(uint32_t cell) {
    taken_.add(cell);
    bounds_[cell] = 0.0F;  // never again
  }

  float nextRadius(float radius) {
    const bool first = radius * kFirstStep > kLastRounds * goal_.first_radius;
    float next = radius * (first ? kFirstStep : kLastStep);
    if (goal_.count > 0) {
      // On a surface the count grows as radius^-2; vertices that a round chooses in vain cost time.
      const float filled = static_cast<float>(chosen()) / static_cast<float>(goal_.count);
      const float expected = radius * std::sqrt(std::min(filled, 1.0F)) * kBeyondCount;
      if (expected >= next && last_rounds_++ == 0) next = expected;
    }
    return std::max(next, goal_.radius);
  }

  bool done(float radius) const {
    if (goal_.count > 0 && chosen() >= goal_.count) return true;
    // At the last radius there are rounds until none finds a vertex.
    if (goal_.radius > 0 && radius <= goal_.radius && added_ == 0) return true;
    return radius < kLeastRadius || std::chrono::steady_clock::now() >= goal_.deadline;
  }

  void start() {
    tiles_.run(pool_, [this](int thread, std::size_t i) {
      const Tiles::Tile& tile = tiles_.tile(i);
      Scramble order(tile.end - tile.first);
      for (uint32_t n = tile.first; n < tile.end; ++n) {
        const uint32_t cell = tile.first + order.next();
        if (field_->arrivals[cell].time < goal_.first_radius) continue;
        const Eigen::Vector3f& place = field_->crust->positions[cell];
        if (timeOfOthers(thread, goal_.first_radius, cell, place) < goal_.first_radius) continue;
        insert(&fronts_[static_cast<std::size_t>(thread)], cell, place);
        chosen_[i].push_back({cell, goal_.first_radius});
      }
    });
    for (const std::vector<Choice>& choices : chosen_) {
      for (const Choice& choice : choices) start_.push_back(choice.cell);
    }
    std::sort(start_.begin(), start_.end());
  }

  std::size_t chosen() const { return set_.size() + start_.size(); }

  /// The start's samples, farthest first, with cells between them as witnesses: after others, those
  /// that are new.
  void orderStart(const std::vector<uint32_t>& new_cells) {
    const std::vector<uint32_t> cells = std::exchange(start_, {});
    std::vector<WeightedPlace> places;
    for (const uint32_t cell : cells) places.push_back(placeOf(cell));
    const std::size_t size_of_new = set_.size() == 0 ? field_->crust->size() : new_cells.size();
    std::vector<WeightedPlace> witnesses;
    witnesses.reserve(size_of_new / kWitnessStride + 1);
    for (std::size_t i = 0; i < size_of_new; i += kWitnessStride) {
      const std::size_t cell = set_.size() == 0 ? i : new_cells[i];
      witnesses.push_back({field_->crust->positions[cell], field_->crust->slowness[cell]});
    }
    std::vector<WeightedPlace> before;
    for (const uint32_t cell : set_.cells) before.push_back(placeOf(cell));
    const PlaceOrder order = orderFarthestFirst(places, witnesses, before);
    // What has come to the crust since may be far from them.
    for (std::size_t i = 0; i < before.size(); ++i) {
      set_.covering[i] = std::max(set_.covering[i], order.covering_before[i]);
    }
    std::size_t size = order.order.size();
    if (goal_.count > 0 && set_.size() + size > goal_.count) {
      size = goal_.count - std::min(goal_.count, set_.size());
      left_out_ = size > 0 ? order.covering[size - 1] : goal_.first_radius;
    }
    for (std::size_t i = 0; i < size; ++i) {
      const uint32_t cell = cells[order.order[i]];
      set_.cells.push_back(cell);
      set_.positions.push_back(field_->samples[cell].position());
      set_.covering.push_back(order.covering[i]);
    }
  }

  WeightedPlace placeOf(uint32_t cell) const {
    return {field_->samples[cell].position(), field_->samples[cell].slowness};
  }

  /// Puts samples at all vertices farther than `radius`; of the last round only the farthest count.
  /// `beside` is done meanwhile.
  void fillRound(float radius, const std::function<void()>& beside) {
    const auto fill = [&](int thread, std::size_t i) {
      chosen_[i].clear();
      fillTile(radius, thread, i);
      // No other round has them any more.
      if (last_rounds_ > 0) fillTile(radius, thread, i);
    };
    tiles_.run(pool_, fill, beside);
    std::vector<Choice> choices;
    for (const std::vector<Choice>& of_tile : chosen_) {
      choices.insert(choices.end(), of_tile.begin(), of_tile.end());
    }
    added_ = choices.size();
    std::sort(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) {
      return a.time != b.time ? a.time > b.time : a.cell < b.cell;
    });
    for (const Choice& choice : choices) {
      if (goal_.count > 0 && set_.size() == goal_.count) {
        left_out_ = std::max(left_out_, choice.time);
        break;
      }
      if (!set_.covering.empty()) {
        set_.covering.back() = std::min(set_.covering.back(), std::max(choice.time, radius));
      }
      set_.cells.push_back(choice.cell);
      set_.positions.push_back(field_->samples[choice.cell].position());
      set_.covering.push_back(choice.time);
    }
  }

  void fillTile(float radius, int thread, std::size_t i) {
    const Tiles::Tile& tile = tiles_.tile(i);
    for (uint32_t cell = tile.first; cell < tile.end; ++cell) {
      if (std::min(field_->arrivals[cell].time + slack_[cell], bounds_[cell]) < radius) continue;
      if (!isLatest(*field_, cell)) continue;
      const VoronoiVertex vertex = findVertex(*field_, cell);
      bounds_[cell] = vertex.time;
      if (vertex.time < radius) continue;
      const float others = timeOfOthers(thread, radius, cell, vertex.position);
      if (others < radius) continue;
      insert(&fronts_[static_cast<std::size_t>(thread)], cell, vertex.position);
      chosen_[i].push_back({cell, std::min(vertex.time, others)});
    }
  }

  /// The least time from a sample near a place in a cell to it, in a straight line: its front may
  /// not have come there, where cells are few, or on a sheet of the surface so near that samples on
  /// both would be too near to each other. If the time is less than `radius`, it enters the cell.
  float timeOfOthers(int thread, float radius, uint32_t cell, const Eigen::Vector3f& place) {
    const auto own = static_cast<std::size_t>(thread);
    std::vector<uint32_t>& around = around_[own];
    around.clear();
    taken_.findAround(cell, place, &around);
    const float reach = kSheetCells * field_->crust->edge(cell);
    Choice nearest = {kNoIndex, std::numeric_limits<float>::infinity()};
    for (const uint32_t near : around) {
      const FrontField::Node& sample = field_->samples[near];
      const float distance = (sample.position() - place).norm();
      const float slowness = 0.5F * (field_->nodes[cell].slowness + sample.slowness);
      if (distance < reach && distance * slowness < nearest.time) {
        nearest = {near, distance * slowness};
      }
    }
    if (nearest.time < radius) {
      bounds_[cell] = nearest.time;
      fronts_[own].enter(cell, nearest.cell);
    }
    return nearest.time;
  }

  float latest() const {
    float time = 0.0F;
    for (const FrontField::Arrival& arrival : field_->arrivals) time = std::max(time, arrival.time);
    return time;
  }

  FrontField* field_;
  FarthestPointsGoal goal_;
  ThreadPool* pool_;
  Tiles tiles_;
  std::vector<float> bounds_;  // of the time of the vertex near a cell: it can only fall
  std::vector<float> slack_;   // how much later than a cell its vertex may be
  TakenCells taken_;
  std::vector<std::vector<Choice>> chosen_;    // by tile, in this round
  std::vector<Fronts<Metric>> fronts_;         // by thread
  std::vector<std::vector<uint32_t>> around_;  // by thread: cells with samples
  SampleSet set_;
  std::vector<uint32_t> start_;  // cells of the start's samples, until they are ordered into set_
  int last_rounds_ = 0;          // rounds that are likely to reach the count
  std::size_t added_ = 1;        // by the last round
  float left_out_ = 0.0F;        // arrival time at the farthest place chosen but not taken
};

}  // namespace

template <typename Metric>
SampleSet chooseFarthestPoints(FrontField* field, const FarthestPointsGoal& goal, ThreadPool* pool,
                               const EarlierSamples& before) {
  if (field->crust->size() == 0) return {};
  return Chooser<Metric>(field, goal, pool).run(before);
}

template SampleSet chooseFarthestPoints<Flood>(FrontField*, const FarthestPointsGoal&, ThreadPool*,
                                               const EarlierSamples&);
template SampleSet chooseFarthestPoints<FastMarching>(FrontField*, const FarthestPointsGoal&,
                                                      ThreadPool*, const EarlierSamples&);

}  // namespace ladar_perception
