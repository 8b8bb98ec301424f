// SPDX-License-Identifier: MIT
#include "alidade/fleet/fleet_unit.h"

#include <gtest/gtest.h>

namespace alidade {
namespace {

FleetUnit unit(const std::string& place, const std::string& name = "", const std::string& serial = "") {
  return {.file = "folder/" + place,
          .place = place,
          .name = {.name = name, .serial = serial, .lens = ""},
          .camera = AnyCamera::make("pinhole", std::vector<double>{500, 500, 320, 240}),
          .size = {640, 480}};
}

using Pairs = std::vector<std::optional<std::size_t>>;

TEST(PairedUnits, TakesTheSerialNumberFirstThenNameAndPlace) {
  const std::vector<FleetUnit> units = {unit("a.yaml", "front", "S1"), unit("b.yaml", "rear", "S2"),
                                        unit("c/d.yaml"), unit("e.yaml", "left"), unit("f/g.yaml")};
  const std::vector<FleetUnit> previous = {unit("e.yaml", "left", "S9"), unit("a.yaml", "rear", "S1"),
                                           unit("c/d.yaml"), unit("b.yaml", "front", "S2"),
                                           unit("2024/g.yaml")};
  EXPECT_EQ(pairedUnits(units, previous), (Pairs{1, 3, 2, 0, 4}));
}

TEST(PairedUnits, PairsNothingByWhatIsThereTwice) {
  const std::vector<FleetUnit> units = {unit("a/camera.yaml", "camera"), unit("b/camera.yaml", "camera"),
                                        unit("new.yaml")};
  const std::vector<FleetUnit> previous = {unit("b/camera.yaml", "camera"), unit("x/camera.yaml", "camera")};
  // The place tells b; a and x are of one file name, which says nothing where it is everybody's.
  EXPECT_EQ(pairedUnits(units, previous), (Pairs{std::nullopt, 0, std::nullopt}));
  EXPECT_EQ(pairedUnits(units, {}), Pairs(3));
}

TEST(PairedUnits, KeepsACameraApartFromTheOneItReplaced) {
  const std::vector<FleetUnit> units = {unit("a.yaml", "front", "S5")};
  const std::vector<FleetUnit> previous = {unit("a.yaml", "front", "S1")};
  EXPECT_EQ(pairedUnits(units, previous), Pairs(1));
}

}  // namespace
}  // namespace alidade
