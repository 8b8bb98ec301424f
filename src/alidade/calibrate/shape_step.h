// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/estimation.h"

namespace alidade {

/// Estimates the bend of the board together with everything else, from the solution for a flat one, if the
/// options ask for it and, when they leave it open, the tests say that the board is bent, see isBent().
void estimateShape(Estimation& estimation);

/// Solves again with the bend that suits the corners now in use, if it is estimated at all, and compares with
/// a flat board on the same corners.
/// @returns false if those corners speak of a bend no more: the board is then taken as flat, and what is an
/// outlier is to be judged anew
bool refineShape(Estimation& estimation);

/// Where the board is held flat by the user's wish, looks whether it is bent all the same, and notes what
/// that does to the parameters.
void noteIgnoredBend(Estimation& estimation);

}  // namespace alidade
