// SPDX-License-Identifier: BSD-3-Clause
#include "campus_quality.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "ladar_perception/resample/sampling_quality.h"

namespace ladar_perception::bench {
namespace {

using Points = std::vector<Eigen::Vector3d>;
using nlohmann::json;

constexpr double kLeastExpected = 100.0;

json toJson(const Summary& summary) {
  return {{"mean", summary.mean},  {"rms", summary.rms}, {"median", summary.median},
          {"p95", summary.p95},    {"p99", summary.p99}, {"max", summary.max},
          {"count", summary.count}};
}

/// What was seen of the faces in one plane.
struct SeenPlane {
  uint32_t plane = 0;
  sim::Material material = sim::Material::kSoil;
  Rectangle rectangle;  ///< around all its faces, from the sensor
  Points places;        ///< true ones of the raw points
};

/// The smallest rectangle along the edges of the first that holds all.
Rectangle around(const std::vector<const Rectangle*>& parts) {
  const Eigen::Vector3d u = parts.front()->edge_u_m.normalized();
  const Eigen::Vector3d v = parts.front()->edge_v_m.normalized();
  const Eigen::Vector3d& corner = parts.front()->corner_m;
  Eigen::Array2d low(0.0, 0.0);
  Eigen::Array2d high(0.0, 0.0);
  for (const Rectangle* part : parts) {
    for (const Eigen::Vector3d& p :
         {part->corner_m, Eigen::Vector3d(part->corner_m + part->edge_u_m + part->edge_v_m),
          Eigen::Vector3d(part->corner_m + part->edge_u_m),
          Eigen::Vector3d(part->corner_m + part->edge_v_m)}) {
      const Eigen::Array2d at((p - corner).dot(u), (p - corner).dot(v));
      low = low.min(at);
      high = high.max(at);
    }
  }
  return {corner + low.x() * u + low.y() * v, (high.x() - low.x()) * u, (high.y() - low.y()) * v};
}

std::vector<SeenPlane> seenPlanes(const TrueCloud& cloud,
                                  const std::vector<sim::PlanarFace>& faces) {
  std::map<uint32_t, Points> places;
  for (const sim::TruePoint& point : cloud.points) {
    if (point.face != 0) places[faces[point.face - 1].plane].push_back(point.p_true_m);
  }
  std::map<uint32_t, std::vector<const Rectangle*>> parts;
  std::map<uint32_t, sim::Material> materials;
  for (const sim::PlanarFace& face : faces) {
    if (places.count(face.plane) == 0) continue;
    parts[face.plane].push_back(&face.rectangle);
    materials[face.plane] = face.material;
  }
  std::vector<SeenPlane> planes;
  for (auto& [plane, seen] : places) {
    SeenPlane result{plane, materials[plane], around(parts[plane]), std::move(seen)};
    result.rectangle.corner_m -= cloud.sensor_world;
    planes.push_back(std::move(result));
  }
  return planes;
}

/// Planes with the region of each that is judged: seen, and away from rims.
struct JudgedPlanes {
  std::vector<SeenPlane> planes;
  std::vector<std::vector<FaceRegion>> regions;
};

JudgedPlanes judgedPlanes(const TrueCloud& cloud, const std::vector<sim::PlanarFace>& faces,
                          double spacing_m) {
  const double per_m2 = 1.0 / (0.8 * spacing_m * spacing_m);
  JudgedPlanes judged;
  for (SeenPlane& plane : seenPlanes(cloud, faces)) {
    if (plane.rectangle.area() * per_m2 < kLeastExpected) continue;
    FaceRegion region(plane.rectangle, 0.125 * spacing_m);
    region.coverBy(plane.places, 0.5 * spacing_m, 1e-2);
    region.shrink(spacing_m);
    if (region.area() * per_m2 < kLeastExpected) continue;
    judged.regions.push_back({std::move(region)});
    judged.planes.push_back(std::move(plane));
  }
  return judged;
}

/// Distances from a plane of the points in its region whose own true place is in the plane, by
/// `face_of`.
template <typename FaceOf>
std::vector<double> planeErrors(const SeenPlane& plane, const FaceRegion& region,
                                const Points& positions, FaceOf&& face_of,
                                const std::vector<sim::PlanarFace>& faces) {
  constexpr double kAnyM = 1e3;
  std::vector<double> errors;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const uint32_t face = face_of(i);
    if (face == 0 || faces[face - 1].plane != plane.plane) continue;
    if (!region.contains(positions[i], kAnyM)) continue;
    const Rectangle& r = plane.rectangle;
    errors.push_back(std::abs((positions[i] - r.corner_m).dot(r.normal())));
  }
  return errors;
}

json surfaceErrors(const TrueCloud& cloud, const Points& positions) {
  constexpr double kFarM = 1.0;
  std::vector<double> errors;
  errors.reserve(positions.size());
  for (const Eigen::Vector3d& p : positions) {
    const sim::SurfacePoint nearest =
        cloud.world.scene.nearestSurface(p + cloud.sensor_world, kFarM);
    errors.push_back(nearest.valid() ? nearest.distance_m : kFarM);
  }
  return toJson(summarize(errors));
}

/// Density and errors of every judged plane, and the errors of all.
json judgePlanes(const TrueCloud& cloud, const ResampledCloud& samples, const Points& raw,
                 double spacing_m) {
  const std::vector<sim::PlanarFace> faces = cloud.world.scene.planarFaces();
  const JudgedPlanes judged = judgedPlanes(cloud, faces, spacing_m);
  const double off_plane_m = 3.0 * cloud.sensor.config.range_sigma_m + 0.1 * spacing_m;
  const auto densities = faceDensities(judged.regions, samples.positions_m, off_plane_m);
  const auto faceOfRaw = [&](std::size_t i) { return cloud.points[i].face; };
  const auto faceOfSample = [&](std::size_t i) { return cloud.points[samples.sources[i]].face; };
  std::vector<double> all_samples;
  std::vector<double> all_raw;
  json rows = json::array();
  for (std::size_t i = 0; i < densities.size(); ++i) {
    const SeenPlane& plane = judged.planes[i];
    const FaceRegion& region = judged.regions[i].front();
    const auto of_samples = planeErrors(plane, region, samples.positions_m, faceOfSample, faces);
    const auto of_raw = planeErrors(plane, region, raw, faceOfRaw, faces);
    all_samples.insert(all_samples.end(), of_samples.begin(), of_samples.end());
    all_raw.insert(all_raw.end(), of_raw.begin(), of_raw.end());
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : plane.places) middle += p;
    middle /= static_cast<double>(plane.places.size());
    rows.push_back({{"label", static_cast<int>(sim::propertiesOf(plane.material).label)},
                    {"distance_m", middle.norm()},
                    {"incidence", std::abs(middle.normalized().dot(plane.rectangle.normal()))},
                    {"area_m2", densities[i].area_m2},
                    {"samples", densities[i].samples},
                    {"raw_per_m2", static_cast<double>(of_raw.size()) / densities[i].area_m2},
                    {"per_m2", densities[i].perSquareMetre()},
                    {"relative", densities[i].relative},
                    {"error_samples_m", summarize(of_samples).mean},
                    {"error_raw_m", summarize(of_raw).mean}});
  }
  return {{"planes", rows},
          {"error_samples_m", toJson(summarize(all_samples))},
          {"error_raw_m", toJson(summarize(all_raw))}};
}

}  // namespace

TrueCloud::TrueCloud(const StandingSensor& standing)
    : sensor(standing),
      world(sim::makeWorld(standing.scene, standing.seed)),
      sensor_world(sim::placeBesideTrack(world, standing.at_m, standing.left_m, standing.height_m)),
      points(sim::takeTrueCloud(world.scene, sensor_world, standing.config, standing.seed)) {}

PoseCloudData TrueCloud::poseCloud(const std::vector<uint8_t>& class_of) const {
  PoseCloudData data;
  for (const sim::TruePoint& point : points) {
    data.positions_m.push_back(point.p_m);
    data.rgb.push_back(point.rgb);
    const auto label = static_cast<std::size_t>(point.label);
    if (!class_of.empty()) data.labels.push_back(label < class_of.size() ? class_of[label] : 0);
  }
  return data;
}

json qualityOf(const TrueCloud& cloud, const ResampledCloud& samples) {
  const SpacingStatistics spacing = spacingOf(samples.positions_m);
  Points raw;
  Points real;
  for (const sim::TruePoint& point : cloud.points) {
    raw.push_back(point.p_m);
    real.push_back(point.p_true_m);
  }
  const auto covering = [&](const Points& reference) {
    return coveringOf(samples.positions_m, reference, spacing.mean_m).p99_over_spacing;
  };
  return {{"points", raw.size()},
          {"samples", samples.size()},
          {"cells", samples.cells},
          {"components", samples.components},
          {"total_ms", samples.times_ms.total},
          {"spacing_m", spacing.mean_m},
          {"nn_cov", spacing.cov},
          {"min_over_mean", spacing.min_over_mean},
          {"isolated", spacing.isolated},
          {"connected_cov", spacing.connected_cov},
          {"connected_min_over_mean", spacing.connected_min_over_mean},
          {"cover_p99_raw", covering(raw)},
          {"cover_p99_true", covering(real)},
          {"range_sigma_m", cloud.sensor.config.range_sigma_m},
          {"error_samples_m", surfaceErrors(cloud, samples.positions_m)},
          {"error_raw_m", surfaceErrors(cloud, raw)},
          {"flat", judgePlanes(cloud, samples, raw, spacing.connected_mean_m)}};
}

}  // namespace ladar_perception::bench
