// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/files/camera_source.h"
#include "alidade/validate/file_judgement.h"
#include "alidade/validate/held_out/held_out_checks.h"
#include "command.h"
#include "given_views.h"

namespace CLI {
class App;
}

namespace alidade {

/// The part of `validate` that tests a camera on images that it was not made from, and against another one.
class HeldOutStage {
 public:
  void addOptions(CLI::App& app);

  /// Finds the boards and reads the other camera, once for all files that are tested.
  /// @throws Error, see readViews(); (kUsage) for flags that need another
  void prepare(const CommonOptions& options);

  [[nodiscard]] bool hasImages() const { return given_.has_value(); }

  /// Adds the checks that were asked for; none if nothing was. `file` is for messages. Thread-safe without
  /// images.
  void addChecks(const StatedCamera& camera, const std::string& file, CameraJudgement& judgement) const;

 private:
  std::vector<std::string> images_;
  std::string board_;
  std::string against_;
  double tolerance_px_ = kDefaultTolerancePx;
  int jobs_ = 0;
  const CancelFlag* cancel_ = nullptr;
  std::optional<GivenViews> given_;
  std::optional<CameraRecord> other_;
};

}  // namespace alidade
