// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/fronts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ladar_perception {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();

// Surface is flat between two places if their normals differ by less than 26 degrees: a chord is
// then 1 % shorter than the arc. The chord leaves the tangent plane by half the angle.
constexpr float kFlatCosine = 0.9F;
constexpr float kFlatRise = 0.25F;
// Half a cell more, for noise of the places next to the sample.
constexpr float kFlatNoise = 0.5F;
// Slowness is even if it differs by less than this part.
constexpr float kEvenSlowness = 0.1F;
// The box around a sample that the front crosses straight, in cells from it.
constexpr float kBox = 2.5F;
// There even a crease of 66 degrees makes the way only 0.4 cells longer than the chord, and normals
// of single cells are off by as much where points are sparse and noisy: one of the two that is near
// the truth must do.
constexpr float kNearCosine = 0.4F;
constexpr float kNearRise = 0.4F;
// Two neighbours that far apart tell where a front comes from; with a wider base, the front's own
// curvature, which is not that of a circle on a curved surface, would count four times as much.
constexpr float kPairWidth = 1.8F;
// A way around is sooner than sight if it takes less than this part; less is rounding.
constexpr float kSooner = 0.98F;
// A cell sees the sample past a neighbour that sees it and lies this near to the line of sight.
constexpr float kSightWidth = 0.8F;

float straight(const FrontField::Node& node, const FrontSource& source, Eigen::Vector3f* d) {
  *d = node.position() - source.position;
  return std::sqrt(d->squaredNorm()) * 0.5F * (node.slowness + source.slowness);
}

/// Distance from the virtual source of a front that has gone r_a and r_b to two places `ab` apart,
/// to a third that lies ac and bc from them; kNever if the front does not come through between
/// them.
float throughTwo(float r_a, float r_b, float ab, float ac, float bc) {
  const float by_ab = 0.5F / ab;
  const float source_x = (r_a * r_a + ab * ab - r_b * r_b) * by_ab;
  const float source_y2 = r_a * r_a - source_x * source_x;
  if (source_y2 < 0.0F) return kNever;
  const float cell_x = (ac * ac + ab * ab - bc * bc) * by_ab;
  const float cell_y2 = ac * ac - cell_x * cell_x;
  if (cell_y2 <= 0.0F) return kNever;
  const float source_y = std::sqrt(source_y2);
  const float height = source_y + std::sqrt(cell_y2);
  const float run = cell_x - source_x;
  const float crossing = source_x + run * source_y / height;
  if (crossing < 0.0F || crossing > ab) return kNever;
  const float distance = std::sqrt(run * run + height * height);
  // Earlier than one of the two it would not come from them. Where the slowness varies fronts are
  // flatter than their virtual source has it, and such times would lower those of the neighbours,
  // these again the cell's, and so on.
  return distance >= std::max(r_a, r_b) ? distance : kNever;
}

class EikonalUpdate {
 public:
  EikonalUpdate(const FrontField& field, uint32_t owner, uint32_t from, uint32_t cell)
      : field_(field),
        owner_(owner),
        from_(from),
        cell_(cell),
        p_cell_(field.nodes[cell].position()),
        p_from_(field.nodes[from].position()),
        step_((p_cell_ - p_from_).norm()) {}

  float solve() const {
    const FrontField::Node& here = field_.nodes[cell_];
    const FrontField::Node& before = field_.nodes[from_];
    const float time_from = field_.arrivals[from_].time;
    float best = time_from + step_ * 0.5F * (here.slowness + before.slowness);
    const Crust& crust = *field_.crust;
    const float limit2 = std::pow(kPairWidth * crust.edge(cell_), 2.0F);
    for (uint32_t k = crust.first_neighbor[cell_]; k < crust.first_neighbor[cell_ + 1]; ++k) {
      const uint32_t other = crust.neighbors[k];
      if (other == from_ || field_.arrivals[other].owner != owner_) continue;
      const FrontField::Node& side = field_.nodes[other];
      const float slowness = 0.5F * here.slowness + 0.25F * (before.slowness + side.slowness);
      const Eigen::Vector3f p_side = side.position();
      if ((p_side - p_from_).squaredNorm() > limit2) continue;
      const float distance =
          throughTwo(time_from / slowness, field_.arrivals[other].time / slowness,
                     (p_side - p_from_).norm(), step_, (p_side - p_cell_).norm());
      best = std::min(best, distance * slowness);
    }
    return best;
  }

 private:
  const FrontField& field_;
  uint32_t owner_;
  uint32_t from_;
  uint32_t cell_;
  Eigen::Vector3f p_cell_;
  Eigen::Vector3f p_from_;
  float step_;
};

/// Whether a line over the surface leaves its tangent plane no more than noise and `slope` explain.
bool isLow(float rise, float length2, float edge, float slope) {
  const float beyond_noise = std::abs(rise) - kFlatNoise * edge;
  return beyond_noise < 0.0F || beyond_noise * beyond_noise < slope * slope * length2;
}

/// Whether the way between two places with these normals is as good as straight.
bool isFlat(const Eigen::Vector3f& n_source, const Eigen::Vector3f& n_cell,
            const Eigen::Vector3f& d, float edge) {
  return n_source.dot(n_cell) > kFlatCosine &&
         isLow(n_source.dot(d), d.squaredNorm(), edge, kFlatRise);
}

/// The same in the box.
bool isNearlyFlat(const Eigen::Vector3f& n_source, const Eigen::Vector3f& n_cell,
                  const Eigen::Vector3f& d, float edge) {
  return n_source.dot(n_cell) > kNearCosine &&
         (isLow(n_source.dot(d), d.squaredNorm(), edge, kNearRise) ||
          isLow(n_cell.dot(d), d.squaredNorm(), edge, kNearRise));
}

/// Whether one of the neighbours that see the sample lies on the line of sight to the cell.
bool seesPast(const FrontField& field, const FrontSource& source, uint32_t cell,
              const Eigen::Vector3f& d) {
  const Crust& crust = *field.crust;
  const float width = kSightWidth * crust.edge(cell);
  const float limit = width * width * d.squaredNorm();
  for (uint32_t k = crust.first_neighbor[cell]; k < crust.first_neighbor[cell + 1]; ++k) {
    const uint32_t other = crust.neighbors[k];
    if (field.arrivals[other].owner != source.cell || field.in_sight[other] == 0) continue;
    const Eigen::Vector3f e = field.nodes[other].position() - source.position;
    if (e.squaredNorm() < d.squaredNorm() && e.dot(d) >= 0.0F &&
        e.cross(d).squaredNorm() <= limit) {
      return true;
    }
  }
  return false;
}

}  // namespace

FrontField::FrontField(const Crust& crust_of_fronts)
    : crust(&crust_of_fronts),
      nodes(crust_of_fronts.size()),
      arrivals(crust_of_fronts.size()),
      samples(crust_of_fronts.size()),
      in_sight(crust_of_fronts.size()) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Eigen::Vector3f& p = crust->positions[i];
    nodes[i] = {p.x(), p.y(), p.z(), crust->slowness[i]};
  }
  reset(kNever);
}

void FrontField::reset(float limit) {
  std::fill(arrivals.begin(), arrivals.end(), Arrival{limit, kNoIndex});
}

float Flood::arrive(const FrontField& field, const FrontSource& source, uint32_t /*from*/,
                    uint32_t cell, bool* /*in_sight*/) {
  Eigen::Vector3f d;
  return straight(field.nodes[cell], source, &d);
}

float FastMarching::arrive(const FrontField& field, const FrontSource& source, uint32_t from,
                           uint32_t cell, bool* in_sight) {
  const FrontField::Node& node = field.nodes[cell];
  Eigen::Vector3f d;
  const float time = straight(node, source, &d);
  const bool even = std::abs(node.slowness - source.slowness) < kEvenSlowness * source.slowness;
  const bool straight_so_far = even && field.in_sight[from] != 0;
  // What cannot be earlier than it is known is not solved for: no way is shorter than the straight
  // one, and where the front is not in sight of the sample, none is sooner than where it comes from.
  const float known = field.arrivals[cell].time;
  if (straight_so_far && time >= known) return time;
  const bool late = field.arrivals[from].time >= known;
  if (!even && late) return known;
  const Crust& crust = *field.crust;
  const float edge = crust.edge(cell);
  const bool near = d.squaredNorm() < kBox * kBox * edge * edge;
  *in_sight = even && (near ? isNearlyFlat(source.normal, crust.normals[cell], d, edge)
                            : isFlat(source.normal, crust.normals[cell], d, edge) &&
                                  seesPast(field, source, cell, d));
  if (*in_sight && straight_so_far) return time;
  if (!*in_sight && late) return known;
  // The front may have come sooner on a way around, over faster ground.
  const float solved = EikonalUpdate(field, source.cell, from, cell).solve();
  if (solved < kSooner * time) *in_sight = false;
  return *in_sight ? time : solved;
}

template <typename Metric>
void Fronts<Metric>::push(uint32_t cell, float time, uint32_t owner, bool in_sight) {
  field_->arrivals[cell] = {time, owner};
  field_->in_sight[cell] = in_sight ? 1 : 0;
  queue_.push_back(cell);
}

template <typename Metric>
void Fronts<Metric>::insert(uint32_t cell, const Eigen::Vector3f& position) {
  field_->samples[cell] = {position.x(), position.y(), position.z(), field_->nodes[cell].slowness};
  const FrontSource source = sourceOf(cell);
  queue_.clear();
  Eigen::Vector3f d;
  push(cell, straight(field_->nodes[cell], source, &d), cell, true);
  run(source);
}

template <typename Metric>
void Fronts<Metric>::enter(uint32_t cell, uint32_t sample) {
  const FrontSource source = sourceOf(sample);
  queue_.clear();
  Eigen::Vector3f d;
  const float time = straight(field_->nodes[cell], source, &d);
  if (time >= field_->arrivals[cell].time) return;
  push(cell, time, sample, true);
  run(source);
}

template <typename Metric>
void Fronts<Metric>::runOn(uint32_t cell) {
  queue_.assign(1, cell);
  run(sourceOf(field_->arrivals[cell].owner));
}

template <typename Metric>
FrontSource Fronts<Metric>::sourceOf(uint32_t sample) const {
  const FrontField::Node& node = field_->samples[sample];
  return {sample, node.position(), field_->crust->normals[sample], node.slowness};
}

template <>
void Fronts<Flood>::run(const FrontSource& source) {
  const Crust& crust = *field_->crust;
  const FrontField::Node* nodes = field_->nodes.data();
  FrontField::Arrival* arrivals = field_->arrivals.data();
  const FrontSource front = source;
  std::size_t size = queue_.size();
  for (std::size_t head = 0; head < size; ++head) {
    const uint32_t first = crust.first_neighbor[queue_[head]];
    const uint32_t end = crust.first_neighbor[queue_[head] + 1];
    if (queue_.size() < size + end - first) queue_.resize(2 * (size + end - first));
    uint32_t* queue = queue_.data();
    for (const uint32_t* to = crust.neighbors.data() + first; to < crust.neighbors.data() + end;
         ++to) {
      Eigen::Vector3f d;
      const float time = straight(nodes[*to], front, &d);
      // Whether the front is sooner cannot be foreseen (in its own cells it is not), hence no
      // branch.
      FrontField::Arrival& known = arrivals[*to];
      const uint32_t sooner = time < known.time ? 1 : 0;
      queue[size] = *to;
      size += sooner;
      known.time = std::min(time, known.time);
      known.owner ^= (known.owner ^ front.cell) & (0U - sooner);
    }
  }
}

template <typename Metric>
void Fronts<Metric>::run(const FrontSource& source) {
  const Crust& crust = *field_->crust;
  // Fronts are a few cells long: first in, first out visits them nearly in the order of arrival,
  // and a cell that is reached earlier on another way is visited again.
  for (std::size_t head = 0; head < queue_.size(); ++head) {
    const uint32_t from = queue_[head];
    const uint32_t end = crust.first_neighbor[from + 1];
    for (uint32_t k = crust.first_neighbor[from]; k < end; ++k) {
      const uint32_t to = crust.neighbors[k];
      const FrontField::Arrival& known = field_->arrivals[to];
      const bool own = known.owner == source.cell;
      if (own && known.time <= field_->arrivals[from].time) continue;
      bool in_sight = false;
      const float time = Metric::arrive(*field_, source, from, to, &in_sight);
      // A least gain, so that rounding cannot send cells around in circles.
      const float gain = own ? 1e-4F * time : 0.0F;
      if (time < known.time - gain) push(to, time, source.cell, in_sight);
    }
  }
}

template class Fronts<Flood>;
template class Fronts<FastMarching>;

}  // namespace ladar_perception
