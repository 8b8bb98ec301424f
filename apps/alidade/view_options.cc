// SPDX-License-Identifier: MIT
#include "view_options.h"

#include <CLI/CLI.hpp>

#include "alidade/core/error.h"

namespace alidade {

void ViewOptions::addOptions(CLI::App& app, const std::string& projection_help,
                             const std::string& size_help) {
  app.add_option("--projection", projection, "Output projection" + projection_help)
      ->check(CLI::IsMember(projectionNames()))
      ->capture_default_str();
  app.add_option("--fov", fov_deg, "Horizontal field of view in degrees")->check(finiteNumber, "");
  app.add_option("--keep", keep,
                 "What stays visible. all: every input pixel with a ray; valid: the largest view without "
                 "black pixels")
      ->check(CLI::IsMember({"all", "valid"}));
  app.add_option("--size", size, "Size of the output, for example 1280x720. Default: " + size_help)
      ->check(sizeComplaint, "");
  app.add_option("--interpolation", interpolation,
                 "Interpolation; cubic is sharper but may overshoot at edges")
      ->check(CLI::IsMember({"linear", "cubic"}))
      ->capture_default_str();
  app.add_flag("--overwrite", may_overwrite,
               "Replace an earlier, unchanged result of this command; other files are never changed");
}

void ViewOptions::checkUsage(const CLI::App& app) const {
  if (app.count("--fov") == 0 || keep.empty()) return;
  throw usageError({.where = commandName(app),
                    .found = "--fov and --keep",
                    .expected = "one of them: both set the field of view"});
}

ViewExtent ViewOptions::extent(const CLI::App& app) const {
  if (keep == "all") return ViewExtent::kAll;
  if (keep == "valid") return ViewExtent::kValid;
  return app.count("--fov") > 0 ? ViewExtent::kFieldOfView : ViewExtent::kSameScale;
}

}  // namespace alidade
