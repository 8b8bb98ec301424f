// SPDX-License-Identifier: MIT
#include "support/flawed_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "support/simulated_set.h"

namespace alidade {
namespace {

// Between two sizes, each order of magnitude as likely.
double drawSize(Random& random, double least, double most) {
  return least * std::exp(random.uniform() * std::log(most / least));
}

double drawSign(Random& random) {
  return random.uniform() < 0.5 ? -1 : 1;
}

Eigen::Vector2d drawNormal(Random& random) {
  const double x = random.normal();
  return {x, random.normal()};
}

Eigen::Vector2d drawDirection(Random& random) {
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  return {std::cos(azimuth), std::sin(azimuth)};
}

// Takes all corners again from `pixel_of(view, corner id)`; those without a pixel are gone.
template <class PixelOf>
void photograph(FlawedSet& of, Random& random, const PixelOf& pixel_of) {
  for (std::size_t v = 0; v < of.set.views.size(); ++v) {
    std::vector<Corner> seen;
    for (Corner corner : of.set.views[v].corners) {
      const std::optional<Eigen::Vector2d> pixel = pixel_of(v, corner.id);
      const Eigen::Vector2d noise = of.noise_px * drawNormal(random);
      if (!pixel) continue;
      corner.pixel = *pixel + noise;
      seen.push_back(corner);
    }
    of.set.views[v].corners = std::move(seen);
  }
}

std::optional<Eigen::Vector2d> pixelAt(const AnyCamera& camera, const Eigen::Vector3d& p_cam) {
  const Projection projection = camera.project(p_cam);
  return projection.ok() ? std::optional(projection.pixel) : std::nullopt;
}

// With another point in the place of a corner, on the board or in the camera's frame.
template <class PointOf>
void photographBoard(FlawedSet& of, Random& random, const PointOf& point_of) {
  photograph(of, random,
             [&](std::size_t v, int id) { return pixelAt(of.drawn.camera, of.set.poses[v] * point_of(id)); });
}
template <class PointOf>
void photographThrough(FlawedSet& of, Random& random, const PointOf& point_of) {
  photograph(of, random, [&](std::size_t v, int id) {
    return pixelAt(of.drawn.camera, point_of(v, Eigen::Vector3d(of.set.poses[v] * of.set.board.corner(id))));
  });
}

// The place of a corner, from -1 to 1 both ways.
Eigen::Vector2d placeOf(const Checkerboard& board, int id) {
  const Eigen::Vector3d half = board.middle();
  return ((board.corner(id) - half).head<2>().array() / half.head<2>().array()).matrix();
}

// The board `height_at(place)` times 0.05 to 3 % of its half width off its plane.
template <class HeightAt>
void bend(FlawedSet& of, Random& random, const HeightAt& height_at) {
  const double height = drawSign(random) * drawSize(random, 5e-4, 0.03) * of.set.board.middle().x();
  photographBoard(of, random, [&](int id) -> Eigen::Vector3d {
    return of.set.board.corner(id) + Eigen::Vector3d(0, 0, height * height_at(placeOf(of.set.board, id)));
  });
}

void bendCylinder(FlawedSet& of, Random& random) {
  bend(of, random, [](const Eigen::Vector2d& p) { return p.x() * p.x(); });
}
void bendSaddle(FlawedSet& of, Random& random) {
  bend(of, random, [](const Eigen::Vector2d& p) { return p.x() * p.x() - p.y() * p.y(); });
}
void twist(FlawedSet& of, Random& random) {
  bend(of, random, [](const Eigen::Vector2d& p) { return p.x() * p.y(); });
}
void wave(FlawedSet& of, Random& random) {
  bend(of, random, [](const Eigen::Vector2d& p) { return std::sin(2 * std::numbers::pi * p.x()); });
}
void liftCorner(FlawedSet& of, Random& random) {
  bend(of, random, [](const Eigen::Vector2d& p) { return std::pow(std::max(0.0, 0.5 * p.sum()), 3); });
}

// Paper that bends differently in each view, or in the two halves of a set.
void flex(FlawedSet& of, Random& random, std::size_t num_bends) {
  const double height = drawSize(random, 5e-4, 0.03) * of.set.board.middle().x();
  std::vector<Eigen::Vector2d> bends;
  for (std::size_t i = 0; i < num_bends; ++i) bends.emplace_back(height * drawNormal(random));
  const std::size_t num_views = of.set.views.size();
  photograph(of, random, [&](std::size_t v, int id) {
    const Eigen::Vector2d& at = bends[v * num_bends / num_views];
    const double z = at.dot(placeOf(of.set.board, id).cwiseAbs2());
    return pixelAt(of.drawn.camera, of.set.poses[v] * (of.set.board.corner(id) + Eigen::Vector3d(0, 0, z)));
  });
}
void flexAlways(FlawedSet& of, Random& random) {
  flex(of, random, of.set.views.size());
}
void flexMidway(FlawedSet& of, Random& random) {
  flex(of, random, 2);
}

void stretch(FlawedSet& of, Random& random) {
  const double factor = 1 + drawSign(random) * drawSize(random, 1e-4, 0.02);
  photographBoard(of, random, [&](int id) -> Eigen::Vector3d {
    return of.set.board.corner(id).cwiseProduct(Eigen::Vector3d(1, factor, 1));
  });
}

// Squares that grow along the board.
void grade(FlawedSet& of, Random& random) {
  const double growth = drawSign(random) * drawSize(random, 1e-4, 0.02);
  photographBoard(of, random, [&](int id) -> Eigen::Vector3d {
    Eigen::Vector3d p = of.set.board.corner(id);
    p.x() *= 1 + growth * placeOf(of.set.board, id).x();
    return p;
  });
}

void misprint(FlawedSet& of, Random& random) {
  const double size = drawSize(random, 2e-5, 1e-3);
  std::vector<Eigen::Vector2d> offsets;
  for (int i = 0; i < of.set.board.numCorners(); ++i) offsets.emplace_back(size * drawNormal(random));
  photographBoard(of, random, [&](int id) -> Eigen::Vector3d {
    const Eigen::Vector2d& offset = offsets[static_cast<std::size_t>(id)];
    return of.set.board.corner(id) + Eigen::Vector3d(offset.x(), offset.y(), 0);
  });
}

// As `camera`, with focal lengths `factor` times as long and the principal point elsewhere.
AnyCamera changed(const AnyCamera& camera, double factor, const Eigen::Vector2d& shift) {
  std::vector<double> params(camera.parameters().begin(), camera.parameters().end());
  params[0] *= factor;
  params[1] *= factor;
  params[2] += shift.x();
  params[3] += shift.y();
  return AnyCamera::make(camera.modelId(), params);
}

// Each view by a camera of its own; the true one is that of the first view.
template <class CameraOf>
void photographBy(FlawedSet& of, Random& random, const CameraOf& camera_of) {
  std::vector<AnyCamera> cameras;
  for (std::size_t v = 0; v < of.set.views.size(); ++v) cameras.push_back(camera_of(v));
  photograph(of, random, [&](std::size_t v, int id) {
    return pixelAt(cameras[v], of.set.poses[v] * of.set.board.corner(id));
  });
}

void mixTwoCameras(FlawedSet& of, Random& random) {
  const AnyCamera other = changed(of.drawn.camera, 1 + drawSign(random) * drawSize(random, 1e-4, 0.05),
                                  drawSize(random, 0.1, 30) * drawDirection(random));
  photographBy(of, random, [&](std::size_t v) { return v % 2 == 0 ? of.drawn.camera : other; });
}
void zoomMidway(FlawedSet& of, Random& random) {
  const AnyCamera zoomed = changed(of.drawn.camera, 1 + drawSize(random, 1e-4, 0.05), {0, 0});
  photographBy(of, random,
               [&](std::size_t v) { return 2 * v < of.set.views.size() ? of.drawn.camera : zoomed; });
}
// Focus follows the board's distance, and the focal length the focus; far away it is the true one.
void breathe(FlawedSet& of, Random& random) {
  const double size = drawSize(random, 1e-4, 0.02);
  const double near_m = of.set.poses.front().translation.norm();
  photographBy(of, random, [&](std::size_t v) {
    return changed(of.drawn.camera, 1 + size * near_m / of.set.poses[v].translation.norm(), {0, 0});
  });
}
void stabilise(FlawedSet& of, Random& random) {
  const double size = drawSize(random, 0.05, 20);
  photographBy(of, random,
               [&](std::size_t) { return changed(of.drawn.camera, 1, size * drawNormal(random)); });
}
void swapImage(FlawedSet& of, Random& random) {
  const AnyCamera other = changed(of.drawn.camera, drawSize(random, 1.01, 1.5), {0, 0});
  photographBy(of, random, [&](std::size_t v) { return v == 3 ? other : of.drawn.camera; });
}

// The entrance pupil moves along the axis as rays come from farther off it.
void movePupil(FlawedSet& of, Random& random) {
  const double size = drawSign(random) * drawSize(random, 1e-4, 0.01);
  photographThrough(of, random, [&](std::size_t, const Eigen::Vector3d& p) -> Eigen::Vector3d {
    const double angle = std::atan2(p.head<2>().norm(), p.z());
    return p - Eigen::Vector3d(0, 0, size * angle * angle);
  });
}
// A pane of glass in front of the lens brings everything nearer, most at large angles.
void refract(FlawedSet& of, Random& random) {
  const double thickness = drawSize(random, 3e-4, 0.02);
  constexpr double kIndex = 1.5;
  photographThrough(of, random, [&](std::size_t, const Eigen::Vector3d& p) -> Eigen::Vector3d {
    const double sine = p.head<2>().norm() / p.norm();
    const double ratio = std::sqrt((1 - sine * sine) / (kIndex * kIndex - sine * sine));
    return p - Eigen::Vector3d(0, 0, thickness * (1 - ratio));
  });
}

void rollShutter(FlawedSet& of, Random& random) {
  const double size = drawSize(random, 1e-5, 5e-3);  // metres, and radians, in an image
  std::vector<SE3::Vec6> twists;
  for (std::size_t v = 0; v < of.set.views.size(); ++v) {
    SE3::Vec6& twist = twists.emplace_back();
    for (double& value : twist) value = size * random.normal();
  }
  photograph(of, random, [&](std::size_t v, int id) {
    const Eigen::Vector3d p = of.set.board.corner(id);
    auto pixel = pixelAt(of.drawn.camera, of.set.poses[v] * p);
    constexpr int kRounds = 4;
    for (int i = 0; pixel && i < kRounds; ++i) {
      const double time = pixel->y() / of.drawn.size.height - 0.5;
      pixel = pixelAt(of.drawn.camera, of.set.poses[v] * (SE3::exp(time * twists[v]) * p));
    }
    return pixel;
  });
}

// Displaces the corners that there are, by what depends on view and corner.
template <class OffsetOf>
void displace(FlawedSet& of, const OffsetOf& offset_of) {
  for (std::size_t v = 0; v < of.set.views.size(); ++v) {
    for (Corner& corner : of.set.views[v].corners) corner.pixel += offset_of(v, corner);
  }
}

// Each view by an amount that grows over the board.
void shake(FlawedSet& of, Random& random) {
  const double size = drawSize(random, 0.02, 3);
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> motions;
  for (std::size_t v = 0; v < of.set.views.size(); ++v) {
    const Eigen::Vector2d along = drawDirection(random);
    motions.emplace_back(along, size * random.normal() * drawDirection(random));
  }
  displace(of, [&](std::size_t v, const Corner& corner) -> Eigen::Vector2d {
    const double t = placeOf(of.set.board, corner.id).dot(motions[v].first);
    return t * t * motions[v].second;
  });
}
void biasAlongRadius(FlawedSet& of, Random& random) {
  const double size = drawSign(random) * drawSize(random, 0.01, 0.5);
  const Eigen::Vector2d centre(0.5 * of.drawn.size.width, 0.5 * of.drawn.size.height);
  displace(of, [&](std::size_t, const Corner& corner) -> Eigen::Vector2d {
    const Eigen::Vector2d r = (corner.pixel - centre) / centre.norm();
    return size * r.norm() * r;
  });
}
// Towards the middle of the board, as where its white margin blooms.
void biasAlongBoard(FlawedSet& of, Random& random) {
  const double size = drawSign(random) * drawSize(random, 0.01, 0.5);
  displace(of, [&](std::size_t v, const Corner& corner) -> Eigen::Vector2d {
    const auto middle = pixelAt(of.drawn.camera, of.set.poses[v] * of.set.board.middle());
    if (!middle) return {0, 0};
    const double share = placeOf(of.set.board, corner.id).squaredNorm();
    return size * share * (corner.pixel - *middle).normalized();
  });
}
void addHeavyTails(FlawedSet& of, Random& random) {
  const double size = drawSize(random, 0.5, 5) * of.noise_px;
  displace(of, [&](std::size_t, const Corner&) -> Eigen::Vector2d {  // Student's t of 2 degrees of freedom
    return size * drawNormal(random) / std::sqrt(-std::log(1 - random.uniform()));
  });
}
void addUnevenNoise(FlawedSet& of, Random& random) {
  std::vector<double> sizes;
  for (std::size_t v = 0; v < of.set.views.size(); ++v) sizes.push_back(drawSize(random, 0.01, 2));
  displace(of,
           [&](std::size_t v, const Corner&) -> Eigen::Vector2d { return sizes[v] * drawNormal(random); });
}
void addNoiseByRows(FlawedSet& of, Random& random) {
  const double size = drawSize(random, 0.02, 1);
  std::vector<Eigen::Vector2d> offsets;
  for (std::size_t i = 0; i < of.set.views.size() * static_cast<std::size_t>(of.set.board.rows); ++i)
    offsets.emplace_back(size * drawNormal(random));
  displace(of, [&](std::size_t v, const Corner& corner) {
    return offsets[v * static_cast<std::size_t>(of.set.board.rows) +
                   static_cast<std::size_t>(corner.id / of.set.board.columns)];
  });
}
void moveOutliers(FlawedSet& of, Random& random) {
  const double share = drawSize(random, 0.002, 0.1);
  const double size = drawSize(random, 1, 30);
  displace(of, [&](std::size_t, const Corner&) -> Eigen::Vector2d {
    const Eigen::Vector2d direction = drawDirection(random);
    return random.uniform() < share ? Eigen::Vector2d(size * direction) : Eigen::Vector2d(0, 0);
  });
}
void quantise(FlawedSet& of, Random& random) {
  const double step = drawSize(random, 0.05, 1);
  for (View& view : of.set.views) {
    for (Corner& corner : view.corners) corner.pixel = (corner.pixel / step).array().round().matrix() * step;
  }
}

void numberBackwards(FlawedSet& of, Random& random) {
  View& view = of.set.views[random.index(of.set.views.size())];
  for (Corner& corner : view.corners) corner.id = of.set.board.numCorners() - 1 - corner.id;
}

// Keeps the views that `isKept` of their middle, as a share of the image; at least three.
template <class IsKept>
void keepViews(FlawedSet& of, Random& random, const IsKept& isKept) {
  const std::size_t count = of.set.views.size();
  const UserSet many = drawUserViews(of.drawn, 8 * static_cast<int>(count), of.noise_px, random);
  UserSet kept{.board = many.board, .poses = {}, .views = {}};
  for (std::size_t v = 0; v < many.views.size() && kept.views.size() < count; ++v) {
    const auto middle = pixelAt(of.drawn.camera, many.poses[v] * many.board.middle());
    const Eigen::Array2d size(of.drawn.size.width, of.drawn.size.height);
    if (!middle || !isKept(Eigen::Vector2d(middle->array() / size))) continue;
    kept.views.push_back(many.views[v]);
    kept.poses.push_back(many.poses[v]);
  }
  constexpr std::size_t kFewest = 3;
  if (kept.views.size() >= kFewest) of.set = std::move(kept);
}
void keepOneHalf(FlawedSet& of, Random& random) {
  const Eigen::Vector2d towards = drawDirection(random);
  keepViews(of, random,
            [&](const Eigen::Vector2d& p) { return (p - Eigen::Vector2d(0.5, 0.5)).dot(towards) > 0.05; });
}
void keepMiddle(FlawedSet& of, Random& random) {
  const double radius = random.uniform(0.08, 0.3);
  keepViews(of, random,
            [&](const Eigen::Vector2d& p) { return (p - Eigen::Vector2d(0.5, 0.5)).norm() < radius; });
}

void keepFew(FlawedSet& of, Random& random) {
  const std::size_t count = 3 + random.index(4);
  of.set.views.resize(count);
  of.set.poses.resize(count);
}

// A film of few places.
void repeatPlaces(FlawedSet& of, Random& random) {
  const std::size_t num_places = 3 + random.index(5);
  constexpr double kStillM = 2e-4;  // a hand that holds still
  for (std::size_t v = 0; v < of.set.views.size(); ++v) {
    const std::size_t place = v % num_places;
    SE3::Vec6 tremble;
    for (double& value : tremble) value = kStillM * random.normal();
    of.set.poses[v] = of.set.poses[place] * SE3::exp(tremble);
    of.set.views[v].corners = of.set.views[place].corners;
  }
  photographBoard(of, random, [&](int id) { return of.set.board.corner(id); });
}

// Parallel to the image but for a few degrees, at the places where they were.
void facePlane(FlawedSet& of, Random& random) {
  const double tilt = random.uniform(0.01, 0.15);
  const Eigen::Vector3d middle = of.set.board.middle();
  for (SE3& pose : of.set.poses) {
    const Eigen::Vector3d place = pose * middle;
    const Eigen::Vector2d axis = tilt * random.uniform() * drawDirection(random);
    pose.rotation = SO3::exp({axis.x(), axis.y(), 0}) * SO3::exp({0, 0, random.uniform(-0.3, 0.3)});
    pose.translation = place - pose.rotation * middle;
  }
  photographBoard(of, random, [&](int id) { return of.set.board.corner(id); });
}

void stepBack(FlawedSet& of, Random& random) {
  const double factor = random.uniform(2, 6);
  for (SE3& pose : of.set.poses) pose.translation *= factor;
  photographBoard(of, random, [&](int id) { return of.set.board.corner(id); });
}

void leaveAsIs(FlawedSet&, Random&) {}

constexpr std::array<FlawKind, 34> kKinds = {{{"none", leaveAsIs},
                                              {"cylinder", bendCylinder},
                                              {"saddle", bendSaddle},
                                              {"twist", twist},
                                              {"wave", wave},
                                              {"lifted_corner", liftCorner},
                                              {"flexing", flexAlways},
                                              {"flexed_midway", flexMidway},
                                              {"stretched", stretch},
                                              {"graded", grade},
                                              {"misprint", misprint},
                                              {"two_cameras", mixTwoCameras},
                                              {"zoom_midway", zoomMidway},
                                              {"breathing", breathe},
                                              {"stabilised", stabilise},
                                              {"swapped_image", swapImage},
                                              {"entrance_pupil", movePupil},
                                              {"refraction", refract},
                                              {"rolling_shutter", rollShutter},
                                              {"shaken", shake},
                                              {"radial_bias", biasAlongRadius},
                                              {"board_bias", biasAlongBoard},
                                              {"heavy_tails", addHeavyTails},
                                              {"uneven_noise", addUnevenNoise},
                                              {"noise_by_rows", addNoiseByRows},
                                              {"outliers", moveOutliers},
                                              {"quantised", quantise},
                                              {"backwards", numberBackwards},
                                              {"one_half", keepOneHalf},
                                              {"middle", keepMiddle},
                                              {"few_views", keepFew},
                                              {"few_places", repeatPlaces},
                                              {"parallel", facePlane},
                                              {"far", stepBack}}};

}  // namespace

std::span<const FlawKind> flawKinds() {
  return kKinds;
}

FlawedSet drawFlawedSet(const FlawKind& kind, std::string_view model, std::uint64_t seed) {
  Random random(seed);
  const double fov_deg = model == "radtan" ? random.uniform(50, 90) : random.uniform(90, 135);
  FlawedSet of{
      .drawn = drawCamera(model, fov_deg, random), .set = {}, .noise_px = drawSize(random, 0.05, 0.3)};
  of.set = drawUserViews(of.drawn, 8 + static_cast<int>(random.index(23)), of.noise_px, random);
  kind.apply(of, random);
  dropOutside(of.set.views);
  constexpr std::size_t kFewest = 6;
  for (std::size_t v = of.set.views.size(); v-- > 0;) {
    if (of.set.views[v].corners.size() >= kFewest) continue;
    of.set.views.erase(of.set.views.begin() + static_cast<std::ptrdiff_t>(v));
    of.set.poses.erase(of.set.poses.begin() + static_cast<std::ptrdiff_t>(v));
  }
  return of;
}

}  // namespace alidade
