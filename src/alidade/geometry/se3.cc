// SPDX-License-Identifier: MIT
#include "alidade/geometry/se3.h"

namespace alidade {

template class BasicSO3<double>;
template struct BasicSE3<double>;

}  // namespace alidade
