// SPDX-License-Identifier: MIT
#include "alidade/imagery/frame_choice.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/core/error.h"

namespace alidade {
namespace {

// Mean square of the difference of two thumbnails.
double distanceOf(const FrameLook& a, const FrameLook& b) {
  int sum = 0;
  for (std::size_t i = 0; i < a.thumbnail.size(); ++i) {
    const int difference = a.thumbnail[i] - b.thumbnail[i];
    sum += difference * difference;
  }
  return static_cast<double>(sum) / static_cast<double>(a.thumbnail.size());
}

}  // namespace

FrameLook lookAt(const GrayImage& image) {
  // OpenCV has no view of constant data; this function does not write to it.
  const cv::Mat gray(image.size.height, image.size.width, CV_8UC1,
                     const_cast<std::uint8_t*>(image.pixels.data()));
  FrameLook look;
  cv::Mat laplacian;
  cv::Laplacian(gray, laplacian, CV_16S);
  look.sharpness = cv::norm(laplacian, cv::NORM_L2SQR) / static_cast<double>(gray.total());
  cv::Mat thumbnail(FrameLook::kRows, FrameLook::kColumns, CV_8UC1, look.thumbnail.data());
  cv::resize(gray, thumbnail, thumbnail.size(), 0, 0, cv::INTER_AREA);
  return look;
}

FrameChooser::FrameChooser(std::size_t num_wanted) : num_wanted_(num_wanted) {
  expect(num_wanted > 0, "at least one frame is wanted");
}

void FrameChooser::add(std::size_t number, const FrameLook& look) {
  constexpr std::size_t kCandidatesPerFrame = 8;
  if (num_in_run_ == 0 || num_in_run_ == run_length_) {
    if (candidates_.size() == kCandidatesPerFrame * num_wanted_) halve();
    candidates_.push_back({number, look});
    num_in_run_ = 1;
    return;
  }
  ++num_in_run_;
  if (look.sharpness > candidates_.back().look.sharpness) candidates_.back() = {number, look};
}

// Keeps the sharper of each two neighbours.
void FrameChooser::halve() {
  for (std::size_t i = 0; i < candidates_.size() / 2; ++i) {
    const Candidate& first = candidates_[2 * i];
    const Candidate& second = candidates_[2 * i + 1];
    candidates_[i] = second.look.sharpness > first.look.sharpness ? second : first;
  }
  candidates_.resize(candidates_.size() / 2);
  run_length_ *= 2;
}

// Motion blurs only some frames within a second. The scene, which also affects sharpness, hardly changes in
// that time.
std::vector<double> FrameChooser::sharpnessWeights() const {
  constexpr std::size_t kNeighbours = 15;  // on each side
  constexpr std::size_t kSharpOf = 4;      // the sharpest quarter of the neighbours counts as sharp
  std::vector<double> weights;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    std::vector<double> around;
    const std::size_t end = std::min(i + kNeighbours + 1, candidates_.size());
    for (std::size_t k = i - std::min(i, kNeighbours); k < end; ++k)
      around.push_back(candidates_[k].look.sharpness);
    const auto sharp = around.begin() + static_cast<std::ptrdiff_t>(around.size() / kSharpOf);
    std::nth_element(around.begin(), sharp, around.end(), std::greater<>());
    const double share = std::min(*sharp > 0 ? candidates_[i].look.sharpness / *sharp : 1.0, 1.0);
    weights.push_back(std::max(share * share, 1e-9));
  }
  return weights;
}

std::vector<std::size_t> FrameChooser::chosen() const {
  const std::vector<double> weights = sharpnessWeights();
  // Noise, compression and flicker stay below this difference of grey values (root mean square).
  constexpr double kSameLook = 1.0;
  std::vector<double> distances(candidates_.size(), std::numeric_limits<double>::max());
  std::vector<std::size_t> numbers;
  while (numbers.size() < num_wanted_) {
    std::size_t best = candidates_.size();
    double best_score = 0;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (distances[i] <= kSameLook * kSameLook) continue;
      const double score = distances[i] * weights[i];
      if (score > best_score) {
        best = i;
        best_score = score;
      }
    }
    if (best == candidates_.size()) break;
    numbers.push_back(candidates_[best].number);
    for (std::size_t i = 0; i < candidates_.size(); ++i)
      distances[i] = std::min(distances[i], distanceOf(candidates_[i].look, candidates_[best].look));
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

}  // namespace alidade
