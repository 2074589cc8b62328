// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/learn/labelled_pass.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "ladar_perception/io/point_stream.h"
#include "ladar_perception/util/progress.h"

namespace ladar_perception {
namespace {

using Points = std::vector<Eigen::Vector3d>;
using Indices = std::vector<std::size_t>;

// Features look no farther around a voxel than this.
constexpr double kMargin_m = 12.0;
// Beyond this from the middle of the cloud a point is a fault of its file.
constexpr double kFarthest_m = 1e6;
// Of a map that cannot be as high as the cloud: from where most points begin, down.
constexpr double kBelowMost_m = 10.0;
constexpr int kMaxColumnsPerAxis = 4000;
constexpr int kMaxHeights = 1000;
constexpr double kMaxColumnBytes = 2.5e8;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Positions near the origin: all moved by the same whole number of voxels.
Points centredPositions(const Scan& cloud, double voxel_size_m) {
  Points points;
  std::string error;
  const CloudView view{cloud.layout, cloud.data.data(), cloud.data.size()};
  const auto fields = findPointFields(view, &error);
  if (!fields) throw std::runtime_error(error);
  readPositions(view, *fields, &points);
  std::vector<double> finite;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    finite.clear();
    for (const Eigen::Vector3d& p : points) {
      if (p.allFinite()) finite.push_back(p[axis]);
    }
    if (!finite.empty()) origin[axis] = std::round(median(finite) / voxel_size_m) * voxel_size_m;
  }
  for (Eigen::Vector3d& p : points) p -= origin;
  return points;
}

bool isPlaceable(const Eigen::Vector3d& p) { return p.cwiseAbs().maxCoeff() <= kFarthest_m; }

Scan scanOf(const Points& points, const Indices& indices) {
  std::vector<Column> columns;
  for (int axis = 0; axis < 3; ++axis) {
    columns.push_back({std::string(1, "xyz"[axis]), ScalarType::kFloat64, {}});
    for (const std::size_t i : indices) columns.back().values.push_back(points[i][axis]);
  }
  return makeScan(columns);
}

const ScanReport& processScan(const Scan& scan, const Eigen::Isometry3d& T_map_sensor,
                              const Eigen::Vector3d& p_map_vehicle, TerrainPipeline* pipeline) {
  std::string error;
  const CloudView view{scan.layout, scan.data.data(), scan.data.size()};
  const auto fields = findPointFields(view, &error);
  assert(fields);
  return pipeline->process(view, *fields, {}, SensorMotion(T_map_sensor), p_map_vehicle);
}

/// How a cloud is laid out in maps: one map for all, or a grid of pieces.
struct Tiling {
  TerrainConfig config;      ///< of every piece's map
  Eigen::Vector2d origin_m;  ///< lowest corner of piece (0, 0)
  Eigen::Vector2d step_m;    ///< from a piece to the next; a map is wider by twice the margin
  double margin_m = 0.0;
  double ground_z_m = 0.0;  ///< lower end of the maps
};

/// From the lowest to the highest point, or, if no map is that high, from where most points begin.
std::pair<double, double> heightRange(const Points& points, double most_m) {
  std::vector<double> z;
  for (const Eigen::Vector3d& p : points) {
    if (isPlaceable(p)) z.push_back(p.z());
  }
  if (z.empty()) return {0.0, 0.0};
  std::sort(z.begin(), z.end());
  if (z.back() - z.front() <= most_m) return {z.front(), z.back()};
  const double low = std::max(z.front(), z[z.size() / 1000] - kBelowMost_m);
  return {low, std::min(z.back(), low + most_m)};
}

/// Columns along one side of the largest square map with so many heights.
int mostColumns(int heights) {
  const double words = std::ceil(heights / 64.0);
  double heights_rounded = 1.0;
  while (heights_rounded < heights) heights_rounded *= 2.0;
  const double by_memory = kMaxColumnBytes / (8.0 * words + 16.0);
  const double by_index = 4294967294.0 / heights_rounded;
  const auto side = static_cast<int>(std::sqrt(std::min(by_memory, by_index)));
  return std::min(side, kMaxColumnsPerAxis);
}

Tiling layOut(const Points& points, const TerrainConfig& config) {
  const double h = config.voxel_size_m;
  Tiling tiling;
  tiling.config = config;
  tiling.config.min_range_m = 0.0;
  tiling.config.max_range_m = 2.0 * kFarthest_m;
  tiling.config.forget_after_s = 0.0;
  tiling.config.forget_after_scans = 0;
  const auto [low, high] = heightRange(points, (kMaxHeights - 3) * h);
  // A voxel more below and above, so that rounding leaves none out.
  const int heights = static_cast<int>(std::floor(high / h) - std::floor(low / h)) + 3;
  tiling.ground_z_m = (std::floor(low / h) - 1.0) * h;
  tiling.config.map_size_z_m = heights * h;
  tiling.config.map_center_height_m = 0.5 * tiling.config.map_size_z_m;
  Eigen::Vector2d lower = Eigen::Vector2d::Zero();
  Eigen::Vector2d upper = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3d& p : points) {
    if (!isPlaceable(p)) continue;
    lower = lower.cwiseMin(p.head<2>());
    upper = upper.cwiseMax(p.head<2>());
  }
  tiling.origin_m = lower.array() - h;
  const double widest_m = mostColumns(heights) * h;
  double* const sizes[] = {&tiling.config.map_size_x_m, &tiling.config.map_size_y_m};
  const Eigen::Vector2d extent = (upper - lower).array() + 3.0 * h;
  const bool fits = extent.maxCoeff() <= widest_m;
  tiling.margin_m = fits ? 0.0 : std::min(kMargin_m, 0.25 * widest_m);
  for (int axis = 0; axis < 2; ++axis) {
    *sizes[axis] = fits ? extent[axis] : widest_m;
    tiling.step_m[axis] = *sizes[axis] - 2.0 * tiling.margin_m;
  }
  return tiling;
}

/// Points by the piece they lie in, and those no piece is for.
struct Pieces {
  using Key = std::pair<int64_t, int64_t>;
  std::map<Key, Indices> points;
  Indices without_place;
};

Pieces cutPieces(const Points& points, const Tiling& tiling) {
  Pieces pieces;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!isPlaceable(points[i])) {
      pieces.without_place.push_back(i);
      continue;
    }
    const Eigen::Vector2d at =
        (points[i].head<2>() - tiling.origin_m).cwiseQuotient(tiling.step_m).array().floor();
    pieces.points[{static_cast<int64_t>(at.x()), static_cast<int64_t>(at.y())}].push_back(i);
  }
  return pieces;
}

/// Points of the pieces around `key` that lie within the margin of it.
Indices pointsAround(const Pieces& pieces, const Pieces::Key& key, const Points& points,
                     const Tiling& tiling) {
  Indices around;
  if (tiling.margin_m <= 0.0) return around;
  const Eigen::Vector2d place(static_cast<double>(key.first), static_cast<double>(key.second));
  const Eigen::Vector2d lower = tiling.origin_m + tiling.step_m.cwiseProduct(place);
  const Eigen::Vector2d upper = lower + tiling.step_m;
  for (int64_t dx = -1; dx <= 1; ++dx) {
    for (int64_t dy = -1; dy <= 1; ++dy) {
      const auto it = pieces.points.find({key.first + dx, key.second + dy});
      if (it == pieces.points.end() || (dx == 0 && dy == 0)) continue;
      for (const std::size_t i : it->second) {
        const Eigen::Vector2d p = points[i].head<2>();
        const double outside = std::max((lower - p).maxCoeff(), (p - upper).maxCoeff());
        if (outside < tiling.margin_m) around.push_back(i);
      }
    }
  }
  return around;
}

void runWhole(const Points& points, const std::vector<double>& truth, const TerrainConfig& config,
              const ClassifierModel& model, const std::string& name,
              const LabelledScanVisitor& visit) {
  const Tiling tiling = layOut(points, config);
  Pieces pieces = cutPieces(points, tiling);
  // They are in no map whatever piece they go with, and must count.
  const Indices lost = std::move(pieces.without_place);
  if (pieces.points.empty()) pieces.points[{0, 0}] = {};
  Progress progress("pieces of " + name, pieces.points.size());
  bool first = true;
  for (const auto& [key, inside] : pieces.points) {
    Indices indices = inside;
    if (first) indices.insert(indices.end(), lost.begin(), lost.end());
    first = false;
    std::vector<double> piece_truth;
    for (const std::size_t i : indices) piece_truth.push_back(truth[i]);
    const Indices around = pointsAround(pieces, key, points, tiling);
    indices.insert(indices.end(), around.begin(), around.end());
    piece_truth.resize(indices.size(), 0.0);
    TerrainPipeline pipeline(tiling.config, model);
    pipeline.keepFeatures(true);
    const Eigen::Vector2d place(static_cast<double>(key.first), static_cast<double>(key.second));
    const Eigen::Vector2d middle =
        tiling.origin_m + tiling.step_m.cwiseProduct(place) + 0.5 * tiling.step_m;
    processScan(scanOf(points, indices), Eigen::Isometry3d::Identity(),
                {middle.x(), middle.y(), tiling.ground_z_m}, &pipeline);
    visit(pipeline, piece_truth);
    if (pieces.points.size() > 1) progress.advance();
  }
  progress.finish();
}

void runStream(const Points& points, const std::vector<double>& truth, const TerrainConfig& config,
               const ClassifierModel& model, const std::string& name,
               const LabelledScanVisitor& visit) {
  Indices all(points.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  const Scan tile = scanOf(points, all);
  const std::vector<StreamScan> scans = cutStream(tile, StreamConfig());
  TerrainPipeline pipeline(config, model);
  pipeline.keepFeatures(true);
  Progress progress("scans of " + name, scans.size());
  for (const StreamScan& scan : scans) {
    std::vector<double> scan_truth;
    for (const std::size_t i : scan.points) scan_truth.push_back(truth[i]);
    processScan(takeStreamScan(tile, scan, scan.T_map_vehicle), scan.T_map_vehicle,
                scan.T_map_vehicle.translation(), &pipeline);
    visit(pipeline, scan_truth);
    progress.advance();
  }
  progress.finish();
}

}  // namespace

TerrainConfig configFor(const ClassifierModel& model, TerrainConfig config) {
  config.voxel_size_m = model.voxel_size_m;
  config.support_radius_voxels = model.support_radius_voxels;
  config.support_kernel = model.support_kernel;
  std::string violations;
  for (const std::string& violation : config.validate()) violations += "; " + violation;
  if (violations.empty()) return config;
  throw std::runtime_error("the configuration does not go with the model" + violations);
}

void runLabelledPass(const Scan& cloud, const std::vector<double>& truth, Pass pass,
                     const TerrainConfig& config, const ClassifierModel& model,
                     const std::string& name, const LabelledScanVisitor& visit) {
  assert(truth.size() == cloud.size() && pass != Pass::kRecorded);
  if (cloud.size() == 0) throw std::runtime_error("has no points");
  const Points points = centredPositions(cloud, config.voxel_size_m);
  const auto run = pass == Pass::kStream ? runStream : runWhole;
  run(points, truth, config, model, name, visit);
}

std::vector<VoxelIndex> voxelsBySlot(const VoxelMap& map) {
  std::vector<VoxelIndex> voxels(map.slotBound());
  map.forEachVoxel([&](const VoxelIndex& voxel, std::size_t slot) { voxels[slot] = voxel; });
  return voxels;
}

}  // namespace ladar_perception
