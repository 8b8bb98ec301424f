// SPDX-License-Identifier: MIT
#include "alidade/imagery/video_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <boost/algorithm/string/predicate.hpp>

#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/files/text/atomic_file.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/mem.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

namespace alidade {
namespace {

constexpr std::array<std::string_view, 20> kExtensions = {
    ".mp4",  ".m4v", ".mov", ".avi", ".mkv", ".webm", ".mpg", ".mpeg", ".ts",  ".mts",
    ".m2ts", ".wmv", ".flv", ".ogv", ".mxf", ".3gp",  ".y4m", ".264",  ".265", ".mjpeg"};

// Containers that consist of one file. Others name further files or addresses to read.
constexpr const char* kContainers =
    "mov,matroska,avi,mpegts,mpeg,asf,flv,ogg,mxf,yuv4mpegpipe,h264,hevc,mjpeg,m4v";

std::string reasonOf(int status) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(status, text.data(), text.size());
  return text.data();
}

Error videoError(const std::string& path, std::string found) {
  return inputError(
      {.where = path,
       .found = std::move(found),
       .expected = "a video (MP4, MOV, AVI, Matroska, WebM, MPEG and others)",
       .next_step = "play it in a video player; copy or record it again, or convert it: ffmpeg -i '" + path +
                    "' -c:v libx264 -crf 10 converted.mp4"});
}

// FFmpeg measures rotations counter-clockwise.
int exifOrientationOf(const AVStream& stream) {
  const auto* matrix = reinterpret_cast<const std::int32_t*>(
      av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr));
  if (matrix == nullptr) return 1;
  const double degrees = -av_display_rotation_get(matrix);
  if (std::isnan(degrees)) return 1;
  constexpr std::array<int, 4> kExif = {1, 6, 3, 8};
  const int quarters = static_cast<int>(std::lround(degrees / 90.0)) % 4;
  return kExif[static_cast<std::size_t>((quarters + 4) % 4)];
}

// True if the rows of the first plane hold consecutive luma samples.
bool hasLumaRows(const AVPixFmtDescriptor& format) {
  const AVComponentDescriptor& luma = format.comp[0];
  constexpr std::uint64_t kNoLuma = AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_HWACCEL |
                                    AV_PIX_FMT_FLAG_BITSTREAM | AV_PIX_FMT_FLAG_FLOAT;
  if ((format.flags & kNoLuma) != 0 || luma.plane != 0 || std::string_view(format.name).starts_with("xyz"))
    return false;
  const bool is_uneven = (format.flags & AV_PIX_FMT_FLAG_PLANAR) == 0 && format.log2_chroma_w > 1;  // UYYVYY
  return luma.depth >= 8 && luma.depth <= 16 && !is_uneven;
}

std::uint8_t roundedTo8Bits(unsigned sample, int depth) {
  const int excess = depth - 8;
  const unsigned half = excess > 0 ? 1U << static_cast<unsigned>(excess - 1) : 0;
  return static_cast<std::uint8_t>(std::min((sample + half) >> static_cast<unsigned>(excess), 255U));
}

void copyLuma(const AVFrame& frame, const AVPixFmtDescriptor& format, GrayImage& gray) {
  const AVComponentDescriptor& luma = format.comp[0];
  const int high_byte = (format.flags & AV_PIX_FMT_FLAG_BE) != 0 ? 0 : 1;
  const unsigned mask = (1U << static_cast<unsigned>(luma.depth)) - 1;
  std::uint8_t* pixel = gray.pixels.data();
  for (int y = 0; y < gray.size.height; ++y) {
    const std::uint8_t* sample =
        frame.data[0] + static_cast<std::ptrdiff_t>(y) * frame.linesize[0] + luma.offset;
    for (int x = 0; x < gray.size.width; ++x, sample += luma.step) {
      if (luma.depth == 8) {
        *pixel++ = *sample;
        continue;
      }
      const unsigned word = static_cast<unsigned>(sample[high_byte]) << 8U | sample[1 - high_byte];
      *pixel++ = roundedTo8Bits(word >> static_cast<unsigned>(luma.shift) & mask, luma.depth);
    }
  }
}

}  // namespace

struct VideoReader::State {
  struct Freed {
    void operator()(AVFormatContext* object) const { avformat_close_input(&object); }
    void operator()(AVCodecContext* object) const { avcodec_free_context(&object); }
    void operator()(AVFrame* object) const { av_frame_free(&object); }
    void operator()(AVPacket* object) const { av_packet_free(&object); }
    void operator()(SwsContext* object) const { sws_freeContext(object); }
  };
  template <class T>
  using Owned = std::unique_ptr<T, Freed>;

  // A video's file while its packets are read.
  struct File {
    struct Track {
      int num_packets = 0;
      double first = 0;
      double last = 0;
      double end = 0;
    };

    File(std::string file, const VideoOptions& wanted) : path(std::move(file)), options(wanted) {}

    std::string path;
    VideoOptions options;
    Owned<AVFormatContext> format;
    Owned<AVPacket> packet{av_packet_alloc()};
    int stream_index = -1;
    bool is_at_end = false;
    bool is_cut = false;  // the end of the file could not be read
    std::int64_t num_file_bytes = 0;
    std::map<int, Track> tracks;
    std::int64_t num_packets = 0;
    std::int64_t num_packet_bytes = 0;
    std::int64_t end_position = 0;  // in the file, after the packets so far

    [[nodiscard]] const AVStream& stream() const { return *format->streams[stream_index]; }
    [[nodiscard]] double secondsPerTick() const { return av_q2d(stream().time_base); }
    [[nodiscard]] bool isMatroska() const {
      return std::string_view(format->iformat->name).starts_with("matroska");
    }

    // Treats a lack of memory like other errors, because damaged headers may ask for any amount.
    void check(int status, const char* what) const {
      throwIfCancelled(options.cancel);
      if (status >= 0) return;
      throw videoError(path, std::string("the video cannot be ") + what + " (" + reasonOf(status) + ")");
    }

    void checkSize(const ImageSize& size) const {
      if (std::int64_t{size.width} * size.height <= options.max_pixels) return;
      throw inputError({.where = path,
                        .found = "frames of " + sizeText(size) + " pixels",
                        .expected = "at most " + std::to_string(options.max_pixels) + " pixels in a frame",
                        .next_step = "check that the file is not damaged, or make the video smaller"});
    }

    void open() {
      format.reset(avformat_alloc_context());
      if (!format) throw std::bad_alloc();
      format->interrupt_callback = {[](void* cancel) {
                                      const auto* const flag = static_cast<const CancelFlag*>(cancel);
                                      return flag != nullptr && flag->load() ? 1 : 0;
                                    },
                                    const_cast<CancelFlag*>(options.cancel)};
      AVDictionary* settings = nullptr;
      av_dict_set(&settings, "format_whitelist", kContainers, 0);
      av_dict_set(&settings, "protocol_whitelist", "file", 0);
      av_dict_set(&settings, "max_streams", "32", 0);  // each may have large tables
      // FFmpeg frees the context when opening fails.
      AVFormatContext* opened = format.release();
      // With the protocol, because a name may contain a colon. Judged by content alone, a stream of JPEG
      // images looks like a single image.
      const AVInputFormat* known =
          boost::iends_with(path, ".mjpeg") ? av_find_input_format("mjpeg") : nullptr;
      const int status = avformat_open_input(&opened, ("file:" + path).c_str(), known, &settings);
      av_dict_free(&settings);
      format.reset(opened);
      check(status, "opened");
      for (unsigned i = 0; i < format->nb_streams; ++i) {
        const AVCodecParameters& parameters = *format->streams[i]->codecpar;
        if (parameters.codec_type == AVMEDIA_TYPE_VIDEO) checkSize({parameters.width, parameters.height});
      }
      // Decodes a few frames to find their format.
      const std::string max_pixels = std::to_string(options.max_pixels);
      std::vector<AVDictionary*> limits(format->nb_streams);
      for (AVDictionary*& limit : limits) av_dict_set(&limit, "max_pixels", max_pixels.c_str(), 0);
      const int found = avformat_find_stream_info(format.get(), limits.data());
      for (AVDictionary*& limit : limits) av_dict_free(&limit);
      check(found, "read");
    }

    // Goes to the next packet, or the end.
    void advance() {
      av_packet_unref(packet.get());
      const int status = av_read_frame(format.get(), packet.get());
      throwIfCancelled(options.cancel);
      is_at_end = status < 0;
      is_cut = is_at_end && (status != AVERROR_EOF || (format->pb != nullptr && format->pb->error < 0));
      if (is_at_end) return;
      ++num_packets;
      num_packet_bytes += packet->size;
      checkExtent();
      const std::int64_t time = packet->pts != AV_NOPTS_VALUE ? packet->pts : packet->dts;
      if (time == AV_NOPTS_VALUE) return;
      Track& track = tracks[packet->stream_index];
      const double tick = av_q2d(format->streams[packet->stream_index]->time_base);
      const double seconds = static_cast<double>(time) * tick;
      if (track.num_packets++ == 0) track.first = track.last = seconds;
      track.first = std::min(track.first, seconds);
      track.last = std::max(track.last, seconds);
      track.end = std::max(track.end, seconds + static_cast<double>(packet->duration) * tick);
    }

    // Each byte of a file is normally read about once. Tables that list the same data repeatedly would turn a
    // small file into an endless video. Matroska has no such tables, but may be compressed.
    void checkExtent() const {
      constexpr std::int64_t kMostReadings = 4;
      constexpr std::int64_t kSlack = 1 << 20;
      const bool is_too_much = num_packet_bytes > kMostReadings * num_file_bytes + kSlack;
      if (!(is_too_much && !isMatroska()) && num_packets <= num_file_bytes) return;
      throw videoError(path, "the video is damaged: it gives more data than the file holds");
    }

    // FFmpeg silently skips damaged structure to the next intact part. The packets of an intact file follow
    // each other with only short headers between them.
    [[nodiscard]] bool hasGapBeforePacket() {
      constexpr std::int64_t kMostHeaders = 512;
      if (!isMatroska() || packet->pos < 0) return false;
      const bool is_gap = end_position > 0 && packet->pos > end_position + kMostHeaders;
      end_position = std::max(end_position, packet->pos + packet->size);
      return is_gap;
    }

    // End of the last packet of any stream; sound may be longer than the pictures.
    [[nodiscard]] double endSeconds() const {
      double end = 0;
      for (const auto& [index, track] : tracks) {
        const double gap = track.num_packets > 1 ? (track.last - track.first) / (track.num_packets - 1) : 0;
        end = std::max({end, track.end, track.last + gap});
      }
      return end;
    }
  };

  State(const std::string& path, const VideoOptions& options) : file(path, options) {}

  File file;
  Owned<AVCodecContext> codec;
  Owned<AVFrame> frame{av_frame_alloc()};
  Owned<SwsContext> scaler;
  std::size_t num_frames = 0;
  std::size_t num_lost = 0;
  bool is_packet_waiting = false;  // the decoder had no room for the packet
  bool is_repaired = false;        // a frame since the last key frame was repaired
  std::int64_t repair_time =
      AV_NOPTS_VALUE;  // of the last packet with errors; frames may leave the decoder in a different order

  void open() {
    file.open();
    const AVCodec* decoder = nullptr;
    file.stream_index = av_find_best_stream(file.format.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
    if (file.stream_index < 0 || decoder == nullptr) {
      throw videoError(file.path, file.stream_index == AVERROR_DECODER_NOT_FOUND || file.stream_index >= 0
                                      ? "a video that FFmpeg cannot decode"
                                      : "no pictures in the file");
    }
    const AVCodecParameters& parameters = *file.stream().codecpar;
    file.checkSize({parameters.width, parameters.height});
    codec.reset(avcodec_alloc_context3(decoder));
    if (!codec || avcodec_parameters_to_context(codec.get(), &parameters) < 0) throw std::bad_alloc();
    // Enables all checks: otherwise, most damage is repaired silently.
    codec->err_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_EXPLODE;
    // With several frames at once, errors would be reported for later frames; with several slices at once,
    // the H.264 decoder does not check for missing parts.
    codec->thread_type = FF_THREAD_SLICE;
    codec->thread_count = decoder->id == AV_CODEC_ID_H264 ? 1 : 0;  // 0: one per processor
    codec->pkt_timebase = file.stream().time_base;
    codec->max_pixels = file.options.max_pixels;
    file.check(avcodec_open2(codec.get(), decoder, nullptr), "decoded");
  }

  void noteError() {
    is_repaired = true;
    if (file.packet->pts != AV_NOPTS_VALUE) repair_time = std::max(repair_time, file.packet->pts);
  }

  void noteLoss() {
    noteError();
    ++num_lost;
  }

  void readPacket() {
    file.advance();
    if (file.is_at_end) return;
    is_packet_waiting = file.packet->stream_index == file.stream_index;
    const bool is_gap = file.hasGapBeforePacket();
    const bool is_fresh = is_packet_waiting && (file.packet->flags & AV_PKT_FLAG_KEY) != 0;
    const bool is_corrupt = is_packet_waiting && (file.packet->flags & AV_PKT_FLAG_CORRUPT) != 0;
    num_lost += is_gap ? 1 : 0;
    if ((is_gap && !is_fresh) || is_corrupt) noteError();
  }

  // Sends the decoder its next packet, or the end.
  void feed() {
    while (!is_packet_waiting && !file.is_at_end) readPacket();
    const int status = avcodec_send_packet(codec.get(), is_packet_waiting ? file.packet.get() : nullptr);
    is_packet_waiting = false;
    // The decoder has room, because it had no frame to give.
    if (status < 0 && status != AVERROR_EOF) noteLoss();
  }

  bool advance() {
    for (;;) {
      throwIfCancelled(file.options.cancel);
      av_frame_unref(frame.get());
      const int status = avcodec_receive_frame(codec.get(), frame.get());
      if (status == AVERROR_EOF) return false;
      if (status == AVERROR(EAGAIN)) {
        feed();
      } else if (status < 0) {
        noteLoss();
      } else {
        break;
      }
    }
    const bool is_flawed = frame->decode_error_flags != 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0;
    const std::int64_t time = frame->best_effort_timestamp;
    const bool is_fresh = frame->key_frame != 0 && (time == AV_NOPTS_VALUE || time > repair_time);
    is_repaired = is_flawed || (is_repaired && !is_fresh);
    ++num_frames;
    return true;
  }

  GrayImage grayImage() {
    const ImageSize size{frame->width, frame->height};
    file.checkSize(size);
    GrayImage gray{.size = size, .pixels = {}};
    gray.pixels.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
    const auto pixel_format = static_cast<AVPixelFormat>(frame->format);
    const AVPixFmtDescriptor* description = av_pix_fmt_desc_get(pixel_format);
    if (description == nullptr) throw videoError(file.path, "pixels in an unknown format");
    if (hasLumaRows(*description)) {
      copyLuma(*frame, *description, gray);
      return gray;
    }
    // Converts to 16 bits first, because dithering to 8 bits would add noise to pixels with more bits.
    scaler.reset(sws_getCachedContext(scaler.release(), size.width, size.height, pixel_format, size.width,
                                      size.height, AV_PIX_FMT_GRAY16, SWS_POINT | SWS_ACCURATE_RND, nullptr,
                                      nullptr, nullptr));
    std::vector<std::uint16_t> wide(gray.pixels.size());
    auto* const rows = reinterpret_cast<std::uint8_t*>(wide.data());
    const int stride = 2 * size.width;
    if (!scaler || sws_scale(scaler.get(), frame->data, frame->linesize, 0, size.height, &rows, &stride) < 0)
      throw videoError(file.path, "pixels that cannot be converted to grey");
    std::ranges::transform(wide, gray.pixels.begin(),
                           [](std::uint16_t value) { return roundedTo8Bits(value, 16); });
    return gray;
  }
};

VideoReader::VideoReader(const std::string& path, const VideoOptions& options)
    : state_(std::make_unique<State>(path, options)) {
  // FFmpeg keeps these settings for the whole process. Problems are reported as an Error. A table of a
  // kilobyte may claim a billion frames; this limit allows fifty hours, and frames of 8192x8192.
  constexpr std::size_t kMaxAllocation = std::size_t{130} << 20U;
  [[maybe_unused]] static const bool kIsSet = [] {
    av_log_set_level(AV_LOG_QUIET);
    av_max_alloc(kMaxAllocation);
    return true;
  }();
  checkVideoFile(path);
  std::error_code error;
  state_->file.num_file_bytes = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  state_->open();
}

VideoReader::~VideoReader() = default;
VideoReader::VideoReader(VideoReader&&) noexcept = default;
VideoReader& VideoReader::operator=(VideoReader&&) noexcept = default;

bool VideoReader::advance() {
  return state_->advance();
}

std::size_t VideoReader::number() const {
  return state_->num_frames - 1;
}

bool VideoReader::isIntact() const {
  return !state_->is_repaired;
}

std::size_t VideoReader::numLost() const {
  return state_->num_lost;
}

bool VideoReader::isInterlaced() const {
  return state_->frame->interlaced_frame != 0;
}

LoadedImage VideoReader::image() const {
  return {.image = state_->grayImage(), .exif_orientation = exifOrientationOf(state_->file.stream())};
}

std::size_t VideoReader::statedFrames() const {
  return static_cast<std::size_t>(std::max<std::int64_t>(state_->file.stream().nb_frames, 0));
}

double VideoReader::statedSeconds() const {
  const AVFormatContext& format = *state_->file.format;
  // Otherwise, it is a guess from the file size.
  if (format.duration_estimation_method != AVFMT_DURATION_FROM_STREAM) return 0;
  const AVStream& stream = state_->file.stream();
  // For a truncated file, FFmpeg reduces the duration, but not the number of frames. One frame is one tick
  // here.
  if (std::string_view(format.iformat->name) == "avi" && stream.nb_frames > 0)
    return static_cast<double>(stream.nb_frames) * state_->file.secondsPerTick();
  const double of_stream = static_cast<double>(stream.duration) * state_->file.secondsPerTick();
  const double of_file = static_cast<double>(format.duration) / AV_TIME_BASE;
  if (stream.duration > 0 && format.duration > 0)
    return std::min(of_stream, of_file);  // edit lists may hide frames
  return stream.duration > 0 ? of_stream : format.duration > 0 ? of_file : 0.0;
}

double VideoReader::missingShare() const {
  const auto shareOf = [](double reached, double stated) {
    return stated > 0 ? std::clamp(1 - reached / stated, 0.0, 1.0) : 1.0;
  };
  const AVFormatContext& format = *state_->file.format;
  // In Matroska the stated duration counts from 0.
  const bool is_from_start = format.start_time != AV_NOPTS_VALUE && !state_->file.isMatroska();
  const double start = is_from_start ? static_cast<double>(format.start_time) / AV_TIME_BASE : 0;
  const double of_frames = shareOf(static_cast<double>(state_->num_frames + state_->num_lost),
                                   static_cast<double>(statedFrames()));
  const double of_seconds = shareOf(state_->file.endSeconds() - start, statedSeconds());
  if (statedFrames() == 0 && statedSeconds() <= 0) return 0;
  return std::min(of_frames, of_seconds);
}

bool VideoReader::isCut() const {
  return state_->file.is_cut;
}

double VideoReader::seconds() const {
  const AVStream& stream = state_->file.stream();
  const std::int64_t time = state_->frame->best_effort_timestamp;
  if (time == AV_NOPTS_VALUE) return 0;
  const std::int64_t start = stream.start_time == AV_NOPTS_VALUE ? 0 : stream.start_time;
  return static_cast<double>(time - start) * state_->file.secondsPerTick();
}

void checkVideoFile(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw missingPathError(path);
  if (!std::filesystem::is_regular_file(status)) throw videoError(path, "this is no ordinary file");
  if (std::filesystem::file_size(path, error) == 0) throw videoError(path, "the file is empty (0 bytes)");
}

std::string videoDecoderVersion() {
  return std::to_string(avcodec_version()) + " " + std::to_string(swscale_version());
}

bool hasVideoName(const std::string& path) {
  return std::any_of(kExtensions.begin(), kExtensions.end(),
                     [&](std::string_view extension) { return boost::iends_with(path, extension); });
}

}  // namespace alidade
