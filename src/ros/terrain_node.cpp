// SPDX-License-Identifier: BSD-3-Clause
#include "terrain_node.h"

#include <boost/make_shared.hpp>
#include <chrono>

#include "cloud_message.h"
#include "statistics_parts.h"

namespace ladar_perception {
namespace {

constexpr std::size_t kStatisticsWindow = 1000;
constexpr double kWarningPeriod_s = 5.0;
constexpr uint32_t kBurst = 1000;  // scans

double millisecondsSince(const ros::WallTime& begin) {
  return (ros::WallTime::now() - begin).toSec() * 1e3;
}

}  // namespace

TerrainNode::TerrainNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle)
    : handle_(handle),
      private_handle_(private_handle),
      config_(readConfig<TerrainNodeConfig>(private_handle)),
      model_(loadFittingModel(config_)),
      tf_listener_(tf_buffer_, handle_),
      processor_(config_, model_, &tf_buffer_),
      statistics_(config_.model, kStatisticsWindow),
      queue_(static_cast<std::size_t>(config_.queue_size)),
      diagnostics_(handle_, private_handle_, private_handle_.getNamespace()) {
  points_publisher_ = handle_.advertise<sensor_msgs::PointCloud2>("labeled_points", 2);
  map_publisher_ = handle_.advertise<sensor_msgs::PointCloud2>("labeled_map", 1, true);
  statistics_publisher_ = handle_.advertise<TerrainStatistics>("statistics", 1, true);
  reset_service_ = private_handle_.advertiseService("reset", &TerrainNode::onReset, this);
  diagnostics_.setHardwareID("none");
  diagnostics_.add("terrain", this, &TerrainNode::diagnose);
  timer_ = handle_.createWallTimer(ros::WallDuration(1.0 / config_.statistics_rate_hz),
                                   &TerrainNode::onTimer, this);
  worker_ = std::thread([this] { work(); });
  ROS_INFO("terrain: model %s (%zu classes), map %g x %g x %g m of %g m voxels in %s",
           config_.model.c_str(), model_.classes.size(), config_.pipeline.map_size_x_m,
           config_.pipeline.map_size_y_m, config_.pipeline.map_size_z_m,
           config_.pipeline.voxel_size_m, config_.map_frame.c_str());
  // The queue of our own does the waiting and the counting. This one drops without a word, so it
  // is long enough for any burst that comes while a callback runs.
  subscriber_ = handle_.subscribe("points", kBurst, &TerrainNode::onScan, this);
}

TerrainNode::~TerrainNode() {
  subscriber_.shutdown();
  timer_.stop();
  queue_.stop();
  worker_.join();
}

void TerrainNode::onScan(const sensor_msgs::PointCloud2ConstPtr& scan) {
  const auto displaced = queue_.pushOverOldest({scan, ros::WallTime::now()});
  if (displaced) {
    reportDrop(*displaced->scan, ScanDrop::kQueueFull,
               "more than queue_size " + std::to_string(config_.queue_size) + " scans waiting");
  }
}

bool TerrainNode::onReset(std_srvs::Trigger::Request& /*request*/,
                          std_srvs::Trigger::Response& response) {
  {
    const std::lock_guard<std::mutex> lock(processor_mutex_);
    processor_.reset();
  }
  const std::lock_guard<std::mutex> lock(statistics_mutex_);
  statistics_.addReset();
  response.success = true;
  response.message = "the map is empty";
  ROS_INFO("terrain: map reset on request");
  return true;
}

void TerrainNode::onTimer(const ros::WallTimerEvent& /*event*/) {
  {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    statistics_publisher_.publish(
        boost::make_shared<TerrainStatistics>(statistics_.message(model_)));
  }
  diagnostics_.update();
}

void TerrainNode::work() {
  while (const auto arrival = queue_.pop()) {
    try {
      processArrival(*arrival);
    } catch (const std::exception& error) {
      // Whatever it was, it concerned one scan; the manager and the other nodelets go on.
      reportDrop(*arrival->scan, ScanDrop::kError, error.what());
    }
  }
}

void TerrainNode::processArrival(const Arrival& arrival) {
  const sensor_msgs::PointCloud2& scan = *arrival.scan;
  std::unique_lock<std::mutex> lock(processor_mutex_);
  const ScanOutcome outcome =
      processor_.process(scan, [this, &lock](const std::function<bool()>& ready) {
        // ~reset must not wait for tf: it would hold a thread of the manager up.
        lock.unlock();
        const bool all_there =
            queue_.pollUntil(ready, std::chrono::duration<double>(config_.tf_timeout_s));
        lock.lock();
        return all_there;
      });
  if (outcome.map_reset) {
    ROS_WARN("terrain: time of '%s' jumped back to %.3f s, the map was reset",
             scan.header.frame_id.c_str(), scan.header.stamp.toSec());
    last_map_stamp_ = ros::Time();
    const std::lock_guard<std::mutex> statistics_lock(statistics_mutex_);
    statistics_.addReset();
  }
  if (outcome.drop) {
    reportDrop(scan, *outcome.drop, outcome.detail);
    return;
  }
  publishScan(scan);
  {
    const std::lock_guard<std::mutex> statistics_lock(statistics_mutex_);
    statistics_.addScan(scan, processor_.pipeline().report(), millisecondsSince(arrival.time));
  }
  publishMap(scan, outcome.p_map_vehicle);
}

void TerrainNode::reportDrop(const sensor_msgs::PointCloud2& scan, ScanDrop reason,
                             const std::string& detail) {
  {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    statistics_.addDrop(scan, reason);
  }
  ROS_WARN_THROTTLE(kWarningPeriod_s,
                    "terrain: scan on '%s' at %.3f s in frame '%s' dropped, %s: %s",
                    handle_.resolveName("points").c_str(), scan.header.stamp.toSec(),
                    scan.header.frame_id.c_str(), scanDropName(reason), detail.c_str());
}

void TerrainNode::publishScan(const sensor_msgs::PointCloud2& scan) {
  if (points_publisher_.getNumSubscribers() == 0) return;
  points_publisher_.publish(
      makeLabeledPoints(scan, processor_.scanLayout(), processor_.pipeline()));
}

void TerrainNode::publishMap(const sensor_msgs::PointCloud2& scan,
                             const Eigen::Vector3d& p_map_vehicle) {
  if (config_.map_rate_hz <= 0.0 || map_publisher_.getNumSubscribers() == 0) return;
  const ros::Time& stamp = scan.header.stamp;
  if (!last_map_stamp_.isZero() && (stamp - last_map_stamp_).toSec() < 1.0 / config_.map_rate_hz) {
    return;
  }
  last_map_stamp_ = stamp;
  std_msgs::Header header = scan.header;
  header.frame_id = config_.map_frame;
  map_publisher_.publish(
      makeLabeledMap(processor_.pipeline(), header, p_map_vehicle, config_.map_radius_m));
}

void TerrainNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const std::lock_guard<std::mutex> lock(statistics_mutex_);
  const uint64_t drops = statistics_.scansDropped();
  if (drops > diagnosed_drops_) {
    status.summaryf(DiagnosticStatus::WARN, "%lu scans dropped since the last report",
                    static_cast<unsigned long>(drops - diagnosed_drops_));
  } else if (statistics_.scans() == diagnosed_scans_) {
    status.summary(DiagnosticStatus::WARN, "no scans on " + handle_.resolveName("points"));
  } else {
    status.summary(DiagnosticStatus::OK, "labelling scans");
  }
  diagnosed_scans_ = statistics_.scans();
  diagnosed_drops_ = drops;
  const TerrainStatistics message = statistics_.message(model_);
  status.add("scans", message.scans);
  status.add("scan rate (Hz)", message.scan_rate_hz);
  status.add("points per second", message.points_per_second);
  status.add("latency p50 (ms)", message.latency_p50_ms);
  status.add("latency p99 (ms)", message.latency_p99_ms);
  addDrops("scans dropped", message.scans_dropped, &status);
  addDrops("points dropped", message.points_dropped, &status);
  status.add("occupied voxels", message.occupied_voxels);
  status.add("memory (MB)", static_cast<double>(message.memory_bytes) * 1e-6);
  status.add("map resets", message.resets);
  status.add("model", message.model);
}

}  // namespace ladar_perception
