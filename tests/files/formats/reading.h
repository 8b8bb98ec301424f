// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "alidade/core/error.h"
#include "alidade/files/camera_source.h"

namespace alidade {

/// What reading a camera file of this text complains of, under the name "file"; empty if it does not. A
/// camera that is set aside counts, though others of the file may be read.
inline std::string complaintAbout(const std::string& text, const ReadOptions& options = {}) {
  try {
    const CameraSource source = parseCameras(text, "file", options);
    return source.refused.empty() ? "" : source.refused.front().reason.what();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput);
    return error.what();
  }
}

/// All remarks on a camera, a line each: "id: message".
inline std::string remarksOn(const StatedCamera& camera) {
  std::string text;
  for (const Remark& remark : camera.remarks) text += remark.id + ": " + remark.message + "\n";
  return text;
}

}  // namespace alidade
