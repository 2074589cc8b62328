// SPDX-License-Identifier: BSD-3-Clause
// Samples as the bytes of a cloud, with everything their nearest original points had.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/cloud/cloud_layout.h"
#include "ladar_perception/resample/cloud_resampler.h"

namespace ladar_perception {

/// Layout of the samples of a cloud: every field of the input at its own offset, then normal_x,
/// normal_y, normal_z and covering_radius (float32). An input field that already has one of these
/// names is kept as `<name>_input`, as are x, y, z of whole numbers, which cannot hold a sample's
/// position: float32 ones take their place. One row, without points yet.
CloudLayout sampleLayout(const CloudLayout& input);

/// Writes the samples in their order and in the input's byte order. `samples.sources` are indices
/// into `originals`. Sets the shape of `layout`, which is sampleLayout(originals.layout).
void writeSampleCloud(const CloudView& originals, const ResampledCloud& samples,
                      CloudLayout* layout, std::vector<uint8_t>* bytes);

}  // namespace ladar_perception
