// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/cloud/cloud_layout.h"

#include <algorithm>

namespace ladar_perception {

std::size_t scalarSize(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
    case ScalarType::kUint8:
      return 1;
    case ScalarType::kInt16:
    case ScalarType::kUint16:
      return 2;
    case ScalarType::kInt32:
    case ScalarType::kUint32:
    case ScalarType::kFloat32:
      return 4;
    case ScalarType::kFloat64:
      return 8;
  }
  return 0;
}

std::string scalarName(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
      return "int8";
    case ScalarType::kUint8:
      return "uint8";
    case ScalarType::kInt16:
      return "int16";
    case ScalarType::kUint16:
      return "uint16";
    case ScalarType::kInt32:
      return "int32";
    case ScalarType::kUint32:
      return "uint32";
    case ScalarType::kFloat32:
      return "float32";
    case ScalarType::kFloat64:
      return "float64";
  }
  return "invalid(" + std::to_string(static_cast<int>(type)) + ")";
}

const Field* CloudLayout::find(const std::string& name) const {
  const auto it = std::find_if(fields.begin(), fields.end(),
                               [&](const Field& field) { return field.name == name; });
  return it == fields.end() ? nullptr : &*it;
}

std::string CloudLayout::describeFields() const {
  std::string text;
  for (const Field& field : fields) {
    text += (text.empty() ? "" : ", ") + field.name + ":" + scalarName(field.type);
    if (field.count > 1) text += "[" + std::to_string(field.count) + "]";
  }
  return text.empty() ? "none" : text;
}

Field& CloudLayout::append(const std::string& name, ScalarType type) {
  const auto size = static_cast<uint32_t>(scalarSize(type));
  const uint32_t offset = (point_step + size - 1) / size * size;
  point_step = offset + size;
  fields.push_back({name, offset, type, 1});
  return fields.back();
}

void CloudLayout::makeWay(const std::string& name) {
  for (Field& field : fields) {
    if (field.name != name) continue;
    std::string free_name = name + "_input";
    while (find(free_name) != nullptr) free_name += "_input";
    field.name = free_name;
  }
}

std::string layoutError(const CloudView& cloud) {
  const CloudLayout& layout = cloud.layout;
  if (layout.pointCount() == 0) return "";
  for (const Field& field : layout.fields) {
    const std::size_t size = scalarSize(field.type);
    if (size == 0) {
      return "field '" + field.name + "' has the unknown datatype " +
             std::to_string(static_cast<int>(field.type)) + ", expected 1 to 8";
    }
    const std::size_t end = field.offset + size * std::max<std::size_t>(field.count, 1);
    if (end > layout.point_step) {
      return "field '" + field.name + "' ends at byte " + std::to_string(end) +
             " of a point of " + std::to_string(layout.point_step) + " bytes";
    }
  }
  if (layout.point_step == 0) return "point_step is 0";
  const std::size_t row_bytes = std::size_t{layout.width} * layout.point_step;
  if (layout.height > 1 && layout.row_step < row_bytes) {
    return "row_step is " + std::to_string(layout.row_step) + ", expected at least width x " +
           "point_step = " + std::to_string(row_bytes);
  }
  const std::size_t needed = std::size_t{layout.height - 1} * layout.row_step + row_bytes;
  if (cloud.size < needed) {
    return "data has " + std::to_string(cloud.size) + " bytes, expected at least " +
           std::to_string(needed) + " for " + std::to_string(layout.width) + " x " +
           std::to_string(layout.height) + " points";
  }
  return "";
}

}  // namespace ladar_perception
