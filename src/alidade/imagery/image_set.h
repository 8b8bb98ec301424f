// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "alidade/core/cancel.h"
#include "alidade/core/error.h"
#include "alidade/imagery/image_file.h"

namespace alidade {

class ContentCache;

/// An image that is not decoded yet.
struct EncodedImage {
  std::string identity;                 ///< digest of everything that its pixels depend on; empty if unknown
  std::function<LoadedImage()> decode;  ///< @throws Error (kInput); may be called once
};

/// The images of a run: files, and chosen frames of videos and image sequences. An image is read when it is
/// requested, so a set needs little memory.
class ImageSet {
 public:
  using Load = std::function<LoadedImage(const std::string&)>;

  struct Item {
    std::string name;
    std::optional<std::size_t> sequence = std::nullopt;
    std::function<EncodedImage(const std::string&)> read;  ///< reads an image by its name; from any thread
  };

  /// @param files  image files, for example from listImages()
  ImageSet(std::vector<std::string> files);
  /// Images that `load` makes from their names.
  ImageSet(const std::vector<std::string>& names, const Load& load);
  ImageSet(std::vector<Item> items, std::vector<std::string> notes);

  [[nodiscard]] std::size_t size() const { return items_.size(); }
  /// Paths of files; "clip.mp4@120" is frame 120 of a video, which counts from 0.
  [[nodiscard]] const std::string& name(std::size_t i) const { return items_[i].name; }
  [[nodiscard]] std::vector<std::string> names() const;
  /// The number of the video or sequence that image i belongs to, if any. Successive frames of a video may
  /// look nearly the same, unlike photographs.
  [[nodiscard]] std::optional<std::size_t> sequenceOf(std::size_t i) const { return items_[i].sequence; }

  /// Reads image i; from any thread. The frames of a video are read fastest in their order.
  /// @throws Error (kInput); Cancelled, from decode() too
  [[nodiscard]] EncodedImage read(std::size_t i) const;

  /// The same images with left and right exchanged.
  [[nodiscard]] ImageSet mirrored() const;

  /// Messages for the user about videos and sequences, one sentence each.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  std::vector<Item> items_;
  std::vector<std::string> notes_;
};

struct OpenImagesOptions {
  std::size_t num_frames = 100;  ///< largest number from each video or sequence
  /// Evenly spaced frames of videos from this number on, instead of sharp ones that differ: of several
  /// videos, the same numbers. They are no sequence, of which similar frames would be left out.
  std::optional<std::size_t> even_from = {};
  int num_jobs = 0;  ///< threads; 0 = one per processor
  /// (done, total) while the frames of a video or sequence are examined; total = 0: unknown.
  std::function<void(std::size_t, std::size_t)> progress = {};
  const CancelFlag* cancel = nullptr;   ///< must outlive the set: reading a frame may mean reading a whole
                                        ///< video
  const ContentCache* cache = nullptr;  ///< for the choice of frames
};

/// The images that inputs stand for (listInputs()). All frames of videos and sequences are examined once, and
/// the sharpest ones that show something new are chosen (FrameChooser). A video that cannot be read becomes
/// an image that cannot be read; so does one that ends before nine tenths of its stated length. A note
/// reports a video that ends a little early. Damaged frames of a video are not chosen.
/// @throws Error as listInputs(); Cancelled
[[nodiscard]] ImageSet openImages(std::span<const std::string> inputs, const OpenImagesOptions& options = {});

/// The video and the number, from 0, in the name of a frame as from ImageSet::name(): "clip.mp4@120". Nothing
/// for any other name.
[[nodiscard]] std::optional<std::pair<std::string, std::size_t>> parseFrameName(std::string_view name);

/// Images and frames of videos by their names, as in ImageSet::name(). A file whose name looks like that of a
/// frame is treated as a file. Frames that are requested in order take one pass through their video.
[[nodiscard]] ImageSet openNamed(const std::vector<std::string>& names);

}  // namespace alidade
