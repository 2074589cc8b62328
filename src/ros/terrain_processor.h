// SPDX-License-Identifier: BSD-3-Clause
// From a PointCloud2 and tf to labels: what the nodelet and classify_bag share.
#pragma once

#include <sensor_msgs/PointCloud2.h>
#include <tf2/buffer_core.h>

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ladar_perception/terrain/terrain_pipeline.h"
#include "terrain_node_config.h"

namespace ladar_perception {

/// Why a whole scan was not labelled.
enum class ScanDrop {
  kEmpty,        ///< no points
  kBadCloud,     ///< no readable x y z
  kNoStamp,      ///< stamp 0: nothing tells where the sensor was
  kNoTransform,  ///< tf did not have the poses in time
  kBadPose,      ///< a pose is not finite or farther out than the map can index
  kQueueFull,    ///< newer scans came faster than they could be processed
  kError,        ///< an exception, out of memory for example
};
constexpr int kScanDrops = 7;
const char* scanDropName(ScanDrop reason);

/// What became of one scan.
struct ScanOutcome {
  std::optional<ScanDrop> drop;  ///< empty when the scan was labelled
  std::string detail;            ///< of a drop: what was expected and what was there
  bool map_reset = false;        ///< the stamp lay before the last one: the map was reset first
  Eigen::Vector3d p_map_vehicle = Eigen::Vector3d::Zero();
};

/// Takes scans one after the other. Not thread-safe; the tf buffer may be fed meanwhile.
class TerrainProcessor {
 public:
  /// Calls its argument until it returns true or time is up; returns what it returned last.
  /// reset() may be called meanwhile.
  using Wait = std::function<bool(const std::function<bool()>& ready)>;

  TerrainProcessor(const TerrainNodeConfig& config, const ClassifierModel& model,
                   tf2::BufferCore* buffer);

  ScanOutcome process(const sensor_msgs::PointCloud2& scan, const Wait& wait);
  void reset();
  /// As TerrainPipeline::keepFeatures.
  void keepFeatures(bool keep) { pipeline_.keepFeatures(keep); }

  const TerrainPipeline& pipeline() const { return pipeline_; }
  /// Layout of the last labelled scan.
  const CloudLayout& scanLayout() const { return layout_; }

 private:
  bool resetIfTimeJumped(const sensor_msgs::PointCloud2& scan);
  std::vector<double> knotOffsets(double stamp_s);
  void readTimes(const CloudView& cloud, const PointFields& fields, double stamp_s);
  bool canTransform(const std::string& frame, const ros::Time& stamp,
                    const std::vector<double>& offsets_s, std::string* why) const;
  Eigen::Isometry3d lookUp(const std::string& frame, const ros::Time& stamp) const;
  std::string vehicleFrameFor(const std::string& sensor_frame) const;

  TerrainNodeConfig config_;
  tf2::BufferCore* buffer_;
  TerrainPipeline pipeline_;
  CloudLayout layout_;
  std::vector<float> time_offsets_s_;
  std::map<std::string, ros::Time> last_stamp_;  // by the cloud's frame
};

}  // namespace ladar_perception
