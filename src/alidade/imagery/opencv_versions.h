// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/core/version.hpp>

#if CV_VERSION_MAJOR >= 5
#include <opencv2/features.hpp>
#include <opencv2/geometry.hpp>
#else
#include <opencv2/features2d.hpp>
#endif
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
#include <opencv2/objdetect/aruco_detector.hpp>
#define ALIDADE_MARKERS_ARE_VALUES
#else
#include <opencv2/aruco.hpp>
#endif

namespace alidade::detail {

// What differs between OpenCV 4.5 and 5: the functions for markers, and the headers for key points and
// homographies.

using MarkerCorners = std::vector<std::vector<cv::Point2f>>;

/// The dictionary `id` of cv::aruco::PREDEFINED_DICTIONARY_NAME (PredefinedDictionaryType from 4.7 on).
inline cv::aruco::Dictionary markerDictionary(int id) {
#ifdef ALIDADE_MARKERS_ARE_VALUES
  return cv::aruco::getPredefinedDictionary(id);
#else
  return *cv::aruco::getPredefinedDictionary(id);
#endif
}

/// The marker `id` as an image of `side` pixels along a side, 0 where it is dark, with a border of
/// `border_cells`.
inline cv::Mat drawnMarker(const cv::aruco::Dictionary& dictionary, int id, int side, int border_cells) {
  cv::Mat drawn;
#ifdef ALIDADE_MARKERS_ARE_VALUES
  dictionary.generateImageMarker(id, side, drawn, border_cells);
#else
  dictionary.drawMarker(id, side, drawn, border_cells);
#endif
  return drawn;
}

#ifdef ALIDADE_MARKERS_ARE_VALUES
/// True if the corners of two quadrilaterals, from any first one, differ by little of the smaller perimeter.
inline bool areNear(const std::vector<cv::Point2f>& a, const std::vector<cv::Point2f>& b) {
  constexpr double kMinDistanceRate = 0.05;  // DetectorParameters::minMarkerDistanceRate until 4.9
  double perimeter_a = 0;
  double perimeter_b = 0;
  std::array<double, 4> sums{};  // squared distances, by the shift between the first corners
  for (std::size_t i = 0; i < 4; ++i) {
    perimeter_a += cv::norm(a[i] - a[(i + 1) % 4]);
    perimeter_b += cv::norm(b[i] - b[(i + 1) % 4]);
    for (std::size_t shift = 0; shift < 4; ++shift) {
      const cv::Point2f apart = a[i] - b[(i + shift) % 4];
      sums[shift] += apart.dot(apart);
    }
  }
  const double limit = kMinDistanceRate * std::min(perimeter_a, perimeter_b);
  return *std::min_element(sums.begin(), sums.end()) < 4 * limit * limit;
}
#endif

/// Finds markers, and the quadrilaterals that are none (`rest`); of those with nearly the same corners, the
/// largest.
inline void findMarkers(const cv::Mat& image, const cv::aruco::Dictionary& dictionary,
                        const cv::aruco::DetectorParameters& parameters, MarkerCorners& corners,
                        std::vector<int>& ids, MarkerCorners& rest) {
#ifdef ALIDADE_MARKERS_ARE_VALUES
  // The newer versions group quadrilaterals in another way, and return too few of them. Here they return all.
  cv::aruco::DetectorParameters apart = parameters;
  apart.minMarkerDistanceRate = 0;
  MarkerCorners found;
  MarkerCorners others;
  std::vector<int> found_ids;
  cv::aruco::ArucoDetector(dictionary, apart).detectMarkers(image, found, found_ids, others);
  const auto area = [](const std::vector<cv::Point2f>& q) {
    return std::abs((q[2] - q[0]).cross(q[3] - q[1]));
  };
  const auto byArea = [&](const MarkerCorners& quads) {
    std::vector<std::size_t> order(quads.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, std::greater(), [&](std::size_t i) { return area(quads[i]); });
    return order;
  };
  const auto isNearAny = [](const std::vector<cv::Point2f>& quad, const MarkerCorners& kept) {
    return std::ranges::any_of(kept, [&](const auto& other) { return areNear(quad, other); });
  };
  const auto middle = [](const std::vector<cv::Point2f>& q) { return 0.25F * (q[0] + q[1] + q[2] + q[3]); };
  const auto isSeen = [&](std::size_t i) {  // also as a quadrilateral around it
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const double distance = cv::norm(middle(found[i]) - middle(corners[k]));
      if (ids[k] == found_ids[i] && distance * distance < 0.0625 * area(corners[k])) return true;
    }
    return isNearAny(found[i], corners);
  };
  for (const std::size_t i : byArea(found)) {
    if (isSeen(i)) continue;
    corners.push_back(found[i]);
    ids.push_back(found_ids[i]);
  }
  for (const std::size_t i : byArea(others)) {
    if (!isNearAny(others[i], rest)) rest.push_back(others[i]);
  }
#else
  cv::aruco::detectMarkers(image, cv::makePtr<cv::aruco::Dictionary>(dictionary), corners, ids,
                           cv::makePtr<cv::aruco::DetectorParameters>(parameters), rest);
#endif
}

}  // namespace alidade::detail
