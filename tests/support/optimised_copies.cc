// SPDX-License-Identifier: MIT
// Of several copies of an inline function the linker takes the first one. Without these, the library's
// calibrations would run with the unoptimised copies of the tests, three times as slowly.
#include "alidade/geometry/se3.h"

namespace alidade {

template class BasicSO3<double>;
template struct BasicSE3<double>;

}  // namespace alidade
