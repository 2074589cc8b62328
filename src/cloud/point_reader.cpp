// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/cloud/point_reader.h"

#include <cmath>

#include "byte_order.h"

namespace ladar_perception {
namespace {

// Offsets beyond these cannot be relative to a stamp: a driver wrote absolute times.
constexpr double kAbsoluteSecondsFrom = 1e6;
constexpr double kAbsoluteNanosecondsFrom = 1e12;

template <typename Source, typename Out>
void gatherAs(const CloudView& cloud, uint32_t offset, Out* out, std::size_t stride) {
  const bool swap = cloud.layout.big_endian != kHostIsBigEndian;
  for (std::size_t row = 0; row < cloud.layout.height; ++row) {
    const uint8_t* bytes = cloud.point(row, 0) + offset;
    for (std::size_t col = 0; col < cloud.layout.width; ++col) {
      *out = static_cast<Out>(loadScalar<Source>(bytes, swap));
      out += stride;
      bytes += cloud.layout.point_step;
    }
  }
}

// The type is looked at once per column of the cloud, never per point.
template <typename Out>
void gather(const CloudView& cloud, const Field& field, Out* out, std::size_t stride) {
  switch (field.type) {
    case ScalarType::kInt8:
      return gatherAs<int8_t>(cloud, field.offset, out, stride);
    case ScalarType::kUint8:
      return gatherAs<uint8_t>(cloud, field.offset, out, stride);
    case ScalarType::kInt16:
      return gatherAs<int16_t>(cloud, field.offset, out, stride);
    case ScalarType::kUint16:
      return gatherAs<uint16_t>(cloud, field.offset, out, stride);
    case ScalarType::kInt32:
      return gatherAs<int32_t>(cloud, field.offset, out, stride);
    case ScalarType::kUint32:
      return gatherAs<uint32_t>(cloud, field.offset, out, stride);
    case ScalarType::kFloat32:
      return gatherAs<float>(cloud, field.offset, out, stride);
    case ScalarType::kFloat64:
      return gatherAs<double>(cloud, field.offset, out, stride);
  }
}

/// x, y and z as most drivers send them, in one pass.
void gatherFloats(const CloudView& cloud, const PointFields& fields, double* out) {
  for (std::size_t row = 0; row < cloud.layout.height; ++row) {
    const uint8_t* bytes = cloud.point(row, 0);
    for (std::size_t col = 0; col < cloud.layout.width; ++col) {
      *out++ = static_cast<double>(loadScalar<float>(bytes + fields.x.offset, false));
      *out++ = static_cast<double>(loadScalar<float>(bytes + fields.y.offset, false));
      *out++ = static_cast<double>(loadScalar<float>(bytes + fields.z.offset, false));
      bytes += cloud.layout.point_step;
    }
  }
}

bool isFloat(ScalarType type) {
  return type == ScalarType::kFloat32 || type == ScalarType::kFloat64;
}

std::optional<Field> findFirst(const CloudLayout& layout,
                               std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (const Field* field = layout.find(name)) return *field;
  }
  return std::nullopt;
}

double offsetFromStamp(double value, bool is_float, double stamp_s) {
  if (!is_float) return value * 1e-9;
  if (std::abs(value) < kAbsoluteSecondsFrom) return value;
  if (std::abs(value) < kAbsoluteNanosecondsFrom) return value - stamp_s;
  return value * 1e-9 - stamp_s;
}

}  // namespace

std::optional<PointFields> findPointFields(const CloudView& cloud, std::string* error) {
  const CloudLayout& layout = cloud.layout;
  for (const char* name : {"x", "y", "z"}) {
    if (layout.find(name) == nullptr) {
      *error = std::string("field '") + name + "' is missing, expected numeric x, y and z; " +
               "fields present: " + layout.describeFields();
      return std::nullopt;
    }
  }
  *error = layoutError(cloud);
  if (!error->empty()) return std::nullopt;
  PointFields fields;
  fields.x = *layout.find("x");
  fields.y = *layout.find("y");
  fields.z = *layout.find("z");
  fields.time =
      findFirst(layout, {"time", "t", "timestamp", "time_stamp", "offset_time", "time_offset"});
  fields.color = findFirst(layout, {"rgb", "rgba"});
  if (fields.color && scalarSize(fields.color->type) != 4) fields.color.reset();
  return fields;
}

void readPositions(const CloudView& cloud, const PointFields& fields,
                   std::vector<Eigen::Vector3d>* positions_m) {
  positions_m->resize(cloud.layout.pointCount());
  if (positions_m->empty()) return;
  double* first = positions_m->front().data();
  const auto isPlain = [&](const Field& field) { return field.type == ScalarType::kFloat32; };
  if (isPlain(fields.x) && isPlain(fields.y) && isPlain(fields.z) &&
      cloud.layout.big_endian == kHostIsBigEndian) {
    gatherFloats(cloud, fields, first);
    return;
  }
  gather(cloud, fields.x, first, 3);
  gather(cloud, fields.y, first + 1, 3);
  gather(cloud, fields.z, first + 2, 3);
}

bool readTimeOffsets(const CloudView& cloud, const Field& time, double stamp_s, double max_offset_s,
                     std::vector<float>* offsets_s) {
  std::vector<double> values;
  readScalars(cloud, time, &values);
  offsets_s->resize(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double offset_s = offsetFromStamp(values[i], isFloat(time.type), stamp_s);
    if (!(std::abs(offset_s) <= max_offset_s)) {
      offsets_s->clear();
      return false;
    }
    (*offsets_s)[i] = static_cast<float>(offset_s);
  }
  return true;
}

void readColors(const CloudView& cloud, const Field& color, std::vector<uint32_t>* rgb) {
  rgb->resize(cloud.layout.pointCount());
  if (rgb->empty()) return;
  // A float32 colour is its bits, never its value.
  gatherAs<uint32_t>(cloud, color.offset, rgb->data(), 1);
  for (uint32_t& value : *rgb) value &= 0x00ffffffU;
}

void readScalars(const CloudView& cloud, const Field& field, std::vector<double>* values) {
  values->resize(cloud.layout.pointCount());
  if (!values->empty()) gather(cloud, field, values->data(), 1);
}

}  // namespace ladar_perception
