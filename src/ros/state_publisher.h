// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/ros.h>

#include <atomic>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "delayed_state_node_config.h"
#include "ladar_perception/util/work_queue.h"
#include "state_messages.h"

namespace ladar_perception {

/// Publishes `path`, `pose_graph`, `pose_graph_markers` and `map_cloud`, latched: each when it
/// changed, but not more often than its rate, and only while somebody subscribes.
/// Messages, which take time in proportion to the poses, are made on a thread of its own.
class StatePublisher {
 public:
  StatePublisher(ros::NodeHandle handle, const DelayedStateNodeConfig& config);
  ~StatePublisher();
  StatePublisher(const StatePublisher&) = delete;
  StatePublisher& operator=(const StatePublisher&) = delete;

  /// The estimate is another one. This and the two below are for one thread.
  void changed();
  /// Whether an output is due and has not got the present estimate.
  bool wants() const;
  /// Publishes what is due. Call it if wants().
  void publish(std::shared_ptr<const StateSnapshot> state);

 private:
  using Send = std::function<void(const ros::Publisher&, const StateSnapshot&)>;
  struct Output {
    ros::Publisher publisher;
    ros::WallDuration period;
    Send send;
    ros::WallTime last;
    bool outdated = true;
  };
  struct Job {
    std::shared_ptr<const StateSnapshot> state;
    std::vector<const Output*> outputs;
  };

  template <typename Message>
  void add(const std::string& topic, double rate_hz, Send send);
  static bool isDue(const Output& output);
  void work();

  ros::NodeHandle handle_;
  std::vector<std::unique_ptr<Output>> outputs_;
  std::atomic<bool> busy_{false};
  WorkQueue<Job> jobs_{1};
  std::thread worker_;
};

}  // namespace ladar_perception
