// SPDX-License-Identifier: BSD-3-Clause
// One scan as it came from a file: bytes with their field table, and access to whole columns.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ladar_perception/cloud/cloud_layout.h"

namespace ladar_perception {

/// A cloud that owns its bytes. Points keep the order of the file.
struct Scan {
  CloudLayout layout;
  std::vector<uint8_t> data;
  bool is_dense = true;  ///< no x, y or z is NaN or infinite

  std::size_t size() const { return layout.pointCount(); }
};

/// One field of every point. Doubles hold every scalar type of a cloud exactly.
struct Column {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  std::vector<double> values;
};

/// A scan of one row made of columns of equal length, which must include x, y and z.
Scan makeScan(const std::vector<Column>& columns);

/// Appends a field; throws std::runtime_error if the scan has one of that name already.
void addColumn(Scan& scan, const Column& column);

/// Values of a field; throws std::runtime_error that lists the fields if it is not among them.
std::vector<double> readColumn(const Scan& scan, const std::string& name);
/// Values of a field at some points, given by their indices.
std::vector<double> readColumn(const Scan& scan, const std::string& name,
                               const std::vector<std::size_t>& points);

/// Sets `is_dense` from the coordinates.
void updateIsDense(Scan& scan);

/// float32, or float64 if float32 would move one of the coordinates by more than a millimetre.
ScalarType positionType(const std::vector<double>& x, const std::vector<double>& y,
                        const std::vector<double>& z);

/// float32, or float64 if float32 would change one of the values by more than 1e-5, as it does
/// with times since 1970 and with large identifiers.
ScalarType attributeType(const std::vector<double>& values);

}  // namespace ladar_perception
