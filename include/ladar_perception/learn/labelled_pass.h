// SPDX-License-Identifier: BSD-3-Clause
// Sends a labelled cloud through the pipeline of the vehicle: what is learned from and what is
// judged is computed by the very code that will label scans.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "ladar_perception/io/scan.h"
#include "ladar_perception/learn/labelled_inputs.h"
#include "ladar_perception/terrain/terrain_pipeline.h"

namespace ladar_perception {

/// Called after every scan with the pipeline and the truth of the scan's points (0 is ignored).
/// Over all calls of one pass every point has its truth once.
using LabelledScanVisitor =
    std::function<void(const TerrainPipeline& pipeline, const std::vector<double>& truth)>;

/// The configuration for a model: voxels and supports are the model's. Throws std::runtime_error
/// with what does not go together then, such as a map of too many of its voxels.
TerrainConfig configFor(const ClassifierModel& model, TerrainConfig config);

/// Sends a cloud with one truth per point through new pipelines that keep features. `config` must
/// fit the model.
///
/// kWhole takes from it only what makes features: the map is made as large as the cloud, no range
/// limit drops a point and nothing is forgotten. A cloud too large for one map goes in overlapping
/// pieces; points in an overlap count once, where their surroundings are complete. kStream cuts it
/// as import_scans does and uses `config` as it is: the map does not hold what is far off.
/// Coordinates may be anything finite: the cloud is brought near the origin first, by whole voxels.
/// `name` is what progress is shown for. Throws std::runtime_error if the cloud has no points or
/// its x, y, z cannot be read.
void runLabelledPass(const Scan& cloud, const std::vector<double>& truth, Pass pass,
                     const TerrainConfig& config, const ClassifierModel& model,
                     const std::string& name, const LabelledScanVisitor& visit);

/// World indices of the occupied voxels by their slots; slots without a voxel hold anything.
std::vector<VoxelIndex> voxelsBySlot(const VoxelMap& map);

}  // namespace ladar_perception
