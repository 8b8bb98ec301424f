// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/camera/batch_kernel.h"

namespace alidade {

/// Calls f for both variants of the loops over lanes, whichever the processor has.
template <class F>
void withAndWithoutAvx2(const F& f) {
  const bool has_avx2 = batch::usesAvx2();
  f();
  batch::usesAvx2() = false;
  f();
  batch::usesAvx2() = has_avx2;
}

}  // namespace alidade
