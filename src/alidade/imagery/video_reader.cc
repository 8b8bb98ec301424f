// SPDX-License-Identifier: MIT
#include "alidade/imagery/video_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include <boost/algorithm/string/predicate.hpp>

#include "alidade/core/error.h"
#include "alidade/files/atomic_file.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

namespace alidade {
namespace {

constexpr std::array<std::string_view, 20> kExtensions = {
    ".mp4",  ".m4v", ".mov", ".avi", ".mkv", ".webm", ".mpg", ".mpeg", ".ts",  ".mts",
    ".m2ts", ".wmv", ".flv", ".ogv", ".mxf", ".3gp",  ".y4m", ".264",  ".265", ".mjpeg"};

// Containers of one file. Others name further files or addresses to read.
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

// FFmpeg turns counter-clockwise.
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

bool isLumaPlane(const AVPixFmtDescriptor& format) {
  const AVComponentDescriptor& luma = format.comp[0];
  constexpr std::uint64_t kNoLuma =
      AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_BITSTREAM;
  return (format.flags & kNoLuma) == 0 && luma.plane == 0 && luma.step == 1 && luma.offset == 0 &&
         luma.depth == 8;
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

  std::string path;
  Owned<AVFormatContext> format;
  Owned<AVCodecContext> codec;
  Owned<AVFrame> frame{av_frame_alloc()};
  Owned<AVPacket> packet{av_packet_alloc()};
  Owned<SwsContext> scaler;
  int stream_index = -1;
  int exif_orientation = 1;
  std::size_t num_frames = 0;
  std::size_t num_lost = 0;
  bool is_packet_waiting = false;  // the decoder had no room for it
  bool is_at_end = false;          // the file is
  bool is_repaired = false;        // a frame since the last key frame
  std::int64_t repair_time =
      AV_NOPTS_VALUE;  // of the last packet with errors; frames may leave in another order

  [[nodiscard]] const AVStream& stream() const { return *format->streams[stream_index]; }
  [[nodiscard]] double secondsPerTick() const { return av_q2d(stream().time_base); }

  void open() {
    AVFormatContext* opened = nullptr;
    AVDictionary* options = nullptr;
    av_dict_set(&options, "format_whitelist", kContainers, 0);
    av_dict_set(&options, "protocol_whitelist", "file", 0);
    // With the protocol, as a name may contain a colon.
    const int status = avformat_open_input(&opened, ("file:" + path).c_str(), nullptr, &options);
    av_dict_free(&options);
    if (status < 0) throw videoError(path, "the video cannot be opened (" + reasonOf(status) + ")");
    format.reset(opened);
    if (const int found = avformat_find_stream_info(format.get(), nullptr); found < 0)
      throw videoError(path, "the video cannot be read (" + reasonOf(found) + ")");
    const AVCodec* decoder = nullptr;
    stream_index = av_find_best_stream(format.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
    if (stream_index < 0 || decoder == nullptr) {
      throw videoError(path, stream_index == AVERROR_DECODER_NOT_FOUND || stream_index >= 0
                                 ? "a video that FFmpeg cannot decode"
                                 : "no pictures in the file");
    }
    const AVCodecParameters& parameters = *stream().codecpar;
    checkDecodedSize(path, {parameters.width, parameters.height});
    codec.reset(avcodec_alloc_context3(decoder));
    if (!codec || avcodec_parameters_to_context(codec.get(), &parameters) < 0) throw std::bad_alloc();
    // With all checks: otherwise most damage is repaired without a word.
    codec->err_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_EXPLODE;
    codec->thread_count = 0;               // one per processor
    codec->thread_type = FF_THREAD_SLICE;  // with several frames at once, errors would be told of later ones
    codec->pkt_timebase = stream().time_base;
    if (const int began = avcodec_open2(codec.get(), decoder, nullptr); began < 0)
      throw videoError(path, "the video cannot be decoded (" + reasonOf(began) + ")");
    exif_orientation = exifOrientationOf(stream());
    for (unsigned i = 0; i < format->nb_streams; ++i) {
      if (static_cast<int>(i) != stream_index) format->streams[i]->discard = AVDISCARD_ALL;
    }
  }

  void noteError() {
    is_repaired = true;
    if (packet->pts != AV_NOPTS_VALUE) repair_time = std::max(repair_time, packet->pts);
  }

  void noteLoss() {
    noteError();
    ++num_lost;
  }

  // Hands the decoder its next packet, or the end.
  void feed() {
    while (!is_packet_waiting && !is_at_end) {
      av_packet_unref(packet.get());
      const int status = av_read_frame(format.get(), packet.get());
      if (status == AVERROR(ENOMEM)) throw std::bad_alloc();
      is_at_end = status < 0;
      if (status < 0 && status != AVERROR_EOF) noteError();
      is_packet_waiting = status >= 0 && packet->stream_index == stream_index;
      if (is_packet_waiting && (packet->flags & AV_PKT_FLAG_CORRUPT) != 0) noteError();
    }
    const int status = avcodec_send_packet(codec.get(), is_packet_waiting ? packet.get() : nullptr);
    if (status == AVERROR(EAGAIN)) return;
    if (status == AVERROR(ENOMEM)) throw std::bad_alloc();
    is_packet_waiting = false;
    if (status < 0 && status != AVERROR_EOF) noteLoss();
  }

  bool advance() {
    for (;;) {
      av_frame_unref(frame.get());
      const int status = avcodec_receive_frame(codec.get(), frame.get());
      if (status == AVERROR(ENOMEM)) throw std::bad_alloc();
      if (status == AVERROR_EOF) return false;
      if (status == AVERROR(EAGAIN)) {
        feed();
        continue;
      }
      if (status < 0) {
        noteLoss();
        continue;
      }
      const bool is_flawed = frame->decode_error_flags != 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0;
      const std::int64_t time = frame->best_effort_timestamp;
      const bool is_fresh = frame->key_frame != 0 && (time == AV_NOPTS_VALUE || time > repair_time);
      is_repaired = is_flawed || (is_repaired && !is_fresh);
      ++num_frames;
      return true;
    }
  }

  GrayImage grayImage() {
    const ImageSize size{frame->width, frame->height};
    checkDecodedSize(path, size);
    GrayImage gray{.size = size, .pixels = {}};
    gray.pixels.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
    const auto pixel_format = static_cast<AVPixelFormat>(frame->format);
    const AVPixFmtDescriptor* description = av_pix_fmt_desc_get(pixel_format);
    if (description == nullptr) throw videoError(path, "pixels in an unknown format");
    if (isLumaPlane(*description)) {
      for (int y = 0; y < size.height; ++y) {
        const std::uint8_t* row = frame->data[0] + static_cast<std::ptrdiff_t>(y) * frame->linesize[0];
        std::copy_n(row, size.width, gray.pixels.data() + static_cast<std::ptrdiff_t>(y) * size.width);
      }
      return gray;
    }
    scaler.reset(sws_getCachedContext(scaler.release(), size.width, size.height, pixel_format, size.width,
                                      size.height, AV_PIX_FMT_GRAY8, SWS_POINT, nullptr, nullptr, nullptr));
    std::uint8_t* const rows = gray.pixels.data();
    const int stride = size.width;
    if (!scaler || sws_scale(scaler.get(), frame->data, frame->linesize, 0, size.height, &rows, &stride) < 0)
      throw videoError(path, "pixels that cannot be converted to grey");
    return gray;
  }
};

VideoReader::VideoReader(const std::string& path) : state_(std::make_unique<State>()) {
  // What goes wrong is told as an Error. FFmpeg has one level for the whole process.
  [[maybe_unused]] static const bool kIsSilent = [] {
    av_log_set_level(AV_LOG_QUIET);
    return true;
  }();
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw missingPathError(path);
  if (!std::filesystem::is_regular_file(status)) throw videoError(path, "this is no ordinary file");
  if (std::filesystem::file_size(path, error) == 0) throw videoError(path, "the file is empty (0 bytes)");
  state_->path = path;
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
  return {.image = state_->grayImage(), .exif_orientation = state_->exif_orientation};
}

std::size_t VideoReader::statedFrames() const {
  return static_cast<std::size_t>(std::max<std::int64_t>(state_->stream().nb_frames, 0));
}

double VideoReader::statedSeconds() const {
  const AVStream& stream = state_->stream();
  if (stream.duration > 0) return static_cast<double>(stream.duration) * state_->secondsPerTick();
  const std::int64_t duration = state_->format->duration;
  return duration > 0 ? static_cast<double>(duration) / AV_TIME_BASE : 0.0;
}

double VideoReader::seconds() const {
  const AVStream& stream = state_->stream();
  const std::int64_t time = state_->frame->best_effort_timestamp;
  if (time == AV_NOPTS_VALUE) return 0;
  const std::int64_t start = stream.start_time == AV_NOPTS_VALUE ? 0 : stream.start_time;
  return static_cast<double>(time - start) * state_->secondsPerTick();
}

bool hasVideoName(const std::string& path) {
  return std::any_of(kExtensions.begin(), kExtensions.end(),
                     [&](std::string_view extension) { return boost::iends_with(path, extension); });
}

}  // namespace alidade
