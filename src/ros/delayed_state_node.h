// SPDX-License-Identifier: BSD-3-Clause
// The delayed-state node: the shell around DelayedState that the nodelet and the program share.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ladar_perception/LoadState.h>
#include <ladar_perception/PoseCloud.h>
#include <ladar_perception/SaveState.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>

#include <mutex>
#include <string>
#include <thread>

#include "delayed_state_node_config.h"
#include "errands.h"
#include "ladar_perception/slam/delayed_state.h"
#include "ladar_perception/util/work_queue.h"
#include "map_frame_broadcaster.h"
#include "pose_sequence.h"
#include "state_publisher.h"
#include "state_statistics.h"
#include "warning_gate.h"

namespace ladar_perception {

/// Subscribes to `pose_cloud`, publishes tf, `path`, `pose_graph`, `pose_graph_markers`,
/// `map_cloud`, `delayed_state_statistics` and diagnostics, offers `~save_state`, `~load_state`,
/// `~optimize` and `~reset`.
///
/// One thread owns the state. Poses wait for it in a queue, whose oldest is dropped and counted
/// when it is full; services, which have a thread of their own, wait for the pose it is at. So
/// neither a manager's threads nor poses nor tf wait for either.
class DelayedStateNode {
 public:
  /// Throws std::runtime_error with a readable report if the parameters are unfit.
  DelayedStateNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle);
  ~DelayedStateNode();
  DelayedStateNode(const DelayedStateNode&) = delete;
  DelayedStateNode& operator=(const DelayedStateNode&) = delete;

 private:
  struct Arrival {
    PoseCloudConstPtr pose;
    uint64_t number = 0;  // of the statistics
  };

  void advertise();
  void onPose(const PoseCloudConstPtr& pose);
  void onTimer(const ros::WallTimerEvent& event);
  void onTfTimer(const ros::WallTimerEvent& /*event*/) { broadcaster_->repeat(); }

  // On the services' thread.
  bool onSave(SaveState::Request& request, SaveState::Response& response);
  bool onLoad(LoadState::Request& request, LoadState::Response& response);
  bool onOptimize(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool onReset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  /// Has the worker do something that returns what to tell; fills the response in.
  template <typename Response>
  void answer(const std::function<std::string()>& errand, Response* response);

  // On the thread that owns the state.
  void work();
  void add(const Arrival& arrival);
  /// Whether the pose may be added after those that came before; begins a new state if time jumped.
  std::optional<StateDrop> place(const PoseCloud& pose, std::string* detail);
  void beginState();
  void load(const std::string& path);
  /// Tells everybody of a changed state.
  void stateChanged();
  void offerSnapshot();
  std::string describeState() const;
  void reportDrop(const Arrival& arrival, StateDrop reason, const std::string& detail);

  DelayedStateStatistics statisticsMessage();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle handle_;
  ros::NodeHandle private_handle_;
  ros::CallbackQueue service_queue_;
  DelayedStateNodeConfig config_;
  DelayedState state_;  // of the worker, as are the two below
  PoseSequence sequence_;
  std::string vehicle_frame_;  // "" before the first pose
  Errands errands_;

  std::mutex statistics_mutex_;  // guards the five below
  StateStatisticsLog statistics_;
  std_msgs::Header newest_;
  WarningGate<kStateDrops> warnings_;
  uint64_t diagnosed_drops_ = 0;

  WorkQueue<Arrival> poses_;

  std::unique_ptr<MapFrameBroadcaster> broadcaster_;  // none if tf is not published
  StatePublisher publisher_;
  ros::Publisher statistics_publisher_;
  std::vector<ros::ServiceServer> services_;
  diagnostic_updater::Updater diagnostics_;
  ros::WallTimer timer_;
  ros::WallTimer tf_timer_;
  std::thread worker_;
  ros::AsyncSpinner service_spinner_;
  ros::Subscriber subscriber_;  // last: callbacks may come before the constructor returns
};

}  // namespace ladar_perception
