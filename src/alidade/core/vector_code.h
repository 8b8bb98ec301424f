// SPDX-License-Identifier: MIT
// Helpers that make compilers vectorise short loops. Loops are written once, for the vectors that GCC and
// Clang support on any processor. On x86-64 they are also compiled for AVX2 with fused multiplication and
// selected at run time. Other compilers get vectors of one element.
#pragma once

#if defined(__GNUC__) || defined(__clang__)
#define ALIDADE_HAS_VECTORS 1
/// For functions called by such loops: only inlined code uses the instructions of the loop.
#define ALIDADE_ALWAYS_INLINE __attribute__((always_inline)) inline
#define ALIDADE_INLINE_LAMBDA __attribute__((always_inline))
#else
#define ALIDADE_ALWAYS_INLINE inline
#define ALIDADE_INLINE_LAMBDA
#endif

#if defined(ALIDADE_HAS_VECTORS) && defined(__x86_64__)
#define ALIDADE_HAS_AVX2_VARIANT 1
#define ALIDADE_TARGET_AVX2 __attribute__((target("avx2,fma")))
#endif

namespace alidade {

/// True if the processor supports ALIDADE_TARGET_AVX2.
[[nodiscard]] inline bool hasAvx2() {
#if defined(ALIDADE_HAS_AVX2_VARIANT)
  static const bool has = __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
  return has;
#else
  return false;
#endif
}

/// True if callVectorised() uses AVX2; a test may turn it off.
inline bool& usesAvx2() {
  static bool uses = hasAvx2();
  return uses;
}

#if defined(ALIDADE_HAS_AVX2_VARIANT)
template <class F>
ALIDADE_TARGET_AVX2 void callWithAvx2(const F& f) {
  f();
}
#endif

/// Calls a lambda, inlined (ALIDADE_INLINE_LAMBDA) in a function for the best instruction set of the
/// processor.
template <class F>
void callVectorised(const F& f) {
#if defined(ALIDADE_HAS_AVX2_VARIANT)
  if (usesAvx2()) return callWithAvx2(f);
#endif
  f();
}

}  // namespace alidade
