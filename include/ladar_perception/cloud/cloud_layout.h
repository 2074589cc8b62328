// SPDX-License-Identifier: BSD-3-Clause
// Description of a point cloud held as raw bytes: the same field table a sensor_msgs/PointCloud2
// carries, without depending on ROS.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace ladar_perception {

/// Scalar type of a field; the values are those of sensor_msgs/PointField.
enum class ScalarType : uint8_t {
  kInt8 = 1,
  kUint8 = 2,
  kInt16 = 3,
  kUint16 = 4,
  kInt32 = 5,
  kUint32 = 6,
  kFloat32 = 7,
  kFloat64 = 8,
};

/// Bytes of one scalar, or 0 if `type` is none of the enumerators (fields come from outside).
std::size_t scalarSize(ScalarType type);
/// "float32", "uint8", ...; "invalid(<n>)" for anything else.
std::string scalarName(ScalarType type);

/// One named column of a cloud.
struct Field {
  std::string name;
  uint32_t offset = 0;  ///< bytes from the start of a point
  ScalarType type = ScalarType::kFloat32;
  uint32_t count = 1;  ///< scalars in the field; drivers that write 0 mean 1
};

/// Shape and field table of a cloud: `height` rows of `width` points.
struct CloudLayout {
  uint32_t width = 0;
  uint32_t height = 1;
  uint32_t point_step = 0;  ///< bytes from a point to the next in its row
  uint32_t row_step = 0;    ///< bytes from a row to the next; padding is allowed
  bool big_endian = false;
  std::vector<Field> fields;

  std::size_t pointCount() const { return std::size_t{width} * height; }
  /// The field of that name, or nullptr.
  const Field* find(const std::string& name) const;
  /// "x:float32, y:float32, intensity:uint8", for messages to people.
  std::string describeFields() const;
  /// Appends a field at the next offset aligned to its own size and enlarges point_step.
  /// Does not touch row_step: call `pack()` when all fields are in.
  Field& append(const std::string& name, ScalarType type);
  /// Renames fields of that name to `<name>_input` (and once more while that is taken), so that one
  /// of ours can be appended under it.
  void makeWay(const std::string& name);
  /// Sets the row step of a cloud without padding between rows.
  void pack() { row_step = width * point_step; }
};

/// A cloud's bytes with their layout; owns neither.
struct CloudView {
  const CloudLayout& layout;
  const uint8_t* data = nullptr;
  std::size_t size = 0;  ///< bytes

  const uint8_t* point(std::size_t row, std::size_t col) const {
    return data + row * layout.row_step + col * layout.point_step;
  }
};

/// Why the bytes cannot be read with this layout, or "" if they can: every field lies inside the
/// point, rows do not overlap, and all points lie inside the buffer.
std::string layoutError(const CloudView& cloud);

}  // namespace ladar_perception
