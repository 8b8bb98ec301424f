// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/core/cancel.h"

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
/// @param fit  of one camera, solved
[[nodiscard]] Fit regularised(Fit fit, const CancelFlag* cancel);

/// What is known of parameters that were estimated under a prior. Before any view the truth is taken to lie
/// about the model's start by a natural size, or by the prior's width where that is wider. Where the prior is
/// narrower, which keeps the lens from folding where no corner was seen, the estimate is not the most likely
/// truth, but so far from it: C = variance (H + Q)^-1 + d d^T, d = (H + Q)^-1 (P - Q) (estimate - start),
/// with the information H of the views, the prior's P and the natural Q. (Averaged over the truths it is the
/// mean square error of ridge regression, Hoerl and Kennard 1970, Technometrics 12(1), section 4.) So a
/// narrow prior does not make the sigmas small.
///
/// @param information  of the views alone, N x N, per px^2
/// @param camera       as estimated, with its prior
/// @param variance     of the coordinate of a corner of weight 1, px^2
/// @param robust       what the views alone would say without a prior, the covariance by views; empty: the
///                     covariance by noise is asked for
/// @returns nothing where H + Q is singular
[[nodiscard]] std::optional<Eigen::MatrixXd> heldCovariance(const Eigen::MatrixXd& information,
                                                            const FitCamera& camera, double variance,
                                                            const Eigen::MatrixXd& robust = {});

}  // namespace alidade
