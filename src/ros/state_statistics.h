// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <ladar_perception/DelayedStateStatistics.h>
#include <ros/time.h>

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "ladar_perception/slam/delayed_state.h"
#include "ladar_perception/util/sample_window.h"
#include "state_drop.h"

namespace ladar_perception {

/// Counts of every pose that came, and what became of it.
class StateStatisticsLog {
 public:
  /// Percentiles are over the last `window` poses, 0 for all.
  explicit StateStatisticsLog(std::size_t window);

  /// A pose came; returns its number, by which it is named below.
  uint64_t addArrival();
  void addDrop(uint64_t number, StateDrop reason);
  /// It is in the state; `missing` ids before it never came.
  void addPose(uint64_t number, const AddReport& report, uint64_t missing);
  /// The state begins anew: forgotten, or loaded.
  void addReset();
  void addLoad();
  void addSave() { ++saves_; }
  /// What is in the state now.
  void describe(const DelayedState& state);

  uint64_t received() const { return received_; }
  uint64_t dropped() const;
  /// The typed message, without its header.
  DelayedStateStatistics message() const;

 private:
  uint64_t received_ = 0;
  uint64_t added_ = 0;
  std::array<uint64_t, kStateDrops> dropped_{};
  uint64_t missing_ = 0;
  uint64_t resets_ = 0;
  uint64_t loads_ = 0;
  uint64_t saves_ = 0;
  uint64_t loops_closed_ = 0;
  std::map<uint64_t, ros::WallTime> waiting_since_;  // by number
  SampleWindow lag_ms_;
  std::vector<SampleWindow> stage_ms_;
  DelayedStateStatistics state_;  // only what describe() fills in
};

/// Adds them to diagnostics.
void addTo(const DelayedStateStatistics& statistics,
           diagnostic_updater::DiagnosticStatusWrapper* status);

}  // namespace ladar_perception
