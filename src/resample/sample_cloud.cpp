// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/sample_cloud.h"

#include <cassert>
#include <cstring>

#include "../cloud/byte_order.h"

namespace ladar_perception {
namespace {

constexpr const char* kAxes[] = {"x", "y", "z"};
constexpr const char* kNormals[] = {"normal_x", "normal_y", "normal_z"};
constexpr const char* kCoveringRadius = "covering_radius";

bool isFloat(const Field& field) {
  return field.type == ScalarType::kFloat32 || field.type == ScalarType::kFloat64;
}

void appendFloat(CloudLayout* layout, const char* name) {
  layout->makeWay(name);
  layout->append(name, ScalarType::kFloat32);
}

/// Writes what a sample has besides its original's fields.
class SampleWriter {
 public:
  explicit SampleWriter(const CloudLayout& layout) : swap_(layout.big_endian != kHostIsBigEndian) {
    for (const char* name : kAxes) axes_.push_back(*layout.find(name));
    for (const char* name : kNormals) normals_.push_back(*layout.find(name));
    covering_radius_ = *layout.find(kCoveringRadius);
  }

  void write(const ResampledCloud& samples, std::size_t i, uint8_t* point) const {
    for (int axis = 0; axis < 3; ++axis) {
      put(axes_[axis], samples.positions_m[i][axis], point);
      put(normals_[axis], static_cast<double>(samples.normals[i][axis]), point);
    }
    put(covering_radius_, static_cast<double>(samples.covering_radii[i]), point);
  }

 private:
  void put(const Field& field, double value, uint8_t* point) const {
    if (field.type == ScalarType::kFloat64) {
      storeScalar(value, swap_, point + field.offset);
    } else {
      storeScalar(static_cast<float>(value), swap_, point + field.offset);
    }
  }

  bool swap_;
  std::vector<Field> axes_;
  std::vector<Field> normals_;
  Field covering_radius_;
};

}  // namespace

CloudLayout sampleLayout(const CloudLayout& input) {
  CloudLayout output = input;
  for (const char* name : kAxes) {
    const Field* axis = output.find(name);
    if (axis == nullptr || !isFloat(*axis)) appendFloat(&output, name);
  }
  for (const char* name : kNormals) appendFloat(&output, name);
  appendFloat(&output, kCoveringRadius);
  output.point_step = (output.point_step + 3) / 4 * 4;
  output.width = 0;
  output.height = 1;
  output.pack();
  return output;
}

void writeSampleCloud(const CloudView& originals, const ResampledCloud& samples,
                      CloudLayout* layout, std::vector<uint8_t>* bytes) {
  layout->width = static_cast<uint32_t>(samples.size());
  layout->height = 1;
  layout->pack();
  bytes->assign(samples.size() * layout->point_step, 0);
  const SampleWriter writer(*layout);
  const uint32_t columns = originals.layout.width;
  uint8_t* point = bytes->data();
  for (std::size_t i = 0; i < samples.size(); ++i, point += layout->point_step) {
    const uint32_t source = samples.sources[i];
    assert(source < originals.layout.pointCount());
    std::memcpy(point, originals.point(source / columns, source % columns),
                originals.layout.point_step);
    writer.write(samples, i, point);
  }
}

}  // namespace ladar_perception
