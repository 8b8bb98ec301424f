// SPDX-License-Identifier: MIT
#include "alidade/imagery/image_set.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "alidade/core/digest.h"
#include "alidade/core/mapped.h"
#include "alidade/core/parallel.h"
#include "alidade/core/text.h"
#include "alidade/files/content_cache.h"
#include "alidade/imagery/frame_choice.h"
#include "alidade/imagery/image_list.h"
#include "alidade/imagery/video_program.h"
#include "alidade/imagery/video_reader.h"

namespace alidade {
namespace {

EncodedImage readFile(const std::string& path) {
  std::string bytes = readImageBytes(path);
  std::string identity = digestOf(bytes);
  return {.identity = std::move(identity), .decode = [path, bytes = std::move(bytes)]() mutable {
            return decodeGrayImage(path, std::move(bytes));
          }};
}

std::string digestOfFile(const std::string& path, const CancelFlag* cancel) {
  std::ifstream file(path, std::ios::binary);
  DigestOfParts digest;
  std::vector<char> block(std::size_t{1} << 20U);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0) {
    throwIfCancelled(cancel);
    digest.add({block.data(), static_cast<std::size_t>(file.gcount())});
  }
  if (!file.eof())
    throw inputError({.where = path, .found = "cannot be read", .expected = "a readable file"});
  return digest.hex();
}

// Identifies the frames of a video as long as the file does not change.
class VideoIdentity {
 public:
  VideoIdentity() = default;  // unknown
  /// @throws Error (kInput) if it is not a regular file, such as a pipe, which could be read only once
  VideoIdentity(const std::string& path, const CancelFlag* cancel) : path_(path), stamp_(stampOf(path)) {
    checkVideoFile(path);
    text_ = digestOfFile(path, cancel) + " " + videoDecoderVersion(path);
  }

  [[nodiscard]] const std::string& text() const { return text_; }

  /// Called before a result is cached, because it would be stored under the identity of different bytes.
  void checkUnchanged() const {
    if (text_.empty() || stampOf(path_) == stamp_) return;
    throw inputError({.where = path_,
                      .found = "the video changed while it was read",
                      .expected = "a finished file",
                      .next_step = "wait until it is completely written"});
  }

 private:
  using Stamp = std::pair<std::uintmax_t, std::filesystem::file_time_type>;
  static Stamp stampOf(const std::string& path) {
    std::error_code error;
    return {std::filesystem::file_size(path, error), std::filesystem::last_write_time(path, error)};
  }

  std::string path_;
  std::string text_;
  Stamp stamp_;
};

// The chosen frames of a video. Several threads request them in approximately rising order.
class VideoFrames {
 public:
  VideoFrames(std::string path, VideoIdentity identity, const std::vector<std::size_t>& numbers,
              const CancelFlag* cancel)
      : path_(std::move(path)),
        identity_(std::move(identity)),
        numbers_(numbers.begin(), numbers.end()),
        cancel_(cancel) {}

  [[nodiscard]] std::string identityOf(std::size_t number) const {
    return identity_.text().empty() ? "" : identity_.text() + "@" + std::to_string(number);
  }

  LoadedImage load(std::size_t number) {
    const std::lock_guard lock(mutex_);
    LoadedImage image = read(number);
    identity_.checkUnchanged();
    return image;
  }

 private:
  LoadedImage read(std::size_t number) {
    if (auto passed = passed_.extract(number)) return std::move(passed.mapped());
    // The frame is behind the reader, so the video is read from its beginning again.
    if (!reader_ || number < next_) {
      reader_.emplace(path_, VideoOptions{.cancel = cancel_});
      next_ = 0;
    }
    while (reader_->advance()) {
      next_ = reader_->number() + 1;
      if (reader_->number() == number) return reader_->image();
      keepPassed();
    }
    throw inputError({.where = path_,
                      .found = fmt::format("frame {} cannot be read a second time", number),
                      .expected = "a file that does not change while it is read"});
  }

  void keepPassed() {
    constexpr std::size_t kMost = 16;  // limits the memory; dropped frames are read again
    if (!numbers_.contains(reader_->number())) return;
    if (passed_.size() == kMost) passed_.erase(passed_.begin());
    passed_[reader_->number()] = reader_->image();
  }

  std::string path_;
  VideoIdentity identity_;
  std::set<std::size_t> numbers_;
  const CancelFlag* cancel_;
  std::mutex mutex_;
  std::optional<VideoReader> reader_;
  std::size_t next_ = 0;                       // the reader's next frame
  std::map<std::size_t, LoadedImage> passed_;  // chosen frames before `next_` that were not requested yet
};

void addItems(const std::string& path, const VideoIdentity& identity, const std::vector<std::size_t>& numbers,
              std::optional<std::size_t> sequence, const CancelFlag* cancel,
              std::vector<ImageSet::Item>& items) {
  const auto frames = std::make_shared<VideoFrames>(path, identity, numbers, cancel);
  for (const std::size_t number : numbers) {
    items.push_back({.name = path + "@" + std::to_string(number),
                     .sequence = sequence,
                     .read = [frames, number](const std::string&) -> EncodedImage {
                       return {.identity = frames->identityOf(number),
                               .decode = [frames, number] { return frames->load(number); }};
                     }});
  }
}

// The frames worth searching, and the problems found on the way.
struct VideoChoice {
  std::vector<std::size_t> numbers;
  std::size_t num_frames = 0;
  std::size_t num_damaged = 0;
  std::size_t num_interlaced = 0;
  bool is_cut = false;  // more frames are expected after the last one
};

std::string choiceText(const VideoChoice& choice) {
  return fmt::format("{} {} {} {} {}", choice.num_frames, choice.num_damaged, choice.num_interlaced,
                     choice.is_cut ? 1 : 0, fmt::join(choice.numbers, " "));
}

// Nothing if the text is not a valid choice of up to this many frames.
std::optional<VideoChoice> parseChoice(std::string_view text, std::size_t num_wanted) {
  std::vector<std::size_t> numbers;
  for (const std::string_view word : split(text, ' ')) {
    const std::optional<int> number = parseInt(word);
    if (!number || *number < 0) return std::nullopt;
    numbers.push_back(static_cast<std::size_t>(*number));
  }
  constexpr std::size_t kNumCounts = 4;
  if (numbers.size() <= kNumCounts || numbers.size() > kNumCounts + num_wanted) return std::nullopt;
  const VideoChoice choice{.numbers = {numbers.begin() + kNumCounts, numbers.end()},
                           .num_frames = numbers[0],
                           .num_damaged = numbers[1],
                           .num_interlaced = numbers[2],
                           .is_cut = numbers[3] == 1};
  const bool is_rising =
      std::ranges::adjacent_find(choice.numbers, std::greater_equal<>()) == choice.numbers.end();
  const bool is_within = choice.numbers.back() < choice.num_frames &&
                         choice.num_damaged < choice.num_frames &&
                         choice.num_interlaced <= choice.num_frames && numbers[3] <= 1;
  return is_rising && is_within ? std::optional(choice) : std::nullopt;
}

Error unreadableVideo(const std::string& path, std::string found, std::string next_step) {
  return inputError({.where = path,
                     .found = std::move(found),
                     .expected = "a video that can be decoded completely",
                     .next_step = std::move(next_step)});
}

// Six to twelve frames a second from a first one on, enough to follow the motion of a hand. Of a longer
// video, the first half of the frames is without a gap, so that recordings that start at different times have
// frames in common; the others are in runs, chosen by chance, but alike in all videos.
class EvenFrames {
 public:
  EvenFrames(std::size_t first, std::size_t num_wanted, double rate_hz)
      : first_(first), num_wanted_(num_wanted) {
    constexpr double kRate = 12;
    // Powers of two, so that videos of nearly one rate have frames in common.
    if (rate_hz > kRate) step_ = std::bit_ceil(static_cast<std::size_t>(std::ceil(rate_hz / kRate)));
  }

  void add(std::size_t number) {
    if (number >= first_ && (number - first_) % step_ == 0) numbers_.push_back(number);
  }
  [[nodiscard]] std::vector<std::size_t> chosen() const {
    const std::size_t num_first = (num_wanted_ + 1) / 2;
    std::vector<std::size_t> chosen = numbers_;
    std::ranges::sort(chosen, {}, [&](std::size_t number) {
      const std::size_t place = (number - first_) / step_;
      return std::pair(place < num_first ? 0 : mixed(place / kRun), number);
    });
    chosen.resize(std::min(chosen.size(), num_wanted_));
    std::ranges::sort(chosen);
    return chosen;
  }

 private:
  // Looks random (Steele, Lea and Flood 2014, the finaliser of SplitMix), and is not 0.
  static std::uint64_t mixed(std::uint64_t run) {
    run = (run + 0x9e3779b97f4a7c15U) * 0xbf58476d1ce4e5b9U;
    run = (run ^ (run >> 27U)) * 0x94d049bb133111ebU;
    return (run ^ (run >> 31U)) | 1U;
  }

  static constexpr std::size_t kRun = 30;  // frames
  std::size_t first_;
  std::size_t num_wanted_;
  std::size_t step_ = 1;
  std::vector<std::size_t> numbers_;
};

VideoChoice chooseFrames(const std::string& path, const OpenImagesOptions& options) {
  VideoReader reader(path, {.cancel = options.cancel});
  FrameChooser chooser(options.num_frames);
  EvenFrames even(options.even_from.value_or(0), options.num_frames, reader.frameRate());
  VideoChoice choice;
  while (reader.advance()) {
    ++choice.num_frames;
    choice.num_interlaced += reader.isInterlaced() ? 1 : 0;
    choice.num_damaged += reader.isIntact() ? 0 : 1;
    if (reader.isIntact() && options.even_from) even.add(reader.number());
    if (reader.isIntact() && !options.even_from) chooser.add(reader.number(), lookAt(reader.image().image));
    if (options.progress) options.progress(choice.num_frames, reader.statedFrames());
  }
  const bool is_none_intact = choice.num_frames == choice.num_damaged;
  choice.num_frames += reader.numLost();
  choice.num_damaged += reader.numLost();
  if (is_none_intact) {
    throw unreadableVideo(path,
                          choice.num_frames == 0
                              ? "no frame can be decoded"
                              : fmt::format("all {} frames are damaged", choice.num_frames),
                          "copy or record the video again");
  }
  constexpr double kMuch = 0.1;
  constexpr double kLittle =
      0.02;  // headers may count frames that are not shown, or state a rounded duration
  const double missing = reader.missingShare();
  if (missing > kMuch) {
    const std::string whole = reader.statedFrames() > 0 ? fmt::format("{} frames", reader.statedFrames())
                                                        : fmt::format("{:.3g} s", reader.statedSeconds());
    throw unreadableVideo(
        path, fmt::format("the file ends early: only {:.0f} % of {} can be read", 100 * (1 - missing), whole),
        "copy the video again, or convert it: ffmpeg -i '" + path + "' -map 0:v:0 -c copy whole.mp4");
  }
  choice.is_cut = missing > kLittle || reader.isCut();
  choice.numbers = options.even_from ? even.chosen() : chooser.chosen();
  return choice;
}

// The result of `compute`, or from the cache if `parse` accepts the cached text.
template <typename Parse, typename Compute, typename Write>
auto cached(const ContentCache* cache, const std::string& key, const Parse& parse, const Write& write,
            const Compute& compute) {
  if (cache != nullptr) {
    if (const std::optional<std::string> text = cache->find(key)) {
      if (auto result = parse(*text)) return std::move(*result);
      cache->reject(key);
    }
  }
  auto result = compute();
  if (cache != nullptr) cache->keep(key, write(result));
  return result;
}

std::string lookText(const FrameLook& look) {
  return fmt::format("{} {}", exactText(look.sharpness), fmt::join(look.thumbnail, " "));
}

std::optional<FrameLook> parseLook(std::string_view text) {
  const std::vector<std::string_view> words = split(text, ' ');
  FrameLook look;
  if (words.size() != look.thumbnail.size() + 1) return std::nullopt;
  const std::optional<double> sharpness = parseDouble(words.front());
  if (!sharpness || !std::isfinite(*sharpness) || *sharpness < 0) return std::nullopt;
  look.sharpness = *sharpness;
  for (std::size_t i = 0; i < look.thumbnail.size(); ++i) {
    const std::optional<int> value = parseInt(words[i + 1]);
    if (!value || *value < 0 || *value > std::numeric_limits<std::uint8_t>::max()) return std::nullopt;
    look.thumbnail[i] = static_cast<std::uint8_t>(*value);
  }
  return look;
}

// Must change whenever the choice of frames may change.
constexpr std::string_view kChoiceVersion = "frames 3 ";

class Opening {
 public:
  explicit Opening(const OpenImagesOptions& options) : options_(options) {}

  void add(const std::vector<std::string>& files) {
    for (const std::string& file : files) items_.push_back({.name = file, .read = readFile});
  }

  void add(const ImageSequence& sequence) {
    // Unreadable files count as images, so that the run reports them.
    std::vector<std::optional<FrameLook>> looks(sequence.files.size());
    std::mutex mutex;
    std::size_t num_done = 0;
    parallelFor(
        looks.size(), options_.num_jobs,
        [&](std::size_t i) {
          try {
            looks[i] = lookAtFile(sequence.files[i]);
          } catch (const Error&) {
          }
          const std::lock_guard lock(mutex);
          if (options_.progress) options_.progress(++num_done, looks.size());
        },
        options_.cancel);
    FrameChooser chooser(options_.num_frames);
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < looks.size(); ++i) {
      if (looks[i]) chooser.add(i, *looks[i]);
      if (!looks[i]) numbers.push_back(i);
    }
    const std::vector<std::size_t> chosen = chooser.chosen();
    noteChoice(sequence.pattern, chosen.size(), looks.size() - numbers.size(), "images");
    numbers.insert(numbers.end(), chosen.begin(), chosen.end());
    std::sort(numbers.begin(), numbers.end());
    for (const std::size_t number : numbers)
      items_.push_back({.name = sequence.files[number], .sequence = num_sequences_, .read = readFile});
    ++num_sequences_;
  }

  void addVideo(const std::string& path) {
    try {
      addFrames(path);
    } catch (const Error& error) {
      items_.push_back({.name = path, .read = [error](const std::string&) -> EncodedImage { throw error; }});
    }
  }

  ImageSet finish() { return {std::move(items_), std::move(notes_)}; }

 private:
  [[nodiscard]] FrameLook lookAtFile(const std::string& path) const {
    const EncodedImage image = readFile(path);
    return cached(options_.cache, std::string(kChoiceVersion) + image.identity, parseLook, lookText,
                  [&] { return lookAt(image.decode().image); });
  }

  void addFrames(const std::string& path) {
    const VideoIdentity identity =
        options_.cache == nullptr ? VideoIdentity() : VideoIdentity(path, options_.cancel);
    const VideoChoice choice = cached(
        options_.cache,
        fmt::format("{}{}{} {}", kChoiceVersion, options_.num_frames,
                    options_.even_from ? fmt::format(" even {}", *options_.even_from) : "", identity.text()),
        [&](const std::string& text) { return parseChoice(text, options_.num_frames); }, choiceText,
        [&] {
          VideoChoice made = chooseFrames(path, options_);
          identity.checkUnchanged();
          return made;
        });
    noteChoice(path, choice.numbers.size(), choice.num_frames, "frames");
    if (choice.num_damaged > 0) {
      notes_.push_back(fmt::format("{}: {} of {} frames are damaged; they are not used", path,
                                   choice.num_damaged, choice.num_frames));
    }
    if (2 * choice.num_interlaced > choice.num_frames) {
      notes_.push_back(path +
                       ": the video is interlaced: a frame shows two moments. If the board moved, convert it "
                       "first: ffmpeg -i IN -vf bwdif -crf 10 OUT.mp4");
    }
    if (choice.is_cut) {
      notes_.push_back(
          path +
          ": the file ends early, or its end cannot be read; copy or record it again if frames are missing");
    }
    // Of frames that look the same to one camera, each may show another one something new.
    const auto sequence = options_.even_from ? std::nullopt : std::optional(num_sequences_++);
    addItems(path, identity, choice.numbers, sequence, options_.cancel, items_);
  }

  void noteChoice(const std::string& name, std::size_t num_chosen, std::size_t num_all, const char* what) {
    notes_.push_back(fmt::format("{}: {} of {} {} are searched{}", name, num_chosen, num_all, what,
                                 options_.even_from ? "" : " (sharp, and different from each other)"));
  }

  OpenImagesOptions options_;
  std::size_t num_sequences_ = 0;
  std::vector<ImageSet::Item> items_;
  std::vector<std::string> notes_;
};

}  // namespace

ImageSet::ImageSet(std::vector<std::string> files) {
  for (std::string& file : files) items_.push_back({.name = std::move(file), .read = readFile});
}

ImageSet::ImageSet(const std::vector<std::string>& names, const Load& load) {
  for (const std::string& name : names) {
    items_.push_back({.name = name, .read = [load](const std::string& asked) {
                        return EncodedImage{.identity = "", .decode = [load, asked] { return load(asked); }};
                      }});
  }
}

ImageSet::ImageSet(std::vector<Item> items, std::vector<std::string> notes)
    : items_(std::move(items)), notes_(std::move(notes)) {}

std::vector<std::string> ImageSet::names() const {
  return mapped(items_, &Item::name);
}

EncodedImage ImageSet::read(std::size_t i) const {
  return items_[i].read(items_[i].name);
}

ImageSet ImageSet::mirrored() const {
  ImageSet result = *this;
  for (Item& item : result.items_) {
    item.read = [read = item.read](const std::string& name) {
      EncodedImage image = read(name);
      if (!image.identity.empty()) image.identity += " mirrored";
      image.decode = [decode = std::move(image.decode)] {
        LoadedImage loaded = decode();
        loaded.image = mirroredOf(std::move(loaded.image));
        return loaded;
      };
      return image;
    };
  }
  return result;
}

ImageSet openImages(std::span<const std::string> inputs, const OpenImagesOptions& options) {
  expect(options.num_frames > 0, "at least one frame of a video");
  const InputFiles files = listInputs(inputs);
  Opening opening(options);
  opening.add(files.images);
  for (const ImageSequence& sequence : files.sequences) opening.add(sequence);
  for (const std::string& video : files.videos) opening.addVideo(video);
  return opening.finish();
}

std::optional<std::pair<std::string, std::size_t>> parseFrameName(std::string_view name) {
  const std::size_t at = name.rfind('@');
  if (at == std::string_view::npos || at == 0) return std::nullopt;
  const std::optional<int> number = parseInt(name.substr(at + 1));
  if (!number || *number < 0) return std::nullopt;
  return std::pair(std::string(name.substr(0, at)), static_cast<std::size_t>(*number));
}

ImageSet openNamed(const std::vector<std::string>& names) {
  std::map<std::string, std::vector<std::size_t>> frames_of;
  std::map<std::string, std::vector<std::size_t>> places_of;  // positions of these frames among the names
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto frame = parseFrameName(names[i]);
    std::error_code failed;
    if (!frame || std::filesystem::exists(names[i], failed)) continue;
    const auto& [video, number] = *frame;
    frames_of[video].push_back(number);
    places_of[video].push_back(i);
  }
  std::vector<ImageSet::Item> items;
  for (std::size_t i = 0; i < names.size(); ++i) items.push_back({.name = names[i], .read = readFile});
  for (const auto& [video, numbers] : frames_of) {
    std::vector<ImageSet::Item> frames;
    addItems(video, VideoIdentity(), numbers, 0, nullptr, frames);
    for (std::size_t k = 0; k < numbers.size(); ++k) items[places_of[video][k]].read = frames[k].read;
  }
  return {std::move(items), {}};
}

}  // namespace alidade
