// SPDX-License-Identifier: BSD-3-Clause
// Scans to the clouds that are re-sampled, and the samples back to scans.
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/io/class_mapping.h"
#include "ladar_perception/io/scan.h"
#include "ladar_perception/resample/cloud_resampler.h"

namespace ladar_perception {

/// Colours that text files have as numbers become one field rgb of bits 0x00RRGGBB: three columns
/// red green blue or r g b of 0 to 255, or one column rgb of 256 (256 red + green) + blue. A scan
/// without such columns stays as it is. Throws std::runtime_error if a value is none of these.
void packColors(Scan* scan);

/// Positions, and colours if there are any; the sensor is at the origin.
PoseCloudData poseCloudOf(const Scan& scan);

/// Labels of the classes of a mapping. Throws std::runtime_error that names the field, the value
/// and the point if one is no label.
std::vector<uint8_t> labelsOf(const Scan& scan, const std::string& label_field,
                              const ClassMapping& mapping);
/// Labels as the terrain nodelet gives them: 0 unknown, 1 to `classes`. Errors as above.
std::vector<uint8_t> labelsOf(const Scan& scan, const std::string& label_field, int classes);

/// The samples with every field of their nearest original points, in which x y z are those of the
/// samples (float32, or float64 where the original has these), then normal_x normal_y normal_z and
/// covering_radius (float32). An original field that has one of these names is kept as
/// `<name>_input`. One row.
Scan resampledScan(const Scan& original, const ResampledCloud& samples);

}  // namespace ladar_perception
