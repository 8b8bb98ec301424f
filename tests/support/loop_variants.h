// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/core/vector_code.h"

namespace alidade {

/// Calls f for both variants of the loops over lanes, whichever the processor has.
template <class F>
void withAndWithoutAvx2(const F& f) {
  const bool has_avx2 = usesAvx2();
  f();
  usesAvx2() = false;
  f();
  usesAvx2() = has_avx2;
}

}  // namespace alidade
