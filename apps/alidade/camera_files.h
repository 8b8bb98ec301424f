// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/files/camera_source.h"
#include "flags.h"

namespace alidade {

/// The flags --image-size and --read-as, for properties that camera files of other tools may omit.
void addReadOptions(Flags& flags, ReadOptions& options);

/// Reads the only camera of a file of any format. Prints what was skipped or assumed in the file, unless
/// `quiet`.
[[nodiscard]] CameraRecord readCameraTelling(const std::string& path, const ReadOptions& options, bool quiet);

/// The same for a file that was already read.
[[nodiscard]] CameraRecord onlyCameraTelling(const CameraSource& source, bool quiet);

/// Prints what was skipped or assumed in a file.
void tellRemarks(const CameraSource& source);

/// The flag --to; the formats follow its text.
void addFormatFlag(Flags& flags, std::string& format, const std::string& text);

}  // namespace alidade
