// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace alidade {

/// The outcome of a step of a minimisation.
enum class StepResult : std::uint8_t {
  kBetter,     ///< the step was taken
  kWorse,      ///< not taken; try more damping
  kConverged,  ///< at a minimum
  kFailed,     ///< no step leads further
};

/// Changes of the damping after each step.
struct DampingRule {
  double start = 0;
  double (*raised)(double);   ///< damping after a worse step; infinite to give up
  double (*lowered)(double);  ///< damping after a better step
  int max_steps = 0;
};

/// Levenberg-Marquardt's loop. `step(damping)` solves the damped normal equations at the present point and
/// takes the step if it improves the cost.
/// @returns true if a minimum was reached
template <class Step>
bool minimise(const DampingRule& rule, const Step& step) {
  constexpr double kMost = 1e300;
  double damping = rule.start;
  for (int i = 0; i < rule.max_steps; ++i) {
    switch (step(damping)) {
      case StepResult::kBetter:
        damping = rule.lowered(damping);
        break;
      case StepResult::kWorse:
        damping = rule.raised(damping);
        if (damping > kMost) return false;
        break;
      case StepResult::kConverged:
        return true;
      case StepResult::kFailed:
        return false;
    }
  }
  return false;
}

}  // namespace alidade
