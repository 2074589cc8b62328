// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_message.h"

#include <boost/make_shared.hpp>
#include <cstring>
#include <limits>

namespace ladar_perception {
namespace {

/// A point of the labelled map as it lies in the message.
struct MapPoint {
  float x, y, z;
  uint32_t rgb;
  float confidence;
  float scatter, surface, linear;
  float normal_x, normal_y, normal_z;
  uint32_t points;
  uint8_t label;
  uint8_t padding[3];
};
static_assert(sizeof(MapPoint) == 52, "no hidden padding");

CloudLayout mapLayout() {
  CloudLayout layout;
  for (const char* name : {"x", "y", "z", "rgb", "confidence", "scatter", "surface", "linear",
                           "normal_x", "normal_y", "normal_z"}) {
    layout.append(name, ScalarType::kFloat32);
  }
  layout.append("points", ScalarType::kUint32);
  layout.append("label", ScalarType::kUint8);
  layout.point_step = sizeof(MapPoint);
  layout.big_endian = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;
  return layout;
}

MapPoint mapPoint(const Eigen::Vector3d& p_map, uint32_t points, const SaliencyF& saliency,
                  const Classification& classification, const ClassifierModel& model) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  MapPoint out{};
  out.x = static_cast<float>(p_map.x());
  out.y = static_cast<float>(p_map.y());
  out.z = static_cast<float>(p_map.z());
  out.rgb = model.labelColor(classification.label);
  out.confidence = classification.confidence;
  const auto known = [&](float value) { return saliency.defined ? value : kNaN; };
  out.scatter = known(saliency.scatter);
  out.surface = known(saliency.surface);
  out.linear = known(saliency.linear);
  out.normal_x = known(saliency.normal.x());
  out.normal_y = known(saliency.normal.y());
  out.normal_z = known(saliency.normal.z());
  out.points = points;
  out.label = classification.label;
  return out;
}

/// Mean of a voxel's own points.
Eigen::Vector3d centroid(const Moments& moments, const VoxelIndex& voxel, double step_m) {
  const FixedPoint center = centerOf(voxel);
  const CenteredMoments m = moments.about(center);
  const double n = static_cast<double>(m.n);
  // Half a step: quantising took the lower end of every step.
  return {(static_cast<double>(center.x) + static_cast<double>(m.x) / n + 0.5) * step_m,
          (static_cast<double>(center.y) + static_cast<double>(m.y) / n + 0.5) * step_m,
          (static_cast<double>(center.z) + static_cast<double>(m.z) / n + 0.5) * step_m};
}

}  // namespace

CloudLayout layoutOf(const sensor_msgs::PointCloud2& cloud) {
  CloudLayout layout;
  layout.width = cloud.width;
  layout.height = cloud.height;
  layout.point_step = cloud.point_step;
  layout.row_step = cloud.row_step;
  layout.big_endian = cloud.is_bigendian != 0;
  layout.fields.reserve(cloud.fields.size());
  for (const auto& field : cloud.fields) {
    layout.fields.push_back(
        {field.name, field.offset, static_cast<ScalarType>(field.datatype), field.count});
  }
  return layout;
}

void setLayout(const CloudLayout& layout, sensor_msgs::PointCloud2* cloud) {
  cloud->width = layout.width;
  cloud->height = layout.height;
  cloud->point_step = layout.point_step;
  cloud->row_step = layout.row_step;
  cloud->is_bigendian = layout.big_endian;
  cloud->fields.clear();
  cloud->fields.reserve(layout.fields.size());
  for (const Field& field : layout.fields) {
    sensor_msgs::PointField out;
    out.name = field.name;
    out.offset = field.offset;
    out.datatype = static_cast<uint8_t>(field.type);
    out.count = field.count;
    cloud->fields.push_back(out);
  }
}

sensor_msgs::PointCloud2Ptr makeLabeledPoints(const sensor_msgs::PointCloud2& scan,
                                              const CloudLayout& scan_layout,
                                              const TerrainPipeline& pipeline) {
  auto message = boost::make_shared<sensor_msgs::PointCloud2>();
  message->header = scan.header;
  const CloudLayout layout = labeledLayout(scan_layout);
  setLayout(layout, message.get());
  const auto not_finite = pipeline.report().dropped[static_cast<int>(PointDrop::kNotFinite)];
  message->is_dense = not_finite == 0;
  writeLabeledCloud({scan_layout, scan.data.data(), scan.data.size()}, pipeline.pointLabels(),
                    layout, &message->data);
  return message;
}

sensor_msgs::PointCloud2Ptr makeLabeledMap(const TerrainPipeline& pipeline,
                                           const std_msgs::Header& header,
                                           const Eigen::Vector3d& p_map_vehicle, double radius_m) {
  const VoxelMap& map = pipeline.map();
  const double step_m = pipeline.config().voxel_size_m / static_cast<double>(kStepsPerVoxel);
  auto message = boost::make_shared<sensor_msgs::PointCloud2>();
  message->header = header;
  message->data.reserve(map.occupied() * sizeof(MapPoint));
  bool dense = true;
  map.forEachVoxel([&](const VoxelIndex& voxel, std::size_t slot) {
    const Moments& record = map.record(slot);
    const Eigen::Vector3d p_map = centroid(record, voxel, step_m);
    if ((p_map - p_map_vehicle).head<2>().squaredNorm() > radius_m * radius_m) return;
    const SaliencyF& saliency = pipeline.saliency(slot);
    dense = dense && saliency.defined;
    const MapPoint point =
        mapPoint(p_map, record.count(), saliency, pipeline.classification(slot), pipeline.model());
    const auto* bytes = reinterpret_cast<const uint8_t*>(&point);
    message->data.insert(message->data.end(), bytes, bytes + sizeof(point));
  });
  CloudLayout layout = mapLayout();
  layout.width = static_cast<uint32_t>(message->data.size() / sizeof(MapPoint));
  layout.pack();
  setLayout(layout, message.get());
  // is_dense speaks of positions, which are all finite; NaN in other fields is not meant by it,
  // but readers exist that take it so.
  message->is_dense = dense;
  return message;
}

}  // namespace ladar_perception
