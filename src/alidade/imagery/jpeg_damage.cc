// SPDX-License-Identifier: MIT
#include "alidade/imagery/jpeg_damage.h"

#include <array>
#include <csetjmp>
#include <cstdio>

#include <jerror.h>
#include <jpeglib.h>

namespace alidade {
namespace {

// No member has a destructor: libjpeg leaves by longjmp.
struct Complaints {
  jpeg_error_mgr base{};  // first, as libjpeg hands this back
  std::jmp_buf end{};
  std::array<char, JMSG_LENGTH_MAX> first{};
};

Complaints& complaintsOf(j_common_ptr jpeg) {
  return *reinterpret_cast<Complaints*>(jpeg->err);
}

void onWarning(j_common_ptr jpeg, int level) {
  constexpr int kPaddingBytes = 2;
  Complaints& complaints = complaintsOf(jpeg);
  const int code = complaints.base.msg_code;
  if (level >= 0 || complaints.first[0] != '\0') return;
  const auto* const parameters = complaints.base.msg_parm.i;
  if (code == JWRN_EXTRANEOUS_DATA && parameters[0] <= kPaddingBytes && parameters[1] == JPEG_EOI) return;
  if (code == JWRN_ADOBE_XFORM || code == JWRN_JFIF_MAJOR) return;  // of headers
  complaints.base.format_message(jpeg, complaints.first.data());
}

[[noreturn]] void onError(j_common_ptr jpeg) {
  Complaints& complaints = complaintsOf(jpeg);
  if (complaints.first[0] == '\0') complaints.base.format_message(jpeg, complaints.first.data());
  std::longjmp(complaints.end, 1);
}

// Reads all coded data; the pixels are not wanted. None of its variables is used after the jump.
void decodeCoarsely(std::string_view content, jpeg_decompress_struct& jpeg, Complaints& complaints) {
  if (setjmp(complaints.end) != 0) return;  // NOLINT(cert-err52-cpp): libjpeg has no other way
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(content.data()),
               static_cast<unsigned long>(content.size()));
  jpeg_read_header(&jpeg, TRUE);
  jpeg.scale_num = 1;
  jpeg.scale_denom = 8;
  jpeg.out_color_space = jpeg.jpeg_color_space;
  jpeg_start_decompress(&jpeg);
  const JDIMENSION row_bytes = jpeg.output_width * static_cast<JDIMENSION>(jpeg.output_components);
  JSAMPARRAY row = jpeg.mem->alloc_sarray(reinterpret_cast<j_common_ptr>(&jpeg), JPOOL_IMAGE, row_bytes, 1);
  while (jpeg.output_scanline < jpeg.output_height) jpeg_read_scanlines(&jpeg, row, 1);
  jpeg_finish_decompress(&jpeg);
}

}  // namespace

std::string jpegDamage(std::string_view content) {
  Complaints complaints;
  jpeg_decompress_struct jpeg{};
  jpeg.err = jpeg_std_error(&complaints.base);
  complaints.base.emit_message = onWarning;
  complaints.base.error_exit = onError;
  decodeCoarsely(content, jpeg, complaints);
  jpeg_destroy_decompress(&jpeg);
  return complaints.first.data();
}

}  // namespace alidade
