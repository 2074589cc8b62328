// SPDX-License-Identifier: BSD-3-Clause
#include "delayed_state_node.h"

#include <boost/make_shared.hpp>
#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "ladar_perception/slam/surface_registration.h"
#include "pose_cloud_reader.h"

namespace ladar_perception {
namespace {

constexpr std::size_t kStatisticsWindow = 1000;
constexpr uint32_t kBurst = 1000;  // poses
// Services are heard, and changes published, at least this often.
constexpr std::chrono::milliseconds kHeedPeriod{20};

/// The nodelet manager's working directory is no place that a user knows.
void requireAbsolute(const std::string& path) {
  if (path.empty() || path[0] != '/') {
    throw std::runtime_error("path '" + path + "' is not absolute");
  }
}

}  // namespace

DelayedStateNode::DelayedStateNode(const ros::NodeHandle& handle,
                                   const ros::NodeHandle& private_handle)
    : handle_(handle),
      private_handle_(private_handle),
      config_(readConfig<DelayedStateNodeConfig>(private_handle)),
      state_(config_.state, surfaceRegistration(config_.registration)),
      statistics_(kStatisticsWindow),
      poses_(static_cast<std::size_t>(config_.queue_size)),
      publisher_(handle_, config_),
      diagnostics_(handle_, private_handle_, private_handle_.getNamespace()),
      service_spinner_(1, &service_queue_) {
  if (config_.publish_tf) {
    broadcaster_ = std::make_unique<MapFrameBroadcaster>(config_.map_frame, config_.odom_frame,
                                                         1.0 / config_.tf_rate_hz);
    tf_timer_ = handle_.createWallTimer(ros::WallDuration(1.0 / config_.tf_rate_hz),
                                        &DelayedStateNode::onTfTimer, this);
  }
  advertise();
  timer_ = handle_.createWallTimer(ros::WallDuration(1.0 / config_.statistics_rate_hz),
                                   &DelayedStateNode::onTimer, this);
  worker_ = std::thread([this] { work(); });
  service_spinner_.start();
  ROS_INFO("delayed_state: poses in %s from '%s' are estimated in %s", config_.odom_frame.c_str(),
           handle_.resolveName("pose_cloud").c_str(), config_.map_frame.c_str());
  // The queue of our own does the waiting and the counting. This one drops without a word, so it
  // is long enough for any burst that comes while a callback runs.
  subscriber_ = handle_.subscribe("pose_cloud", kBurst, &DelayedStateNode::onPose, this);
}

DelayedStateNode::~DelayedStateNode() {
  subscriber_.shutdown();
  timer_.stop();
  tf_timer_.stop();
  poses_.stop();
  errands_.close();
  worker_.join();
  for (ros::ServiceServer& service : services_) service.shutdown();
  service_spinner_.stop();
  const uint32_t lost = statistics_.message().poses_waiting;
  if (lost > 0) ROS_WARN("delayed_state: ends before %u poses were registered", lost);
}

void DelayedStateNode::advertise() {
  statistics_publisher_ =
      handle_.advertise<DelayedStateStatistics>("delayed_state_statistics", 1, true);
  ros::NodeHandle own_thread = private_handle_;
  own_thread.setCallbackQueue(&service_queue_);
  services_ = {own_thread.advertiseService("save_state", &DelayedStateNode::onSave, this),
               own_thread.advertiseService("load_state", &DelayedStateNode::onLoad, this),
               own_thread.advertiseService("optimize", &DelayedStateNode::onOptimize, this),
               own_thread.advertiseService("reset", &DelayedStateNode::onReset, this)};
  diagnostics_.setHardwareID("none");
  diagnostics_.add("delayed_state", this, &DelayedStateNode::diagnose);
}

void DelayedStateNode::onPose(const PoseCloudConstPtr& pose) {
  Arrival arrival{pose, 0};
  {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    arrival.number = statistics_.addArrival();
  }
  const auto displaced = poses_.pushOverOldest(std::move(arrival));
  if (displaced) {
    reportDrop(*displaced, StateDrop::kQueueFull,
               "more than queue_size " + std::to_string(config_.queue_size) + " poses waiting");
  }
}

void DelayedStateNode::onTimer(const ros::WallTimerEvent& /*event*/) {
  statistics_publisher_.publish(boost::make_shared<DelayedStateStatistics>(statisticsMessage()));
  diagnostics_.update();
}

template <typename Response>
void DelayedStateNode::answer(const std::function<std::string()>& errand, Response* response) {
  try {
    std::string message = "the node ends";
    const bool done = errands_.run([&] { message = errand(); });
    response->success = done;
    response->message = message;
  } catch (const std::exception& error) {
    response->success = false;
    response->message = error.what();
    ROS_WARN("delayed_state: %s", error.what());
  }
}

bool DelayedStateNode::onSave(SaveState::Request& request, SaveState::Response& response) {
  answer(
      [&] {
        requireAbsolute(request.path);
        state_.save(request.path);
        const std::lock_guard<std::mutex> lock(statistics_mutex_);
        statistics_.addSave();
        return "saved " + describeState() + " to " + request.path;
      },
      &response);
  return true;
}

bool DelayedStateNode::onLoad(LoadState::Request& request, LoadState::Response& response) {
  answer(
      [&] {
        requireAbsolute(request.path);
        load(request.path);
        return "loaded " + describeState() + " from " + request.path;
      },
      &response);
  return true;
}

bool DelayedStateNode::onOptimize(std_srvs::Trigger::Request& /*request*/,
                                  std_srvs::Trigger::Response& response) {
  answer(
      [&] {
        state_.optimize();
        stateChanged();
        return "optimised " + describeState();
      },
      &response);
  return true;
}

bool DelayedStateNode::onReset(std_srvs::Trigger::Request& /*request*/,
                               std_srvs::Trigger::Response& response) {
  answer(
      [&] {
        const std::string what = "forgot " + describeState();
        beginState();
        ROS_INFO("delayed_state: %s on request", what.c_str());
        return what;
      },
      &response);
  return true;
}

void DelayedStateNode::work() {
  while (!poses_.stopped()) {
    const auto arrival = poses_.pop(kHeedPeriod);
    errands_.doAll();
    if (arrival) {
      try {
        add(*arrival);
      } catch (const std::exception& error) {
        // Whatever it was, it concerned one pose; the manager and the other nodelets go on.
        reportDrop(*arrival, StateDrop::kError, error.what());
      }
    }
    try {
      offerSnapshot();
    } catch (const std::exception& error) {
      ROS_ERROR_THROTTLE(5.0, "delayed_state: cannot be published: %s", error.what());
    }
  }
}

void DelayedStateNode::add(const Arrival& arrival) {
  const PoseCloud& message = *arrival.pose;
  StatePose pose;
  std::string detail;
  auto drop = readPoseCloud(message, &pose, &detail);
  if (!drop) drop = place(message, &detail);
  if (drop) {
    reportDrop(arrival, *drop, detail);
    return;
  }
  const AddReport report = state_.add(pose);
  const uint64_t missing = sequence_.advance(message.id, message.header.stamp);
  vehicle_frame_ = message.vehicle_frame;
  {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    statistics_.addPose(arrival.number, report, missing);
  }
  if (report.closed_loop) {
    ROS_INFO("delayed_state: pose %lu at %.3f s closed a loop",
             static_cast<unsigned long>(message.id), message.header.stamp.toSec());
  }
  stateChanged();
}

std::optional<StateDrop> DelayedStateNode::place(const PoseCloud& pose, std::string* detail) {
  if (pose.header.frame_id != config_.odom_frame) {
    *detail = "expected a pose in odom_frame '" + config_.odom_frame + "'";
    return StateDrop::kOtherFrame;
  }
  const PosePlace found = sequence_.placeOf(pose.id, pose.header.stamp);
  const std::string before = "the pose before is " + sequence_.describeLast();
  if (found == PosePlace::kTimeJump && config_.time_jump == "new_state") {
    ROS_WARN("delayed_state: time of '%s' jumped back to %.3f s, %s: forgot %s, a new state begins",
             handle_.resolveName("pose_cloud").c_str(), pose.header.stamp.toSec(), before.c_str(),
             describeState().c_str());
    beginState();
    return std::nullopt;
  }
  if (!vehicle_frame_.empty() && pose.vehicle_frame != vehicle_frame_) {
    *detail = "it is of '" + pose.vehicle_frame + "', those before are of '" + vehicle_frame_ + "'";
    return StateDrop::kOtherFrame;
  }
  if (found == PosePlace::kNext) return std::nullopt;
  *detail = before;
  if (found == PosePlace::kRestarted) {
    ROS_WARN(
        "delayed_state: ids on '%s' go back to %lu, %s: was the re-sampler started again, or do "
        "two publish?",
        handle_.resolveName("pose_cloud").c_str(), static_cast<unsigned long>(pose.id),
        before.c_str());
    return std::nullopt;
  }
  if (found == PosePlace::kDuplicate) return StateDrop::kDuplicate;
  *detail += "; ~reset begins a new state";
  return StateDrop::kOutOfOrder;
}

void DelayedStateNode::beginState() {
  state_.reset();
  sequence_.begin();
  vehicle_frame_.clear();
  {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    statistics_.addReset();
  }
  stateChanged();
}

void DelayedStateNode::load(const std::string& path) {
  state_.load(path);
  vehicle_frame_.clear();
  sequence_.begin();
  if (state_.size() > 0) sequence_.beginAfter(ros::Time(state_.poses().back().stamp_s));
  {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    statistics_.addLoad();
  }
  ROS_INFO("delayed_state: loaded %s from %s", describeState().c_str(), path.c_str());
  stateChanged();
}

void DelayedStateNode::stateChanged() {
  if (broadcaster_) broadcaster_->set(state_.T_map_odom());
  publisher_.changed();
  const std::lock_guard<std::mutex> lock(statistics_mutex_);
  statistics_.describe(state_);
  newest_ = {};
  if (state_.size() == 0) return;
  newest_.stamp = ros::Time(state_.poses().back().stamp_s);
  newest_.frame_id = config_.map_frame;
}

void DelayedStateNode::offerSnapshot() {
  if (!publisher_.wants()) return;
  auto snapshot = std::make_shared<StateSnapshot>();
  snapshot->poses = state_.poses();
  snapshot->graph = state_.graph();
  snapshot->header.stamp =
      state_.size() > 0 ? ros::Time(state_.poses().back().stamp_s) : ros::Time::now();
  snapshot->header.frame_id = config_.map_frame;
  snapshot->odom_frame = config_.odom_frame;
  snapshot->vehicle_frame = vehicle_frame_;
  publisher_.publish(std::move(snapshot));
}

std::string DelayedStateNode::describeState() const {
  return std::to_string(state_.size()) + " poses and " +
         std::to_string(state_.graph().constraints().size()) + " constraints";
}

void DelayedStateNode::reportDrop(const Arrival& arrival, StateDrop reason,
                                  const std::string& detail) {
  {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    statistics_.addDrop(arrival.number, reason);
    if (!warnings_.opens(reason)) return;
  }
  const PoseCloud& pose = *arrival.pose;
  ROS_WARN("delayed_state: pose %lu on '%s' at %.3f s in frame '%s' dropped, %s: %s",
           static_cast<unsigned long>(pose.id), handle_.resolveName("pose_cloud").c_str(),
           pose.header.stamp.toSec(), pose.header.frame_id.c_str(), stateDropName(reason),
           detail.c_str());
}

DelayedStateStatistics DelayedStateNode::statisticsMessage() {
  const std::lock_guard<std::mutex> lock(statistics_mutex_);
  DelayedStateStatistics message = statistics_.message();
  message.header = newest_;
  return message;
}

void DelayedStateNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const DelayedStateStatistics message = statisticsMessage();
  const std::lock_guard<std::mutex> lock(statistics_mutex_);
  const uint64_t drops = statistics_.dropped();
  if (drops > diagnosed_drops_) {
    status.summaryf(DiagnosticStatus::ERROR, "%lu poses dropped since the last report",
                    static_cast<unsigned long>(drops - diagnosed_drops_));
  } else if (message.poses_waiting > static_cast<uint32_t>(config_.queue_size) / 2) {
    status.summaryf(DiagnosticStatus::WARN, "%u poses wait: they come faster than registering is",
                    message.poses_waiting);
  } else if (message.poses_received == 0) {
    status.summary(DiagnosticStatus::WARN, "no poses on " + handle_.resolveName("pose_cloud"));
  } else {
    status.summary(DiagnosticStatus::OK, "estimating poses");
  }
  diagnosed_drops_ = drops;
  addTo(message, &status);
}

}  // namespace ladar_perception
