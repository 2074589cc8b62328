// SPDX-License-Identifier: BSD-3-Clause
// What the tests of classify_bag share: a simulated bag, and how to run the program on it.
#pragma once

#include <std_msgs/String.h>

#include <memory>
#include <string>
#include <vector>

#include "program_bag.h"
#include "program_run.h"

namespace ladar_perception::test {

using Json = nlohmann::json;

inline uint64_t sumOf(const Json& counts) {
  uint64_t sum = 0;
  for (const auto& count : counts) sum += count.get<uint64_t>();
  return sum;
}

inline void expectSumsUp(const Json& metrics) {
  EXPECT_EQ(metrics.at("points_in").get<uint64_t>(),
            metrics.at("points_inserted").get<uint64_t>() + sumOf(metrics.at("dropped")))
      << metrics;
}

/// The same bag for all tests: a simulated forest with a latched message of somebody else.
class ClassifyBag : public ::testing::Test {
 protected:
  static constexpr std::size_t kScans = 40;
  static constexpr std::size_t kPointsPerScan = std::size_t{180} * 32;

  static void SetUpTestSuite() {
    shared_ = std::make_unique<ScratchFolder>();
    const std::string simulated = shared_->file("simulated.bag");
    expectSuccess(runProgram("simulate_ladar", {"--scene", "forest", "--duration", "2", "--seed",
                                                "17", "--out", simulated}));
    rosbag::Bag bag(shared_->file("forest.bag"), rosbag::bagmode::Write);
    copyBag(simulated, writeAsItIs, &bag);
    std_msgs::String note;
    note.data = "keep me";
    const auto header = boost::make_shared<ros::M_string>();
    (*header)["latching"] = "1";
    (*header)["callerid"] = "/writer";
    (*header)["type"] = ros::message_traits::datatype(note);
    (*header)["md5sum"] = ros::message_traits::md5sum(note);
    (*header)["message_definition"] = ros::message_traits::definition(note);
    bag.write("/note", ros::Time(1000.7), note, header);
    bag.close();
  }
  static void TearDownTestSuite() { shared_.reset(); }

  static std::string forest() { return shared_->file("forest.bag"); }

  /// Runs on `input` with --out and --metrics in this test's folder.
  ProgramRun classify(const std::string& input, std::vector<std::string> more = {},
                      const std::string& name = "run") {
    more.insert(more.begin(),
                {input, "--out", out(name), "--metrics", folder_.file(name + ".json")});
    return runProgram("classify_bag", more);
  }
  std::string out(const std::string& name = "run") const { return folder_.file(name + ".bag"); }
  Json metrics(const std::string& name = "run") const {
    return readJson(folder_.file(name + ".json"));
  }

  ScratchFolder folder_;

 private:
  inline static std::unique_ptr<ScratchFolder> shared_;
};

}  // namespace ladar_perception::test
