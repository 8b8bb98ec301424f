// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/core/cancel.h"

namespace alidade {

/// From now on the first Ctrl-C (or SIGTERM, SIGHUP) raises the flag instead of ending the program; a second
/// one ends it. Signals that the caller had ignored, as nohup does, stay ignored.
[[nodiscard]] const CancelFlag* catchInterrupts();

/// Ends the program by the signal that was caught, as callers such as shells expect of an interrupted
/// program.
[[noreturn]] void endByCaughtSignal();

}  // namespace alidade
