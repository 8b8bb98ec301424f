// SPDX-License-Identifier: MIT
#include "alidade/imagery/gray_jpeg.h"

#include <cstddef>
#include <span>

#include "alidade/imagery/jpeg_complaints.h"

namespace alidade {
namespace {

struct Decoder {
  detail::JpegComplaints complaints;
  jpeg_decompress_struct jpeg{};

  Decoder() { jpeg.err = complaints.install(); }
  ~Decoder() { jpeg_destroy_decompress(&jpeg); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
};

struct Encoder {
  detail::JpegComplaints complaints;
  jpeg_compress_struct jpeg{};
  jpeg_destination_mgr destination;

  explicit Encoder(std::span<JOCTET> bytes) : destination(detail::fixedDestination(bytes)) {
    jpeg.err = complaints.install();
  }
  ~Encoder() { jpeg_destroy_compress(&jpeg); }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
};

// The functions with setjmp() have no variables that are used after the jump, and none with a destructor.

bool readHeader(const cv::Mat& encoded, Decoder& decoder) {
  if (setjmp(decoder.complaints.end) != 0) return false;  // NOLINT(cert-err52-cpp): libjpeg has no other way
  jpeg_create_decompress(&decoder.jpeg);
  jpeg_mem_src(&decoder.jpeg, encoded.data, static_cast<unsigned long>(encoded.total()));
  jpeg_read_header(&decoder.jpeg, TRUE);
  const J_COLOR_SPACE space = decoder.jpeg.jpeg_color_space;
  decoder.jpeg.out_color_space = JCS_GRAYSCALE;
  return space == JCS_GRAYSCALE || space == JCS_YCbCr;
}

bool readRows(Decoder& decoder, cv::Mat& image) {
  if (setjmp(decoder.complaints.end) != 0) return false;  // NOLINT(cert-err52-cpp)
  jpeg_start_decompress(&decoder.jpeg);
  while (decoder.jpeg.output_scanline < decoder.jpeg.output_height) {
    JSAMPROW row = image.ptr(static_cast<int>(decoder.jpeg.output_scanline));
    jpeg_read_scanlines(&decoder.jpeg, &row, 1);
  }
  jpeg_finish_decompress(&decoder.jpeg);
  return true;
}

bool write(const cv::Mat& image, int quality, Encoder& encoder) {
  if (setjmp(encoder.complaints.end) != 0) return false;  // NOLINT(cert-err52-cpp)
  jpeg_create_compress(&encoder.jpeg);
  encoder.jpeg.dest = &encoder.destination;
  encoder.jpeg.image_width = static_cast<JDIMENSION>(image.cols);
  encoder.jpeg.image_height = static_cast<JDIMENSION>(image.rows);
  encoder.jpeg.input_components = 1;
  encoder.jpeg.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&encoder.jpeg);
  jpeg_set_quality(&encoder.jpeg, quality, TRUE);
  jpeg_start_compress(&encoder.jpeg, TRUE);
  while (encoder.jpeg.next_scanline < encoder.jpeg.image_height) {
    auto* row = const_cast<JSAMPROW>(image.ptr(static_cast<int>(encoder.jpeg.next_scanline)));
    jpeg_write_scanlines(&encoder.jpeg, &row, 1);
  }
  jpeg_finish_compress(&encoder.jpeg);
  return true;
}

}  // namespace

cv::Mat decodeGrayJpeg(const cv::Mat& encoded) {
  if (encoded.total() < 2 || encoded.data[0] != 0xff || encoded.data[1] != 0xd8) return {};
  Decoder decoder;
  cv::Mat image;
  if (readHeader(encoded, decoder)) {
    image.create(static_cast<int>(decoder.jpeg.image_height), static_cast<int>(decoder.jpeg.image_width),
                 CV_8U);
    if (!readRows(decoder, image)) image.release();
  }
  decoder.complaints.throwIfOutOfMemory();
  return decoder.complaints.isEmpty() ? image : cv::Mat();
}

bool encodeGrayJpeg(const cv::Mat& image, int quality, std::vector<std::uint8_t>& encoded) {
  constexpr std::size_t kMostBytesPerPixel = 4;
  constexpr std::size_t kHeaderBytes = 4096;
  encoded.resize(kMostBytesPerPixel * image.total() + kHeaderBytes);
  Encoder encoder(encoded);
  const bool is_written = write(image, quality, encoder);
  encoder.complaints.throwIfOutOfMemory();
  encoded.resize(is_written ? encoded.size() - encoder.destination.free_in_buffer : 0);
  return is_written;
}

}  // namespace alidade
