// SPDX-License-Identifier: MIT
#include "support/verdict_case.h"

#include <numbers>
#include <utility>

#include "alidade/target/board_shape.h"
#include "support/spoiled_set.h"

namespace alidade {
namespace {

constexpr double kNoisePx = 0.1;

// The views again, each corner where `pixel_of(view, corner's point on the board)` sees it.
template <class PixelOf>
void photographAgain(SimulatedSet& set, Random& random, const PixelOf& pixel_of) {
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    for (Corner& corner : set.views[v].corners) {
      const Eigen::Vector2d noise(random.normal(), random.normal());
      corner.pixel = pixel_of(v, set.board.corner(corner.id)) + kNoisePx * noise;
    }
  }
}

// From the present poses.
void photographAgain(SimulatedSet& set, Random& random) {
  photographAgain(set, random, [&](std::size_t v, const Eigen::Vector3d& p) {
    return set.camera.project(set.poses[v] * p).pixel;
  });
}

// Where they are, but parallel to the image but for up to 4 degrees.
void facePlane(SimulatedSet& set, Random& random) {
  constexpr double kMaxTilt = 4 * std::numbers::pi / 180;
  const Eigen::Vector3d middle = set.board.middle();
  for (SE3& pose : set.poses) {
    const Eigen::Vector3d place = pose * middle;
    const double direction = random.uniform(0, 2 * std::numbers::pi);
    const double tilt = random.uniform(0, kMaxTilt);
    const SO3 roll = SO3::exp({0, 0, random.uniform(-0.3, 0.3)});
    pose.rotation = SO3::exp({tilt * std::cos(direction), tilt * std::sin(direction), 0}) * roll;
    pose.translation = place - pose.rotation * middle;
  }
  photographAgain(set, random);
}

// Farther away, and towards the middle.
void drawToCentre(SimulatedSet& set, Random& random) {
  for (SE3& pose : set.poses)
    pose.translation = pose.translation.cwiseProduct(Eigen::Vector3d(0.15, 0.15, 2.2));
  photographAgain(set, random);
}

AnyCamera zoomed(const AnyCamera& camera, double factor) {
  std::vector<double> params(camera.parameters().begin(), camera.parameters().end());
  params[0] *= factor;
  params[1] *= factor;
  return AnyCamera::make(camera.modelId(), params);
}

void changeFocal(SimulatedSet& set, Random& random, double strength) {
  const AnyCamera second = zoomed(set.camera, 1 + strength * random.uniform(0.01, 0.03));
  photographAgain(set, random, [&](std::size_t v, const Eigen::Vector3d& p) {
    const AnyCamera& camera = 2 * v < set.views.size() ? set.camera : second;
    return camera.project(set.poses[v] * p).pixel;
  });
}

void swapImage(SimulatedSet& set, Random& random, double strength) {
  const AnyCamera other = zoomed(set.camera, 1 + 0.2 * strength);
  const std::size_t swapped = set.views.size() / 2;
  photographAgain(set, random, [&](std::size_t v, const Eigen::Vector3d& p) {
    return (v == swapped ? other : set.camera).project(set.poses[v] * p).pixel;
  });
}

void stretch(SimulatedSet& set, Random& random, double strength) {
  photographAgain(set, random, [&](std::size_t v, const Eigen::Vector3d& p) {
    return set.camera.project(set.poses[v] * Eigen::Vector3d((1 + 0.005 * strength) * p.x(), p.y(), p.z()))
        .pixel;
  });
}

void bend(SimulatedSet& set, Random& random, double strength) {
  const double share = 0.015 * strength;
  const BoardShape shape{
      .bend_x_m = (random.uniform() < 0.5 ? 1 : -1) * share * set.board.square_m * (set.board.columns - 1),
      .bend_y_m = 0};
  photographAgain(set, random, [&](std::size_t v, const Eigen::Vector3d& p) {
    return set.camera.project(set.poses[v] * onBentBoard(set.board, shape, p)).pixel;
  });
}

// A hand that moves the board at 0.1 to 0.3 m/s and turns it at 15 to 40 degrees/s, seen by a sensor that
// reads its rows in 20 ms.
void carryAlong(SimulatedSet& set, Random& random, double strength) {
  const double readout_s = 0.02 * strength;
  std::vector<Eigen::Matrix<double, 6, 1>> twists;
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    Eigen::Vector3d way(random.normal(), random.normal(), random.normal());
    Eigen::Vector3d axis(random.normal(), random.normal(), random.normal());
    way *= random.uniform(0.1, 0.3) / way.norm();
    axis *= random.uniform(15, 40) * std::numbers::pi / 180 / axis.norm();
    Eigen::Matrix<double, 6, 1> twist;
    twist << way, axis;
    twists.push_back(readout_s * twist);
  }
  photographAgain(set, random, [&](std::size_t v, const Eigen::Vector3d& p) {
    Eigen::Vector2d pixel = set.camera.project(set.poses[v] * p).pixel;
    constexpr int kRounds = 5;  // the row at which the corner is seen depends on when its row is read
    for (int i = 0; i < kRounds; ++i) {
      const double time = pixel.y() / set.size.height - 0.5;
      pixel = set.camera.project(set.poses[v] * (SE3::exp(time * twists[v]) * p)).pixel;
    }
    return pixel;
  });
}

// A lens with more distortion than `model` has terms for.
AnyCamera richerCamera(std::string_view model) {
  if (model == "radtan") {
    return AnyCamera::make("thin_prism", std::vector<double>{1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4,
                                                             -0.01, 0, 0, 0, 0.01, -0.008, -0.008, 0.006});
  }
  return AnyCamera::make("omni", std::vector<double>{1205, 1203, 645, 475, 1.1, -0.05, 0.4, 3e-3, -2e-3});
}

}  // namespace

std::string_view flawName(Flaw flaw) {
  switch (flaw) {
    case Flaw::kNone:
      return "none";
    case Flaw::kThreeViews:
      return "three_views";
    case Flaw::kFrontoParallel:
      return "fronto_parallel";
    case Flaw::kCentreOnly:
      return "centre_only";
    case Flaw::kFocalChanged:
      return "focal_changed";
    case Flaw::kSwappedImage:
      return "swapped_image";
    case Flaw::kTooLean:
      return "too_lean";
    case Flaw::kFolded:
      return "folded";
    case Flaw::kBentBoard:
      return "bent_board";
    case Flaw::kStretchedBoard:
      return "stretched_board";
    case Flaw::kRollingShutter:
      return "rolling_shutter";
    case Flaw::kUnsharp:
      return "unsharp";
  }
  return "unknown";
}

std::vector<DiagnosisId> findingsFor(Flaw flaw) {
  switch (flaw) {
    case Flaw::kNone:
      return {};
    case Flaw::kThreeViews:
      return {"few_views"};
    case Flaw::kFrontoParallel:
      return {"fronto_parallel"};
    case Flaw::kCentreOnly:
      return {"poor_coverage"};
    case Flaw::kFocalChanged:
      return {"focal_changed", "two_cameras"};
    case Flaw::kSwappedImage:
      return {"view_left_out", "influential_view"};
    case Flaw::kTooLean:
      return {"model_too_lean", "lens_deviates", "misfit"};
    case Flaw::kFolded:
      return {"folds_in_image"};
    case Flaw::kBentBoard:
      return {"bent_board"};
    case Flaw::kStretchedBoard:
      return {"board_not_square"};
    case Flaw::kRollingShutter:
      return {"rolling_shutter"};
    case Flaw::kUnsharp:
      return {"misfit", "poor_coverage", "inaccurate"};
  }
  return {};
}

bool hasStrength(Flaw flaw) {
  switch (flaw) {
    case Flaw::kFocalChanged:
    case Flaw::kSwappedImage:
    case Flaw::kBentBoard:
    case Flaw::kStretchedBoard:
    case Flaw::kRollingShutter:
      return true;
    default:
      return false;
  }
}

VerdictCase makeVerdictCase(Flaw flaw, std::string_view model, std::uint64_t number, double strength) {
  const std::uint64_t seed = streamSeed(streamSeed(77, static_cast<std::uint64_t>(flaw)), number);
  Random random(seed);
  int num_views = 15;
  AnyCamera camera = spoiledCamera(model);
  RandomViewOptions views;
  double noise = kNoisePx;
  std::string used(model);
  if (flaw == Flaw::kNone) num_views = 30;
  if (flaw == Flaw::kThreeViews) num_views = 3;
  if (flaw == Flaw::kUnsharp) noise = 0.6;
  if (flaw == Flaw::kTooLean) {
    if (number % 2 == 0) used = "pinhole";
    if (number % 2 == 1) camera = richerCamera(model);
  }
  if (flaw == Flaw::kFolded) {
    camera = AnyCamera::make("kannala_brandt",
                             std::vector<double>{430, 429, 645, 475, 0.02, -0.005, 0.001, -2e-4});
    used = "radtan";
  }
  VerdictCase c{.set = simulateSet(camera, kSpoiledSize, num_views, noise, random.index(1U << 30U), views,
                                   kSpoiledBoard),
                .options = {.model = used}};
  switch (flaw) {
    case Flaw::kCentreOnly:
      drawToCentre(c.set, random);
      break;
    case Flaw::kFrontoParallel:
      facePlane(c.set, random);
      break;
    case Flaw::kFocalChanged:
      changeFocal(c.set, random, strength);
      break;
    case Flaw::kSwappedImage:
      swapImage(c.set, random, strength);
      break;
    case Flaw::kBentBoard:
      bend(c.set, random, strength);
      break;
    case Flaw::kStretchedBoard:
      stretch(c.set, random, strength);
      break;
    case Flaw::kRollingShutter:
      carryAlong(c.set, random, strength);
      break;
    default:
      break;
  }
  dropOutside(c.set.views);
  return c;
}

}  // namespace alidade
