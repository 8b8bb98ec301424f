// SPDX-License-Identifier: MIT
#pragma once

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

// What differs between OpenCV 4.5 and 5: the functions for markers, and the headers for key points,
// homographies and polygons.

/// The dictionary `id` of cv::aruco::PREDEFINED_DICTIONARY_NAME (PredefinedDictionaryType from 4.7 on).
inline cv::aruco::Dictionary markerDictionary(int id) {
#ifdef ALIDADE_MARKERS_ARE_VALUES
  return cv::aruco::getPredefinedDictionary(id);
#else
  return *cv::aruco::getPredefinedDictionary(id);
#endif
}

/// Makes OpenCV use only the calling thread, in the whole process. Builds with TBB crash if two threads set
/// this at once.
inline void useOneThread() {
  [[maybe_unused]] static const bool is_done = [] {
    cv::setNumThreads(1);
    return true;
  }();
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

}  // namespace alidade::detail
