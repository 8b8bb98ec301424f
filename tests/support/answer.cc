// SPDX-License-Identifier: MIT
#include "support/answer.h"

#include <cmath>

#include "alidade/calibrate/uncertainty/aligned_difference.h"
#include "alidade/core/error.h"

namespace alidade {

Answer answerOf(const Checkerboard& board, const std::vector<View>& views, const CalibratorOptions& options,
                const AnyCamera& truth) {
  Answer answer;
  try {
    const Calibration result = calibrate(board, views, options);
    answer.verdict = result.verdict();
    answer.diagnoses = result.diagnoses;
    if (!result.uncertainty.accuracy) return answer;
    const Accuracy& accuracy = *result.uncertainty.accuracy;
    std::vector<Eigen::Vector2d> anchors;
    for (std::size_t i = 0; i < accuracy.pixels.size(); ++i) {
      if (accuracy.is_covered[i]) anchors.push_back(accuracy.pixels[i]);
    }
    const std::vector<double> errors = alignedDifferences(result.camera(), truth, accuracy.pixels, anchors);
    std::vector<double> claimed;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      if (std::isnan(accuracy.error_px[i])) continue;
      const double error = std::isnan(errors[i]) ? 1e9 : errors[i];  // the truth has no pixel there
      if (accuracy.error_px[i] <= kTolerancePx) claimed.push_back(error);
      answer.worst_px = std::max(answer.worst_px, error);
      answer.worst_ratio = std::max(answer.worst_ratio, error / accuracy.error_px[i]);
      if (!accuracy.is_covered[i]) continue;
      ++answer.num_covered;
      answer.num_within += error < accuracy.error_px[i] ? 1 : 0;
    }
    std::ranges::sort(claimed);
    if (!claimed.empty()) answer.p95_px = claimed[claimed.size() * 95 / 100];
    answer.stated_px = accuracy.covered_px;
  } catch (const Error&) {
    answer.verdict = Verdict::kNo;
  }
  return answer;
}

}  // namespace alidade
