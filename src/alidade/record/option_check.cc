// SPDX-License-Identifier: MIT
#include "alidade/record/option_check.h"

#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade::detail {

void checkOption(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw inputError({.where = name,
                    .found = exactText(value),
                    .expected = "a number from " + exactText(low) + " to " + exactText(high)});
}

}  // namespace alidade::detail
