// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/text.h"
#include "alidade/files/formats/alidade_writer.h"
#include "apps/project_support.h"
#include "apps/rig_support.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class RigTriangulate : public testing::Test {
 protected:
  RigTriangulate() { scratch_.write("rig.yaml", rigFileText(pairOfCameras())); }

  // Rows of the pixels of a point.
  [[nodiscard]] std::string rowsOfPoint(const std::string& id, const Eigen::Vector3d& point) const {
    std::string rows;
    for (std::size_t i = 0; i < 2; ++i) {
      const Projection projection = rig_.project(i, point);
      EXPECT_TRUE(projection.ok());
      rows +=
          fmt::format("{},{},{},{}\n", id, rig_.camera(i).name, projection.pixel.x(), projection.pixel.y());
    }
    return rows;
  }
  [[nodiscard]] RunResult triangulate(const std::string& table, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"rig", "triangulate", scratch_.path("rig.yaml")});
    return runAlidade(more, {.input = table});
  }

  ScratchFolder scratch_;
  AnyRig rig_ = rigOf(pairOfCameras());
};

TEST_F(RigTriangulate, FindsPointsInTheFrameOfTheRig) {
  const std::vector<Eigen::Vector3d> points = {{0.1, -0.05, 1}, {-0.4, 0.2, 2.5}, {0, 0, 0.4}};
  std::string table = "id,camera,u,v\n";
  for (std::size_t i = 0; i < points.size(); ++i) table += rowsOfPoint("p" + std::to_string(i), points[i]);
  table += "alone,left,320,240\n";
  const RunResult result = triangulate(table);
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(headerOf(result.out),
            "id,x,y,z,std_x,std_y,std_z,std_by_pixels,std_by_rig,error_px,num_cameras,status");
  const auto rows = rowsOf(result.out);
  ASSERT_EQ(rows.size(), 4u);
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(rows[i].size(), 12u);
    EXPECT_EQ(rows[i][0], "p" + std::to_string(i));
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(numberIn(rows[i][1 + axis]), points[i][static_cast<Eigen::Index>(axis)], 1e-9);
    const double whole = std::hypot(numberIn(rows[i][4]), numberIn(rows[i][5]), numberIn(rows[i][6]));
    EXPECT_GT(numberIn(rows[i][7]), 1e-4);
    EXPECT_GT(numberIn(rows[i][8]), 1e-4);
    EXPECT_NEAR(whole, std::hypot(numberIn(rows[i][7]), numberIn(rows[i][8])), 1e-9 * whole);
    EXPECT_LT(numberIn(rows[i][9]), 1e-8);
    EXPECT_EQ(rows[i][10], "2");
    EXPECT_EQ(rows[i][11], "ok");
  }
  EXPECT_EQ(rows[3][1], "nan");
  EXPECT_EQ(rows[3][10], "1");
  EXPECT_EQ(rows[3][11], "too_few_cameras");
  EXPECT_EQ(result.err, "3 ok, 1 too_few_cameras\n");
}

TEST_F(RigTriangulate, TakesThePixelsInAnyOrderWithTheirNoise) {
  // Columns in another order, with units and a column of the user's; the rows of a point apart.
  const std::string text = rowsOfPoint("7", {0.1, 0, 1});
  const auto rows = split(trim(text), '\n');
  ASSERT_EQ(rows.size(), 2u);
  const auto moved = [](std::string_view row, const std::string& sigma) {
    const auto fields = split(row, ',');
    return fmt::format("{};{};{};{};note;{}\n", fields[2], fields[3], fields[1], fields[0], sigma);
  };
  const std::string table = "u [px];v [px];camera;id;remark;sigma_px\n" + moved(rows[0], "0.1") +
                            "100;100;left;8;;\n" + moved(rows[1], "0.1");
  const RunResult fine = triangulate(table);
  ASSERT_THAT(fine, EndsWith(0));
  const RunResult coarse = triangulate("id,camera,u,v\n" + rowsOfPoint("7", {0.1, 0, 1}));
  const auto answer = rowsOf(fine.out);
  ASSERT_EQ(answer.size(), 2u);
  EXPECT_EQ(answer[0][0], "7");
  EXPECT_EQ(answer[1][0], "8");
  EXPECT_NEAR(numberIn(rowsOf(coarse.out)[0][7]), 10 * numberIn(answer[0][7]), 1e-9);
  EXPECT_NEAR(numberIn(rowsOf(coarse.out)[0][8]), numberIn(answer[0][8]), 1e-9);
  const RunResult flag = triangulate("id,camera,u,v\n" + rowsOfPoint("7", {0.1, 0, 1}), {"--sigma", "0.1px"});
  EXPECT_EQ(rowsOf(flag.out)[0], answer[0]);
}

TEST_F(RigTriangulate, WritesAFileAndJson) {
  scratch_.write("pixels.csv", "id,camera,u,v\n" + rowsOfPoint("a", {0.1, 0, 1}) + "b,left,1,1\n");
  const RunResult to_file = runAlidade({"rig", "triangulate", scratch_.path("rig.yaml"),
                                        scratch_.path("pixels.csv"), "-o", scratch_.path("points.csv")});
  ASSERT_THAT(to_file, EndsWith(0));
  EXPECT_THAT(to_file.out, IsEmpty());
  EXPECT_EQ(rowsOf(scratch_.read("points.csv")).size(), 2u);
  const RunResult as_json = runAlidade({"rig", "triangulate", scratch_.path("rig.yaml"),
                                        scratch_.path("pixels.csv"), "--json", "--covariance", "--quiet"});
  ASSERT_THAT(as_json, EndsWith(0));
  EXPECT_THAT(as_json.err, IsEmpty());
  const auto document = nlohmann::json::parse(as_json.out);
  EXPECT_EQ(document.at("is_rig_covariance_known"), true);
  const auto& a = document.at("points").at(0);
  EXPECT_EQ(a.at("id"), "a");
  EXPECT_NEAR(a.at("z").get<double>(), 1, 1e-9);
  EXPECT_NEAR(a.at("by_pixels_xx").get<double>() + a.at("by_rig_xx").get<double>(),
              std::pow(a.at("std_x").get<double>(), 2), 1e-15);
  EXPECT_TRUE(document.at("points").at(1).at("x").is_null());
  EXPECT_EQ(document.at("points").at(1).at("status"), "too_few_cameras");
}

TEST_F(RigTriangulate, SaysWhereTheUncertaintyOfTheRigIsUnknown) {
  RigRecord rig = pairOfCameras();
  rig.covariance.clear();
  scratch_.write("rig.yaml", rigFileText(rig));
  const RunResult result = triangulate("id,camera,u,v\n" + rowsOfPoint("a", {0.1, 0, 1}));
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.err, HasSubstr("states no covariance"));
  EXPECT_EQ(rowsOf(result.out)[0][8], "nan");
  EXPECT_GT(numberIn(rowsOf(result.out)[0][4]), 0);
}

TEST_F(RigTriangulate, SaysWhatIsWrong) {
  const std::string header = "id,camera,u,v\n";
  EXPECT_THAT(runAlidade({"rig", "triangulate"}), FailsWith(2, HasSubstr("no rig file")));
  EXPECT_THAT(triangulate("1,left,3,4\n"), FailsWith(1, HasSubstr("standard input:1: ")));
  EXPECT_THAT(triangulate("id,u,v\n1,3,4\n"), FailsWith(1, HasSubstr("columns id,camera,u,v")));
  EXPECT_THAT(triangulate(header + "1,lft,3,4\n"),
              FailsWith(1, AllOf(HasSubstr("input:2: "), HasSubstr("left, right"), HasSubstr("'left'?"))));
  EXPECT_THAT(triangulate(header + "1,left,3,x\n"), FailsWith(1, HasSubstr("input:2: ")));
  EXPECT_THAT(triangulate(header + "1,left,3,4\n1,left,3,4\n"),
              FailsWith(1, AllOf(HasSubstr("input:3: "), HasSubstr("second pixel"))));
  EXPECT_THAT(triangulate("id,camera,u,v,sigma_px\n1,left,3,4,0\n"), FailsWith(1, HasSubstr("sigma_px")));
  EXPECT_THAT(triangulate("", {scratch_.path("none.csv")}), FailsWith(1, HasSubstr("none.csv")));
  EXPECT_THAT(triangulate(header, {"-o", scratch_.path("rig.yaml")}),
              FailsWith(2, HasSubstr("this is also an input")));
  EXPECT_THAT(triangulate(header, {"--sigma", "0"}), FailsWith(2, HasSubstr("--sigma")));
  EXPECT_THAT(runAlidade({"rig", "triangulate", dataPath("camera.yaml")}),
              FailsWith(1, HasSubstr("rig calibrate")));
  const RunResult empty = triangulate(header);
  EXPECT_THAT(empty, EndsWith(0));
  EXPECT_EQ(empty.err, "no points\n");
}

}  // namespace
}  // namespace alidade
