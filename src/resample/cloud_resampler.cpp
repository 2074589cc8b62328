// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/cloud_resampler.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "ladar_perception/resample/area_estimate.h"
#include "ladar_perception/resample/carried_fronts.h"
#include "ladar_perception/resample/crust.h"
#include "ladar_perception/resample/farthest_points.h"
#include "ladar_perception/resample/fronts.h"
#include "ladar_perception/resample/grid_points.h"
#include "ladar_perception/resample/islands.h"
#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/nearest_points.h"
#include "ladar_perception/resample/point_normals.h"
#include "ladar_perception/resample/surface_fit.h"

namespace ladar_perception {
namespace {

using Clock = std::chrono::steady_clock;

// Samples on a surface of area A have the mean spacing a with A = 0.8 a^2 a sample.
constexpr double kAreaPerSample = 0.8;
// About three and a half cells a sample: with fewer, places are missed and left too far from any
// sample.
constexpr double kCellPerSpacing = 0.465;
// The random start's distance, in spacings: large enough that most samples are put in by the
// rounds, small enough that few long fronts are run.
constexpr float kFirstRadiusPerSpacing = 2.0F;
// Islands of points are joined across gaps of up to two cubes of 2^2 cells, about four spacings: a
// few points farther from all others are mixed pixels, and would each get a sample.
constexpr int kIslandLevel = 2;
// A point with no other within so many spacings has no surface, and would be the farthest place of
// all, if it is one of so few.
constexpr double kLoneSpacings = 1.7;
constexpr std::size_t kPointsPerLone = 100;
// Normals are those of voxels about a spacing wide, in cells: what varies over less, no samples can
// show, and the noise of fewer points would be taken for it.
constexpr double kNormalCells = 2.0;
// A radius that no place is farther from is about this part of the spacing.
constexpr double kRadiusPerSpacing = 0.85;
// The cell size, from an estimate of the area, is corrected by the crust's own area if it is off by
// more than this: larger cells would be too few for good places, smaller ones too many for speed.
constexpr double kTooLarge = 1.2;
constexpr double kTooSmall = 1.25;
// Every so many points are enough to estimate an area, as long as these are left.
constexpr std::size_t kEstimateStride = 4;
constexpr std::size_t kEstimatePoints = 20000;
constexpr int kEstimateSteps = 20;
// Cells of that grid along the cloud's extent, of which what is beyond 10 km does not count.
constexpr double kFineCells = 4096.0;
constexpr double kLargestExtent_m = 1e4;
constexpr double kLeastCell_m = 1e-4;
// A count that a crust cannot hold is tried again with cells so much finer.
constexpr double kFiner = 0.6;
constexpr int kFinerAttempts = 4;
constexpr int kMaxCellLevel = 12;
constexpr int kEllipsoidNeighbors = 12;

double millisecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

class Stopwatch {
 public:
  explicit Stopwatch(double* total_ms) : total_ms_(total_ms), begin_(Clock::now()) {}
  ~Stopwatch() { *total_ms_ += millisecondsSince(begin_); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double* total_ms_;
  Clock::time_point begin_;
};

std::string joined(const std::vector<std::string>& lines) {
  std::string text = "ResampleConfig:";
  for (const std::string& line : lines) text += "\n  " + line;
  return text;
}

/// Throws unless a field is there for all points, or for none of these and those `before`.
void requireLength(const char* name, std::size_t length, std::size_t points, std::size_t before,
                   bool there_before) {
  const bool there = length > 0;
  if (points == 0 && !there) return;
  if ((!there || length == points) && (before == 0 || there == there_before)) return;
  throw std::invalid_argument(std::string("PoseCloudData: ") + name + " has " +
                              std::to_string(length) + " entries, expected " +
                              std::to_string(points) +
                              ", as many as positions_m, or none in the cloud and all it extends");
}

/// Appends the values of points [indices of `finite`]; what is empty stays empty.
template <typename T>
void append(const std::vector<T>& given, const std::vector<uint32_t>& finite,
            std::vector<T>* values) {
  if (given.empty()) return;
  values->reserve(values->size() + finite.size());
  for (const uint32_t i : finite) values->push_back(given[i]);
}

}  // namespace

class CloudResampler::Impl {
 public:
  explicit Impl(const ResampleConfig& config) : config_(config), pool_(config.threads) {}

  ResampledCloud resample(const PoseCloudData& cloud, const Policies& policies, bool more_to_come) {
    begin_ = Clock::now();
    result_ = ResampledCloud();
    policies_ = policies;
    points_ = PointAttributes();
    kept_.clear();
    points_in_ = 0;
    set_ = SampleSet();
    crust_.reset();
    field_.reset();
    memory_ = CrustMemory();
    remembers_ = more_to_come;
    takePoints(cloud);
    return sampleAnew(cloud.sensor_m);
  }

  ResampledCloud extend(const PoseCloudData& more) {
    begin_ = Clock::now();
    result_ = ResampledCloud();
    const std::size_t before = points_.size();
    takePoints(more);
    if (before == 0) return sampleAnew(more.sensor_m);
    extendWeights(before);
    remembers_ = true;
    const std::unique_ptr<const Crust> old = std::move(crust_);
    if (!field_) field_.emplace(*old);
    makeCrust(old->frame, true);
    goal_.deadline = deadline();
    chooseSamples(true);
    write(set_, unit());
    result_.times_ms.total = millisecondsSince(begin_);
    return std::move(result_);
  }

 private:
  ResampledCloud sampleAnew(const Eigen::Vector3d& sensor_m) {
    points_.sensor_m = sensor_m;
    if (points_.size() > 0) {
      weights_ = weigh(points_);
      normalizeWeights();
      double cell_m = buildCrust();
      goal_ = makeGoal();
      chooseSamples(false);
      for (int attempt = 0; attempt < kFinerAttempts && tooFew(); ++attempt) {
        cell_m *= kFiner;
        makeCrust(frameFor(points_.positions_m, cell_m), false);
        goal_ = makeGoal();
        chooseSamples(false);
      }
      write(set_, unit());
    }
    result_.times_ms.total = millisecondsSince(begin_);
    return std::move(result_);
  }

  /// Appends the points that are finite.
  void takePoints(const PoseCloudData& cloud) {
    const Stopwatch watch(&result_.times_ms.voxels);
    const std::size_t size = cloud.positions_m.size();
    std::vector<uint32_t> finite;
    finite.reserve(size);
    for (std::size_t i = 0; i < size; ++i) {
      if (cloud.positions_m[i].allFinite()) finite.push_back(static_cast<uint32_t>(i));
    }
    const std::size_t before = points_.size();
    requireLength("rgb", cloud.rgb.size(), size, before, !points_.rgb.empty());
    requireLength("labels", cloud.labels.size(), size, before, !points_.labels.empty());
    append(cloud.positions_m, finite, &points_.positions_m);
    append(cloud.rgb, finite, &points_.rgb);
    append(cloud.labels, finite, &points_.labels);
    for (const uint32_t i : finite) kept_.push_back(static_cast<uint32_t>(points_in_ + i));
    points_in_ += size;
    result_.points_in = points_in_;
    result_.points_finite = kept_.size();
  }

  /// Weights by the policies; empty if there are none.
  std::vector<float> weigh(PointAttributes& points) {
    const Stopwatch watch(&result_.times_ms.attributes);
    if (policies_.empty()) return {};
    if (std::any_of(policies_.begin(), policies_.end(),
                    [](const auto& policy) { return policy->needsNormals(); })) {
      const double cell_m = kNormalCells * firstCell(points.positions_m, {});
      const GridPoints grid =
          sortIntoGrid(points.positions_m, frameFor(points.positions_m, cell_m));
      const VoxelPyramid pyramid(grid, {}, kBridgeLevels + 1);
      PointNormals found = pointNormals(grid, pyramid, sensorIn(grid.frame), &pool_);
      found.normals.resize(points.size(), Eigen::Vector3f::Zero());
      found.variation.resize(points.size(), 0.0F);
      points.normals = std::move(found.normals);
      points.normal_variation = std::move(found.variation);
    }
    std::vector<float> weights(points.size(), 1.0F);
    for (const auto& policy : policies_) policy->multiply(points, &weights);
    return weights;
  }

  /// From here on weights are relative to the greatest: the densest place has the finest cells.
  void normalizeWeights() {
    greatest_weight_ = 1.0;
    if (weights_.empty()) return;
    const auto range = std::minmax_element(weights_.begin(), weights_.end());
    greatest_weight_ = double{*range.second};
    if (*range.first == *range.second) {
      weights_.clear();
      return;
    }
    for (float& weight : weights_) weight = static_cast<float>(weight / greatest_weight_);
  }

  /// Weights of the points that came last, by themselves; none is greater than the greatest was, so
  /// that cells stay as they are.
  void extendWeights(std::size_t before) {
    if (policies_.empty() || (weights_.empty() && before == 0)) return;
    PointAttributes last;
    last.sensor_m = points_.sensor_m;
    const auto from = static_cast<std::ptrdiff_t>(before);
    last.positions_m.assign(points_.positions_m.begin() + from, points_.positions_m.end());
    if (!points_.rgb.empty()) last.rgb.assign(points_.rgb.begin() + from, points_.rgb.end());
    if (!points_.labels.empty()) {
      last.labels.assign(points_.labels.begin() + from, points_.labels.end());
    }
    if (last.size() == 0) return;
    const std::vector<float> weights = weigh(last);
    weights_.resize(before, 1.0F);
    for (const float weight : weights) {
      weights_.push_back(static_cast<float>(std::min(weight / greatest_weight_, 1.0)));
    }
  }

  Eigen::Vector3f sensorIn(const GridFrame& frame) const {
    return frame.toCells(points_.sensor_m).cast<float>();
  }

  static GridFrame frameFor(const std::vector<Eigen::Vector3d>& positions_m, double cell_m) {
    GridFrame frame;
    frame.cell_m = cell_m;
    frame.origin_m = gridOrigin(positions_m, cell_m);
    return frame;
  }

  /// The size of cells for an estimate of the area, from points, or enough of them, in fine cells.
  double firstCell(const std::vector<Eigen::Vector3d>& positions_m,
                   const std::vector<float>& weights) const {
    Eigen::Vector3d least = positions_m.front();
    Eigen::Vector3d greatest = least;
    for (const Eigen::Vector3d& p : positions_m) {
      least = least.cwiseMin(p);
      greatest = greatest.cwiseMax(p);
    }
    const double extent_m = std::min((greatest - least).maxCoeff(), kLargestExtent_m);
    const double fine_m = std::max(extent_m / kFineCells, kLeastCell_m);
    const bool many = positions_m.size() > kEstimateStride * kEstimatePoints;
    const std::size_t stride = many ? kEstimateStride : 1;
    const AreaEstimate estimate(sortIntoGrid(positions_m, frameFor(positions_m, fine_m), stride),
                                weights, stride);
    // Smaller cells see less of a surface in sparse points, and more of them are needed then.
    double cell_m = cellFor(estimate.area_m2(std::numeric_limits<double>::max()));
    for (int step = 0; step < kEstimateSteps; ++step) cell_m = cellFor(estimate.area_m2(cell_m));
    return cell_m;
  }

  std::size_t wantedSamples() const {
    if (config_.count > 0) return static_cast<std::size_t>(config_.count);
    return std::max<std::size_t>(points_.size() / 2, 1);
  }

  /// Spacing of the densest place: from the radius, or from the samples wanted on a weighted area.
  double spacingFor(double area_m2) const {
    const double by_radius = config_.radius_m / kRadiusPerSpacing / std::sqrt(greatest_weight_);
    if (config_.radius_m > 0.0 && config_.count == 0) return by_radius;
    const double by_count =
        std::sqrt(area_m2 / (kAreaPerSample * static_cast<double>(wantedSamples())));
    return std::max(by_count, by_radius);
  }

  double cellFor(double area_m2) const {
    return std::max(kCellPerSpacing * spacingFor(area_m2), kLeastCell_m);
  }

  /// Whether there were no more cells for the samples that are wanted.
  bool tooFew() const {
    return config_.cell_size_m == 0.0 && set_.size() < goal_.count &&
           Clock::now() < goal_.deadline &&
           (goal_.radius == 0.0F || set_.radius_reached > goal_.radius);
  }

  /// Returns the size of its cells.
  double buildCrust() {
    double cell_m = config_.cell_size_m;
    if (cell_m == 0.0) {
      const Stopwatch watch(&result_.times_ms.voxels);
      cell_m = firstCell(points_.positions_m, weights_);
    }
    for (int attempt = 0;; ++attempt) {
      makeCrust(frameFor(points_.positions_m, cell_m), false);
      if (config_.cell_size_m > 0.0 || attempt == 2) return cell_m;
      // By the faces: what counts is how many cells there are, and at a slant they are farther
      // apart.
      const double better_m = cellFor(weightedArea(false));
      if (better_m < cell_m * kTooSmall && cell_m < better_m * kTooLarge) return cell_m;
      cell_m = better_m;
    }
  }

  /// Areas of the crust's cells times their weights: of their faces along the grid, or of the
  /// surface in them, which is larger at a slant.
  double weightedArea(bool of_surface) const {
    double cells = 0.0;
    for (std::size_t i = 0; i < crust_->size(); ++i) {
      const double face = double{crust_->edge(i)} * crust_->edge(i) * crust_->weight(i);
      cells += of_surface ? face / crust_->normals[i].cwiseAbs().maxCoeff() : face;
    }
    return cells * crust_->frame.cell_m * crust_->frame.cell_m;
  }

  /// `extends`: the frame is that of the last crust, and its points are among these.
  void makeCrust(const GridFrame& frame, bool extends) {
    {
      const Stopwatch watch(&result_.times_ms.voxels);
      grid_ = sortIntoGrid(points_.positions_m, frame);
      const int coarsest = weights_.empty() ? 0 : coarsestLevel();
      const Islands islands = dropSmallIslands(
          kIslandLevel + coarsest, static_cast<std::size_t>(config_.min_component_points),
          static_cast<std::size_t>(config_.count), &grid_);
      result_.components = islands.kept;
      result_.dropped_components = islands.dropped;
      if (config_.min_component_points > 1) {
        constexpr auto kLoneCells = static_cast<float>(kLoneSpacings / kCellPerSpacing);
        result_.lone_points =
            dropLonePoints(kIslandLevel + coarsest, kLoneCells * static_cast<float>(1 << coarsest),
                           grid_.size() / kPointsPerLone, &grid_);
      }
      cell_levels_.clear();
      if (coarsest > 0) wantLevels();
      VoxelPyramid pyramid(grid_, weights_, kBridgeLevels + 1 + coarsest);
      unchanged_.clear();
      if (extends) {
        for (int level = 0; level < std::min(pyramid.levels(), pyramid_->levels()); ++level) {
          unchanged_.push_back(unchangedBricks(pyramid.level(level), pyramid_->level(level)));
        }
      } else {
        memory_ = CrustMemory();
      }
      pyramid_ = std::move(pyramid);
      if (!cell_levels_.empty()) groupLevels();
    }
    const Stopwatch watch(&result_.times_ms.crust);
    const Eigen::Vector3f sensor = sensorIn(grid_.frame);
    Crust crust = config_.crust == "surfels"
                      ? makeSurfelCrust(*pyramid_, grid_.frame, cell_levels_, sensor, &pool_,
                                        unchanged_, remembers_ ? &memory_ : nullptr)
                      : makeEllipsoidCrust(grid_, weights_, kEllipsoidNeighbors, sensor, &pool_);
    crust_ = std::make_unique<const Crust>(std::move(crust));
  }

  /// The size of cells for a weight: the spacing of a place is weight^(-1/2) of the densest's, and
  /// cells are as much larger, as far as powers of two go.
  static int levelFor(float weight) {
    return std::clamp(static_cast<int>(std::floor(-0.5F * std::log2(weight) + 1e-3F)), 0,
                      kMaxCellLevel);
  }
  int coarsestLevel() const {
    return levelFor(*std::min_element(weights_.begin(), weights_.end()));
  }
  void wantLevels() {
    cell_levels_.resize(grid_.size());
    for (std::size_t i = 0; i < grid_.size(); ++i) {
      cell_levels_[i] = static_cast<uint8_t>(levelFor(weights_[grid_.sources[i]]));
    }
  }

  /// From points to voxels: the finest that one of the points wants.
  void groupLevels() {
    const VoxelLevel& voxels = pyramid_->level(0);
    std::vector<uint8_t> least(voxels.grid.size());
    for (std::size_t i = 0; i < least.size(); ++i) {
      least[i] = *std::min_element(cell_levels_.begin() + voxels.first_point[i],
                                   cell_levels_.begin() + voxels.first_point[i + 1]);
    }
    cell_levels_ = std::move(least);
  }

  /// m, or arrival time of as many units of weight 1.
  double unit() const { return crust_->frame.cell_m * std::sqrt(greatest_weight_); }

  Clock::time_point deadline() const {
    if (config_.time_budget_s == 0.0) return Clock::time_point::max();
    return begin_ + std::chrono::duration_cast<Clock::duration>(
                        std::chrono::duration<double>(config_.time_budget_s));
  }

  FarthestPointsGoal makeGoal() const {
    FarthestPointsGoal goal;
    goal.count = static_cast<std::size_t>(config_.count);
    goal.radius = static_cast<float>(config_.radius_m / unit());
    goal.deadline = deadline();
    const auto spacing = static_cast<float>(spacingFor(weightedArea(true)) / crust_->frame.cell_m);
    goal.first_radius = std::max(kFirstRadiusPerSpacing * spacing, 1.0F);
    return goal;
  }

  /// `more`: those that are there stay.
  void chooseSamples(bool more) {
    result_.cells = crust_->size();
    result_.cell_size_m = crust_->frame.cell_m;
    const Stopwatch watch(&result_.times_ms.fronts);
    if (config_.engine == "flood") {
      chooseSamplesBy<Flood>(more);
    } else {
      chooseSamplesBy<FastMarching>(more);
    }
  }

  template <typename Metric>
  void chooseSamplesBy(bool more) {
    FrontField field(*crust_);
    EarlierSamples before;
    if (more) {
      field.reset(goal_.first_radius);
      before = carryFronts<Metric>(*field_, set_, &field);
      if (goal_.count > 0) {
        goal_.count = before.set.size() + static_cast<std::size_t>(config_.count);
      }
    }
    set_ = chooseFarthestPoints<Metric>(&field, goal_, &pool_, before);
    field_.reset();
    if (remembers_) field_ = std::move(field);
  }

  void write(const SampleSet& set, double unit_m) {
    const Stopwatch watch(&result_.times_ms.samples);
    const std::vector<uint32_t> nearest = nearestOf(set);
    result_.positions_m.reserve(set.size());
    result_.normals.reserve(set.size());
    result_.sources.reserve(set.size());
    result_.covering_radii.reserve(set.size());
    result_.weights.reserve(set.size());
    for (std::size_t i = 0; i < set.size(); ++i) {
      const uint32_t source = grid_.sources[nearest[i]];
      const uint32_t cell = set.cells[i];
      result_.positions_m.push_back(config_.nearest_original
                                        ? points_.positions_m[source]
                                        : crust_->frame.toMetres(set.positions[i]));
      result_.normals.push_back(crust_->normals[cell]);
      result_.sources.push_back(kept_[source]);
      result_.covering_radii.push_back(static_cast<float>(set.covering[i] * unit_m));
      result_.weights.push_back(static_cast<float>(crust_->weight(cell) * greatest_weight_));
    }
  }

  /// The nearest point of every sample, looked for in the order of the cells.
  std::vector<uint32_t> nearestOf(const SampleSet& set) {
    std::vector<uint32_t> sample_of_cell(crust_->size(), kNoIndex);
    for (std::size_t i = 0; i < set.size(); ++i) {
      sample_of_cell[set.cells[i]] = static_cast<uint32_t>(i);
    }
    std::vector<uint32_t> samples;
    std::vector<Eigen::Vector3f> places;
    for (const uint32_t sample : sample_of_cell) {
      if (sample == kNoIndex) continue;
      samples.push_back(sample);
      places.push_back(set.positions[sample]);
    }
    const std::vector<uint32_t> found = nearestPoints(grid_, *pyramid_, places, &pool_);
    std::vector<uint32_t> nearest(set.size());
    for (std::size_t i = 0; i < samples.size(); ++i) nearest[samples[i]] = found[i];
    return nearest;
  }

  ResampleConfig config_;
  ThreadPool pool_;
  Clock::time_point begin_;
  ResampledCloud result_;
  Policies policies_;
  std::size_t points_in_ = 0;
  std::vector<uint32_t> kept_;  // points given that are finite
  PointAttributes points_;
  std::vector<float> weights_;  // by point, relative to the greatest; empty if all alike
  double greatest_weight_ = 1.0;
  GridPoints grid_;
  std::optional<VoxelPyramid> pyramid_;
  std::vector<uint8_t> cell_levels_;
  std::vector<std::vector<uint32_t>> unchanged_;  // bricks by level, since the crust before
  bool remembers_ = false;                        // for extend(), in memory_ and field_
  CrustMemory memory_;
  std::unique_ptr<const Crust> crust_;
  std::optional<FrontField> field_;  // on it
  FarthestPointsGoal goal_;
  SampleSet set_;
};

CloudResampler::CloudResampler(const ResampleConfig& config) {
  const std::vector<std::string> violations = config.validate();
  if (!violations.empty()) throw std::invalid_argument(joined(violations));
  impl_ = std::make_unique<Impl>(config);
}
CloudResampler::~CloudResampler() = default;
CloudResampler::CloudResampler(CloudResampler&&) noexcept = default;
CloudResampler& CloudResampler::operator=(CloudResampler&&) noexcept = default;

ResampledCloud CloudResampler::resample(const PoseCloudData& cloud, const Policies& policies,
                                        bool more_to_come) {
  return impl_->resample(cloud, policies, more_to_come);
}

ResampledCloud CloudResampler::extend(const PoseCloudData& more) { return impl_->extend(more); }

}  // namespace ladar_perception
