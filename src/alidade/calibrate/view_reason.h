// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/estimation.h"

namespace alidade {

/// Gives each view that was set aside its reason, as far as its corners show one, and lists it as excluded.
void nameReasons(Estimation& estimation);

}  // namespace alidade
