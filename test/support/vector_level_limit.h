// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ostream>

#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {

inline void PrintTo(VectorLevel level, std::ostream* out) { *out << vectorLevelName(level); }

}  // namespace ladar_perception

namespace ladar_perception::test {

constexpr VectorLevel kVectorLevels[] = {VectorLevel::kBaseline, VectorLevel::kAvx2,
                                         VectorLevel::kAvx512};

/// No more than this vector level as long as the object lives.
class VectorLevelLimit {
 public:
  explicit VectorLevelLimit(VectorLevel level) : before_(vectorLevel()) { limitVectorLevel(level); }
  ~VectorLevelLimit() { limitVectorLevel(before_); }
  VectorLevelLimit(const VectorLevelLimit&) = delete;
  VectorLevelLimit& operator=(const VectorLevelLimit&) = delete;

 private:
  VectorLevel before_;
};

}  // namespace ladar_perception::test
