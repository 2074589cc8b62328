// SPDX-License-Identifier: BSD-3-Clause
// What stands around a delayed-state node in a test: a source of poses, and a reader of all it
// publishes.
#pragma once

#include <ladar_perception/DelayedStateStatistics.h>
#include <ladar_perception/LoadState.h>
#include <ladar_perception/PoseCloud.h>
#include <ladar_perception/SaveState.h>
#include <ladar_perception/StateGraph.h>
#include <nav_msgs/Path.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include <boost/make_shared.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "pose_cloud_reader.h"
#include "ros_nodelets.h"

namespace ladar_perception::test {

const std::string kTestStateConfig =
    std::string(LADAR_SOURCE_DIR) + "/test/data/ros_delayed_state.yaml";

/// The last message of a topic, and how many came.
template <typename Message>
class Heard {
 public:
  Heard(ros::NodeHandle handle, const std::string& topic) {
    subscriber_ = handle.subscribe<Message>(
        topic, 1000, [this](const boost::shared_ptr<const Message>& message) {
          last_ = message;
          ++count;
        });
  }
  bool connected() const { return subscriber_.getNumPublishers() > 0; }
  const Message& last() const { return last_ ? *last_ : none_; }

  int count = 0;

 private:
  Message none_;
  boost::shared_ptr<const Message> last_;
  ros::Subscriber subscriber_;
};

/// Feeds the delayed-state node whose topics lie in namespace `ns` and collects what it publishes.
class StateClient {
 public:
  static constexpr const char* kNodelet = "ladar_perception/DelayedStateNodelet";
  static constexpr const char* kName = "delayed_state";
  static ParamMap testParameters() { return loadParamFile(kTestStateConfig); }

  explicit StateClient(const std::string& node_name, const std::string& ns = "/",
                       const std::string& path_topic = "path")
      : node_name_(node_name),
        handle_(ns),
        poses_(handle_.advertise<PoseCloud>("pose_cloud", 1000)),
        path_(handle_, path_topic),
        graph_(handle_, "pose_graph"),
        markers_(handle_, "pose_graph_markers"),
        map_(handle_, "map_cloud"),
        statistics_(handle_, "delayed_state_statistics") {
    tf_sub_ = handle_.subscribe<tf2_msgs::TFMessage>(
        "/tf", 1000, [this](const tf2_msgs::TFMessageConstPtr& message) {
          for (const auto& transform : message->transforms) {
            if (transform.header.frame_id == "map") transforms.push_back(transform);
          }
        });
  }

  /// Waits until every connection of what it reads stands.
  bool hears() {
    return waitFor([this] {
      return path_.connected() && graph_.connected() && markers_.connected() && map_.connected() &&
             statistics_.connected();
    });
  }
  /// The same in both directions.
  bool connected() {
    return hears() && waitFor([this] { return poses_.getNumSubscribers() > 0; });
  }
  /// Waits until the node and its connections are gone.
  bool disconnected() {
    return waitFor([this] {
      return poses_.getNumSubscribers() == 0 && !path_.connected() && !statistics_.connected();
    });
  }

  /// By pointer: inside a manager messages that are passed so overtake others.
  void send(const PoseCloud& pose) { poses_.publish(boost::make_shared<const PoseCloud>(pose)); }
  /// Sends a pose and waits until the node has done with it; whether it is in the state.
  bool add(const PoseCloud& pose) {
    const DelayedStateStatistics before = statistics();
    send(pose);
    return waitForStatistics([&](const auto& s) {
             return s.poses_received > before.poses_received && s.poses_waiting == 0;
           }) &&
           statistics().poses_added > before.poses_added;
  }
  bool waitForStatistics(const std::function<bool(const DelayedStateStatistics&)>& condition,
                         double timeout_s = kPatience_s) {
    return waitFor([&] { return condition(statistics()); }, timeout_s);
  }
  /// Waits for messages of everything, with so many poses, that come from now on.
  bool waitForOutputs(std::size_t poses) {
    const int paths = path_.count, graphs = graph_.count, arrays = markers_.count,
              maps = map_.count;
    return waitFor([&] {
      return path_.count > paths && graph_.count > graphs && markers_.count > arrays &&
             map_.count > maps && path().poses.size() == poses && graph().poses.size() == poses;
    });
  }

  bool save(const std::string& path, std::string* message = nullptr) {
    return onPath<SaveState>("/save_state", path, message);
  }
  bool load(const std::string& path, std::string* message = nullptr) {
    return onPath<LoadState>("/load_state", path, message);
  }
  bool reset() { return trigger("/reset"); }
  bool optimize() { return trigger("/optimize"); }

  const nav_msgs::Path& path() const { return path_.last(); }
  const StateGraph& graph() const { return graph_.last(); }
  const visualization_msgs::MarkerArray& markers() const { return markers_.last(); }
  const sensor_msgs::PointCloud2& map() const { return map_.last(); }
  const DelayedStateStatistics& statistics() const { return statistics_.last(); }

  std::vector<geometry_msgs::TransformStamped> transforms;  ///< out of the map

 private:
  template <typename Service>
  bool onPath(const std::string& name, const std::string& path, std::string* message) {
    Service service;
    service.request.path = path;
    const bool called = callService(node_name_ + name, &service);
    if (message != nullptr) *message = service.response.message;
    return called && service.response.success;
  }
  bool trigger(const std::string& name) {
    std_srvs::Trigger trigger;
    return callService(node_name_ + name, &trigger) && trigger.response.success;
  }

  std::string node_name_;
  ros::NodeHandle handle_;
  ros::Publisher poses_;
  Heard<nav_msgs::Path> path_;
  Heard<StateGraph> graph_;
  Heard<visualization_msgs::MarkerArray> markers_;
  Heard<sensor_msgs::PointCloud2> map_;
  Heard<DelayedStateStatistics> statistics_;
  ros::Subscriber tf_sub_;
};

using LoadedState = LoadedNodelet<StateClient>;

/// Every pose and every registration is accounted for, and no pose waits any more.
inline void expectAccounted(const DelayedStateStatistics& s) {
  EXPECT_EQ(s.poses_received, s.poses_added + sumOf(s.poses_dropped));
  EXPECT_EQ(s.poses_waiting, 0U);
  EXPECT_EQ(s.backlog_s, 0.0F);
  EXPECT_EQ(s.registrations_tried,
            s.registrations_accepted + s.registrations_waiting + sumOf(s.registrations_refused));
}

inline Eigen::Isometry3d poseOf(const geometry_msgs::Pose& message) {
  return isometryOf(message).value_or(Eigen::Isometry3d::Identity());
}

inline Eigen::Isometry3d poseOf(const geometry_msgs::Transform& message) {
  geometry_msgs::Pose pose;
  pose.position.x = message.translation.x;
  pose.position.y = message.translation.y;
  pose.position.z = message.translation.z;
  pose.orientation = message.rotation;
  return poseOf(pose);
}

}  // namespace ladar_perception::test
