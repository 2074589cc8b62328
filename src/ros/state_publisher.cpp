// SPDX-License-Identifier: BSD-3-Clause
#include "state_publisher.h"

#include <algorithm>
#include <utility>

namespace ladar_perception {

StatePublisher::StatePublisher(ros::NodeHandle handle, const DelayedStateNodeConfig& config)
    : handle_(std::move(handle)) {
  add<nav_msgs::Path>("path", config.graph_rate_hz, [](const auto& publisher, const auto& state) {
    publisher.publish(makePath(state));
  });
  add<StateGraph>("pose_graph", config.graph_rate_hz, [](const auto& publisher, const auto& state) {
    publisher.publish(makeStateGraph(state));
  });
  add<visualization_msgs::MarkerArray>(
      "pose_graph_markers", config.graph_rate_hz,
      [hops = config.state.loop_hops](const auto& publisher, const auto& state) {
        publisher.publish(makeGraphMarkers(state, hops));
      });
  if (config.map_rate_hz > 0.0) {
    const auto samples = static_cast<std::size_t>(config.map_samples_per_pose);
    add<sensor_msgs::PointCloud2>("map_cloud", config.map_rate_hz,
                                  [samples](const auto& publisher, const auto& state) {
                                    publisher.publish(makeMapCloudMessage(state, samples));
                                  });
  }
  worker_ = std::thread([this] { work(); });
}

StatePublisher::~StatePublisher() {
  jobs_.stop();
  worker_.join();
}

template <typename Message>
void StatePublisher::add(const std::string& topic, double rate_hz, Send send) {
  outputs_.push_back(std::make_unique<Output>());
  Output* output = outputs_.back().get();
  output->period = ros::WallDuration(1.0 / rate_hz);
  output->send = std::move(send);
  output->publisher = handle_.advertise<Message>(topic, 1, true);
}

void StatePublisher::changed() {
  for (const auto& output : outputs_) output->outdated = true;
}

bool StatePublisher::isDue(const Output& output) {
  return output.outdated && output.publisher.getNumSubscribers() > 0 &&
         ros::WallTime::now() - output.last >= output.period;
}

bool StatePublisher::wants() const {
  return !busy_ && std::any_of(outputs_.begin(), outputs_.end(),
                               [](const auto& output) { return isDue(*output); });
}

void StatePublisher::publish(std::shared_ptr<const StateSnapshot> state) {
  Job job{std::move(state), {}};
  for (const auto& output : outputs_) {
    if (!isDue(*output)) continue;
    output->outdated = false;
    output->last = ros::WallTime::now();
    job.outputs.push_back(output.get());
  }
  busy_ = true;
  jobs_.pushOverOldest(std::move(job));
}

void StatePublisher::work() {
  while (const auto job = jobs_.pop()) {
    for (const Output* output : job->outputs) {
      try {
        output->send(output->publisher, *job->state);
      } catch (const std::exception& error) {
        ROS_ERROR_THROTTLE(5.0, "delayed_state: %s cannot be published: %s",
                           output->publisher.getTopic().c_str(), error.what());
      }
    }
    busy_ = false;
  }
}

}  // namespace ladar_perception
