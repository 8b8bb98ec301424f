// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>

namespace alidade {

/// Every entry within `tolerance`; false if any is NaN.
template <class A, class B>
testing::AssertionResult isNear(const Eigen::MatrixBase<A>& actual, const Eigen::MatrixBase<B>& expected,
                                double tolerance) {
  const typename A::PlainObject difference = actual - expected;
  if ((difference.array().abs() <= tolerance).all()) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "off by up to " << difference.cwiseAbs().maxCoeff() << ", allowed "
                                     << tolerance << "\nactual\n"
                                     << actual << "\nexpected\n"
                                     << expected;
}

}  // namespace alidade
