// SPDX-License-Identifier: BSD-3-Clause
// Starts that must fail with one report, of every node.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "ros_nodelets.h"
#include "ros_process.h"

namespace ladar_perception::test {

/// Parameters of one start, and what the report must say of them.
struct BadStart {
  std::string name;
  ParamMap parameters;
  std::vector<std::string> report;
  /// Sets what a ParamMap cannot hold.
  std::function<void(const std::string& node)> more = {};
};

template <typename Client>
void setBadParameters(const std::string& node, const BadStart& start) {
  setTestParameters<Client>(node);
  setParameters(node, start.parameters);
  if (start.more) start.more(node);
}

inline void expectReport(const std::string& text, const BadStart& start) {
  for (const std::string& part : start.report) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in:\n" << text;
  }
}

/// The program ends with status 1 and one report.
template <typename Client>
void expectProgramRefuses(const std::string& program_name, const std::vector<BadStart>& starts) {
  for (const BadStart& start : starts) {
    SCOPED_TRACE(start.name);
    const std::string node = "/node_" + start.name;
    setBadParameters<Client>(node, start);
    TemporaryFolder folder;
    const std::string output = folder.file("output.txt");
    ChildProcess program({programPath(program_name), "__name:=" + node.substr(1)}, output);
    ASSERT_TRUE(waitFor([&] { return !program.running(); })) << "it runs all the same";
    EXPECT_EQ(program.exitCode(), 1);
    const std::string text = textOf(output);
    expectReport(text, start);
    // One report, not one more after another start.
    const std::size_t fatal = text.find("FATAL");
    EXPECT_NE(fatal, std::string::npos) << text;
    EXPECT_EQ(text.find("FATAL", fatal + 1), std::string::npos) << text;
    ros::param::del(node);
  }
}

/// The nodelet is not loaded, and the manager logs the report.
template <typename Client>
void expectManagerRefuses(const std::vector<BadStart>& starts) {
  const Manager manager("/manager");
  for (const BadStart& start : starts) {
    SCOPED_TRACE(start.name);
    const std::string nodelet = "/nodelet_" + start.name;
    setBadParameters<Client>(nodelet, start);
    LogListener log;
    // The manager's log has to be connected before it has anything to say.
    ASSERT_TRUE(log.hears("/manager"));
    EXPECT_FALSE(manager.load(nodelet, Client::kNodelet));
    EXPECT_TRUE(waitFor([&] { return log.count(start.report.back()) > 0; }));
    expectReport(log.find(start.report.back()), start);
    ros::param::del(nodelet);
  }
}

}  // namespace ladar_perception::test
