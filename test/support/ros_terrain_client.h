// SPDX-License-Identifier: BSD-3-Clause
// What stands around a terrain node in a test: a source of scans and transforms, and a reader of
// all it publishes.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <ladar_perception/TerrainStatistics.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>

#include "ros_nodelets.h"
#include "ros_scene.h"

namespace ladar_perception::test {

const std::string kTestModel = std::string(LADAR_SOURCE_DIR) + "/test/data/ros_model.yaml";
const std::string kTestConfig = std::string(LADAR_SOURCE_DIR) + "/test/data/ros_terrain.yaml";

/// Feeds the terrain node whose topics lie in namespace `ns` and collects what it publishes.
class TerrainClient {
 public:
  static constexpr const char* kNodelet = "ladar_perception/TerrainNodelet";
  static constexpr const char* kName = "terrain";
  /// All but the model as the package has them, and frequent statistics.
  static ParamMap testParameters() {
    return {{"model", kTestModel},
            {"statistics_rate_hz", 20.0},
            {"tf_timeout_s", 5.0},
            {"map_rate_hz", 5.0}};
  }

  explicit TerrainClient(const std::string& node_name, const std::string& ns = "/")
      : node_name_(node_name), handle_(ns) {
    points_ = handle_.advertise<sensor_msgs::PointCloud2>("points", 1000);
    // One latched message holds all static transforms.
    tf_static_ = handle_.advertise<tf2_msgs::TFMessage>("/tf_static", 1, true);
    tf_ = handle_.advertise<tf2_msgs::TFMessage>("/tf", 1000);
    // Another nodelet of the same manager may listen already; they share a connection.
    tf_others_ = tf_.getNumSubscribers();
    tf_static_others_ = tf_static_.getNumSubscribers();
    labeled_sub_ = handle_.subscribe<sensor_msgs::PointCloud2>(
        "labeled_points", 1000,
        [this](const sensor_msgs::PointCloud2ConstPtr& cloud) { labeled.push_back(cloud); });
    map_sub_ = handle_.subscribe<sensor_msgs::PointCloud2>(
        "labeled_map", 1000,
        [this](const sensor_msgs::PointCloud2ConstPtr& cloud) { maps.push_back(cloud); });
    statistics_sub_ = handle_.subscribe<TerrainStatistics>(
        "statistics", 1000,
        [this](const TerrainStatisticsConstPtr& message) { statistics = *message; });
  }

  /// Waits until every connection stands, in both directions.
  bool connected() {
    return waitFor([this] {
      return points_.getNumSubscribers() > 0 && tf_.getNumSubscribers() > 0 &&
             tf_static_.getNumSubscribers() > 0 && labeled_sub_.getNumPublishers() > 0 &&
             map_sub_.getNumPublishers() > 0 && statistics_sub_.getNumPublishers() > 0;
    });
  }

  /// Waits until the node and its connections are gone.
  bool disconnected() {
    return waitFor([this] {
      return points_.getNumSubscribers() == 0 && tf_.getNumSubscribers() <= tf_others_ &&
             tf_static_.getNumSubscribers() <= tf_static_others_ &&
             labeled_sub_.getNumPublishers() == 0;
    });
  }

  void sendMount(const std::vector<std::string>& sensor_frames = {kSensorFrame}) {
    tf2_msgs::TFMessage message;
    for (const std::string& frame : sensor_frames) {
      message.transforms.push_back(
          transformMessage(ros::Time(1), kVehicleFrame, frame, sensorMount()));
    }
    tf_static_.publish(message);
  }
  void send(const std::vector<geometry_msgs::TransformStamped>& transforms) {
    tf2_msgs::TFMessage message;
    message.transforms = transforms;
    tf_.publish(message);
  }
  void send(const sensor_msgs::PointCloud2& scan) { points_.publish(scan); }

  /// Sends a scan and waits for its labels; nullptr if they do not come.
  sensor_msgs::PointCloud2ConstPtr label(const sensor_msgs::PointCloud2& scan,
                                         double timeout_s = kPatience_s) {
    const std::size_t before = labeled.size();
    send(scan);
    waitFor([&] { return labeled.size() > before; }, timeout_s);
    if (labeled.size() <= before || labeled.back()->header.stamp != scan.header.stamp) {
      return nullptr;
    }
    return labeled.back();
  }
  /// The same for scans [begin, end) of a drive with their transforms; how many were labelled.
  int labelScans(const Drive& drive, int begin, int end, double density = 1.0) {
    send(drive.vehicleTransforms(begin, end));
    int count = 0;
    for (int i = begin; i < end; ++i) count += label(drive.scan(i, density)) ? 1 : 0;
    return count;
  }
  bool waitForStatistics(const std::function<bool(const TerrainStatistics&)>& condition,
                         double timeout_s = kPatience_s) {
    return waitFor([&] { return condition(statistics); }, timeout_s);
  }
  bool reset(double timeout_s = kPatience_s) {
    std_srvs::Trigger trigger;
    return callService(node_name_ + "/reset", &trigger, timeout_s) && trigger.response.success;
  }

  std::vector<sensor_msgs::PointCloud2ConstPtr> labeled;
  std::vector<sensor_msgs::PointCloud2ConstPtr> maps;
  TerrainStatistics statistics;  ///< the last

 private:
  std::string node_name_;
  ros::NodeHandle handle_;
  ros::Publisher points_;
  ros::Publisher tf_;
  ros::Publisher tf_static_;
  uint32_t tf_others_ = 0;
  uint32_t tf_static_others_ = 0;
  ros::Subscriber labeled_sub_;
  ros::Subscriber map_sub_;
  ros::Subscriber statistics_sub_;
};

using LoadedTerrain = LoadedNodelet<TerrainClient>;

/// Share of the points of a true class that got its label.
inline double recallOf(const sensor_msgs::PointCloud2& labeled, uint8_t label) {
  const std::vector<double> truth = fieldValues(labeled, "truth");
  const std::vector<double> found = fieldValues(labeled, "label");
  double points = 0;
  double right = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] != label) continue;
    ++points;
    right += i < found.size() && found[i] == label ? 1 : 0;
  }
  return points > 0 ? right / points : 0.0;
}

}  // namespace ladar_perception::test
