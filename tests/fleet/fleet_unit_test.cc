// SPDX-License-Identifier: MIT
#include "alidade/fleet/fleet_unit.h"

#include <gmock/gmock.h>

#include "alidade/core/error.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/rig_file.h"
#include "support/drawn_fleet.h"
#include "support/scratch_folder.h"

namespace alidade {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ReadFleetFiles, ListsWhatItReadsAndWhatItCannotRead) {
  const ScratchFolder scratch;
  const CameraPopulation population;
  std::vector<CameraRecord> records = population.drawFleet(3, 1);
  records[0].name.serial = "S7";
  saveCamera(scratch.path("a.yaml"), records[0], "alidade");
  saveCamera(scratch.path("b.yaml"), records[1], "opencv");
  scratch.write("c.yaml", "alidade_camera: 1\nmodel: radtan\n");
  scratch.write("notes.txt", "nothing of a camera\n");
  RigRecord rig;
  for (const char* name : {"left", "right"}) {
    rig.cameras.push_back({.camera = records[2]});
    rig.cameras.back().camera.name.name = name;
  }
  saveRig(scratch.path("rig.yaml"), rig);

  std::vector<std::pair<std::size_t, std::size_t>> progress;
  const std::vector<std::string> inputs = {scratch.path(""), scratch.path("a.yaml")};
  const FleetFiles files = readFleetFiles(
      inputs, {.jobs = 1,
               .progress = [&](std::size_t done, std::size_t total) { progress.emplace_back(done, total); }});
  std::vector<std::string> places;
  for (const FleetUnit& unit : files.units) places.push_back(unit.place);
  EXPECT_THAT(places, ElementsAre("a.yaml", "b.yaml", "rig.yaml#left", "rig.yaml#right"));
  EXPECT_EQ(files.num_files, 4u);
  ASSERT_EQ(files.unreadable.size(), 1u);
  EXPECT_THAT(files.unreadable[0].file, HasSubstr("c.yaml"));
  EXPECT_THAT(files.unreadable[0].reason, HasSubstr("c.yaml"));
  ASSERT_EQ(files.other_files.size(), 1u);
  EXPECT_EQ(progress.back(), std::pair(std::size_t{5}, std::size_t{5}));

  const FleetUnit& own = files.units[0];
  EXPECT_EQ(own.name.serial, "S7");
  EXPECT_EQ(own.verdict, Verdict::kTrustworthy);
  EXPECT_EQ(own.accuracy_px, records[0].calibration->accuracy_px);
  EXPECT_TRUE(own.compared().covariance->view().isApprox(statedCovariance(records[0])->view(), 1e-12));
  EXPECT_FALSE(files.units[1].verdict);
  EXPECT_TRUE(files.units[1].covariance.empty());
}

TEST(ReadFleetFiles, LeavesOutAnInvalidCovariance) {
  const ScratchFolder scratch;
  CameraRecord record = CameraPopulation().drawFleet(1, 2).front();
  record.calibration->covariance[1] = 100 * record.calibration->covariance[0];
  saveCamera(scratch.path("a.yaml"), record, "alidade");
  const std::vector<std::string> inputs = {scratch.path("a.yaml")};
  const FleetFiles files = readFleetFiles(inputs);
  EXPECT_TRUE(files.units.empty());
  ASSERT_EQ(files.unreadable.size(), 1u);
  EXPECT_THAT(files.unreadable[0].reason, HasSubstr("negative variances"));
}

TEST(ReadFleetFiles, TakesAFileThatWasNamedForACamera) {
  const ScratchFolder scratch;
  scratch.write("notes.txt", "nothing of a camera\n");
  const std::vector<std::string> inputs = {scratch.path("notes.txt")};
  EXPECT_EQ(readFleetFiles(inputs).unreadable.size(), 1u);
  const std::vector<std::string> missing = {scratch.path("missing.yaml")};
  EXPECT_THROW(static_cast<void>(readFleetFiles(missing)), Error);
}

}  // namespace
}  // namespace alidade
