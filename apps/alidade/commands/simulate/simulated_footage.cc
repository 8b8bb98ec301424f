// SPDX-License-Identifier: MIT
#include "commands/simulate/simulated_footage.h"

#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/files/camera_source.h"
#include "alidade/files/pose_list.h"
#include "alidade/files/scene_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/imagery/image_file.h"
#include "console.h"
#include "program.h"

namespace alidade {
namespace {

std::string tracksText(const FootageSimulator& simulator, const std::vector<TrueTrack>& tracks) {
  std::string text = fmt::format(
      "# {} simulate; exact. u, v: pixels; x, y, z: the point in the world at the time of the frame, metres\n"
      "track,frame,u,v,moving,x,y,z\n",
      programName());
  for (const TrueTrack& track : tracks) {
    for (std::size_t i = 0; i < track.pixels.size(); ++i) {
      const int frame = track.first_frame + static_cast<int>(i);
      const Eigen::Vector3d p = simulator.positionOf(track.point, simulator.timeOf(frame));
      fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{},{}\n", track.id, frame,
                     track.pixels[i].x(), track.pixels[i].y(), track.point.is_moving ? 1 : 0, p.x(), p.y(),
                     p.z());
    }
  }
  return text;
}

}  // namespace

void writeFootage(const FootageSimulator& simulator, const std::vector<TrueTrack>& tracks,
                  const PendingFolder& folder, bool with_images, bool is_quiet, const CancelFlag* cancel) {
  const FootageScene& scene = simulator.scene();
  std::vector<std::string> names;
  std::vector<SE3> poses;
  std::vector<double> times_s;
  for (int i = 0; i < simulator.numFrames(); ++i) {
    names.push_back(fmt::format("frame_{:05}.png", i));
    poses.push_back(simulator.poseOf(i));
    times_s.push_back(simulator.timeOf(i));
  }
  folder.write([&] {
    saveCamera(folder.path("camera.yaml"),
               bareRecord(scene.camera, scene.image_size, programName() + " simulate"));
    writeFileAtomically(folder.path("poses.yaml"), posesText(names, "camera_from_world", poses));
    writeFileAtomically(folder.path("trajectory.txt"), tumText(times_s, poses));
    writeFileAtomically(folder.path("tracks.csv"), tracksText(simulator, tracks));
    if (!with_images) return;
    folder.makeSubfolder("images");
    ProgressBar bar("rendering", is_quiet);
    for (std::size_t i = 0; i < names.size(); ++i) {
      GrayImage image = simulator.renderFrame(static_cast<int>(i), cancel);
      writeImage(folder.path("images/" + names[i]), {.size = image.size, .bytes = std::move(image.pixels)});
      bar.update(i + 1, names.size());
    }
  });
}

}  // namespace alidade
