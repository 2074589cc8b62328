// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/util/dispatch.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace ladar_perception {
namespace {

constexpr VectorLevel kLevels[] = {VectorLevel::kBaseline, VectorLevel::kAvx2,
                                   VectorLevel::kAvx512};

VectorLevel levelOfCpu() {
#ifdef LADAR_HAS_VECTOR_LEVELS
  __builtin_cpu_init();
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
                    __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
  const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
  if (avx2 && avx512) return VectorLevel::kAvx512;
  if (avx2) return VectorLevel::kAvx2;
#endif
  return VectorLevel::kBaseline;
}

VectorLevel levelAtStart() {
  const VectorLevel level = bestVectorLevel();
  const char* wanted = std::getenv("LADAR_VECTOR_LEVEL");
  if (wanted == nullptr) return level;
  for (const VectorLevel candidate : kLevels) {
    if (std::strcmp(wanted, vectorLevelName(candidate)) == 0) return std::min(level, candidate);
  }
  std::fprintf(stderr,
               "LADAR_VECTOR_LEVEL is '%s', expected baseline, avx2 or avx512: %s is used\n",
               wanted, vectorLevelName(level));
  return level;
}

VectorLevel& levelInUse() {
  static VectorLevel level = levelAtStart();
  return level;
}

}  // namespace

VectorLevel bestVectorLevel() {
  static const VectorLevel kBest = levelOfCpu();
  return kBest;
}

VectorLevel vectorLevel() { return levelInUse(); }

void limitVectorLevel(VectorLevel level) { levelInUse() = std::min(level, bestVectorLevel()); }

const char* vectorLevelName(VectorLevel level) {
  switch (level) {
    case VectorLevel::kAvx512:
      return "avx512";
    case VectorLevel::kAvx2:
      return "avx2";
    case VectorLevel::kBaseline:
      break;
  }
  return "baseline";
}

}  // namespace ladar_perception
