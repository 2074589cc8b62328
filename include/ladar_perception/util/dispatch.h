// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Before a function whose loops should run on whatever vector unit the CPU has: the compiler makes
/// one copy per level and the loader picks one, so that a single binary serves every x86-64. With
/// contraction off all copies give the same bits. Elsewhere, and under sanitizers (which cannot run
/// before the loader has picked), it is nothing.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define LADAR_VECTOR_DISPATCH __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define LADAR_VECTOR_DISPATCH
#endif

/// A function that must become part of each of those copies.
#define LADAR_INLINE __attribute__((always_inline)) inline
