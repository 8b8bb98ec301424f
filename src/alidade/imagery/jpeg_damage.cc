// SPDX-License-Identifier: MIT
#include "alidade/imagery/image_damage.h"

#include <optional>
#include <vector>

#include "alidade/imagery/jpeg_complaints.h"

namespace alidade {
namespace {

struct Transcoder {
  detail::JpegComplaints complaints;
  jpeg_decompress_struct in{};
  jpeg_compress_struct out{};
  jpeg_destination_mgr destination{};
  std::vector<JOCTET> encoded;
  bool is_encoded = false;

  explicit Transcoder(std::size_t num_bytes) : encoded(num_bytes + kHeaderBytes) {
    in.err = out.err = complaints.install();
  }
  ~Transcoder() {
    jpeg_destroy_decompress(&in);
    jpeg_destroy_compress(&out);
  }
  Transcoder(const Transcoder&) = delete;
  Transcoder& operator=(const Transcoder&) = delete;

 private:
  static constexpr std::size_t kHeaderBytes = 8192;  // more than the size of all tables
};

void copyTable(const JHUFF_TBL* from, JHUFF_TBL*& to, j_common_ptr owner) {
  if (from == nullptr) return;
  if (to == nullptr) to = jpeg_alloc_huff_table(owner);
  *to = *from;
  to->sent_table = FALSE;
}

// True if coefficients determine the codes. They do not if blocks outside the image have coefficients, if
// bits are spread over several scans, or with arithmetic coding.
bool hasOneCoding(const jpeg_decompress_struct& jpeg) {
  const auto fills = [](JDIMENSION side, int factor) {
    return side % static_cast<JDIMENSION>(DCTSIZE * factor) == 0;
  };
  return jpeg.input_scan_number == 1 && jpeg.progressive_mode == FALSE && jpeg.arith_code == FALSE &&
         fills(jpeg.image_width, jpeg.max_h_samp_factor) && fills(jpeg.image_height, jpeg.max_v_samp_factor);
}

// Encodes the coefficients again with the same codes and restarts, in one scan.
void encodeAgain(Transcoder& jpeg, jvirt_barray_ptr* coefficients) {
  jpeg_create_compress(&jpeg.out);
  // The same coefficients never need more space than before.
  jpeg.destination = detail::fixedDestination(jpeg.encoded);
  jpeg.out.dest = &jpeg.destination;
  jpeg_copy_critical_parameters(&jpeg.in, &jpeg.out);
  jpeg.out.optimize_coding = FALSE;
  jpeg.out.restart_interval = jpeg.in.restart_interval;
  auto* const owner = reinterpret_cast<j_common_ptr>(&jpeg.out);
  for (int i = 0; i < NUM_HUFF_TBLS; ++i) {
    copyTable(jpeg.in.dc_huff_tbl_ptrs[i], jpeg.out.dc_huff_tbl_ptrs[i], owner);
    copyTable(jpeg.in.ac_huff_tbl_ptrs[i], jpeg.out.ac_huff_tbl_ptrs[i], owner);
  }
  for (int i = 0; i < jpeg.in.num_components; ++i) {
    jpeg.out.comp_info[i].dc_tbl_no = jpeg.in.comp_info[i].dc_tbl_no;
    jpeg.out.comp_info[i].ac_tbl_no = jpeg.in.comp_info[i].ac_tbl_no;
  }
  jpeg_write_coefficients(&jpeg.out, coefficients);
  jpeg_finish_compress(&jpeg.out);
  jpeg.is_encoded = true;
}

// Reads all coded data, and encodes them again if that must give the same bytes. None of its variables is
// used after the jump.
void transcode(std::string_view content, Transcoder& jpeg) {
  if (setjmp(jpeg.complaints.end) != 0) return;  // NOLINT(cert-err52-cpp): libjpeg has no other way
  jpeg_create_decompress(&jpeg.in);
  jpeg_mem_src(&jpeg.in, reinterpret_cast<const unsigned char*>(content.data()),
               static_cast<unsigned long>(content.size()));
  jpeg_read_header(&jpeg.in, TRUE);
  jvirt_barray_ptr* const coefficients = jpeg_read_coefficients(&jpeg.in);
  if (jpeg.complaints.isEmpty() && hasOneCoding(jpeg.in)) encodeAgain(jpeg, coefficients);
}

// The data after the header of the first scan.
std::optional<std::string_view> scanOf(std::string_view content) {
  constexpr std::size_t kMarkerBytes = 2;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(content[i]); };
  std::size_t at = kMarkerBytes;  // length of SOI
  while (at + 4 <= content.size() && byte(at) == 0xff) {
    const unsigned char marker = byte(at + 1);
    if (marker == 0xff) {  // a fill byte
      ++at;
      continue;
    }
    const std::size_t length = byte(at + 2) * std::size_t{256} + byte(at + 3);
    at += kMarkerBytes + length;
    constexpr unsigned char kStartOfScan = 0xda;
    if (marker == kStartOfScan)
      return at <= content.size() ? std::optional(content.substr(at)) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

std::string jpegDamage(std::string_view content) {
  Transcoder jpeg(content.size());
  transcode(content, jpeg);
  if (!jpeg.complaints.isEmpty()) return jpeg.complaints.first.data();
  if (!jpeg.is_encoded) return "";
  const std::string_view encoded(reinterpret_cast<const char*>(jpeg.encoded.data()),
                                 jpeg.encoded.size() - jpeg.destination.free_in_buffer);
  const auto is = scanOf(content);
  const auto must_be = scanOf(encoded);
  if (!is || !must_be) return "";
  return is->starts_with(must_be->substr(0, must_be->size() - 2)) ? "" : "codes after the last block";
}

}  // namespace alidade
