// SPDX-License-Identifier: BSD-3-Clause
// What all programs say of arguments that they do not understand.
#include "program_run.h"

namespace ladar_perception::test {
namespace {

const std::vector<std::string> kPrograms = {
    "classify_bag",   "evaluate_classifier", "import_scans", "registration_basin",
    "resample_cloud", "simulate_ladar",      "slam_bag",     "train_classifier"};

TEST(CommandLine, NamesTheOptionThatIsUnknownBeforeWhatIsMissing) {
  for (const std::string& program : kPrograms) {
    const ProgramRun run = runProgram(program, {"--bogus"});
    expectFailure(run, {program, "--bogus"});
    EXPECT_EQ(run.err.find("required"), std::string::npos) << run.err;
  }
}

TEST(CommandLine, NamesEveryUnknownOption) {
  expectFailure(runProgram("slam_bag", {"--one", "drive.bag", "--two"}), {"--one --two"});
}

TEST(CommandLine, NamesWhatIsMissing) {
  expectFailure(runProgram("slam_bag", {}), {"slam_bag", "input is required"});
  expectFailure(runProgram("slam_bag", {"drive.bag"}), {"--out is required"});
}

}  // namespace
}  // namespace ladar_perception::test
