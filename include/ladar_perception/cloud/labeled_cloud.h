// SPDX-License-Identifier: BSD-3-Clause
// A copy of a cloud with label, confidence and class colour added to every point.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/cloud/cloud_layout.h"

namespace ladar_perception {

/// What is added to a point.
struct PointLabel {
  uint8_t label = 0;        ///< 0 is unknown, else 1 + index of the class in the model
  float confidence = 0.0F;  ///< posterior probability of the label, 0 for unknown
  uint32_t rgb = 0;         ///< colour of the class, 0x00RRGGBB
};

/// Layout of the copy: every field of the input at its own offset, then rgb (float32),
/// confidence (float32) and label (uint8). An input field that already has one of these names is
/// kept as `<name>_input`. Rows are packed.
CloudLayout labeledLayout(const CloudLayout& input);

/// Writes the copy: as many points as the input, in the same order and byte order.
/// `output` has pointCount() * point_step bytes of `labeledLayout(input.layout)`.
void writeLabeledCloud(const CloudView& input, const std::vector<PointLabel>& labels,
                       const CloudLayout& output_layout, std::vector<uint8_t>* output);

/// The field with the camera's colours, 4 bytes each, or nullptr: `rgb` or `rgba`, but `rgb_input`
/// of a labelled cloud (one with label and confidence), whose `rgb` tells the class.
const Field* cameraColorField(const CloudLayout& layout);

}  // namespace ladar_perception
