// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace alidade {

/// The outcome of a step of a minimisation.
enum class StepResult : std::uint8_t {
  kBetter,     ///< it was taken
  kWorse,      ///< it was not: to be tried with more damping
  kConverged,  ///< at a minimum
  kFailed,     ///< no step leads on
};

/// How the damping follows the steps.
struct DampingRule {
  double start = 0;
  double (*raised)(double);   ///< the damping after a step that was worse; infinite to give up
  double (*lowered)(double);  ///< after one that was better
  int max_steps = 0;
};

/// Levenberg-Marquardt's loop. `step(damping)` solves the damped normal equations at the present point and
/// goes where they lead if that is better.
/// @returns whether a minimum was reached
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
