// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/carried_fronts.h"

#include <limits>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/sparse_grid.h"

namespace ladar_perception {
namespace {

template <typename Metric>
class Carrier {
 public:
  Carrier(const FrontField& before, const SampleSet& set, FrontField* field)
      : before_(before),
        set_(set),
        field_(field),
        earlier_(sameCells(*field->crust, *before.crust)),
        later_(before.crust->size(), kNoIndex),
        stale_(before.crust->size(), 1) {
    // The field may have other fronts, of samples that were chosen but left out for the count, or
    // none at all.
    for (const uint32_t cell : set.cells)
      stale_[cell] = before.arrivals[cell].owner != cell ? 1 : 0;
    for (uint32_t cell = 0; cell < earlier_.size(); ++cell) {
      if (earlier_[cell] != kNoIndex) later_[earlier_[cell]] = cell;
    }
    findStaleFronts();
  }

  EarlierSamples carry() {
    copyArrivals();
    Fronts<Metric> fronts(field_);
    runOn(&fronts);
    EarlierSamples carried;
    carried.set = moveSamples(&fronts);
    for (uint32_t cell = 0; cell < earlier_.size(); ++cell) {
      if (earlier_[cell] == kNoIndex) carried.new_cells.push_back(cell);
    }
    return carried;
  }

 private:
  /// Those in cells that are not there any more, and in the cells beside what has come or gone.
  void findStaleFronts() {
    const auto touch = [this](uint32_t cell) {
      const uint32_t owner = before_.arrivals[cell].owner;
      if (owner != kNoIndex) stale_[owner] = 1;
    };
    const Crust& old = *before_.crust;
    for (uint32_t cell = 0; cell < later_.size(); ++cell) {
      if (later_[cell] != kNoIndex) continue;
      stale_[cell] = 1;  // if it has a sample
      touch(cell);
      forNeighbors(old, cell, touch);
    }
    for (uint32_t cell = 0; cell < earlier_.size(); ++cell) {
      if (earlier_[cell] != kNoIndex) continue;
      forNeighbors(*field_->crust, cell, [&](uint32_t near) {
        if (earlier_[near] != kNoIndex) touch(earlier_[near]);
      });
    }
  }

  void copyArrivals() {
    for (uint32_t cell = 0; cell < earlier_.size(); ++cell) {
      const uint32_t old = earlier_[cell];
      if (old == kNoIndex) continue;
      const FrontField::Arrival& arrival = before_.arrivals[old];
      if (arrival.owner == kNoIndex || stale_[arrival.owner] != 0) continue;
      const uint32_t owner = later_[arrival.owner];
      field_->arrivals[cell] = {arrival.time, owner};
      field_->in_sight[cell] = before_.in_sight[old];
      field_->samples[owner] = before_.samples[arrival.owner];
    }
  }

  /// Fronts that are there enter the cells that have none.
  void runOn(Fronts<Metric>* fronts) {
    std::vector<uint32_t> edge;
    std::vector<uint8_t> found(field_->crust->size(), 0);
    for (uint32_t cell = 0; cell < found.size(); ++cell) {
      if (field_->arrivals[cell].owner != kNoIndex) continue;
      forNeighbors(*field_->crust, cell, [&](uint32_t near) {
        if (field_->arrivals[near].owner == kNoIndex || found[near] != 0) return;
        found[near] = 1;
        edge.push_back(near);
      });
    }
    for (const uint32_t cell : edge) fronts->runOn(cell);
  }

  SampleSet moveSamples(Fronts<Metric>* fronts) {
    const Crust& crust = *field_->crust;
    SparseGrid cells;
    cells.assign(crust.keys);
    std::vector<uint8_t> taken(crust.size(), 0);
    for (const uint32_t cell : set_.cells) {
      if (later_[cell] != kNoIndex) taken[later_[cell]] = 1;
    }
    SampleSet moved;
    for (std::size_t i = 0; i < set_.size(); ++i) {
      const uint32_t old = set_.cells[i];
      uint32_t cell = later_[old];
      if (cell == kNoIndex) {
        cell = nearestFreeCell(cells, old, set_.positions[i], taken);
        if (cell == kNoIndex) continue;
        taken[cell] = 1;
      }
      if (stale_[old] != 0) fronts->insert(cell, set_.positions[i]);
      moved.cells.push_back(cell);
      moved.positions.push_back(set_.positions[i]);
      moved.covering.push_back(set_.covering[i]);
    }
    return moved;
  }

  /// Of those in the place of a cell that was there before, and in the places of its size around.
  uint32_t nearestFreeCell(const SparseGrid& cells, uint32_t old, const Eigen::Vector3f& position,
                           const std::vector<uint8_t>& taken) const {
    const int shift = 3 * before_.crust->levels[old];
    const uint64_t key = before_.crust->keys[old] >> shift;
    uint32_t nearest = kNoIndex;
    float least = std::numeric_limits<float>::infinity();
    for (int step = 0; step < 27; ++step) {
      const uint32_t cell = cells.find(morton::around(key, step) << shift);
      if (cell == kNoIndex || taken[cell] != 0) continue;
      const float distance = (field_->crust->positions[cell] - position).squaredNorm();
      if (distance < least) {
        least = distance;
        nearest = cell;
      }
    }
    return nearest;
  }

  template <typename Visit>
  static void forNeighbors(const Crust& crust, uint32_t cell, const Visit& visit) {
    for (uint32_t k = crust.first_neighbor[cell]; k < crust.first_neighbor[cell + 1]; ++k) {
      visit(crust.neighbors[k]);
    }
  }

  const FrontField& before_;
  const SampleSet& set_;
  FrontField* field_;
  std::vector<uint32_t> earlier_;  // by cell: the same one before
  std::vector<uint32_t> later_;    // by cell before: the same one now
  std::vector<uint8_t> stale_;     // by cell before: the front of its sample is to be run anew
};

}  // namespace

std::vector<uint32_t> sameCells(const Crust& now, const Crust& before) {
  std::vector<uint32_t> same(now.size(), kNoIndex);
  uint32_t old = 0;
  for (uint32_t cell = 0; cell < same.size(); ++cell) {
    while (old < before.size() && before.keys[old] < now.keys[cell]) ++old;
    if (old == before.size()) break;
    if (before.keys[old] == now.keys[cell] && before.levels[old] == now.levels[cell] &&
        before.positions[old] == now.positions[cell] && before.normals[old] == now.normals[cell] &&
        before.slowness[old] == now.slowness[cell]) {
      same[cell] = old;
    }
  }
  return same;
}

template <typename Metric>
EarlierSamples carryFronts(const FrontField& before, const SampleSet& set, FrontField* field) {
  return Carrier<Metric>(before, set, field).carry();
}

template EarlierSamples carryFronts<Flood>(const FrontField&, const SampleSet&, FrontField*);
template EarlierSamples carryFronts<FastMarching>(const FrontField&, const SampleSet&, FrontField*);

}  // namespace ladar_perception
