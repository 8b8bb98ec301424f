// SPDX-License-Identifier: MIT
#include "view_options.h"

#include "command.h"
#include "pending_folder.h"

namespace alidade {

void ViewOptions::addOptions(Flags& flags, const std::string& projection_help, const std::string& size_help) {
  flags.add("--projection", &projection, "Output projection" + projection_help, oneOf(projectionNames()));
  flags.add("--fov", &fov_deg, "Horizontal field of view in degrees", {.complaint = finiteNumber});
  flags.add("--keep", &keep,
            "What stays visible. all: every input pixel with a ray; valid: the largest view without "
            "black pixels",
            oneOf({"all", "valid"}));
  flags.redirect({"--alpha", "--balance"}, "--keep all (alpha or balance 1), or --keep valid (0)");
  flags.add("--size", &size, "Size of the output, for example 1280x720. Default: " + size_help, kSizeText);
  flags.add("--interpolation", &interpolation, "Interpolation; cubic is sharper but may overshoot at edges",
            oneOf({"linear", "cubic"}));
  flags.addSwitch("--overwrite", may_overwrite, kOverwriteText);
}

void ViewOptions::checkUsage(const Flags& flags) const {
  if (!flags.isGiven("--fov") || keep.empty()) return;
  throw flagError(flags.command(), "--fov and --keep", "one of them: both set the field of view");
}

ViewExtent ViewOptions::extent(const Flags& flags) const {
  if (keep == "all") return ViewExtent::kAll;
  if (keep == "valid") return ViewExtent::kValid;
  return flags.isGiven("--fov") ? ViewExtent::kFieldOfView : ViewExtent::kSameScale;
}

}  // namespace alidade
