// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// Regularises a lens that the views do not determine, by the weakest sufficient prior (LensPrior).
///
/// If the views do not determine some combination of the lens parameters, the solver diverges along it: to
/// absurd numbers, to a pole, or into a fold where there are no corners. Priors are then tried from narrow to
/// wide, each starting from the previous solution. The result is the widest prior whose solution has
/// converged, explains the corners as well as noise allows, does not fold inside the image and has no
/// parameter far from the model's start: beyond 0.3 natural sizes (LensScale), or 1 if no solution stays
/// within 0.3. If the lens then needs no prior, it gets none. If no prior is sufficient, nothing changes.
///
/// Does not change a determined lens.
/// @param fit  of one camera, solved
[[nodiscard]] Fit regularised(Fit fit, const CancelFlag* cancel);

/// Covariance of parameters that were estimated under a prior. The true lens is assumed to scatter about the
/// model's start by a natural size, or by the prior's width if that is wider. If the prior is narrower, to
/// prevent a fold where there are no corners, the estimate is biased: C = variance (H + Q)^-1 + d d^T, d = (H
/// + Q)^-1 (P - Q) (estimate - start), with the information H of the views, P of the prior and Q of the
/// assumed scatter. (Averaged over all true lenses, it is the mean square error of ridge regression, Hoerl
/// and Kennard 1970, Technometrics 12(1), section 4.) A narrow prior therefore does not make the sigmas
/// small.
///
/// @param information  of the views alone, N x N, per px^2
/// @param camera       estimated, with its prior
/// @param variance     of the coordinate of a corner of weight 1, px^2
/// @param robust       the covariance by views, without a prior; empty: returns the covariance by noise
/// @returns nothing if H + Q is singular
[[nodiscard]] std::optional<Eigen::MatrixXd> heldCovariance(const Eigen::MatrixXd& information,
                                                            const FitCamera& camera, double variance,
                                                            const Eigen::MatrixXd& robust = {});

}  // namespace alidade
