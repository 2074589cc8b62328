// SPDX-License-Identifier: BSD-3-Clause
// Poses that cannot be added: each is counted under its reason and told of once in a while, and the
// next good one is added.
#include <cstring>
#include <limits>

#include "ros_scene.h"
#include "ros_state_client.h"
#include "ros_yard.h"

namespace ladar_perception::test {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

class StateBadData : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(state_.ready());
    ASSERT_TRUE(log_.hears("/manager"));
    ASSERT_TRUE(state_->add(next()));
    ASSERT_TRUE(state_->add(next()));
  }
  void TearDown() override {
    // Alive, and as good as before.
    const uint32_t poses = state_->statistics().poses;
    ASSERT_TRUE(state_->add(next()));
    EXPECT_EQ(state_->statistics().poses, poses + 1);
    expectAccounted(state_->statistics());
  }
  PoseCloud next() { return drive_.pose(pose_++); }
  /// Expects that a pose is dropped for `reason`, and told of with all of `parts`; without any it
  /// may have been told of just before.
  void expectDropped(const PoseCloud& pose, const std::string& reason,
                     const std::vector<std::string>& parts) {
    SCOPED_TRACE(reason);
    const DelayedStateStatistics before = state_->statistics();
    EXPECT_FALSE(state_->add(pose));
    const DelayedStateStatistics& after = state_->statistics();
    EXPECT_EQ(after.poses, before.poses);
    EXPECT_EQ(after.poses_received, before.poses_received + 1);
    EXPECT_EQ(countOf(after.poses_dropped, reason), countOf(before.poses_dropped, reason) + 1);
    if (parts.empty()) return;
    ASSERT_TRUE(waitFor([&] { return log_.count("dropped, " + reason) > 0; }));
    const std::string warning = log_.find("dropped, " + reason);
    EXPECT_NE(warning.find("/bad/pose_cloud"), std::string::npos) << warning;
    for (const std::string& part : parts) {
      EXPECT_NE(warning.find(part), std::string::npos) << part << " in: " << warning;
    }
  }
  static void spoil(PoseCloud* pose, std::size_t sample, std::size_t field, float value) {
    const std::size_t at = sample * pose->cloud.point_step + pose->cloud.fields[field].offset;
    std::memcpy(&pose->cloud.data[at], &value, sizeof(value));
  }

  YardDrive drive_;
  int pose_ = 0;
  LogListener log_;
  LoadedState state_{"/bad"};
};

TEST_F(StateBadData, FieldsThatAreMissing) {
  PoseCloud no_normal = next();
  no_normal.cloud.fields[4].name = "curvature";
  expectDropped(no_normal, "bad_cloud", {"no field 'normal_y'", "curvature:float32", "1001.000"});
  PoseCloud no_z = next();
  no_z.cloud.fields[2].name = "depth";
  expectDropped(no_z, "bad_cloud", {});
}

TEST_F(StateBadData, ValuesThatAreNotFinite) {
  PoseCloud nan_position = next();
  spoil(&nan_position, 17, 1, kNaN);
  expectDropped(nan_position, "bad_cloud", {"field 'y' of sample 17", "nan"});
  PoseCloud nan_normal = next();
  spoil(&nan_normal, 3, 5, kNaN);
  expectDropped(nan_normal, "bad_cloud", {});
  PoseCloud far = next();
  spoil(&far, 3, 0, 1e30F);
  expectDropped(far, "bad_cloud", {});
}

TEST_F(StateBadData, HeadersThatClaimWhatIsNotThere) {
  PoseCloud truncated = next();
  truncated.cloud.data.resize(truncated.cloud.data.size() / 2);
  expectDropped(truncated, "bad_cloud", {"bytes"});
  PoseCloud wide = next();
  wide.cloud.width = 0xffffffff;
  expectDropped(wide, "bad_cloud", {});
  PoseCloud empty = next();
  empty.cloud.width = 0;
  empty.cloud.data.clear();
  expectDropped(empty, "empty", {"no samples"});
}

TEST_F(StateBadData, PosesThatAreNone) {
  PoseCloud nan = next();
  nan.pose.pose.position.x = kNaN;
  expectDropped(nan, "bad_pose", {"not finite"});
  PoseCloud no_rotation = next();
  no_rotation.pose.pose.orientation.w = 0.0;
  no_rotation.pose.pose.orientation.z = 0.0;
  expectDropped(no_rotation, "bad_pose", {});
  PoseCloud no_stamp = next();
  no_stamp.header.stamp = ros::Time();
  expectDropped(no_stamp, "no_stamp", {"stamp is 0"});
}

TEST_F(StateBadData, OtherFrames) {
  PoseCloud other = next();
  other.header.frame_id = "utm";
  expectDropped(other, "other_frame", {"'utm'", "odom_frame 'odom'"});
  PoseCloud trailer = next();
  trailer.vehicle_frame = "trailer";
  trailer.cloud.header.frame_id = "trailer";
  expectDropped(trailer, "other_frame", {});
  PoseCloud mixed = next();
  mixed.cloud.header.frame_id = "ladar";
  expectDropped(mixed, "other_frame", {});
}

TEST_F(StateBadData, TheSameAgainAndOutOfOrder) {
  expectDropped(drive_.pose(1), "duplicate", {"pose 1 ", "id 1 at 1000.500 s"});
  PoseCloud same_stamp = drive_.pose(1);
  same_stamp.id = 2;
  expectDropped(same_stamp, "duplicate", {});
  expectDropped(drive_.pose(0), "out_of_order", {"pose 0 ", "id 1 at 1000.500 s", "~reset"});
}

TEST_F(StateBadData, LeftOutIdsAreCountedAndARestartIsTold) {
  pose_ += 3;
  ASSERT_TRUE(state_->add(next()));
  EXPECT_EQ(state_->statistics().poses_missing, 3U);
  PoseCloud restarted = next();
  restarted.id = 0;
  ASSERT_TRUE(state_->add(restarted));
  EXPECT_EQ(state_->statistics().poses_missing, 3U);
  EXPECT_TRUE(waitFor([&] { return log_.count("started again") == 1; }));
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "state_bad_data_test");
}
