// SPDX-License-Identifier: MIT
#include "alidade/imagery/projection_file.h"

#include <gmock/gmock.h>

#include <stdexcept>

#include "alidade/core/error.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

ProjectionFile someFile(ViewProjection projection) {
  return {.view = {.projection = projection,
                   .size = {640, 480},
                   .scale_px = Eigen::Vector2d::Constant(501.23 / 3),
                   .axis_px = {319.25, 240.1}},
          .created_by = "test"};
}

std::string messageFor(const std::string& text) {
  try {
    (void)parseProjectionFile(text, "projection.yaml");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput);
    return error.what();
  }
  return "none";
}

TEST(ProjectionFile, ReadsWhatItWrote) {
  int num_checked = 0;
  for (const ViewProjection projection : {ViewProjection::kCylindrical, ViewProjection::kEquirectangular}) {
    const ProjectionFile file = someFile(projection);
    const std::string text = projectionFileText(file);
    const ProjectionFile back = parseProjectionFile(text, "projection.yaml");
    EXPECT_EQ(back.view.projection, projection);
    EXPECT_EQ(back.view.size, file.view.size);
    EXPECT_NEAR(back.view.scale_px.x(), file.view.scale_px.x(), 1e-12 * file.view.scale_px.x());
    EXPECT_EQ(back.view.axis_px, file.view.axis_px);
    EXPECT_EQ(back.created_by, "test");
    EXPECT_THAT(text, AllOf(HasSubstr("radians_per_pixel: "), HasSubstr("self_check:")));
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 2);
  EXPECT_THROW((void)projectionFileText(someFile(ViewProjection::kRectilinear)), std::logic_error);
}

TEST(ProjectionFile, NoticesChangedNumbers) {
  const std::string text = projectionFileText(someFile(ViewProjection::kCylindrical));
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string other = text;
    const std::size_t at = other.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? other : other.replace(at, from.size(), to);
  };
  EXPECT_EQ(messageFor(text), "none");
  EXPECT_THAT(messageFor(changed("u: 319.25", "u: 319.26")), HasSubstr("does not match its pixel"));
  EXPECT_THAT(messageFor(changed("cylindrical", "equirectangular")), HasSubstr("does not match its pixel"));
  EXPECT_THAT(messageFor(changed("cylindrical", "rectilinear")), HasSubstr("cylindrical or equirectangular"));
  EXPECT_THAT(messageFor(changed("radians_per_pixel: ", "radians_per_pixel: -")),
              HasSubstr("a positive number"));
  EXPECT_THAT(messageFor(changed("axis_pixel", "axis_pxel")), HasSubstr("axis_p"));
  EXPECT_THAT(messageFor(changed("alidade_projection: 1", "alidade_projection: 2")),
              HasSubstr("format version 2"));
}

}  // namespace
}  // namespace alidade
