// SPDX-License-Identifier: BSD-3-Clause
// Storage for short runs of records that grow one by one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ladar_perception/map/moments.h"

namespace ladar_perception {

/// Runs of records in one block of memory; a run's room is a power of two, and room given back is
/// used again, so that a map that has reached its size allocates nothing any more.
class RecordArena {
 public:
  struct Run {
    uint32_t offset = 0;
    uint16_t count = 0;
    int8_t room_log2 = -1;  ///< room for 2^room_log2 records; -1: none
  };

  Moments* records(const Run& run) { return storage_.data() + run.offset; }
  const Moments* records(const Run& run) const { return storage_.data() + run.offset; }

  /// Makes an empty record at position `rank` of the run (later records move up by one) and
  /// returns it. Invalidates pointers into the arena.
  Moments& insert(Run* run, uint32_t rank);
  /// Keeps records [first, first + count) of the run; gives back all room when count is 0.
  void keep(Run* run, uint32_t first, uint32_t count);
  void clear();
  std::size_t bytes() const;

 private:
  static constexpr int kClasses = 16;

  void grow(Run* run);
  uint32_t allocate(int room_log2);

  std::vector<Moments> storage_;
  std::array<std::vector<uint32_t>, kClasses> free_;  // offsets of free runs, by room_log2
};

}  // namespace ladar_perception
