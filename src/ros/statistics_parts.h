// SPDX-License-Identifier: BSD-3-Clause
// What the nodes' statistics are put together from.
#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <ladar_perception/DropCount.h>
#include <ladar_perception/StageTime.h>

#include <array>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

#include "ladar_perception/util/sample_window.h"

namespace ladar_perception {

template <std::size_t kReasons>
uint64_t sumOf(const std::array<uint64_t, kReasons>& counts) {
  return std::accumulate(counts.begin(), counts.end(), uint64_t{0});
}

/// Appends the counts with the names of their reasons.
template <typename Reason, std::size_t kReasons>
void appendDrops(const std::array<uint64_t, kReasons>& counts, const char* (*name)(Reason),
                 std::vector<DropCount>* drops) {
  for (std::size_t i = 0; i < kReasons; ++i) {
    DropCount drop;
    drop.reason = name(static_cast<Reason>(i));
    drop.count = counts[i];
    drops->push_back(drop);
  }
}

/// Adds them to diagnostics, as "<of what>: <reason>".
inline void addDrops(const std::string& of_what, const std::vector<DropCount>& drops,
                     diagnostic_updater::DiagnosticStatusWrapper* status) {
  for (const DropCount& drop : drops) status->add(of_what + ": " + drop.reason, drop.count);
}

inline StageTime stageTime(const char* name, const SampleWindow& times_ms) {
  StageTime stage;
  stage.stage = name;
  stage.p50_ms = static_cast<float>(times_ms.percentile(0.5));
  stage.p99_ms = static_cast<float>(times_ms.percentile(0.99));
  return stage;
}

}  // namespace ladar_perception
