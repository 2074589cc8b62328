// SPDX-License-Identifier: BSD-3-Clause
// Nodelets in a manager, with their parameters and clients.
//
// A client feeds a node and reads what it publishes. It has the nodelet's type as kNodelet, the
// node's name as kName, parameters for tests as testParameters(), a constructor from the node's
// name and the namespace of its topics, connected() and disconnected().
#pragma once

#include <gtest/gtest.h>
#include <ladar_perception/DropCount.h>
#include <nodelet/NodeletLoad.h>
#include <nodelet/NodeletUnload.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ladar_perception/params/param_table.h"
#include "ros_listeners.h"

namespace ladar_perception::test {

/// Calls a service without standing still meanwhile: false if it does not answer in time.
template <typename Service>
bool callService(const std::string& name, Service* service, double timeout_s = kPatience_s) {
  bool there = false;
  waitFor([&] { return there = ros::service::exists(name, false); }, timeout_s);
  return there && ros::service::call(name, *service);
}

/// Count under a reason; ~0 if the reason is not listed.
inline uint64_t countOf(const std::vector<DropCount>& drops, const std::string& reason) {
  for (const DropCount& drop : drops) {
    if (drop.reason == reason) return drop.count;
  }
  return ~uint64_t{0};
}

inline uint64_t sumOf(const std::vector<DropCount>& drops) {
  uint64_t sum = 0;
  for (const DropCount& drop : drops) sum += drop.count;
  return sum;
}

/// Puts parameters where a node reads them.
inline void setParameters(const std::string& node_name, const ParamMap& parameters) {
  for (const auto& [name, value] : parameters) {
    const std::string key = node_name + "/" + name;
    if (const auto* flag = std::get_if<bool>(&value)) ros::param::set(key, *flag);
    if (const auto* whole = std::get_if<int>(&value)) ros::param::set(key, *whole);
    if (const auto* real = std::get_if<double>(&value)) ros::param::set(key, *real);
    if (const auto* text = std::get_if<std::string>(&value)) ros::param::set(key, *text);
  }
}

/// Puts parameters for tests there, and no others.
template <typename Client>
void setTestParameters(const std::string& node_name) {
  ros::param::del(node_name);
  setParameters(node_name, Client::testParameters());
}

/// A nodelet manager that a .test file starts.
class Manager {
 public:
  explicit Manager(std::string name) : name_(std::move(name)) {}

  /// Loads a nodelet as `nodelet_name` with the parameters that stand there.
  bool load(const std::string& nodelet_name, const std::string& type) const {
    nodelet::NodeletLoad load;
    load.request.name = nodelet_name;
    load.request.type = type;
    return callService(name_ + "/load_nodelet", &load) && load.response.success;
  }
  bool unload(const std::string& nodelet_name) const {
    nodelet::NodeletUnload unload;
    unload.request.name = nodelet_name;
    return callService(name_ + "/unload_nodelet", &unload) && unload.response.success;
  }

 private:
  std::string name_;
};

/// A nodelet <ns>/<name> in the manager /manager, with test parameters and `parameters` besides,
/// and its client; both as long as the object lives.
template <typename Client>
class LoadedNodelet {
 public:
  explicit LoadedNodelet(const std::string& ns, const ParamMap& parameters = {})
      : name_(ns + "/" + Client::kName), client_(std::make_unique<Client>(name_, ns)) {
    setTestParameters<Client>(name_);
    setParameters(name_, parameters);
    loaded_ = manager_.load(name_, Client::kNodelet);
    connected_ = loaded_ && client_->connected();
  }
  ~LoadedNodelet() {
    EXPECT_TRUE(!loaded_ || manager_.unload(name_));
    EXPECT_TRUE(client_->disconnected());
    ros::param::del(name_);
  }
  LoadedNodelet(const LoadedNodelet&) = delete;
  LoadedNodelet& operator=(const LoadedNodelet&) = delete;

  /// Whether it loaded and all its topics stand.
  bool ready() const { return connected_; }
  Client* operator->() { return client_.get(); }
  Client& operator*() { return *client_; }

 private:
  std::string name_;
  Manager manager_{"/manager"};
  std::unique_ptr<Client> client_;
  bool loaded_ = false;
  bool connected_ = false;
};

/// main() of a test under rostest.
inline int runRosTest(int argc, char** argv, const std::string& name) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, name);
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}

}  // namespace ladar_perception::test
