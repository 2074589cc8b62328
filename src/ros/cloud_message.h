// SPDX-License-Identifier: BSD-3-Clause
// PointCloud2 messages to and from the core's clouds.
#pragma once

#include <sensor_msgs/PointCloud2.h>

#include "ladar_perception/cloud/cloud_layout.h"
#include "ladar_perception/terrain/terrain_pipeline.h"

namespace ladar_perception {

CloudLayout layoutOf(const sensor_msgs::PointCloud2& cloud);

/// Shape and field table of a message; the data stays as it is.
void setLayout(const CloudLayout& layout, sensor_msgs::PointCloud2* cloud);

/// The scan the pipeline has just processed, with labels: header, order and all fields of `scan`.
sensor_msgs::PointCloud2Ptr makeLabeledPoints(const sensor_msgs::PointCloud2& scan,
                                              const CloudLayout& scan_layout,
                                              const TerrainPipeline& pipeline);

/// Occupied voxels within `radius_m` (horizontally) of the vehicle, one point each at the centroid
/// of the voxel's own points: x y z rgb confidence scatter surface linear normal_x normal_y
/// normal_z (float32), points (uint32) and label (uint8). Voxels without features have saliency
/// and normal NaN.
sensor_msgs::PointCloud2Ptr makeLabeledMap(const TerrainPipeline& pipeline,
                                           const std_msgs::Header& header,
                                           const Eigen::Vector3d& p_map_vehicle, double radius_m);

}  // namespace ladar_perception
