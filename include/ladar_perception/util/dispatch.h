// SPDX-License-Identifier: BSD-3-Clause
// Loops on whatever vector unit the CPU has: one binary, compiled once per level, chosen as it
// runs.
#pragma once

#include <type_traits>

/// A function that must become part of every copy of the loop it is called from.
#define LADAR_INLINE __attribute__((always_inline)) inline
/// The same for a lambda, after its parameters.
#define LADAR_INLINE_LAMBDA __attribute__((always_inline))

namespace ladar_perception {

/// Instruction sets there are copies for. With contraction off all of them give the same bits.
enum class VectorLevel { kBaseline, kAvx2, kAvx512 };

/// The level in use: the best this CPU has, or less if LADAR_VECTOR_LEVEL (baseline, avx2, avx512
/// in the environment) or `limitVectorLevel` asks for less.
VectorLevel vectorLevel();
/// The best level of this CPU.
VectorLevel bestVectorLevel();
/// Uses no more than `level` from now on, for tests and benchmarks. Not while other threads work.
void limitVectorLevel(VectorLevel level);
const char* vectorLevelName(VectorLevel level);

/// Width of a level's vectors, as a constant.
template <int kBytes>
using VectorBytes = std::integral_constant<int, kBytes>;

namespace dispatch_internal {

#if defined(__x86_64__) && defined(__GNUC__)
#define LADAR_HAS_VECTOR_LEVELS 1

template <typename Body>
__attribute__((target("avx2,bmi,bmi2,lzcnt,popcnt"), noinline)) void runAvx2(const Body& body) {
  body(VectorBytes<32>());
}

template <typename Body>
__attribute__((target("avx512f,avx512dq,avx512vl,avx512bw,avx2,bmi,bmi2,lzcnt,popcnt"),
               noinline)) void
runAvx512(const Body& body) {
  body(VectorBytes<64>());
}
#endif

}  // namespace dispatch_internal

/// Calls `body`, a lambda marked LADAR_INLINE_LAMBDA, compiled for the level in use, with the width
/// of its vectors. What it calls is part of that copy only where it is inlined (LADAR_INLINE).
template <typename Body>
inline void dispatchWide(const Body& body) {
#ifdef LADAR_HAS_VECTOR_LEVELS
  switch (vectorLevel()) {
    case VectorLevel::kAvx512:
      return dispatch_internal::runAvx512(body);
    case VectorLevel::kAvx2:
      return dispatch_internal::runAvx2(body);
    case VectorLevel::kBaseline:
      break;
  }
#endif
  body(VectorBytes<16>());
}

/// The same for a lambda without parameters.
template <typename Body>
inline void dispatch(const Body& body) {
  dispatchWide([&](auto /*width*/) LADAR_INLINE_LAMBDA { body(); });
}

}  // namespace ladar_perception
