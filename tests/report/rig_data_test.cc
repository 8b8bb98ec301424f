// SPDX-License-Identifier: MIT
#include "alidade/report/data/rig_data.h"

#include <cmath>
#include <numbers>
#include <regex>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/report/figures/rig_figures.h"
#include "alidade/report/pages/page.h"
#include "alidade/target/board_spec.h"
#include "report/svg_checks.h"

namespace alidade {
namespace {

using testing::HasSubstr;

// Two cameras side by side, which see a board in three frames without any error.
ReportedRig sideBySide() {
  const AnyCamera left =
      AnyCamera::make("radtan", std::vector<double>{520, 522, 318, 241, -0.2, 0.05, 1e-3, -5e-4, 0});
  const AnyCamera right =
      AnyCamera::make("kannala_brandt", std::vector<double>{300, 301, 322, 239, 0.01, -0.002, 0, 0});
  ReportedRig rig;
  rig.boards = {parseBoardSpec("checkerboard:9x6:25mm")};
  rig.cameras.push_back({.name = "left", .camera = left, .size = {640, 480}});
  rig.cameras.push_back(
      {.name = "right",
       .camera = right,
       .size = {640, 480},
       .camera_from_rig = {SO3::exp(Eigen::Vector3d(0.02, -0.05, 0.03)), {-0.12, 0.004, 0.002}}});
  for (std::size_t frame = 0; frame < 3; ++frame) {
    rig.frames.push_back(std::to_string(frame));
    rig.placements.push_back(
        {.frame = frame,
         .board = 0,
         .rig_from_board = {SO3::exp(Eigen::Vector3d(0.2, 0.1 * static_cast<double>(frame), 0)),
                            {-0.08, -0.06, 0.5}}});
    for (std::size_t camera = 0; camera < 2; ++camera) {
      ReportedView view{.image = "x", .camera = camera, .placement = frame};
      for (int id = 0; id < 54; ++id) {
        const ReportedRigCamera& by = rig.cameras[camera];
        const Projection seen = by.camera.project(
            by.camera_from_rig * (rig.placements[frame].rig_from_board * rig.boards[0].corner(id)));
        view.corners.push_back({.id = id, .pixel = seen.pixel});
      }
      rig.views.push_back(view);
    }
  }
  return rig;
}

TEST(EpipolarPairs, AreZeroForExactCorners) {
  const std::vector<EpipolarPair> pairs = epipolarPairs(sideBySide());
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].num_corners, 3u * 54);
  EXPECT_EQ(pairs[0].by_frame.size(), 3u);
  EXPECT_LT(pairs[0].rms_px, 1e-9);
}

TEST(EpipolarPairs, MeasureWhatLiesAcrossTheLines) {
  constexpr double kShift = 0.4;
  ReportedRig rig = sideBySide();
  // The lines of cameras side by side run along the rows, with a slight slope.
  for (CornerError& corner : rig.views[3].corners) corner.pixel.y() += kShift;
  std::vector<EpipolarPair> pairs = epipolarPairs(rig);
  // In the other image, an angle has more pixels: the ratio of the focal lengths.
  const double both = kShift * std::sqrt((1 + std::pow(522.0 / 301, 2)) / 2);
  EXPECT_NEAR(pairs[0].by_frame[1].second, both, 0.04 * both);
  EXPECT_LT(pairs[0].by_frame[0].second, 1e-9);
  rig = sideBySide();
  for (CornerError& corner : rig.views[3].corners) corner.pixel.x() += kShift;
  pairs = epipolarPairs(rig);
  EXPECT_LT(pairs[0].by_frame[1].second, 0.15 * kShift);
}

TEST(EpipolarPairs, NeedCamerasAtDifferentPlaces) {
  ReportedRig rig = sideBySide();
  rig.cameras[1].camera_from_rig = {};
  EXPECT_TRUE(epipolarPairs(rig).empty());
}

TEST(ReadRig, NamesThePlaceOfWhatIsWrong) {
  const auto complaintOf = [](const nlohmann::json& document) -> std::string {
    try {
      static_cast<void>(reportPage(document, "rig.json"));
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(complaintOf({{"kind", "rig"}}), HasSubstr("rig.json: verdict: missing"));
  EXPECT_THAT(complaintOf({{"kind", "rig"}, {"verdict", "good"}}), HasSubstr("rig.json: verdict"));
}

std::string groupOf(const std::string& text, const std::string& pattern) {
  std::smatch found;
  return std::regex_search(text, found, std::regex(pattern)) ? found[1].str() : "";
}

TEST(RigFigures, PlaceAFrameAboveItsName) {
  ReportedRig rig = sideBySide();
  rig.frames = {"7", "8", "9"};
  rig.views[2].image = "left_08.png";
  const std::string lines = epipolarOverTimeFigure(rig, epipolarPairs(rig)).svg;
  const std::string cells = frameErrorsFigure(rig).svg;
  int num_checked = 0;
  for (std::size_t frame = 0; frame < 3; ++frame) {
    const std::string tick = "<text x=\"([-0-9.]+)\"[^>]*class=\"tick\">" + rig.frames[frame] + "<";
    const std::string dot = fmt::format("places\" data-frame=\"{}\"[^>]*d=\"M([-0-9.]+)", frame);
    const std::string cell = fmt::format("<rect x=\"([-0-9.]+)\"[^>]*data-frame=\"{}\"", frame);
    const std::string width =
        fmt::format("<rect x=\"[-0-9.]+\" y=\"[-0-9.]+\" width=\"([-0-9.]+)\"[^>]*data-frame=\"{}\"", frame);
    const double at = std::stod(groupOf(lines, tick));
    EXPECT_NEAR(std::stod(groupOf(lines, dot)), at, 0.02);
    EXPECT_NEAR(std::stod(groupOf(cells, tick)), at, 0.02);
    EXPECT_NEAR(std::stod(groupOf(cells, cell)) + 0.5 * std::stod(groupOf(cells, width)), at, 0.02);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 3);
  EXPECT_THAT(cells, HasSubstr("left, frame 8: RMS 0 px, left_08.png"));
  EXPECT_THAT(lines, HasSubstr("left_08.png"));
}

TEST(RigFigures, BreakALineWhereAFrameHasNoCommonBoard) {
  ReportedRig rig = sideBySide();
  const auto numPieces = [&] {
    const std::string d =
        groupOf(epipolarOverTimeFigure(rig, epipolarPairs(rig)).svg, "class=\"hue0 course\" d=\"(M[^\"]*)\"");
    return countOf(d, "M");
  };
  EXPECT_EQ(numPieces(), 1u);
  rig.views.erase(rig.views.begin() + 3);
  EXPECT_EQ(numPieces(), 2u);
}

nlohmann::json documentOf(const ReportedRig& rig) {
  const auto pose = [](const SE3& p) -> nlohmann::json {
    const Eigen::Quaterniond& q = p.rotation.quaternion();
    return {{"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}},
            {"translation_m", {p.translation.x(), p.translation.y(), p.translation.z()}}};
  };
  nlohmann::json document = {{"kind", "rig"},
                             {"verdict", "trustworthy"},
                             {"tolerance_px", 1},
                             {"rms_px", 0.1},
                             {"holdout_rms_px", nullptr},
                             {"num_linked", 3},
                             {"frames", rig.frames},
                             {"boards", {"checkerboard:9x6:25mm"}},
                             {"diagnoses", nlohmann::json::array()},
                             {"created_by", "a test"}};
  for (const ReportedRigCamera& camera : rig.cameras) {
    nlohmann::json params;
    for (const std::string_view name : camera.camera.parameterNames())
      params[std::string(name)] = camera.camera.parameter(name);
    document["cameras"].push_back({{"name", camera.name + "</script><b>"},
                                   {"model", camera.camera.modelId()},
                                   {"image_size", {{"width", 640}, {"height", 480}}},
                                   {"parameters", params},
                                   {"camera_from_rig", pose(camera.camera_from_rig)},
                                   {"translation_std_m", {1e-3, 1e-3, 1e-3}},
                                   {"rotation_std_rad", {1e-3, 1e-3, 1e-3}},
                                   {"distance_std_m", 1e-3},
                                   {"rms_px", 0.1},
                                   {"alone_rms_px", 0.1},
                                   {"transfer_px", 0.2}});
  }
  for (const ReportedPlacement& placement : rig.placements)
    document["placements"].push_back(
        {{"frame", placement.frame}, {"board", 0}, {"rig_from_board", pose(placement.rig_from_board)}});
  for (const ReportedView& view : rig.views) {
    nlohmann::json corners;
    for (std::size_t i = 0; i < 4; ++i)
      corners.push_back({{"id", view.corners[i].id},
                         {"u", view.corners[i].pixel.x()},
                         {"v", view.corners[i].pixel.y()},
                         {"dx", 0.1},
                         {"dy", 0}});
    document["views"].push_back({{"camera", view.camera},
                                 {"placement", view.placement},
                                 {"image", view.image},
                                 {"rms_px", 0.1},
                                 {"corners", corners}});
  }
  return document;
}

TEST(RigPage, KeepsNamesFromBeingMarkup) {
  const std::string page = reportPage(documentOf(sideBySide()), "rig.json");
  EXPECT_THAT(page, testing::AllOf(HasSubstr("left&lt;/script&gt;&lt;b&gt;"),
                                   testing::Not(HasSubstr("left</script>"))));
  EXPECT_EQ(countOf(page, "</script>"), 2u);
}

TEST(RigPage, StatesTheBaseline) {
  ReportedRig rig = sideBySide();
  rig.cameras[1].camera_from_rig = {SO3::exp(Eigen::Vector3d(0, 0, 0.5 * std::numbers::pi)), {0, -0.12, 0}};
  nlohmann::json document = documentOf(rig);
  document["cameras"][1]["distance_std_m"] = 3e-4;
  const std::string page = reportPage(document, "rig.json");
  EXPECT_THAT(page, testing::AllOf(HasSubstr("<dt>Baseline</dt><dd>120.00 ± 0.30 mm"),
                                   HasSubstr("<dt>Rotation</dt><dd>90.000 ± 0.099°")));
}

// Every value, replaced by one of another kind, is refused with its place or of no matter; nothing crashes.
TEST(RigPage, SurvivesSpoiledEvidence) {
  const nlohmann::json good = documentOf(sideBySide());
  int num_refused = 0;
  const nlohmann::json flat = good.flatten();
  for (const auto& [pointer, value] : flat.items()) {
    for (const nlohmann::json& other : {nlohmann::json(-1e300), nlohmann::json("x"), nlohmann::json(nullptr),
                                        nlohmann::json(1e9), nlohmann::json::array()}) {
      nlohmann::json spoiled = good;
      spoiled[nlohmann::json::json_pointer(pointer)] = other;
      if (!isRigEvidence(spoiled)) continue;
      try {
        EXPECT_THAT(reportPage(spoiled, "rig.json"), HasSubstr("</html>"));
      } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("rig.json")) << pointer;
        ++num_refused;
      }
    }
  }
  EXPECT_GT(num_refused, 300);
}

}  // namespace
}  // namespace alidade
