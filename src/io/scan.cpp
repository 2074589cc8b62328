// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/io/scan.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace ladar_perception {
namespace {

template <typename T>
void storeAs(uint8_t* at, double value) {
  const T scalar = static_cast<T>(value);
  std::memcpy(at, &scalar, sizeof(T));
}

void storeScalar(uint8_t* at, ScalarType type, double value) {
  switch (type) {
    case ScalarType::kInt8:
      return storeAs<int8_t>(at, value);
    case ScalarType::kUint8:
      return storeAs<uint8_t>(at, value);
    case ScalarType::kInt16:
      return storeAs<int16_t>(at, value);
    case ScalarType::kUint16:
      return storeAs<uint16_t>(at, value);
    case ScalarType::kInt32:
      return storeAs<int32_t>(at, value);
    case ScalarType::kUint32:
      return storeAs<uint32_t>(at, value);
    case ScalarType::kFloat32:
      return storeAs<float>(at, value);
    case ScalarType::kFloat64:
      return storeAs<double>(at, value);
  }
}

template <typename T>
double loadAs(const uint8_t* at) {
  T scalar;
  std::memcpy(&scalar, at, sizeof(T));
  return static_cast<double>(scalar);
}

double loadScalar(const uint8_t* at, ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
      return loadAs<int8_t>(at);
    case ScalarType::kUint8:
      return loadAs<uint8_t>(at);
    case ScalarType::kInt16:
      return loadAs<int16_t>(at);
    case ScalarType::kUint16:
      return loadAs<uint16_t>(at);
    case ScalarType::kInt32:
      return loadAs<int32_t>(at);
    case ScalarType::kUint32:
      return loadAs<uint32_t>(at);
    case ScalarType::kFloat32:
      return loadAs<float>(at);
    case ScalarType::kFloat64:
      return loadAs<double>(at);
  }
  return std::nan("");
}

std::size_t byteOf(const CloudLayout& layout, std::size_t point) {
  return (point / layout.width) * layout.row_step + (point % layout.width) * layout.point_step;
}

const Field& expectField(const Scan& scan, const std::string& name) {
  const Field* field = scan.layout.find(name);
  if (field != nullptr) return *field;
  throw std::runtime_error("no field '" + name + "' (fields: " + scan.layout.describeFields() +
                           ")");
}

double valueAt(const Scan& scan, const Field& field, std::size_t point) {
  return loadScalar(scan.data.data() + byteOf(scan.layout, point) + field.offset, field.type);
}

void storeColumn(Scan& scan, const Field& field, const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    storeScalar(scan.data.data() + byteOf(scan.layout, i) + field.offset, field.type, values[i]);
  }
}

double worstFloatError(const std::vector<double>& values) {
  double worst = 0.0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    worst = std::max(worst, std::abs(value - static_cast<double>(static_cast<float>(value))));
  }
  return worst;
}

}  // namespace

Scan makeScan(const std::vector<Column>& columns) {
  assert(!columns.empty());
  Scan scan;
  scan.layout.width = static_cast<uint32_t>(columns.front().values.size());
  for (const Column& column : columns) {
    assert(column.values.size() == columns.front().values.size());
    scan.layout.append(column.name, column.type);
  }
  scan.layout.pack();
  scan.data.resize(scan.layout.pointCount() * scan.layout.point_step);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    storeColumn(scan, scan.layout.fields[c], columns[c].values);
  }
  updateIsDense(scan);
  return scan;
}

void addColumn(Scan& scan, const Column& column) {
  assert(column.values.size() == scan.size());
  if (scan.layout.find(column.name) != nullptr) {
    throw std::runtime_error("the scan already has a field '" + column.name +
                             "' (fields: " + scan.layout.describeFields() + ")");
  }
  Scan wider;
  wider.layout = scan.layout;
  wider.layout.append(column.name, column.type);
  wider.layout.pack();
  wider.is_dense = scan.is_dense;
  wider.data.resize(scan.size() * wider.layout.point_step);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    std::memcpy(wider.data.data() + byteOf(wider.layout, i),
                scan.data.data() + byteOf(scan.layout, i), scan.layout.point_step);
  }
  storeColumn(wider, wider.layout.fields.back(), column.values);
  scan = std::move(wider);
}

std::vector<double> readColumn(const Scan& scan, const std::string& name) {
  const Field& field = expectField(scan, name);
  std::vector<double> values(scan.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = valueAt(scan, field, i);
  return values;
}

std::vector<double> readColumn(const Scan& scan, const std::string& name,
                               const std::vector<std::size_t>& points) {
  const Field& field = expectField(scan, name);
  std::vector<double> values;
  values.reserve(points.size());
  for (const std::size_t i : points) values.push_back(valueAt(scan, field, i));
  return values;
}

void updateIsDense(Scan& scan) {
  scan.is_dense = true;
  for (const char* axis : {"x", "y", "z"}) {
    for (const double value : readColumn(scan, axis)) {
      if (std::isfinite(value)) continue;
      scan.is_dense = false;
      return;
    }
  }
}

ScalarType positionType(const std::vector<double>& x, const std::vector<double>& y,
                        const std::vector<double>& z) {
  constexpr double kMaxErrorM = 1e-3;
  const double worst = std::max({worstFloatError(x), worstFloatError(y), worstFloatError(z)});
  return worst > kMaxErrorM ? ScalarType::kFloat64 : ScalarType::kFloat32;
}

ScalarType attributeType(const std::vector<double>& values) {
  constexpr double kMaxError = 1e-5;
  return worstFloatError(values) > kMaxError ? ScalarType::kFloat64 : ScalarType::kFloat32;
}

}  // namespace ladar_perception
