// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "io_test_files.h"
#include "ladar_perception/slam/delayed_state.h"
#include "slam_stand_in.h"

namespace ladar_perception {
namespace {

using test::driftingOdometry;
using test::squareDrive;
using test::standIn;
using test::statePose;

using Drive = std::vector<Eigen::Isometry3d>;

std::string bytesOfFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void drive(const Drive& odometry, int begin, int end, DelayedState* state) {
  for (int i = begin; i < end; ++i) {
    StatePose pose = statePose(i, odometry[i]);
    if (i % 3 == 0) pose.step_covariance = diagonalCovariance(0.3, 0.05);
    state->add(pose);
  }
}

void expectEqual(const DelayedState& a, const DelayedState& b) {
  ASSERT_EQ(a.size(), b.size());
  for (int i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.graph().pose(i).matrix(), b.graph().pose(i).matrix()) << i;
    EXPECT_EQ(a.pose(i).T_odom_pose.matrix(), b.pose(i).T_odom_pose.matrix());
    EXPECT_EQ(a.pose(i).stamp_s, b.pose(i).stamp_s);
    EXPECT_EQ(a.pose(i).step_covariance, b.pose(i).step_covariance);
    const PoseSamples& samples = *a.pose(i).samples;
    EXPECT_EQ(samples.positions_m, b.pose(i).samples->positions_m);
    EXPECT_EQ(samples.normals, b.pose(i).samples->normals);
    EXPECT_EQ(samples.rgb, b.pose(i).samples->rgb);
    EXPECT_EQ(samples.labels, b.pose(i).samples->labels);
  }
  ASSERT_EQ(a.graph().constraints().size(), b.graph().constraints().size());
  for (std::size_t i = 0; i < a.graph().constraints().size(); ++i) {
    const PoseConstraint& c = a.graph().constraints()[i];
    const PoseConstraint& d = b.graph().constraints()[i];
    EXPECT_EQ(c.from, d.from);
    EXPECT_EQ(c.to, d.to);
    EXPECT_EQ(c.kind, d.kind);
    EXPECT_EQ(c.enabled, d.enabled);
    EXPECT_EQ(c.T_from_to.matrix(), d.T_from_to.matrix());
    EXPECT_EQ(c.information, d.information);
  }
  EXPECT_EQ(a.counts().tried, b.counts().tried);
  EXPECT_EQ(a.counts().accepted, b.counts().accepted);
  EXPECT_EQ(a.counts().rejected(), b.counts().rejected());
  EXPECT_EQ(a.counts().waiting, b.counts().waiting);
}

/// A drive whose first registration of a closing loop waits at pose 60.
struct Case {
  Drive truth = squareDrive(15, 2, 1.0);
  Drive odometry = driftingOdometry(truth, 1.02, 0.05);
  DelayedState state() const {
    DelayedStateConfig config;
    config.confirm_sigma_m = 0.3;
    return {config, standIn(truth, [](int from, int to, RegistrationOutcome* outcome) {
              if (to - from < 30 && to % 5 != 0) outcome->overlap = 0.0;
            })};
  }
};

TEST(SlamStateFile, GoesOnAsIfThereHadBeenNoBreak) {
  const Case c;
  bool waited = false;
  DelayedState whole = c.state();
  const std::string path = (testFolder() / "state.bin").string();
  for (int cut = 0; cut <= 80; cut += 4) {
    drive(c.odometry, std::max(cut - 4, 0), cut, &whole);
    whole.save(path);
    DelayedState loaded = c.state();
    drive(c.odometry, 0, 7, &loaded);  // forgotten
    loaded.load(path);
    expectEqual(whole, loaded);
    waited = waited || whole.counts().waiting > 0;
    if (cut != 60) continue;
    DelayedState on = c.state();
    drive(c.odometry, 0, 80, &on);
    drive(c.odometry, cut, 80, &loaded);
    expectEqual(on, loaded);
  }
  EXPECT_TRUE(waited) << "what waits must have been saved, too";
  EXPECT_GT(whole.counts().accepted, 20u);
}

TEST(SlamStateFile, AnEmptyStateIsOne) {
  const Case c;
  DelayedState state = c.state();
  const std::string path = (testFolder() / "state.bin").string();
  state.save(path);
  drive(c.odometry, 0, 3, &state);
  state.load(path);
  EXPECT_EQ(state.size(), 0);
}

TEST(SlamStateFile, SaysWhatIsWrongAndChangesNothing) {
  const Case c;
  DelayedState state = c.state();
  drive(c.odometry, 0, 10, &state);
  const std::string path = (testFolder() / "state.bin").string();
  state.save(path);
  const std::string bytes = bytesOfFile(path);
  DelayedState other = c.state();
  drive(c.odometry, 0, 5, &other);
  const auto expectRefused = [&](const std::string& changed,
                                 const std::vector<std::string>& parts) {
    const std::string bad = writeFile("bad.bin", changed);
    expectError([&] { other.load(bad); }, parts);
    EXPECT_EQ(other.size(), 5);
  };
  expectError([&] { other.load("/no/such/file"); }, {"/no/such/file", "cannot be opened"});
  expectRefused("", {"bad.bin", "is no saved delayed state"});
  expectRefused("some text that is long enough", {"bad.bin", "is no saved delayed state"});
  expectRefused(bytes.substr(0, 12), {"bad.bin", "cut off"});
  std::string version = bytes;
  version[7] = '2';
  expectRefused(version, {"bad.bin", "version 2", "expected 1"});
  for (const std::size_t length : {std::size_t{16}, std::size_t{23}, std::size_t{24},
                                   std::size_t{100}, bytes.size() / 2, bytes.size() - 1}) {
    expectRefused(bytes.substr(0, length), {"bad.bin", "cut off"});
  }
  expectRefused(bytes + "x", {"bad.bin", "damaged"});
  for (std::size_t at = 16; at < bytes.size(); at += 97) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    expectRefused(damaged, {"bad.bin", "checksum"});
  }
}

/// Payloads with a right checksum that contradict themselves.
TEST(SlamStateFile, RefusesContradictions) {
  const Case c;
  DelayedState state = c.state();
  const auto withPayload = [&](const std::string& payload) {
    uint64_t hash = 0xcbf29ce484222325ULL;
    for (const char byte : payload) {
      hash = (hash ^ static_cast<uint8_t>(byte)) * 0x100000001b3ULL;
    }
    return writeFile("bad.bin", "LADARDS1" + bytesOf<uint64_t>({payload.size()}) + payload +
                                    bytesOf<uint64_t>({hash}));
  };
  const std::string none = bytesOf<uint32_t>({0});
  const std::string counts = bytesOf<uint64_t>({0, 0, 0, 0, 0, 0, 0});
  EXPECT_NO_THROW(state.load(withPayload(none + none + none + counts)));
  expectError([&] { state.load(withPayload(none + none + none)); }, {"ends too early"});
  expectError([&] { state.load(withPayload(none + none + none + counts + "x")); }, {"too long"});
  const std::string many = bytesOf<uint32_t>({0xffffffff});
  expectError([&] { state.load(withPayload(many + none + none + counts)); }, {"ends too early"});
  const std::vector<double> origin = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  std::vector<double> information(36, 0.0);
  const std::string constraint = bytesOf<int32_t>({0, 1}) + bytesOf(origin) + bytesOf(information) +
                                 std::string(1, '\0') + "\1";
  const std::string one = bytesOf<uint32_t>({1});
  expectError([&] { state.load(withPayload(none + one + constraint + none + counts)); },
              {"contradicts itself", "there is no such pose"});
  expectError(
      [&] {
        state.load(withPayload(none + none + one + constraint + bytesOf<int32_t>({3}) + counts));
      },
      {"contradicts itself", "waiting", "there is no such pose"});
}

TEST(SlamStateFile, AFolderThatIsNotThereIsNamed) {
  const Case c;
  expectError([&] { c.state().save("/no/such/folder/state.bin"); },
              {"/no/such/folder/state.bin", "cannot be written"});
}

}  // namespace
}  // namespace ladar_perception
