// SPDX-License-Identifier: BSD-3-Clause
// Storage for short runs of records that grow one by one.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ladar_perception {

/// Records a run of that class has room for: 1, 2, 3, 4, 6, 8, 12, 16, 24 ...
constexpr uint32_t roomOf(int room_class) {
  return room_class == 0 ? 1U : (2U + ((room_class - 1U) & 1U)) << ((room_class - 1U) / 2U);
}

/// Where a run of records lies.
struct RecordRun {
  uint32_t offset = 0;
  uint16_t count = 0;
  int8_t room_class = -1;  ///< room for roomOf(room_class) records; -1: none
};

/// Runs of records in one block of memory; a run's room is one of a few sizes, and room given back
/// is used again, so that a map that has reached its size allocates nothing any more. `Record` is
/// any default-constructible, trivially copyable type.
template <typename Record>
class RecordArena {
 public:
  Record* records(const RecordRun& run) { return storage_.data() + run.offset; }
  const Record* records(const RecordRun& run) const { return storage_.data() + run.offset; }
  const Record& operator[](std::size_t slot) const { return storage_[slot]; }
  /// Every record lies at an offset below this.
  std::size_t size() const { return storage_.size(); }

  /// Makes an empty record at position `rank` of the run (later records move up by one) and
  /// returns it. Invalidates pointers into the arena.
  Record& insert(RecordRun* run, uint32_t rank) {
    assert(rank <= run->count);
    if (run->room_class < 0 || run->count == roomOf(run->room_class)) grow(run);
    Record* first = records(*run);
    std::move_backward(first + rank, first + run->count, first + run->count + 1);
    first[rank] = Record();
    ++run->count;
    return first[rank];
  }

  /// Keeps records [first, first + count) of the run; gives back all room when count is 0.
  void keep(RecordRun* run, uint32_t first, uint32_t count) {
    assert(first + count <= run->count);
    if (count == 0) {
      if (run->room_class >= 0) free_[run->room_class].push_back(run->offset);
      *run = RecordRun();
      return;
    }
    Record* begin = records(*run);
    if (first > 0) std::move(begin + first, begin + first + count, begin);
    run->count = static_cast<uint16_t>(count);
  }

  void clear() {
    storage_.clear();
    for (auto& offsets : free_) offsets.clear();
  }

  std::size_t bytes() const {
    std::size_t bytes = storage_.capacity() * sizeof(Record);
    for (const auto& offsets : free_) bytes += offsets.capacity() * sizeof(uint32_t);
    return bytes;
  }

 private:
  static constexpr int kClasses = 22;

  void grow(RecordRun* run) {
    RecordRun larger;
    larger.room_class = static_cast<int8_t>(run->room_class + 1);
    larger.offset = allocate(larger.room_class);
    larger.count = run->count;
    std::copy_n(records(*run), run->count, records(larger));
    if (run->room_class >= 0) free_[run->room_class].push_back(run->offset);
    *run = larger;
  }

  uint32_t allocate(int room_class) {
    assert(room_class < kClasses);
    auto& offsets = free_[room_class];
    if (offsets.empty()) {
      const std::size_t offset = storage_.size();
      const std::size_t size = offset + roomOf(room_class);
      // By quarters, not by doubling: maps are to fit into little memory.
      if (size > storage_.capacity()) storage_.reserve(size + size / 4);
      storage_.resize(size);
      return static_cast<uint32_t>(offset);
    }
    const uint32_t offset = offsets.back();
    offsets.pop_back();
    return offset;
  }

  std::vector<Record> storage_;
  std::array<std::vector<uint32_t>, kClasses> free_;  // offsets of free runs, by room_class
};

}  // namespace ladar_perception
