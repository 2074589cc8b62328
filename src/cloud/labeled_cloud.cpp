// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/cloud/labeled_cloud.h"

#include <cassert>
#include <cstring>

#include "byte_order.h"

namespace ladar_perception {
namespace {

constexpr const char* kAddedFields[] = {"rgb", "confidence", "label"};

/// A name for a field that makes way for ours, itself not in use yet.
std::string nameMadeWay(const CloudLayout& layout, const std::string& name) {
  std::string free_name = name + "_input";
  while (layout.find(free_name) != nullptr) free_name += "_input";
  return free_name;
}

}  // namespace

CloudLayout labeledLayout(const CloudLayout& input) {
  CloudLayout output = input;
  for (const char* name : kAddedFields) {
    for (Field& field : output.fields) {
      if (field.name == name) field.name = nameMadeWay(output, name);
    }
  }
  output.append("rgb", ScalarType::kFloat32);
  output.append("confidence", ScalarType::kFloat32);
  output.append("label", ScalarType::kUint8);
  output.point_step = (output.point_step + 3) / 4 * 4;
  output.pack();
  return output;
}

void writeLabeledCloud(const CloudView& input, const std::vector<PointLabel>& labels,
                       const CloudLayout& output_layout, std::vector<uint8_t>* output) {
  assert(labels.size() == input.layout.pointCount());
  const bool swap = input.layout.big_endian != kHostIsBigEndian;
  const uint32_t rgb_offset = output_layout.find("rgb")->offset;
  const uint32_t confidence_offset = output_layout.find("confidence")->offset;
  const uint32_t label_offset = output_layout.find("label")->offset;
  output->assign(labels.size() * output_layout.point_step, 0);
  uint8_t* out = output->data();
  const PointLabel* point_label = labels.data();
  for (std::size_t row = 0; row < input.layout.height; ++row) {
    for (std::size_t col = 0; col < input.layout.width; ++col) {
      std::memcpy(out, input.point(row, col), input.layout.point_step);
      storeScalar(point_label->rgb, swap, out + rgb_offset);
      storeScalar(point_label->confidence, swap, out + confidence_offset);
      out[label_offset] = point_label->label;
      out += output_layout.point_step;
      ++point_label;
    }
  }
}

}  // namespace ladar_perception
