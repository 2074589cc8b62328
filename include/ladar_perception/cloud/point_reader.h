// SPDX-License-Identifier: BSD-3-Clause
// Reads columns of a point cloud given as bytes and a field table, whatever their types.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "ladar_perception/cloud/cloud_layout.h"

namespace ladar_perception {

/// The fields of a cloud the package gives a meaning to; all others are carried along untouched.
struct PointFields {
  Field x;  ///< metres, any scalar type
  Field y;
  Field z;
  std::optional<Field> time;   ///< when each point was measured
  std::optional<Field> color;  ///< 0x00RRGGBB in the bits of a float32, uint32 or int32
};

/// Finds them by their usual names (x y z; time, t, timestamp, time_stamp, offset_time,
/// time_offset; rgb, rgba). Returns nothing and sets `*error` to a sentence that lists the fields
/// present if x, y or z is missing or the layout contradicts itself.
std::optional<PointFields> findPointFields(const CloudView& cloud, std::string* error);

/// Positions in the cloud's own frame, metres, in message order (row by row). NaN and infinities
/// are passed on as they are.
void readPositions(const CloudView& cloud, const PointFields& fields,
                   std::vector<Eigen::Vector3d>* positions_m);

/// Seconds from the cloud's stamp at which each point was measured. Units follow the drivers in
/// use: integers are nanoseconds and floats are seconds, from the stamp; floats above 1e6 are
/// absolute seconds and above 1e12 absolute nanoseconds. Returns false, with `offsets_s` empty, if
/// the field has a value that is not finite or lies more than `max_offset_s` from the stamp:
/// such times cannot be used.
bool readTimeOffsets(const CloudView& cloud, const Field& time, double stamp_s,
                     double max_offset_s, std::vector<float>* offsets_s);

/// Colours as 0x00RRGGBB, one per point.
void readColors(const CloudView& cloud, const Field& color, std::vector<uint32_t>* rgb);

/// Any scalar field as double, one per point (the first scalar of a field with count > 1).
void readScalars(const CloudView& cloud, const Field& field, std::vector<double>* values);

}  // namespace ladar_perception
