// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <new>
#include <span>

#include <jerror.h>
#include <jpeglib.h>

namespace alidade::detail {

/// libjpeg's error manager that notes the first complaint. After an error it leaves by longjmp(), because
/// libjpeg has no other way. No member has a destructor, which the jump would skip.
struct JpegComplaints {
  jpeg_error_mgr base{};  // first member, so that libjpeg's pointer to it is a pointer to this struct
  std::jmp_buf end{};
  std::array<char, JMSG_LENGTH_MAX> first{};

  [[nodiscard]] bool isEmpty() const { return first[0] == '\0'; }
  /// @throws std::bad_alloc if libjpeg gave up because it found no memory; call it after the jump
  void throwIfOutOfMemory() const {
    if (!isEmpty() && base.msg_code == JERR_OUT_OF_MEMORY) throw std::bad_alloc();
  }

  /// Returns the manager for a jpeg_decompress_struct or jpeg_compress_struct.
  jpeg_error_mgr* install() {
    jpeg_std_error(&base);
    base.emit_message = onWarning;
    base.error_exit = onError;
    return &base;
  }

 private:
  static JpegComplaints& of(j_common_ptr jpeg) { return *reinterpret_cast<JpegComplaints*>(jpeg->err); }

  static void onWarning(j_common_ptr jpeg, int level) {
    constexpr int kPaddingBytes = 2;
    JpegComplaints& complaints = of(jpeg);
    const int code = complaints.base.msg_code;
    if (level >= 0 || !complaints.isEmpty()) return;
    const auto* const parameters = complaints.base.msg_parm.i;
    if (code == JWRN_EXTRANEOUS_DATA && parameters[0] <= kPaddingBytes && parameters[1] == JPEG_EOI) return;
    if (code == JWRN_ADOBE_XFORM || code == JWRN_JFIF_MAJOR) return;  // warnings about headers
    complaints.base.format_message(jpeg, complaints.first.data());
  }

  [[noreturn]] static void onError(j_common_ptr jpeg) {
    JpegComplaints& complaints = of(jpeg);
    if (complaints.isEmpty()) complaints.base.format_message(jpeg, complaints.first.data());
    std::longjmp(complaints.end, 1);
  }
};

/// A destination of fixed size; more bytes are an error. libjpeg's own destination in memory frees the buffer
/// that it returned if an error interrupts it.
[[nodiscard]] inline jpeg_destination_mgr fixedDestination(std::span<JOCTET> bytes) {
  return {.next_output_byte = bytes.data(),
          .free_in_buffer = bytes.size(),
          .init_destination = [](j_compress_ptr) {},
          .empty_output_buffer = [](j_compress_ptr jpeg) -> boolean {
            jpeg->err->msg_code = JERR_BUFFER_SIZE;
            jpeg->err->error_exit(reinterpret_cast<j_common_ptr>(jpeg));
            return FALSE;
          },
          .term_destination = [](j_compress_ptr) {}};
}

}  // namespace alidade::detail
