// SPDX-License-Identifier: MIT
// Tests whether footage distinguishes a wrong camera from the true one, and finds the error. Each set is a
// walk through a simulated room by a camera of one of ten models, checked with the true camera and with four
// changed ones.
//   footage_check_bench tracks|rendered [sets, default 100] [first set, default 0]
//   footage_check_bench controls [sets per kind, default 5]
// tracks: exact tracks with noise and drift; rendered: optical flow on rendered frames. Footage that cannot
// tell must not be called inconsistent (controls). Exits with 1 if a target is missed.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/core/random.h"
#include "alidade/core/statistics.h"
#include "alidade/footage/check/camera_check.h"
#include "alidade/footage/follow/front_end.h"
#include "alidade/footage/follow/tracks.h"
#include "alidade/simulate/footage_simulator.h"
#include "footage/simulated_tracks.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{640, 480};

struct Lens {
  const char* model;
  std::vector<double> params;
};

// Two lenses of each model; 65 to 185 degrees across the image.
const std::vector<Lens>& lenses() {
  static const std::vector<Lens> all = {
      {"pinhole", {500, 502, 322, 238}},
      {"radtan", {520, 521, 318, 243, -0.28, 0.09, 1e-3, -5e-4, 0}},
      {"rational", {430, 431, 321, 238, 0.3, 0.05, 1e-4, -1e-4, 0, 0.55, 0.1, 0}},
      {"thin_prism",
       {480, 479, 319, 241, -0.25, 0.07, 8e-4, -4e-4, -0.01, 0, 0, 0, 2e-3, -1e-4, -1e-3, 1e-4}},
      {"kannala_brandt", {205, 205.5, 321, 239, 0.01, -0.004, 1e-3, 0}},
      {"fov", {300, 301, 318, 240, 0.9}},
      {"ucm", {420, 421, 320, 240, 0.8}},
      {"omni", {500, 501, 322, 238, 1.1, -0.05, 0.1, 1e-3, -1e-3}},
      {"eucm", {230, 229.5, 319, 240, 0.6, 1.1}},
      {"double_sphere", {190, 190, 320, 240, -0.2, 0.55}},
      {"pinhole", {380, 380, 317, 242}},
      {"radtan", {400, 401, 323, 237, -0.2, 0.04, -5e-4, 4e-4, 0}},
      {"rational", {360, 360, 318, 242, 0.2, 0.02, -2e-4, 1e-4, 0, 0.45, 0.05, 0}},
      {"thin_prism", {420, 421, 322, 238, -0.2, 0.05, -5e-4, 6e-4, 0, 0, 0, 0, -1e-3, 1e-4, 2e-3, -1e-4}},
      {"kannala_brandt", {300, 301, 322, 241, -0.03, 0.01, -3e-3, 0}},
      {"fov", {330, 330, 322, 238, 1.0}},
      {"ucm", {360, 360, 322, 241, 1.0}},
      {"omni", {420, 421, 318, 241, 0.9, -0.1, 0.05, -1e-3, 1e-3}},
      {"eucm", {300, 300, 322, 238, 0.55, 1.0}},
      {"double_sphere", {260, 261, 318, 241, -0.15, 0.6}}};
  return all;
}

AnyCamera cameraOf(int set) {
  const Lens& lens = lenses()[static_cast<std::size_t>(set) % lenses().size()];
  return AnyCamera::make(lens.model, lens.params);
}

FootageScene sceneOf(int set) {
  Random random(streamSeed(77, static_cast<std::uint64_t>(set)));
  FootageScene scene{.camera = cameraOf(set), .image_size = kSize};
  scene.num_frames = 30 + static_cast<int>(random.index(31));
  scene.flow_px = random.uniform(6, 14);
  scene.effects.blur_px = random.uniform(0.5, 1.1);
  scene.effects.read_noise = random.uniform(1, 3);
  scene.seed = streamSeed(78, static_cast<std::uint64_t>(set));
  scene.num_jobs = 1;
  return scene;
}

FootageTracks tracksOf(const FootageSimulator& simulator, std::uint64_t seed) {
  const double noise = Random(seed).uniform(0.1, 0.3);
  return testing::simulatedTracks(simulator, {.noise_px = noise, .drift_px = 0.03}, streamSeed(seed, 1),
                                  {.columns = 20, .rows = 15});
}

// A car's bonnet: the lowest fifth of each image shows the same texture.
void coverBelow(GrayImage& image, const GrayImage& texture) {
  const auto width = static_cast<std::size_t>(image.size.width);
  const auto height = static_cast<std::size_t>(image.size.height);
  for (std::size_t y = height - height / 5; y < height; ++y)
    std::copy_n(&texture.pixels[(height - 1 - y) * width], width, &image.pixels[y * width]);
}

FootageTracks renderedTracks(const FootageSimulator& simulator, bool has_bonnet = false) {
  const auto front_end = makeFrontEnd(FrontEndKind::kFlow);
  FootageTracks kept;
  kept.size = kSize;
  kept.is_video = true;
  GrayImage first;
  for (int i = 0; i < simulator.numFrames(); ++i) {
    GrayImage image = simulator.renderFrame(i);
    if (i == 0) first = image;
    if (has_bonnet) coverBelow(image, first);
    std::vector<TrackPixel> frame = front_end->follow(image);
    if (!isKeyframe(kept, frame)) continue;
    kept.numbers.push_back(static_cast<std::size_t>(i));
    kept.frames.push_back(std::move(frame));
  }
  return kept;
}

enum class Kind { kTrue, kFocal, kPrincipal, kDistortion, kCrop };
constexpr std::array kKinds = {Kind::kTrue, Kind::kFocal, Kind::kPrincipal, Kind::kDistortion, Kind::kCrop};

const char* nameOf(Kind kind) {
  constexpr std::array kNames = {"true", "focal x 1.02", "principal 2 %", "distortion x 0.7", "focal x 0.9"};
  return kNames.at(static_cast<std::size_t>(kind));
}

AnyCamera changed(const AnyCamera& camera, Kind kind, int set) {
  std::vector<double> params(camera.parameters().begin(), camera.parameters().end());
  const double angle = Random(streamSeed(79, static_cast<std::uint64_t>(set))).uniform(0, 6.283185307179586);
  for (std::size_t i = 0; i < params.size(); ++i) {
    if (kind == Kind::kFocal && i < 2) params[i] *= 1.02;
    if (kind == Kind::kCrop && i < 2) params[i] *= 0.9;
    if (kind == Kind::kPrincipal && i == 2) params[i] += 0.02 * kSize.width * std::cos(angle);
    if (kind == Kind::kPrincipal && i == 3) params[i] += 0.02 * kSize.width * std::sin(angle);
    if (kind == Kind::kDistortion && i >= 4) params[i] *= 0.7;
  }
  return AnyCamera::make(camera.modelId(), params);
}

// 95th percentile of the displacement of pixels, in one camera frame.
double effectOf(const AnyCamera& a, const AnyCamera& b) {
  std::vector<double> lengths;
  for (int y = 5; y < kSize.height; y += 10) {
    for (int x = 5; x < kSize.width; x += 10) {
      const auto ray = a.unproject(Eigen::Vector2d(x, y));
      if (!ray) continue;
      const Projection projection = b.project(*ray);
      if (projection.ok()) lengths.push_back((projection.pixel - Eigen::Vector2d(x, y)).norm());
    }
  }
  return lengths.empty() ? 0 : quantile95(std::move(lengths));
}

// Standard deviation of a kind of change relative to the size of the actual change.
double relativeStd(const FootageCheck& at_true, Kind kind) {
  for (const CameraChange& change : at_true.changes) {
    if (change.kind == CameraChangeKind::kFocalLength && kind == Kind::kFocal) return change.std[0] / 0.02;
    if (change.kind == CameraChangeKind::kFocalLength && kind == Kind::kCrop) return change.std[0] / 0.1;
    if (change.kind == CameraChangeKind::kPrincipalPoint && kind == Kind::kPrincipal)
      return std::max(change.std[0], change.std[1]) / (0.02 * kSize.width);
    if (change.kind == CameraChangeKind::kDistortion && kind == Kind::kDistortion) return change.std[0] / 0.3;
  }
  return HUGE_VAL;
}

// The first radial coefficient accounts for most of a lens's distortion.
bool isRight(const FootageCheck& check, Kind kind) {
  if (!check.explanation) return false;
  const CameraChangeKind found = check.changes[*check.explanation].kind;
  switch (kind) {
    case Kind::kTrue:
      return false;
    case Kind::kFocal:
    case Kind::kCrop:
      return found == CameraChangeKind::kFocalLength;
    case Kind::kPrincipal:
      return found == CameraChangeKind::kPrincipalPoint;
    case Kind::kDistortion:
      return found == CameraChangeKind::kDistortion || found == CameraChangeKind::kFirstRadial;
  }
  return false;
}

double processorSeconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

void print(int set, const AnyCamera& camera, const char* what, const FootageCheck& check, double seconds) {
  std::printf("%3d %-14s %-16s %-12s %-14s", set, std::string(camera.modelId()).c_str(), what,
              std::string(verdictId(check.verdict)).c_str(), std::string(gapId(check.gap)).c_str());
  std::printf(" %d windows %d frames %d points noise %.2f blind %.1f %.2f s", check.num_windows,
              check.num_frames, check.num_points, check.noise_px, check.blind_px, seconds);
  if (check.explanation) {
    const CameraChange& change = check.changes[*check.explanation];
    std::printf(" [%s; %.1f px, surely %.1f; score %.1f drop %.2f]", describe(change).c_str(),
                change.effect_px, change.sure_px, change.score, change.cost_drop);
  }
  std::printf("\n");
  std::fflush(stdout);
}

struct Row {
  int num_inconsistent = 0;
  int num_consistent = 0;
  int num_cannot_tell = 0;
  int num_right = 0;  // of the inconsistent ones

  void add(const FootageCheck& check, bool is_right) {
    num_inconsistent += check.verdict == FootageVerdict::kInconsistent ? 1 : 0;
    num_consistent += check.verdict == FootageVerdict::kConsistent ? 1 : 0;
    num_cannot_tell += check.verdict == FootageVerdict::kCannotTell ? 1 : 0;
    num_right += check.verdict == FootageVerdict::kInconsistent && is_right ? 1 : 0;
  }
  [[nodiscard]] int count() const { return num_inconsistent + num_consistent + num_cannot_tell; }
  void print(const char* what) const {
    std::printf("%-28s %4d %12d %10d %11d %14d\n", what, count(), num_inconsistent, num_consistent,
                num_cannot_tell, num_right);
  }
};

int runSets(bool is_rendered, int num_sets, int first) {
  std::array<Row, kKinds.size()> all;
  std::array<Row, kKinds.size()> qualifying;
  std::array<Row, kKinds.size()> small;
  double seconds = 0;
  int num_checks = 0;
  for (int set = first; set < first + num_sets; ++set) {
    const FootageScene scene = sceneOf(set);
    const FootageSimulator simulator(scene);
    const FootageTracks tracks = is_rendered ? renderedTracks(simulator) : tracksOf(simulator, scene.seed);
    FootageCheck at_true;
    for (const Kind kind : kKinds) {
      const AnyCamera camera = changed(scene.camera, kind, set);
      const bool is_true = kind == Kind::kTrue;
      if (!is_true && effectOf(scene.camera, camera) == 0) continue;  // a lens without distortion
      const double before = processorSeconds();
      const FootageCheck check = checkOnFootage(camera, tracks, {.num_jobs = 1});
      seconds += processorSeconds() - before;
      ++num_checks;
      if (is_true) at_true = check;
      print(set, camera, nameOf(kind), check, processorSeconds() - before);
      const auto k = static_cast<std::size_t>(kind);
      const bool is_right = isRight(check, kind);
      all.at(k).add(check, is_right);
      if (is_true) continue;
      const double relative_std = relativeStd(at_true, kind);
      std::printf("      std %.3f of the change, effect %.1f px\n", relative_std,
                  effectOf(scene.camera, camera));
      if (effectOf(scene.camera, camera) < 5) {
        small.at(k).add(check, is_right);
      } else if (relative_std < 1.0 / 3) {
        qualifying.at(k).add(check, is_right);
      }
    }
  }
  std::printf("%-28s sets inconsistent consistent cannot_tell named rightly\n", "");
  bool is_good = all[0].num_inconsistent * 50 <= all[0].count();
  for (const Kind kind : kKinds) {
    const auto k = static_cast<std::size_t>(kind);
    all.at(k).print(nameOf(kind));
    if (kind == Kind::kTrue) continue;
    qualifying.at(k).print("  known to a third");
    small.at(k).print("  below 5 px");
    is_good = is_good && 10 * qualifying.at(k).num_inconsistent >= 9 * qualifying.at(k).count() &&
              10 * qualifying.at(k).num_right >= 9 * qualifying.at(k).num_inconsistent;
  }
  std::printf("%.2f s of processor time a check\n", seconds / std::max(1, num_checks));
  return is_good ? 0 : 1;
}

// Thirteen kinds of footage, with the true camera: it must not be called inconsistent.
int runControls(int num_sets) {
  struct Control {
    const char* name;
    std::function<void(FootageScene&)> apply;
    bool has_bonnet = false;
  };
  const std::vector<Control> controls = {
      {"room", [](FootageScene&) {}},
      {"rotation", [](FootageScene& s) { s.path = FootagePath::kRotation; }},
      {"wall", [](FootageScene& s) { s.surroundings = FootageSurroundings::kPlane; }},
      {"ground, straight",
       [](FootageScene& s) {
         s.surroundings = FootageSurroundings::kPlane;
         s.path = FootagePath::kStraight;
       }},
      {"far away", [](FootageScene& s) { s.surroundings = FootageSurroundings::kFar; }},
      {"crowd, static",
       [](FootageScene& s) {
         s.path = FootagePath::kStatic;
         s.effects.moving_objects = 40;
         s.effects.moving_share = 0.75;
       }},
      {"crowd, walk",
       [](FootageScene& s) {
         s.effects.moving_objects = 40;
         s.effects.moving_share = 0.6;
       }},
      {"bonnet, walk", [](FootageScene&) {}, true},
      {"bonnet, straight", [](FootageScene& s) { s.path = FootagePath::kStraight; }, true},
      {"rolling shutter", [](FootageScene& s) { s.effects.rolling_shutter = 0.7; }},
      {"rolling shutter, shaken",
       [](FootageScene& s) {
         s.effects.rolling_shutter = 0.9;
         s.effects.shake_px = 5;
       }},
      {"zoom", [](FootageScene& s) { s.effects.zoom = 1.2; }},
      {"stabilised", [](FootageScene& s) {
         s.effects.shake_px = 5;
         s.effects.stabilisation_frames = 5;
       }}};
  std::vector<std::pair<std::string, Row>> rows;
  Row all;
  for (const Control& control : controls) {
    Row& row = rows.emplace_back(control.name, Row()).second;
    for (int set = 0; set < num_sets; ++set) {
      FootageScene scene = sceneOf(set);
      control.apply(scene);
      if (scene.path == FootagePath::kStatic) scene.flow_px = 0;
      try {
        const FootageSimulator simulator(scene);
        const FootageTracks tracks = renderedTracks(simulator, control.has_bonnet);
        const double before = processorSeconds();
        const FootageCheck check = checkOnFootage(scene.camera, tracks, {.num_jobs = 2});
        print(set, scene.camera, control.name, check, processorSeconds() - before);
        row.add(check, false);
        all.add(check, false);
      } catch (const std::exception& error) {
        std::printf("%3d %s: no such footage: %s\n", set, control.name, error.what());
      }
    }
  }
  std::printf("%-28s sets inconsistent consistent cannot_tell named rightly\n", "");
  for (const auto& [name, row] : rows) row.print(name.c_str());
  all.print("all");
  return 100 * all.num_inconsistent <= all.count() ? 0 : 1;
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  const std::string_view mode = argc > 1 ? argv[1] : "";
  const int count = argc > 2 ? std::atoi(argv[2]) : mode == "controls" ? 5 : 100;
  const int first = argc > 3 ? std::atoi(argv[3]) : 0;
  if ((mode == "tracks" || mode == "rendered") && argc <= 4)
    return alidade::runSets(mode == "rendered", count, first);
  if (mode == "controls" && argc <= 3) return alidade::runControls(count);
  std::fprintf(stderr, "usage: footage_check_bench tracks|rendered [SETS [FIRST]] | controls [SETS]\n");
  return 2;
}
