// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "alidade/core/image.h"
#include "alidade/report/data/report_data.h"

namespace alidade {

/// The image of a view by the name that the evidence has for it; nothing if there is none. Called from
/// several threads.
using ImageOfView = std::function<std::optional<GrayImage>(const std::string& image)>;

/// A picture of a view, as a JPEG file in a data URI.
struct ViewPicture {
  std::string uri;
  ImageSize size;  ///< of the image that it was made from
};

/// An image as a JPEG file of about at most this many bytes, smaller where that needs it, in a data URI.
[[nodiscard]] std::string pictureUri(const GrayImage& image, double most_bytes);

/// Pictures that are made while images are searched for boards, so that none has to be decoded again. It
/// holds the pictures, which all together take no more memory the more there are, and one image.
class PassingPictures {
 public:
  /// Before add(). @param num_images  that are searched
  void expectImages(std::size_t num_images) { num_images_ = num_images; }
  /// From any thread. @param board_area_px  area of the box around the corners that it shows
  void add(const std::string& name, const GrayImage& image, double board_area_px);

  /// By the name that add() was given; nothing for a different name.
  [[nodiscard]] std::optional<ViewPicture> pictureOf(const std::string& name) const;
  /// The image that shows boards in the largest area, by its name; nothing for a different name.
  [[nodiscard]] std::optional<GrayImage> imageOf(const std::string& name) const;

 private:
  mutable std::mutex mutex_;
  std::size_t num_images_ = 1;
  std::map<std::string, ViewPicture> pictures_;
  std::string largest_name_;
  double largest_area_px_ = 0;
  GrayImage largest_;
};

/// Where the pictures of views come from; called from several threads.
struct PictureSource {
  ImageOfView image_of = {};  ///< may be empty: there are no images
  /// Pictures that were made before, see PassingPictures; may be empty.
  std::function<std::optional<ViewPicture>(const std::string& image)> picture_of = {};
};

/// Reads one image at once and keeps it, so that it is not read again: of a video, that may take another
/// pass.
[[nodiscard]] ImageOfView keepingOne(const ImageOfView& image_of, const std::string& name);

/// Each view's image as a small JPEG file in a data URI; empty for views without one, and for images of
/// another size than the camera's. The more images were given for the calibration, the smaller the pictures:
/// those of 50 take 1.5 MB, those of 1000 take 7 MB. An image is decoded once, however many boards it shows.
/// @param num_images  that were given
/// @param num_jobs  threads; 0: one per processor. The pictures do not depend on it.
[[nodiscard]] std::vector<std::string> viewPictures(const ReportData& data, int num_images,
                                                    const PictureSource& source, int num_jobs);

}  // namespace alidade
