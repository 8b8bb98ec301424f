// SPDX-License-Identifier: MIT
#include "alidade/imagery/image_codecs.h"

#include <dlfcn.h>
#include <opencv2/imgcodecs.hpp>

#include "alidade/core/error.h"
#include "alidade/imagery/gray_jpeg.h"

namespace alidade {
namespace {

using Decode = cv::Mat (*)(const cv::_InputArray&, int);
using Encode = bool (*)(const std::string&, const cv::_InputArray&, std::vector<unsigned char>&,
                        const std::vector<int>&);

struct Codecs {
  Decode decode = nullptr;
  Encode encode = nullptr;
};

#ifdef ALIDADE_CODECS_LIBRARY

Codecs loadCodecs() {
  void* const library = ::dlopen(ALIDADE_CODECS_LIBRARY, RTLD_LAZY | RTLD_LOCAL);
  Codecs codecs;
  if (library != nullptr) {
    codecs.decode = reinterpret_cast<Decode>(::dlsym(library, "_ZN2cv8imdecodeERKNS_11_InputArrayEi"));
    codecs.encode = reinterpret_cast<Encode>(::dlsym(
        library,
        "_ZN2cv8imencodeERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEERKNS_11_InputArrayERSt6vectorIhSaIhEERKSB_IiSaIiEE"));
  }
  if (codecs.decode == nullptr || codecs.encode == nullptr) {
    const char* const reason = ::dlerror();
    throw inputError(
        {.where = ALIDADE_CODECS_LIBRARY,
         .found = std::string("cannot be loaded") + (reason != nullptr ? std::string(": ") + reason : ""),
         .expected = "OpenCV's library for image files",
         .next_step = "install it (Debian: libopencv-imgcodecs406)"});
  }
  return codecs;
}

#else  // if OpenCV is not a shared library

Codecs loadCodecs() {
  return {.decode = &cv::imdecode, .encode = &cv::imencode};
}

#endif

const Codecs& codecs() {
  static const Codecs kCodecs = loadCodecs();
  return kCodecs;
}

}  // namespace

cv::Mat decodeImage(const cv::Mat& encoded, int flags) {
  if (flags == kGrayFlags) {
    if (cv::Mat image = decodeGrayJpeg(encoded); !image.empty()) return image;
  }
  return codecs().decode(encoded, flags);
}

bool encodeImage(const std::string& extension, const cv::Mat& image, std::vector<std::uint8_t>& encoded,
                 const std::vector<int>& options) {
  if (extension == ".jpg" && image.type() == CV_8UC1 && options.size() == 2 &&
      options[0] == cv::IMWRITE_JPEG_QUALITY && encodeGrayJpeg(image, options[1], encoded))
    return true;
  return codecs().encode(extension, image, encoded, options);
}

}  // namespace alidade
