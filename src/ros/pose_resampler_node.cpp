// SPDX-License-Identifier: BSD-3-Clause
#include "pose_resampler_node.h"

#include <boost/make_shared.hpp>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "pose_cloud_message.h"
#include "statistics_parts.h"

namespace ladar_perception {
namespace {

constexpr std::size_t kStatisticsWindow = 1000;
constexpr uint32_t kBurst = 1000;  // messages
// Scans that wait for room among the poses need their transforms for longer than tf's 10 s.
constexpr double kTransformsKept_s = 30.0;
// What was requested by a service is heeded at least this often.
constexpr std::chrono::milliseconds kHeedPeriod{50};

using Seconds = std::chrono::duration<double>;

}  // namespace

PoseResamplerNode::PoseResamplerNode(const ros::NodeHandle& handle,
                                     const ros::NodeHandle& private_handle)
    : handle_(handle),
      private_handle_(private_handle),
      config_(readConfig<PoseResamplerNodeConfig>(private_handle)),
      policies_(loadPolicies(config_)),
      tf_buffer_(ros::Duration(kTransformsKept_s)),
      tf_listener_(tf_buffer_, handle_),
      odometry_(config_.odom_frame, config_.vehicle_frame, config_.odometry_tolerance_s),
      collector_(config_, &tf_buffer_),
      resampler_(config_.resampler),
      statistics_(config_.policies, kStatisticsWindow),
      scans_(static_cast<std::size_t>(config_.queue_size)),
      poses_(static_cast<std::size_t>(config_.pose_queue_size)),
      diagnostics_(handle_, private_handle_, private_handle_.getNamespace()) {
  advertise();
  path_.header.frame_id = config_.odom_frame;
  timer_ = handle_.createWallTimer(ros::WallDuration(1.0 / config_.statistics_rate_hz),
                                   &PoseResamplerNode::onTimer, this);
  gatherer_ = std::thread([this] { gather(); });
  resampling_ = std::thread([this] { resample(); });
  ROS_INFO("pose_resampler: poses of %s in %s by %s, clouds by %s, policies '%s'",
           config_.vehicle_frame.c_str(), config_.odom_frame.c_str(), config_.keeper.join.c_str(),
           config_.keeper.gather.c_str(), config_.policies.c_str());
  odometry_subscriber_ = handle_.subscribe<nav_msgs::Odometry>(
      "odom", kBurst,
      [this](const nav_msgs::OdometryConstPtr& odometry) { odometry_.add(*odometry); });
  // The queue of our own does the waiting and the counting. This one drops without a word, so it
  // is long enough for any burst that comes while a callback runs.
  subscriber_ = handle_.subscribe("points", kBurst, &PoseResamplerNode::onScan, this);
}

PoseResamplerNode::~PoseResamplerNode() {
  subscriber_.shutdown();
  odometry_subscriber_.shutdown();
  timer_.stop();
  scans_.stop();
  poses_.stop();
  gatherer_.join();
  resampling_.join();
  const uint64_t lost = statistics_.posesWaiting();
  if (lost > 0) {
    ROS_WARN("pose_resampler: ends before %lu poses that joined were re-sampled",
             static_cast<unsigned long>(lost));
  }
}

void PoseResamplerNode::advertise() {
  pose_publisher_ = handle_.advertise<PoseCloud>("pose_cloud", 100);
  points_publisher_ = handle_.advertise<sensor_msgs::PointCloud2>("resampled_points", 10);
  path_publisher_ = handle_.advertise<nav_msgs::Path>("path", 1, true);
  statistics_publisher_ = handle_.advertise<PoseResamplerStatistics>("pose_statistics", 1, true);
  add_pose_service_ =
      private_handle_.advertiseService("add_pose", &PoseResamplerNode::onAddPose, this);
  reset_service_ = private_handle_.advertiseService("reset", &PoseResamplerNode::onReset, this);
  diagnostics_.setHardwareID("none");
  diagnostics_.add("pose_resampler", this, &PoseResamplerNode::diagnose);
}

void PoseResamplerNode::onScan(const sensor_msgs::PointCloud2ConstPtr& scan) {
  const auto displaced = scans_.pushOverOldest({scan, ros::WallTime::now()});
  if (displaced) {
    reportScanDrop(*displaced->scan, ScanDrop::kQueueFull,
                   "more than queue_size " + std::to_string(config_.queue_size) + " scans waiting");
  }
}

bool PoseResamplerNode::onAddPose(std_srvs::Trigger::Request& /*request*/,
                                  std_srvs::Trigger::Response& response) {
  add_pose_requested_ = true;
  response.success = true;
  response.message = "the next cloud makes a pose";
  return true;
}

bool PoseResamplerNode::onReset(std_srvs::Trigger::Request& /*request*/,
                                std_srvs::Trigger::Response& response) {
  reset_requested_ = true;
  response.success = true;
  response.message = "the path begins anew with the next cloud; poses that wait are not lost";
  return true;
}

void PoseResamplerNode::onTimer(const ros::WallTimerEvent& /*event*/) {
  statistics_publisher_.publish(boost::make_shared<PoseResamplerStatistics>(statisticsMessage()));
  diagnostics_.update();
}

void PoseResamplerNode::gather() {
  ros::WallTime last_arrival = ros::WallTime::now();
  while (!scans_.stopped()) {
    const auto arrival = scans_.pop(kHeedPeriod);
    heedRequests();
    if (!arrival) {
      completeAfterPause(last_arrival);
      continue;
    }
    last_arrival = arrival->time;
    try {
      collect(*arrival);
    } catch (const std::exception& error) {
      // Whatever it was, it concerned one scan; the manager and the other nodelets go on.
      reportScanDrop(*arrival->scan, ScanDrop::kError, error.what());
    }
  }
}

void PoseResamplerNode::heedRequests() {
  if (reset_requested_.exchange(false)) {
    passOn(collector_.reset(), ros::WallTime::now());
    startPath(collector_.journey());
    ROS_INFO("pose_resampler: path begun anew on request");
  }
  if (add_pose_requested_.exchange(false)) collector_.request();
}

void PoseResamplerNode::collect(const Arrival& arrival) {
  const sensor_msgs::PointCloud2& scan = *arrival.scan;
  CollectOutcome outcome = collector_.process(scan, [this](const std::function<bool()>& ready) {
    return scans_.pollUntil(ready, Seconds(config_.tf_timeout_s));
  });
  if (outcome.time_jumped) {
    ROS_WARN("pose_resampler: time of '%s' jumped back to %.3f s, the path begins anew",
             scan.header.frame_id.c_str(), scan.header.stamp.toSec());
    startPath(collector_.journey());
  }
  if (outcome.drop) {
    reportScanDrop(scan, *outcome.drop, outcome.detail);
  } else {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    statistics_.addScan(outcome.use);
  }
  for (CollectedPose& pose : outcome.complete) passOn(std::move(pose), arrival.time);
}

void PoseResamplerNode::completeAfterPause(const ros::WallTime& last_arrival) {
  if (!collector_.gathering()) return;
  const ros::WallTime now = ros::WallTime::now();
  if ((now - last_arrival).toSec() >= config_.gather_timeout_s) passOn(collector_.close(), now);
}

void PoseResamplerNode::passOn(std::optional<CollectedPose> pose, const ros::WallTime& arrival) {
  if (!pose) return;
  {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    statistics_.addComplete(pose->pose.id, arrival);
  }
  const bool full = poses_.size() >= static_cast<std::size_t>(config_.pose_queue_size);
  if (full && backlog_warnings_.opens(0)) {
    ROS_WARN(
        "pose_resampler: pose_queue_size %d poses wait to be re-sampled; scans on '%s' have to "
        "wait, too",
        config_.pose_queue_size, handle_.resolveName("points").c_str());
  }
  poses_.pushWhenRoom(std::move(*pose));
}

void PoseResamplerNode::startPath(uint64_t journey) {
  {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    statistics_.addReset();
  }
  const std::lock_guard<std::mutex> lock(path_mutex_);
  path_journey_ = journey;
  path_.poses.clear();
  path_publisher_.publish(boost::make_shared<nav_msgs::Path>(path_));
}

void PoseResamplerNode::reportScanDrop(const sensor_msgs::PointCloud2& scan, ScanDrop reason,
                                       const std::string& detail) {
  {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    statistics_.addScanDrop(scan, reason);
    if (!scan_warnings_.opens(reason)) return;
  }
  ROS_WARN("pose_resampler: scan on '%s' at %.3f s in frame '%s' dropped, %s: %s",
           handle_.resolveName("points").c_str(), scan.header.stamp.toSec(),
           scan.header.frame_id.c_str(), scanDropName(reason), detail.c_str());
}

void PoseResamplerNode::resample() {
  while (const auto pose = poses_.pop()) {
    try {
      resamplePose(*pose);
    } catch (const std::runtime_error& error) {
      reportPoseDrop(*pose, PoseDrop::kMissingField, error.what());
    } catch (const std::exception& error) {
      reportPoseDrop(*pose, PoseDrop::kError, error.what());
    }
  }
}

void PoseResamplerNode::resamplePose(const CollectedPose& pose) {
  const ResampledCloud samples = resampler_.resample(pose.pose.points, policies_);
  if (samples.size() == 0) {
    reportPoseDrop(pose, PoseDrop::kNoSamples,
                   "of " + std::to_string(samples.points_finite) + " points in " +
                       std::to_string(samples.dropped_components) + " parts, none is large enough");
    return;
  }
  publish(pose, samples);
}

void PoseResamplerNode::publish(const CollectedPose& pose, const ResampledCloud& samples) {
  const bool pose_wanted = pose_publisher_.getNumSubscribers() > 0;
  const bool points_wanted = points_publisher_.getNumSubscribers() > 0;
  if (pose_wanted || points_wanted) {
    const auto cloud = boost::make_shared<sensor_msgs::PointCloud2>(makeSampleCloud(pose, samples));
    if (pose_wanted) {
      ros::Time stamp;
      stamp.fromNSec(pose.pose.stamp_ns);
      pose_publisher_.publish(
          makePoseCloud(pose, config_.odom_frame, odometry_.covarianceAt(stamp), *cloud));
    }
    if (points_wanted) points_publisher_.publish(cloud);
  }
  extendPath(pose);
  std_msgs::Header header;
  header.stamp.fromNSec(pose.pose.stamp_ns);
  header.frame_id = config_.odom_frame;
  const std::lock_guard<std::mutex> lock(statistics_mutex_);
  statistics_.addPublished(pose.pose.id, header, samples);
}

void PoseResamplerNode::extendPath(const CollectedPose& pose) {
  const std::lock_guard<std::mutex> lock(path_mutex_);
  if (pose.journey != path_journey_) return;
  geometry_msgs::PoseStamped stamped;
  stamped.header.stamp.fromNSec(pose.pose.stamp_ns);
  stamped.header.frame_id = config_.odom_frame;
  stamped.pose = poseMessage(pose.pose.T_map_vehicle);
  path_.header.stamp = stamped.header.stamp;
  path_.poses.push_back(stamped);
  path_publisher_.publish(boost::make_shared<nav_msgs::Path>(path_));
}

void PoseResamplerNode::reportPoseDrop(const CollectedPose& pose, PoseDrop reason,
                                       const std::string& detail) {
  {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    statistics_.addPoseDrop(pose.pose.id, reason);
    if (!pose_warnings_.opens(reason)) return;
  }
  ROS_WARN("pose_resampler: pose %lu of '%s' at %.3f s dropped, %s: %s",
           static_cast<unsigned long>(pose.pose.id), handle_.resolveName("points").c_str(),
           static_cast<double>(pose.pose.stamp_ns) * 1e-9, poseDropName(reason), detail.c_str());
}

PoseResamplerStatistics PoseResamplerNode::statisticsMessage() {
  const std::lock_guard<std::mutex> lock(statistics_mutex_);
  PoseResamplerStatistics message = statistics_.message();
  message.scans_waiting = static_cast<uint32_t>(scans_.size());
  message.odometry = odometry_.taken();
  message.odometry_ignored = odometry_.ignored();
  return message;
}

void PoseResamplerNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const PoseResamplerStatistics message = statisticsMessage();
  const std::lock_guard<std::mutex> lock(statistics_mutex_);
  const uint64_t scan_drops = statistics_.scansDropped();
  const uint64_t pose_drops = statistics_.posesDropped();
  if (pose_drops > diagnosed_pose_drops_) {
    status.summaryf(DiagnosticStatus::ERROR, "%lu poses dropped since the last report",
                    static_cast<unsigned long>(pose_drops - diagnosed_pose_drops_));
  } else if (scan_drops > diagnosed_scan_drops_) {
    status.summaryf(DiagnosticStatus::WARN, "%lu scans dropped since the last report",
                    static_cast<unsigned long>(scan_drops - diagnosed_scan_drops_));
  } else if (message.poses_waiting > static_cast<uint32_t>(config_.pose_queue_size)) {
    status.summaryf(DiagnosticStatus::WARN, "%u poses wait: they come faster than re-sampling is",
                    message.poses_waiting);
  } else if (statistics_.scans() == diagnosed_scans_) {
    status.summary(DiagnosticStatus::WARN, "no scans on " + handle_.resolveName("points"));
  } else {
    status.summary(DiagnosticStatus::OK, "keeping poses");
  }
  diagnosed_scans_ = statistics_.scans();
  diagnosed_scan_drops_ = scan_drops;
  diagnosed_pose_drops_ = pose_drops;
  status.add("scans", message.scans);
  status.add("scans between poses", message.scans_between);
  status.add("scans waiting", message.scans_waiting);
  addDrops("scans dropped", message.scans_dropped, &status);
  addDrops("points dropped", message.points_dropped, &status);
  status.add("poses", message.poses);
  status.add("poses published", message.poses_published);
  status.add("poses waiting", message.poses_waiting);
  status.add("backlog (s)", message.backlog_s);
  addDrops("poses dropped", message.poses_dropped, &status);
  status.add("lag p50 (ms)", message.lag_p50_ms);
  status.add("lag p99 (ms)", message.lag_p99_ms);
  for (const StageTime& stage : message.stages) {
    status.add("re-sampling: " + stage.stage + " p50 (ms)", stage.p50_ms);
  }
  status.add("samples", message.samples);
  status.add("odometry messages", message.odometry);
  status.add("odometry of other frames", message.odometry_ignored);
  status.add("resets", message.resets);
  status.add("policies", message.policies);
}

}  // namespace ladar_perception
