// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "ladar_perception/cloud/cloud_layout.h"

namespace ladar_perception::test {

/// A cloud written byte by byte, without the package's own code for scalars.
class CloudBuilder {
 public:
  CloudLayout layout;
  std::vector<uint8_t> bytes;

  CloudView view() const { return {layout, bytes.data(), bytes.size()}; }
  /// Makes room for all rows; every byte that no field writes is `filler`.
  void allocate(uint8_t filler = 0xA5) {
    bytes.assign(std::size_t{layout.height} * layout.row_step, filler);
  }

  /// Writes a number into element `element` of a field, rounded to the field's type.
  void set(std::size_t row, std::size_t col, const std::string& name, double value,
           std::size_t element = 0) {
    const Field& field = *layout.find(name);
    switch (field.type) {
      case ScalarType::kInt8:
        return put<int8_t>(row, col, field, element, static_cast<int8_t>(value));
      case ScalarType::kUint8:
        return put<uint8_t>(row, col, field, element, static_cast<uint8_t>(value));
      case ScalarType::kInt16:
        return put<int16_t>(row, col, field, element, static_cast<int16_t>(value));
      case ScalarType::kUint16:
        return put<uint16_t>(row, col, field, element, static_cast<uint16_t>(value));
      case ScalarType::kInt32:
        return put<int32_t>(row, col, field, element, static_cast<int32_t>(value));
      case ScalarType::kUint32:
        return put<uint32_t>(row, col, field, element, static_cast<uint32_t>(value));
      case ScalarType::kFloat32:
        return put<float>(row, col, field, element, static_cast<float>(value));
      case ScalarType::kFloat64:
        return put<double>(row, col, field, element, value);
    }
  }
  /// Writes four bytes as they are, for colours in a float32 field.
  void setBits(std::size_t row, std::size_t col, const std::string& name, uint32_t bits) {
    put<uint32_t>(row, col, *layout.find(name), 0, bits);
  }

 private:
  template <typename T>
  void put(std::size_t row, std::size_t col, const Field& field, std::size_t element, T value) {
    uint8_t* out = bytes.data() + row * layout.row_step + col * layout.point_step + field.offset +
                   element * sizeof(T);
    std::memcpy(out, &value, sizeof(T));
    const uint16_t probe = 1;
    const bool host_is_big = *reinterpret_cast<const uint8_t*>(&probe) == 0;
    if (host_is_big != layout.big_endian) std::reverse(out, out + sizeof(T));
  }
};

/// An unorganised cloud of float32 x, y, z.
inline CloudBuilder xyzCloud(const std::vector<Eigen::Vector3d>& points) {
  CloudBuilder cloud;
  for (const char* name : {"x", "y", "z"}) cloud.layout.append(name, ScalarType::kFloat32);
  cloud.layout.width = static_cast<uint32_t>(points.size());
  cloud.layout.pack();
  cloud.allocate();
  for (std::size_t i = 0; i < points.size(); ++i) {
    cloud.set(0, i, "x", points[i].x());
    cloud.set(0, i, "y", points[i].y());
    cloud.set(0, i, "z", points[i].z());
  }
  return cloud;
}

}  // namespace ladar_perception::test
