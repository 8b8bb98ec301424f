// SPDX-License-Identifier: MIT
// The radtan formulas as plain loops over arrays, without checks, for the compiler to vectorise: a lower
// bound for the cost of a batch of points. Compiled for AVX2 if the processor supports it.
#pragma once

#include <cstddef>

namespace alidade {

/// Pixels of points in a second frame; params: fx fy cx cy k1 k2 p1 p2 k3; R row-major.
void plainProjectRadtan(const double* params, const double* R, const double* t, const double* x,
                        const double* y, const double* z, std::size_t count, double* u, double* v);

/// x / z and y / z of the rays of pixels by five steps of Newton's method.
void plainUnprojectRadtan(const double* params, const double* u, const double* v, std::size_t count,
                          double* x, double* y);

}  // namespace alidade
