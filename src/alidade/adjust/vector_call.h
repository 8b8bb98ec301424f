// SPDX-License-Identifier: MIT
// Included by the sources that hold loops over lanes.
#pragma once

#include "alidade/camera/batch_kernel.h"

namespace alidade {

#if defined(ALIDADE_HAS_AVX2_VARIANT)
template <class F>
ALIDADE_TARGET_AVX2 void callWithAvx2(const F& f) {
  f();
}
#endif

/// Calls a lambda that is inlined, in a function for whatever the processor has.
template <class F>
void callVectorised(const F& f) {
#if defined(ALIDADE_HAS_AVX2_VARIANT)
  if (batch::usesAvx2()) return callWithAvx2(f);
#endif
  f();
}

}  // namespace alidade
