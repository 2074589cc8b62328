// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/cloud/labeled_cloud.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "byte_order.h"

namespace ladar_perception {
namespace {

constexpr const char* kAddedFields[] = {"rgb", "confidence", "label"};

/// memcpy, without the call for the few bytes of a point.
void copyBytes(const uint8_t* in, std::size_t size, uint8_t* out) {
  for (; size >= sizeof(uint64_t); size -= sizeof(uint64_t)) {
    std::memcpy(out, in, sizeof(uint64_t));
    in += sizeof(uint64_t);
    out += sizeof(uint64_t);
  }
  for (; size > 0; --size) *out++ = *in++;
}

}  // namespace

CloudLayout labeledLayout(const CloudLayout& input) {
  CloudLayout output = input;
  for (const char* name : kAddedFields) output.makeWay(name);
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
  const std::size_t step = output_layout.point_step;
  // Points are put together in a small buffer and appended: to size the output first would fill all
  // of it with zeros that are then written over.
  constexpr std::size_t kPoints = 128;
  std::vector<uint8_t> buffer(kPoints * step, 0);
  output->clear();
  output->reserve(labels.size() * step);
  const PointLabel* point_label = labels.data();
  for (std::size_t row = 0; row < input.layout.height; ++row) {
    for (std::size_t col = 0; col < input.layout.width; col += kPoints) {
      const std::size_t count = std::min<std::size_t>(kPoints, input.layout.width - col);
      const uint8_t* in = input.point(row, col);
      uint8_t* out = buffer.data();
      for (std::size_t i = 0; i < count; ++i, ++point_label) {
        copyBytes(in, input.layout.point_step, out);
        storeScalar(point_label->rgb, swap, out + rgb_offset);
        storeScalar(point_label->confidence, swap, out + confidence_offset);
        out[label_offset] = point_label->label;
        in += input.layout.point_step;
        out += step;
      }
      output->insert(output->end(), buffer.data(), out);
    }
  }
}

const Field* cameraColorField(const CloudLayout& layout) {
  const bool labeled = layout.find("label") != nullptr && layout.find("confidence") != nullptr;
  const auto names = labeled ? std::vector<const char*>{"rgb_input", "rgba"}
                             : std::vector<const char*>{"rgb", "rgba"};
  for (const char* name : names) {
    const Field* field = layout.find(name);
    if (field != nullptr && scalarSize(field->type) == 4) return field;
  }
  return nullptr;
}

}  // namespace ladar_perception
