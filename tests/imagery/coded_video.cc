// SPDX-License-Identifier: MIT
#include "imagery/coded_video.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

namespace alidade {
namespace {

int checked(int status, const char* what) {
  if (status < 0) throw std::runtime_error(std::string("no video for the test: ") + what);
  return status;
}

class VideoEncoder {
 public:
  VideoEncoder(const std::string& path, const CodedVideo& video) : video_(video) {
    AVFormatContext* made = nullptr;
    checked(avformat_alloc_output_context2(&made, nullptr, nullptr, path.c_str()), "container");
    format_.reset(made);
    const AVCodec* codec = avcodec_find_encoder_by_name(video.codec.c_str());
    if (codec == nullptr) throw std::runtime_error("no encoder " + video.codec);
    codec_.reset(avcodec_alloc_context3(codec));
    codec_->width = video.size.width;
    codec_->height = video.size.height;
    codec_->pix_fmt = av_get_pix_fmt(video.pixel_format.c_str());
    codec_->time_base = {1000, static_cast<int>(std::lround(1000 * video.frames_per_second))};
    codec_->framerate = av_inv_q(codec_->time_base);
    codec_->gop_size = 12;
    codec_->max_b_frames = 0;
    codec_->thread_count = 1;
    codec_->strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL;
    codec_->flags |= AV_CODEC_FLAG_QSCALE;
    codec_->global_quality = video.quality * FF_QP2LAMBDA;
    if ((format_->oformat->flags & AVFMT_GLOBALHEADER) != 0) codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    checked(avcodec_open2(codec_.get(), codec, nullptr), "encoder");
    stream_ = avformat_new_stream(format_.get(), nullptr);
    checked(avcodec_parameters_from_context(stream_->codecpar, codec_.get()), "stream");
    stream_->time_base = codec_->time_base;
    stream_->avg_frame_rate = codec_->framerate;
    checked(avio_open(&format_->pb, path.c_str(), AVIO_FLAG_WRITE), "file");
    AVDictionary* settings = nullptr;
    if (video.is_header_first) av_dict_set(&settings, "movflags", "faststart", 0);
    const int status = avformat_write_header(format_.get(), &settings);
    av_dict_free(&settings);
    checked(status, "header");
  }

  void encode() {
    for (int i = 0; i < video_.num_frames; ++i) send(frameOf(i).get());
    send(nullptr);
    checked(av_write_trailer(format_.get()), "end");
  }

 private:
  struct Freed {
    void operator()(AVFormatContext* object) const {
      avio_closep(&object->pb);
      avformat_free_context(object);
    }
    void operator()(AVCodecContext* object) const { avcodec_free_context(&object); }
    void operator()(AVFrame* object) const { av_frame_free(&object); }
    void operator()(AVPacket* object) const { av_packet_free(&object); }
  };

  [[nodiscard]] std::unique_ptr<AVFrame, Freed> frameOf(int number) const {
    std::unique_ptr<AVFrame, Freed> frame(av_frame_alloc());
    frame->format = codec_->pix_fmt;
    frame->width = video_.size.width;
    frame->height = video_.size.height;
    frame->pts = number;
    frame->quality = codec_->global_quality;
    checked(av_frame_get_buffer(frame.get(), 0), "frame");
    for (const AVBufferRef* buffer : frame->buf) {
      if (buffer != nullptr) std::fill_n(buffer->data, buffer->size, std::uint8_t{0});  // lines are or-ed in
    }
    const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(codec_->pix_fmt);
    const bool is_rgb = (format->flags & AV_PIX_FMT_FLAG_RGB) != 0;
    for (int c = 0; c < format->nb_components; ++c) {
      const bool is_chroma = !is_rgb && (c == 1 || c == 2);
      const int width = is_chroma ? AV_CEIL_RSHIFT(frame->width, format->log2_chroma_w) : frame->width;
      const int height = is_chroma ? AV_CEIL_RSHIFT(frame->height, format->log2_chroma_h) : frame->height;
      const auto middle = static_cast<std::uint16_t>(1U << static_cast<unsigned>(format->comp[c].depth - 1));
      std::vector<std::uint16_t> row(static_cast<std::size_t>(width), middle);
      for (int y = 0; y < height; ++y) {
        for (int x = 0; !is_chroma && x < width; ++x)
          row[static_cast<std::size_t>(x)] = static_cast<std::uint16_t>(video_.sample(x, y, number));
        av_write_image_line(row.data(), frame->data, frame->linesize, format, 0, y, c, width);
      }
    }
    return frame;
  }

  void send(const AVFrame* frame) {
    checked(avcodec_send_frame(codec_.get(), frame), "encoding");
    const std::unique_ptr<AVPacket, Freed> packet(av_packet_alloc());
    while (avcodec_receive_packet(codec_.get(), packet.get()) >= 0) {
      if (packet->duration == 0) packet->duration = 1;
      av_packet_rescale_ts(packet.get(), codec_->time_base, stream_->time_base);
      packet->stream_index = stream_->index;
      checked(av_interleaved_write_frame(format_.get(), packet.get()), "writing");
    }
  }

  const CodedVideo& video_;
  std::unique_ptr<AVFormatContext, Freed> format_;
  std::unique_ptr<AVCodecContext, Freed> codec_;
  AVStream* stream_ = nullptr;
};

}  // namespace

std::string writeVideo(const std::string& path, const CodedVideo& video) {
  av_log_set_level(AV_LOG_QUIET);
  VideoEncoder(path, video).encode();
  return path;
}

bool hasEncoder(const std::string& name) {
  return avcodec_find_encoder_by_name(name.c_str()) != nullptr;
}

}  // namespace alidade
