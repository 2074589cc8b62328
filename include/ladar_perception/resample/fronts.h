// SPDX-License-Identifier: BSD-3-Clause
// Fronts that leave samples and run over the crust until they meet earlier ones. How a front
// arrives at a cell is a policy of the template: FastMarching or Flood.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ladar_perception/resample/crust.h"
#include "ladar_perception/resample/sparse_grid.h"

namespace ladar_perception {

/// The crust as fronts see it, and where they are. Lengths in cells, times in cells at weight 1.
struct FrontField {
  explicit FrontField(const Crust& crust_of_fronts);

  /// Place and slowness, side by side because they are used together.
  struct alignas(16) Node {
    float x, y, z, slowness;
    Eigen::Vector3f position() const { return {x, y, z}; }
  };
  /// A cell's earliest front.
  struct Arrival {
    float time;
    uint32_t owner;  ///< cell whose sample the front left, kNoIndex if none came
  };

  /// All fronts forgotten; none will run beyond `limit`.
  void reset(float limit);

  const Crust* crust;
  std::vector<Node> nodes;
  std::vector<Arrival> arrivals;
  std::vector<Node> samples;      ///< of the sample of a cell, where there is one
  std::vector<uint8_t> in_sight;  ///< the front came straight from the sample (FastMarching)
};

/// A sample whose front is under way.
struct FrontSource {
  uint32_t cell;
  Eigen::Vector3f position;
  Eigen::Vector3f normal;
  float slowness;
};

/// Straight distance times the mean slowness of both ends. Cells are entered through neighbours, so
/// that fronts stay on their surface, but the way is not measured along it.
struct Flood {
  static float arrive(const FrontField& field, const FrontSource& source, uint32_t from,
                      uint32_t cell, bool* in_sight);
};

/// Arrival time by the Eikonal equation |grad T| F = 1 (the paper's equation 7).
///
/// First-order upwind differences, as in the paper, are wrong by up to 20 % next to a source, where
/// the front is curved most, and all fronts of a re-sampling are short. Here
/// - cells that see the sample along a flat piece of surface of even slowness get the exact time;
///   nearer than 2.5 cells flat is taken widely, because the normals of single cells are noisy;
/// - others get it from two neighbours the front has reached: these fix a virtual source in the
///   plane of the three, and the front arrives from there. It is exact for a point source on any
///   surface that unrolls into a plane, and second order elsewhere; across creases as well.
/// Errors at even slowness: see kArrivalError. Behind a hole in the crust fronts come up to 9 %
/// early (sight reaches a bit around its rim), at uneven slowness within 3 %.
struct FastMarching {
  static float arrive(const FrontField& field, const FrontSource& source, uint32_t from,
                      uint32_t cell, bool* in_sight);
};

/// Greatest error of FastMarching's arrival times, relative to the distance, plus some of a cell:
/// on a plane at any angle, a sphere of radius >= 10 cells (up to nine tenths of the way round,
/// where fronts close on themselves) and the corner of two planes. The surfel crust itself cuts
/// such a corner by up to a cell.
constexpr float kArrivalError = 0.02F;
constexpr float kArrivalErrorCells = 0.7F;

/// Sends fronts out from samples.
template <typename Metric>
class Fronts {
 public:
  explicit Fronts(FrontField* field) : field_(field) {}

  /// Puts a sample at `position` near the place of `cell` and lets its front run.
  void insert(uint32_t cell, const Eigen::Vector3f& position);
  /// Lets the front of a sample that is in, in the cell `sample`, come straight to a cell from
  /// which cells of others have kept it, and run on from there.
  void enter(uint32_t cell, uint32_t sample);
  /// Lets the front that holds a cell run on from there, into cells that others do not hold sooner.
  void runOn(uint32_t cell);

 private:
  FrontSource sourceOf(uint32_t sample) const;
  void run(const FrontSource& source);
  void push(uint32_t cell, float time, uint32_t owner, bool in_sight);

  FrontField* field_;
  std::vector<uint32_t> queue_;
};

/// A cell's time does not depend on the way, so that it need not be visited again.
template <>
void Fronts<Flood>::run(const FrontSource& source);

extern template class Fronts<Flood>;
extern template class Fronts<FastMarching>;

}  // namespace ladar_perception
