// SPDX-License-Identifier: MIT
#include <algorithm>
#include <iterator>
#include <optional>
#include <variant>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/corners_file.h"
#include "alidade/files/hand_eye_file.h"
#include "alidade/files/pose_list.h"
#include "alidade/files/robot_table.h"
#include "alidade/files/scene_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/files/text/file_text.h"
#include "alidade/imagery/image_file.h"
#include "alidade/print/ink_of_board.h"
#include "alidade/report/data/json_output.h"
#include "alidade/simulate/footage_simulator.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "alidade/simulate/render.h"
#include "alidade/simulate/robot.h"
#include "command.h"
#include "console.h"
#include "pending_folder.h"

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

// Writes camera.yaml, poses.yaml, trajectory.txt, tracks.csv and, if requested, images/*.png.
void writeFootage(const FootageSimulator& simulator, const std::vector<TrueTrack>& tracks,
                  const PendingFolder& folder, bool with_images, const CommonOptions& common) {
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
    ProgressBar bar("rendering", common.quiet);
    for (std::size_t i = 0; i < names.size(); ++i) {
      GrayImage image = simulator.renderFrame(static_cast<int>(i), common.cancel);
      writeImage(folder.path("images/" + names[i]), {.size = image.size, .bytes = std::move(image.pixels)});
      bar.update(i + 1, names.size());
    }
  });
}

class SimulateCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade simulate config/scene.yaml -o simulated\nWrites images/*.png, camera.yaml (the "
        "true camera), corners.csv (the true corners) and poses.yaml (the true poses).\n"
        "Example: alidade simulate config/footage.yaml -o footage\nWrites tracks.csv (true pixels of points "
        "in each frame) in place of corners.csv, and trajectory.txt (the poses as TUM trajectory).\n"
        "Example: alidade simulate config/robot.yaml -o robot\nWrites robot.csv (what the robot states) and "
        "handeye.yaml (the truth) besides.");
    flags.add("scene", &scene_path_, "Scene file (YAML): camera and board with views or a robot, or footage",
              kFilePath);
    flags.redirect({"--board", "--camera", "--seed"}, "write it in the scene file, see config/scene.yaml");
    flags.add("-o,--output", &output_, "Folder to create", kFolder);
    flags.addSwitch("--corners-only,--truth-only", truth_only_, "Write only the ground truth, no images");
    flags.addSwitch("--overwrite", overwrite_, kOverwriteText);
    flags.addCommon(common_, true);
  }

  int run(const Flags&) override {
    if (scene_path_.empty()) throw missing("no scene file", "a scene file (YAML)");
    if (output_.empty()) throw missing("no --output", "-o FOLDER");
    refuseFolderOfInputs(output_, {scene_path_, common_.config});
    common_.cancel = catchInterrupts();
    const AnyScene any_scene = readSceneFile(scene_path_);
    std::visit(
        [&](const auto& scene) {
          refuseFolderOfInputs(output_, scene.files);
          if (!common_.quiet) printNotes(scene.camera_remarks);
        },
        any_scene);
    if (const auto* footage = std::get_if<FootageScene>(&any_scene)) return runFootage(*footage);
    return runBoard(std::get<Scene>(any_scene));
  }

 private:
  int runFootage(FootageScene scene) {
    scene.num_jobs = common_.jobs;
    // Only the simulator can check whether objects can cover the requested share.
    const FootageSimulator simulator =
        detail::withPlace(scene_path_ + ": footage", [&] { return FootageSimulator(scene); });
    PendingFolder folder(output_, common_.command, overwrite_, common_.quiet);
    const std::vector<TrueTrack> tracks = simulator.trackPoints();
    std::size_t num_pixels = 0;
    for (const TrueTrack& track : tracks) num_pixels += track.pixels.size();
    writeFootage(simulator, tracks, folder, !truth_only_, common_);
    folder.commit();
    answer(
        [&] {
          return jsonText({{"folder", output_},
                           {"num_frames", simulator.numFrames()},
                           {"num_tracks", tracks.size()},
                           {"num_pixels", num_pixels}});
        },
        [&] {
          return fmt::format("{}: {} frames, {} tracks of {} pixels{}\n", printable(output_),
                             simulator.numFrames(), tracks.size(), num_pixels,
                             truth_only_ ? ", no images" : "");
        });
    return 0;
  }

  int runBoard(const Scene& scene) {
    std::vector<SE3> poses = scene.camera_from_board;
    std::optional<RobotSet> robot;
    if (scene.robot) {
      robot = robotSet(scene, poses);
    } else if (poses.empty()) {
      Random random(streamSeed(scene.seed, 0));
      poses = randomViews(scene.camera, scene.image_size, scene.board, scene.num_random_views, random,
                          scene.random_views);
    }
    std::vector<std::string> names;
    for (std::size_t i = 0; i < poses.size(); ++i) names.push_back(fmt::format("view_{:03}.png", i + 1));
    if (robot) names = mapped(robot->views, &View::image);

    CornersFile corners = trueCorners(scene, poses, names);
    if (robot) corners.views = robot->views;
    const std::vector<std::string> without_corners = viewsWithoutCorners(corners);
    PendingFolder folder(output_, common_.command, overwrite_, common_.quiet);
    folder.write([&] {
      writeCornersFile(folder.path("corners.csv"), corners);
      saveCamera(folder.path("camera.yaml"),
                 bareRecord(scene.camera, scene.image_size, programName() + " simulate"));
      writeFileAtomically(folder.path("poses.yaml"), posesText(names, "camera_from_board", poses));
      if (robot) writeRobot(*scene.robot, *robot, folder);
      if (!truth_only_) renderAll(scene, poses, names, folder);
    });
    folder.commit();

    std::size_t num_corners = 0;
    for (const View& view : corners.views) num_corners += view.corners.size();
    answer(
        [&] {
          return jsonText({{"folder", output_},
                           {"num_views", poses.size()},
                           {"num_corners", num_corners},
                           {"views_without_corners", without_corners}});
        },
        [&] {
          return fmt::format("{}: {} views, {} corners{}\n", printable(output_), poses.size(), num_corners,
                             truth_only_ ? ", no images" : "");
        });
    if (!without_corners.empty() && !common_.quiet) {
      printMessage(fmt::format("warning: no corner of the board is visible in {}\n  next: check these poses",
                               join(without_corners, ", ")));
    }
    return 0;
  }

  // @param poses  gets camera_from_board of each image
  static RobotSet robotSet(const Scene& scene, std::vector<SE3>& poses) {
    const SceneRobot& robot = *scene.robot;
    RobotSet set = simulateRobot({.camera = scene.camera,
                                  .size = scene.image_size,
                                  .board = scene.board,
                                  .camera_on = robot.camera_on,
                                  .num_views = robot.num_poses,
                                  .robot_noise = robot.noise,
                                  .corner_noise_px = scene.corner_noise_px},
                                 scene.seed);
    for (const SE3& base_from_gripper : set.base_from_gripper) {
      const SE3 motion = robot.camera_on == CameraOn::kHand ? base_from_gripper.inverse() : base_from_gripper;
      poses.push_back(set.mount_from_camera.inverse() * motion * set.world_from_boards[0]);
    }
    Random random(streamSeed(scene.seed, 2));
    if (robot.mistake && !isOfTable(*robot.mistake)) apply(*robot.mistake, set, random);
    return set;
  }

  // robot.csv, as the robot states it, and the truth as handeye.yaml.
  static void writeRobot(const SceneRobot& robot, const RobotSet& set, const PendingFolder& folder) {
    writeFileAtomically(folder.path("robot.csv"), robotTableText(set.robot.poses, robot.mistake));
    HandEyeRecord truth{.camera_on = robot.camera_on,
                        .mount_from_camera = set.mount_from_camera,
                        .world_from_boards = set.world_from_boards,
                        .boards = {set.scene.board.spec()},
                        .robot_noise = robot.noise,
                        .num_poses = robot.num_poses,
                        .created_by = programName() + " simulate"};
    writeFileAtomically(folder.path("handeye.yaml"), handEyeText(truth, "alidade"));
  }

  [[nodiscard]] std::vector<std::string> viewsWithoutCorners(const CornersFile& corners) const {
    std::vector<std::string> names;
    for (const View& view : corners.views) {
      if (view.corners.empty()) names.push_back(view.image);
    }
    if (names.size() == corners.views.size()) {
      throw inputError(
          {.where = scene_path_ + ": views",
           .found = "no corner of the board is visible in any view",
           .expected = "the printed side of the board in front of the camera and inside the image",
           .next_step = "check the poses: they must be camera_from_board, in metres, z forward"});
    }
    return names;
  }

  static CornersFile trueCorners(const Scene& scene, const std::vector<SE3>& poses,
                                 const std::vector<std::string>& names) {
    CornersFile file;
    file.boards = {scene.board};
    file.comments.push_back(fmt::format(
        "{} simulate; {}", programName(),
        scene.corner_noise_px > 0 ? fmt::format("noise of {} px per axis", scene.corner_noise_px) : "exact"));
    for (std::size_t i = 0; i < poses.size(); ++i) {
      View view = exactView(scene.camera, scene.image_size, scene.board, poses[i], names[i]);
      Random random(streamSeed(scene.seed, 1 + i));
      if (scene.corner_noise_px > 0) addCornerNoise(view, scene.corner_noise_px, random);
      file.views.push_back(std::move(view));
    }
    return file;
  }

  void renderAll(const Scene& scene, const std::vector<SE3>& poses, const std::vector<std::string>& names,
                 const PendingFolder& folder) const {
    folder.makeSubfolder("images");
    ProgressBar bar("rendering", common_.quiet);
    const Renderer renderer(scene.camera, scene.image_size, common_.jobs);
    const auto* squares = std::get_if<Checkerboard>(&scene.board.kind());  // their border may be narrow
    const BoardInk ink = inkOf(scene.board);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      RenderOptions options = scene.render;
      options.num_jobs = common_.jobs;
      options.seed = streamSeed(scene.seed, 1'000'000 + i);
      GrayImage image = squares != nullptr ? renderer.render(*squares, poses[i], options, common_.cancel)
                                           : renderer.render(ink, poses[i], options, common_.cancel);
      if (scene.robot && scene.robot->mistake == RobotMistake::kMirroredImages) {
        for (auto row = image.pixels.begin(); row != image.pixels.end(); row += image.size.width)
          std::reverse(row, row + image.size.width);
      }
      writeImage(folder.path("images/" + names[i]), {.size = image.size, .bytes = std::move(image.pixels)});
      bar.update(i + 1, poses.size());
    }
  }

  std::string scene_path_;
  std::string output_;
  bool truth_only_ = false;
  bool overwrite_ = false;
};

}  // namespace

const CommandEntry kSimulateCommand = {
    "simulate", "Render images of a board, or footage, with known ground truth", made<SimulateCommand>};

}  // namespace alidade
