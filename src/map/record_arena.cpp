// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/map/record_arena.h"

#include <algorithm>
#include <cassert>

namespace ladar_perception {

Moments& RecordArena::insert(Run* run, uint32_t rank) {
  assert(rank <= run->count);
  if (run->room_log2 < 0 || run->count == 1U << run->room_log2) grow(run);
  Moments* first = records(*run);
  std::move_backward(first + rank, first + run->count, first + run->count + 1);
  first[rank] = Moments();
  ++run->count;
  return first[rank];
}

void RecordArena::keep(Run* run, uint32_t first, uint32_t count) {
  assert(first + count <= run->count);
  if (count == 0) {
    if (run->room_log2 >= 0) free_[run->room_log2].push_back(run->offset);
    *run = Run();
    return;
  }
  Moments* begin = records(*run);
  if (first > 0) std::move(begin + first, begin + first + count, begin);
  run->count = static_cast<uint16_t>(count);
}

void RecordArena::clear() {
  storage_.clear();
  for (auto& offsets : free_) offsets.clear();
}

std::size_t RecordArena::bytes() const {
  std::size_t bytes = storage_.capacity() * sizeof(Moments);
  for (const auto& offsets : free_) bytes += offsets.capacity() * sizeof(uint32_t);
  return bytes;
}

void RecordArena::grow(Run* run) {
  Run larger;
  larger.room_log2 = static_cast<int8_t>(run->room_log2 + 1);
  larger.offset = allocate(larger.room_log2);
  larger.count = run->count;
  std::copy_n(records(*run), run->count, records(larger));
  if (run->room_log2 >= 0) free_[run->room_log2].push_back(run->offset);
  *run = larger;
}

uint32_t RecordArena::allocate(int room_log2) {
  assert(room_log2 < kClasses);
  auto& offsets = free_[room_log2];
  if (offsets.empty()) {
    const auto offset = static_cast<uint32_t>(storage_.size());
    storage_.resize(storage_.size() + (std::size_t{1} << room_log2));
    return offset;
  }
  const uint32_t offset = offsets.back();
  offsets.pop_back();
  return offset;
}

}  // namespace ladar_perception
