// SPDX-License-Identifier: BSD-3-Clause
// Waiting, and ears for what nodes log and diagnose. Callbacks run inside waitFor only, so that no
// test needs a lock.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/callback_queue.h>
#include <ros/network.h>
#include <ros/ros.h>
#include <ros/xmlrpc_manager.h>
#include <rosgraph_msgs/Log.h>

namespace ladar_perception::test {

/// For whatever must come; only a failing test waits so long.
constexpr double kPatience_s = 30.0;

/// Handles messages until the condition holds or time (of the wall) is up; says which.
inline bool waitFor(const std::function<bool()>& condition, double timeout_s = kPatience_s) {
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(timeout_s);
  while (ros::ok()) {
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.005));
    if (condition()) return true;
    if (ros::WallTime::now() > end) return false;
  }
  return false;
}

/// Log messages of all nodes.
class LogListener {
 public:
  LogListener() {
    subscriber_ = ros::NodeHandle().subscribe<rosgraph_msgs::Log>(
        "/rosout", 1000, [this](const rosgraph_msgs::LogConstPtr& log) { logs_.push_back(*log); });
  }
  /// Waits until the log of a node is connected: nobody repeats what was said before.
  bool hears(const std::string& node) const {
    return waitFor([&] {
      XmlRpc::XmlRpcValue request, response, uri, connections;
      request[0] = ros::this_node::getName();
      request[1] = node;
      if (!ros::master::execute("lookupNode", request, response, uri, false)) return false;
      // This process's own list of its connections, as rosnode info asks for it.
      std::string host;
      uint32_t port = 0;
      ros::network::splitURI(ros::XMLRPCManager::instance()->getServerURI(), host, port);
      XmlRpc::XmlRpcClient self(host.c_str(), static_cast<int>(port), "/");
      XmlRpc::XmlRpcValue caller;
      caller[0] = ros::this_node::getName();
      if (!self.execute("getBusInfo", caller, response) || response.size() < 3) return false;
      connections = response[2];
      for (int i = 0; i < connections.size(); ++i) {
        const std::string peer = connections[i][1];
        const std::string topic = connections[i][4];
        if (topic == "/rosout" && peer == static_cast<std::string>(uri)) return true;
      }
      return false;
    });
  }
  int count(const std::string& text) const {
    int hits = 0;
    for (const auto& log : logs_) hits += log.msg.find(text) != std::string::npos ? 1 : 0;
    return hits;
  }
  /// The first message with the text in it, or "".
  std::string find(const std::string& text) const {
    for (const auto& log : logs_) {
      if (log.msg.find(text) != std::string::npos) return log.msg;
    }
    return "";
  }

 private:
  std::vector<rosgraph_msgs::Log> logs_;
  ros::Subscriber subscriber_;
};

/// The last diagnostics of the statuses whose name has a text in it.
class DiagnosticsListener {
 public:
  explicit DiagnosticsListener(const std::string& name) {
    using diagnostic_msgs::DiagnosticArrayConstPtr;
    subscriber_ = ros::NodeHandle().subscribe<diagnostic_msgs::DiagnosticArray>(
        "/diagnostics", 100, [this, name](const DiagnosticArrayConstPtr& message) {
          for (const auto& status : message->status) {
            if (status.name.find(name) == std::string::npos) continue;
            summary = status.message;
            for (const auto& entry : status.values) values[entry.key] = entry.value;
          }
        });
  }

  std::map<std::string, std::string> values;
  std::string summary;

 private:
  ros::Subscriber subscriber_;
};

}  // namespace ladar_perception::test
