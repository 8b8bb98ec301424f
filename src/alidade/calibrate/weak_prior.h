// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/calibrate/covariance.h"
#include "alidade/calibrate/estimation.h"

namespace alidade {

/// Holds a lens together that the views leave undetermined, by the weakest prior (LensPrior) that does.
///
/// If the views do not see some combination of the lens' parameters, the solver goes astray along it: to
/// numbers beyond all reason, to a pole, or into a fold where no corner was seen. Then priors are tried, the
/// one by which every parameter is about its natural size first (LensScale), from the model's own start, from
/// which it leads to the best answer more surely than from where the solver went; then wider ones, and
/// if it does not do, narrower ones. The widest is taken whose solution has come to rest, has no parameter
/// far beyond its natural size, and does not fold inside the image. If even the widest is not needed for
/// that, it is let go. Where every prior contradicts the corners, the solution stays as it was.
///
/// Leaves alone what is determined.
void holdTogether(Estimation& estimation);

/// Covariance of the parameters estimated under a prior, for the truth lying about the model's start by no
/// less than the prior's width nor than a natural size: (H + P)^-1 (H variance + P C P) (H + P)^-1 with the
/// information H, the prior's P and the truth's covariance C. (Mean square error of ridge regression, Hoerl
/// and Kennard 1970, Technometrics 12(1), section 4, the bias being averaged over the truths.) A prior
/// narrower than what is known so does not make the sigmas small. Nothing where H + P is singular.
[[nodiscard]] std::optional<Eigen::MatrixXd> heldCovariance(const Eigen::MatrixXd& information,
                                                            const WeakPrior& held, double variance,
                                                            const ParamConstraint& constraint);

/// What the views alone would say, see viewRobustCovariance(), as it is under the prior.
/// @param robust  without the prior
[[nodiscard]] std::optional<Eigen::MatrixXd> heldRobustCovariance(const Eigen::MatrixXd& information,
                                                                  const Eigen::MatrixXd& robust,
                                                                  const WeakPrior& held, double variance,
                                                                  const ParamConstraint& constraint);

}  // namespace alidade
