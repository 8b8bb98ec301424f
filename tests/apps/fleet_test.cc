// SPDX-License-Identifier: MIT
#include <algorithm>
#include <sstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "alidade/files/camera_source.h"
#include "command_line.h"
#include "support/drawn_fleet.h"
#include "support/scratch_folder.h"

namespace alidade {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// Forty units of one kind, of which one has another lens, and one has changed since its previous calibration.
class FleetCommandTest : public ::testing::Test {
 protected:
  void SetUp() override {
    constexpr std::size_t kUnits = 40;
    const CameraPopulation population;
    for (std::size_t i = 0; i < kUnits; ++i) {
      Random random(streamSeed(31, i));
      Eigen::VectorXd unit = population.drawUnit(random);
      if (i == 5) unit(4) += 0.03;
      const Eigen::VectorXd now = i == 9 ? withFocalError(unit, population.size(), 1) : unit;
      const std::string name = "unit" + std::to_string(i) + ".yaml";
      scratch_.makeFolder("now");
      scratch_.makeFolder("before");
      saveCamera(scratch_.path("now/" + name), population.calibrated(now, 0.1, random), "alidade");
      saveCamera(scratch_.path("before/" + name), population.calibrated(unit, 0.1, random), "alidade");
    }
  }

  [[nodiscard]] std::string now() const { return scratch_.path("now"); }
  [[nodiscard]] std::string before() const { return scratch_.path("before"); }

  const ScratchFolder scratch_;
};

std::vector<std::string> linesOf(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST_F(FleetCommandTest, SaysInSixteenLinesWhatThereIs) {
  scratch_.write("now/damaged.yaml", "alidade_camera: 1\nmodel: radtan\n");
  const auto result = runAlidade({"fleet", now(), "--previous", before(), "--tolerance", "15px"});
  EXPECT_THAT(result, EndsWith(0));
  const auto lines = linesOf(result.out);
  EXPECT_LE(lines.size(), 16u);
  for (const std::string& line : lines) EXPECT_LE(line.size(), 100u) << line;
  EXPECT_THAT(result.out, HasSubstr("40 cameras in 41 files"));
  EXPECT_THAT(result.out, HasSubstr("40 trustworthy"));
  EXPECT_THAT(result.out, HasSubstr("Typical   radtan, 1280x960 px, from 39 of 40 units"));
  EXPECT_THAT(result.out,
              HasSubstr("units are within 15 px of the typical camera: one file may serve for these"));
  EXPECT_THAT(result.out, HasSubstr("1 of 40 units differ from the typical camera"));
  EXPECT_THAT(result.out, HasSubstr("1 of 40 units with a previous calibration changed"));
  EXPECT_THAT(result.err, HasSubstr("damaged.yaml"));
  EXPECT_THAT(runAlidade({"fleet", now(), "--strict"}), EndsWith(3));
}

TEST_F(FleetCommandTest, WritesARowForEachUnit) {
  const std::string table = scratch_.path("fleet.csv");
  ASSERT_THAT(runAlidade({"fleet", now(), "--previous", before(), "-o", table}), EndsWith(0));
  const auto rows = linesOf(scratch_.read("fleet.csv"));
  ASSERT_EQ(rows.size(), 41u);
  EXPECT_THAT(rows[0], AllOf(HasSubstr("file,name,serial,model"), HasSubstr("drift_status")));
  std::size_t num_deviating = 0;
  std::size_t num_drifted = 0;
  for (const std::string& row : rows) {
    EXPECT_EQ(std::ranges::count(row, ','), 16) << row;
    const bool is_deviating = row.find(",deviates,") != std::string::npos;
    const bool is_drifted = row.ends_with(",drifted");
    num_deviating += is_deviating ? 1 : 0;
    num_drifted += is_drifted ? 1 : 0;
    if (is_deviating) {
      EXPECT_THAT(row, HasSubstr("unit5.yaml"));
    }
    if (is_drifted) {
      EXPECT_THAT(row, HasSubstr("unit9.yaml"));
    }
  }
  EXPECT_EQ(num_deviating, 1u);
  EXPECT_EQ(num_drifted, 1u);
}

TEST_F(FleetCommandTest, WritesAPageWithItsDataInIt) {
  const std::string page = scratch_.path("fleet.html");
  ASSERT_THAT(runAlidade({"fleet", now(), "--previous", before(), "-o", page}), EndsWith(0));
  const std::string html = scratch_.read("fleet.html");
  for (const char* id : {"fleet-map", "fleet-distances", "fleet-parameters", "fleet-typical",
                         "fleet-deviants", "fleet-drift", "fleet-drifted"})
    EXPECT_THAT(html, HasSubstr("<figure id=\"" + std::string(id) + "\"")) << id;
  EXPECT_THAT(html, HasSubstr("unit5.yaml"));
  const std::string start = "id=\"evidence\">";
  const std::size_t begin = html.find(start) + start.size();
  const auto data = nlohmann::json::parse(html.substr(begin, html.find("</script>", begin) - begin));
  EXPECT_EQ(data["num_units"], 40);
  const auto result = runAlidade({"fleet", now(), "--previous", before(), "--json"});
  auto printed = nlohmann::json::parse(result.out);
  EXPECT_EQ(printed["units"], data["units"]);
  EXPECT_EQ(printed["units"][6]["from_typical"]["significant"], false);
}

TEST_F(FleetCommandTest, BeginsItsPageWithUnitsThatChanged) {
  const std::string page = scratch_.path("fleet.html");
  const auto headline = [&](const std::vector<std::string>& units) {
    std::vector<std::string> args = {"fleet"};
    for (const std::string& unit : units) args.push_back(scratch_.path("now/" + unit));
    args.insert(args.end(), {"--previous", before(), "-o", page});
    EXPECT_THAT(runAlidade(args), EndsWith(0));
    const std::string html = scratch_.read("fleet.html");
    const std::size_t start = html.find("<strong>");
    return html.substr(start, html.find("</strong>") - start);
  };
  // Two are too few for a typical camera.
  EXPECT_THAT(headline({"unit9.yaml", "unit1.yaml"}),
              AllOf(HasSubstr("1 of 2 units with a previous calibration changed"), HasSubstr("unit9.yaml")));
  EXPECT_THAT(headline({"unit3.yaml", "unit1.yaml"}), HasSubstr("no typical camera"));
}

TEST_F(FleetCommandTest, WritesTheTypicalCamera) {
  const std::string typical = scratch_.path("typical.yaml");
  ASSERT_THAT(runAlidade({"fleet", now(), "--typical", typical}), EndsWith(0));
  EXPECT_THAT(runAlidade({"validate", typical}), EndsWith(0));
  // A unit of the fleet is one that it may stand for; the one with another lens is not.
  EXPECT_THAT(runAlidade({"diff", scratch_.path("now/unit0.yaml"), typical}).out,
              HasSubstr("not significant"));
  EXPECT_THAT(runAlidade({"diff", scratch_.path("now/unit5.yaml"), typical}).out,
              HasSubstr("sigma: significant"));
}

TEST_F(FleetCommandTest, RefusesWhatCannotBe) {
  scratch_.write("damaged/a.yaml", "alidade_camera: 1\nmodel: radtan\n");
  EXPECT_THAT(runAlidade({"fleet", scratch_.path("damaged")}), FailsWith(1, HasSubstr("none can be read")));
  EXPECT_THAT(runAlidade({"fleet"}), FailsWith(2, HasSubstr("no file")));
  EXPECT_THAT(runAlidade({"fleet", now(), "-o", "fleet.pdf"}), FailsWith(2, HasSubstr(".html or .csv")));
  EXPECT_THAT(runAlidade({"fleet", now(), "--typical", scratch_.path("now/unit1.yaml")}),
              FailsWith(2, HasSubstr("unit1.yaml")));
  EXPECT_THAT(runAlidade({"fleet", scratch_.path("nowhere")}), FailsWith(1, HasSubstr("nowhere")));
  EXPECT_THAT(runAlidade({"fleet", scratch_.path("now/unit1.yaml"), "--typical", scratch_.path("t.yaml")}),
              FailsWith(1, HasSubstr("at least 3 of one model")));
  EXPECT_FALSE(scratch_.has("t.yaml"));
}

}  // namespace
}  // namespace alidade
