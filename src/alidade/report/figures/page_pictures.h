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

/// The image of a view by its name in the evidence; nothing if there is none. Called from several threads.
using ImageOfView = std::function<std::optional<GrayImage>(const std::string& image)>;

/// A picture of a view, as a JPEG file in a data URI.
struct ViewPicture {
  std::string uri;
  ImageSize size;  ///< of the original image
};

/// An image as a JPEG file of about this many bytes at most, reduced if necessary, in a data URI.
[[nodiscard]] std::string pictureUri(const GrayImage& image, double most_bytes);

/// Pictures made during the search for boards, so that no image needs decoding again. Stores the pictures,
/// whose total size is bounded, and one image.
class PassingPictures {
 public:
  /// Call before add(). @param num_images  to be searched
  void expectImages(std::size_t num_images) { num_images_ = num_images; }
  /// Thread-safe. @param board_area_px  area of the bounding box of its corners
  void add(const std::string& name, const GrayImage& image, double board_area_px);

  /// Looks up by the name given to add(); nothing for a different name.
  [[nodiscard]] std::optional<ViewPicture> pictureOf(const std::string& name) const;
  /// The image with the largest board area, if this is its name; nothing otherwise.
  [[nodiscard]] std::optional<GrayImage> imageOf(const std::string& name) const;

 private:
  mutable std::mutex mutex_;
  std::size_t num_images_ = 1;
  std::map<std::string, ViewPicture> pictures_;
  std::string largest_name_;
  double largest_area_px_ = 0;
  GrayImage largest_;
};

/// Source of the pictures of views; called from several threads.
struct PictureSource {
  ImageOfView image_of = {};  ///< empty if there are no images
  /// Pictures made earlier, see PassingPictures; may be empty.
  std::function<std::optional<ViewPicture>(const std::string& image)> picture_of = {};
};

/// Reads one image immediately and keeps it, so that it is not read again: in a video, that may take a second
/// pass.
[[nodiscard]] ImageOfView keepingOne(const ImageOfView& image_of, const std::string& name);

/// Each view's image as a small JPEG file in a data URI; empty for views without one, and for images of a
/// different size than the camera's. The more images were given for the calibration, the smaller the
/// pictures: those of 50 take 1.5 MB, those of 1000 take 7 MB. An image is decoded once, even if it shows
/// several boards.
/// @param num_images  given for the calibration
/// @param num_jobs  threads; 0: one per processor. The pictures do not depend on it.
[[nodiscard]] std::vector<std::string> viewPictures(const ReportData& data, int num_images,
                                                    const PictureSource& source, int num_jobs);

}  // namespace alidade
