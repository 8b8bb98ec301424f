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
/// numbers beyond all reason, to a pole, or into a fold where no corner was seen. Then priors are tried from
/// narrow to wide, each from the solution of the one before. The widest is taken whose solution has come to
/// rest, explains the corners as well as noise allows, does not fold inside the image and has no parameter
/// far from the model's start: beyond 0.3 natural sizes (LensScale), or 1 where none stays within that. If
/// the lens needs none once it was led there, there is none. If no prior does, everything stays as it was.
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

/// What the views alone would say, see viewCovariance(), as it is under the prior.
/// @param robust  without the prior
[[nodiscard]] std::optional<Eigen::MatrixXd> heldRobustCovariance(const Eigen::MatrixXd& information,
                                                                  const Eigen::MatrixXd& robust,
                                                                  const WeakPrior& held, double variance,
                                                                  const ParamConstraint& constraint);

}  // namespace alidade
