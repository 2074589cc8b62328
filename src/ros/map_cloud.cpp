// SPDX-License-Identifier: BSD-3-Clause
#include "map_cloud.h"

#include <algorithm>
#include <cstddef>

namespace ladar_perception {
namespace {

/// A sample as it lies in the cloud.
struct MapSample {
  float x, y, z;
  float normal_x, normal_y, normal_z;
  uint32_t rgb;
  uint32_t pose;
  uint8_t label;
  uint8_t padding[3];
};
static_assert(sizeof(MapSample) == 36, "no hidden padding");

struct Contents {
  std::size_t samples = 0;
  bool rgb = false;
  bool labels = false;
};

Contents contentsOf(const std::vector<StatePose>& poses, std::size_t samples_per_pose) {
  Contents contents;
  for (const StatePose& pose : poses) {
    if (!pose.samples) continue;
    contents.samples += std::min(pose.samples->size(), samples_per_pose);
    contents.rgb = contents.rgb || !pose.samples->rgb.empty();
    contents.labels = contents.labels || !pose.samples->labels.empty();
  }
  return contents;
}

CloudLayout layoutFor(const Contents& contents) {
  CloudLayout layout;
  for (const char* name : {"x", "y", "z", "normal_x", "normal_y", "normal_z"}) {
    layout.append(name, ScalarType::kFloat32);
  }
  const auto add = [&](const char* name, std::size_t offset, ScalarType type) {
    layout.fields.push_back({name, static_cast<uint32_t>(offset), type, 1});
  };
  if (contents.rgb) add("rgb", offsetof(MapSample, rgb), ScalarType::kUint32);
  add("pose", offsetof(MapSample, pose), ScalarType::kUint32);
  if (contents.labels) add("label", offsetof(MapSample, label), ScalarType::kUint8);
  layout.big_endian = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;
  layout.point_step = sizeof(MapSample);
  layout.width = static_cast<uint32_t>(contents.samples);
  layout.pack();
  return layout;
}

MapSample mapSample(const PoseSamples& samples, std::size_t i, const Eigen::Isometry3d& T,
                    uint32_t pose) {
  const Eigen::Vector3f p = (T * samples.positions_m[i].cast<double>()).cast<float>();
  const Eigen::Vector3f n = T.linear().cast<float>() * samples.normals[i];
  return {p.x(),
          p.y(),
          p.z(),
          n.x(),
          n.y(),
          n.z(),
          samples.rgb.empty() ? 0 : samples.rgb[i],
          pose,
          samples.labels.empty() ? uint8_t{0} : samples.labels[i],
          {}};
}

}  // namespace

MapCloud makeMapCloud(const std::vector<StatePose>& poses, const PoseGraph& graph,
                      std::size_t samples_per_pose) {
  const std::size_t most = samples_per_pose > 0 ? samples_per_pose : SIZE_MAX;
  const Contents contents = contentsOf(poses, most);
  MapCloud cloud{layoutFor(contents), {}};
  cloud.bytes.reserve(contents.samples * sizeof(MapSample));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i].samples) continue;
    const PoseSamples& samples = *poses[i].samples;
    const Eigen::Isometry3d& T_map_pose = graph.pose(static_cast<int>(i));
    for (std::size_t k = 0; k < std::min(samples.size(), most); ++k) {
      const MapSample sample = mapSample(samples, k, T_map_pose, static_cast<uint32_t>(i));
      const auto* bytes = reinterpret_cast<const uint8_t*>(&sample);
      cloud.bytes.insert(cloud.bytes.end(), bytes, bytes + sizeof(sample));
    }
  }
  return cloud;
}

}  // namespace ladar_perception
