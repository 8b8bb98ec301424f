// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/files/camera_source.h"
#include "flags.h"

namespace alidade {

/// The flags --image-size, --read-as, --from and --apply-roi, for what camera files of other tools may omit
/// or leave open. --format is another name of --from, unless the command writes formats too.
void addReadOptions(Flags& flags, ReadOptions& options, bool writes_formats = false);

/// Reads the only camera of a file of any format. Prints what was skipped or assumed in the file, unless
/// `quiet`.
[[nodiscard]] CameraRecord readCameraTelling(const std::string& path, const ReadOptions& options, bool quiet);

/// The same for a file that was already read.
[[nodiscard]] CameraRecord onlyCameraTelling(const CameraSource& source, bool quiet);

/// Prints what was skipped or assumed in a file.
void tellRemarks(const CameraSource& source);

/// The flag --to; the formats follow its text. `reads_formats`: the command has --from too.
void addFormatFlag(Flags& flags, std::string& format, const std::string& text, bool reads_formats = false);

}  // namespace alidade
