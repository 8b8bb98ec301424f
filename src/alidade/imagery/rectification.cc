// SPDX-License-Identifier: MIT
#include "alidade/imagery/rectification.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <opencv2/core/eigen.hpp>

#include "alidade/camera/triangulation.h"
#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/geometry/rotation_conversions.h"
#include "alidade/imagery/image_codecs.h"
#include "alidade/imagery/view_search.h"

namespace alidade {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

// Cylindrical views have y as their axis; x and y are swapped if the baseline is x. Rectilinear views have no
// axis.
bool isSwapped(const Rectification& r) {
  return r.projection != ViewProjection::kRectilinear && !r.is_vertical;
}

Vector3d inViewOrder(const Rectification& r, const Vector3d& ray) {
  return isSwapped(r) ? Vector3d(ray.y(), ray.x(), ray.z()) : ray;
}
Vector2d inViewOrder(const Rectification& r, const Vector2d& plane) {
  return isSwapped(r) ? Vector2d(plane.reverse()) : plane;
}

std::optional<Vector3d> rayOf(const Rectification& r, const Vector2d& plane) {
  const auto ray = rayFromPlane(r.projection, inViewOrder(r, plane));
  return ray ? std::optional(inViewOrder(r, *ray)) : std::nullopt;
}

// Place on the plane; nothing beyond the limits of views.
std::optional<Vector2d> planeOf(const Rectification& r, const Vector3d& ray) {
  const auto plane = planeFromRay(r.projection, inViewOrder(r, ray));
  if (!plane || !detail::isLaidOut(r.projection, *plane)) return std::nullopt;
  return inViewOrder(r, *plane);
}

using CameraPair = std::array<const MountedCamera*, 2>;

Matrix3d rotationFromRig(const MountedCamera& camera) {
  return camera.camera_from_rig.rotation.matrix();
}

std::string cameraNames(const CameraPair& cameras) {
  return "cameras '" + cameras[0]->name + "' and '" + cameras[1]->name + "'";
}

// Sets the common orientation; its rows are its axes in the rig's frame.
void orient(const CameraPair& cameras, Rectification& r) {
  const Vector3d baseline =
      cameras[1]->camera_from_rig.inverse().translation - cameras[0]->camera_from_rig.inverse().translation;
  constexpr double kNoBaseline = 1e-9;
  if (!(baseline.norm() > kNoBaseline)) {
    throw inputError({.where = cameraNames(cameras),
                      .found = "both are at the same place",
                      .expected = "cameras some distance apart"});
  }
  // The rows are the sums of both cameras' axes.
  const Matrix3d sum = rotationFromRig(*cameras[0]) + rotationFromRig(*cameras[1]);
  const Vector3d along = baseline.normalized();
  r.is_vertical = std::abs(sum.row(1).dot(along)) > std::abs(sum.row(0).dot(along));
  const Eigen::Index axis = r.is_vertical ? 1 : 0;
  const double sign = sum.row(axis).dot(along) < 0 ? -1 : 1;
  r.baseline_m = sign * baseline.norm();
  // The rotation about the baseline with the smallest sum of squared differences from both cameras: it
  // maximises the sum over the other two axes. (next, last, axis) is right-handed.
  const Vector3d fixed = sign * along;
  const Vector3d p = fixed.unitOrthogonal();
  const Vector3d q = fixed.cross(p);
  const Vector3d next = sum.row((axis + 1) % 3).transpose();
  const Vector3d last = sum.row((axis + 2) % 3).transpose();
  // With next = cos p + sin q and last = fixed x next = cos q - sin p.
  const double angle = std::atan2(next.dot(q) - last.dot(p), next.dot(p) + last.dot(q));
  Matrix3d rectified_from_rig;
  rectified_from_rig.row(axis) = fixed.transpose();
  rectified_from_rig.row((axis + 1) % 3) = (std::cos(angle) * p + std::sin(angle) * q).transpose();
  rectified_from_rig.row((axis + 2) % 3) = (std::cos(angle) * q - std::sin(angle) * p).transpose();
  for (std::size_t i = 0; i < 2; ++i) {
    r.views[i].rectified_from_camera =
        rotationFromMatrix(rectified_from_rig) * cameras[i]->camera_from_rig.rotation.inverse();
    const double turn =
        std::acos(std::clamp((r.views[i].rectified_from_camera * Vector3d(0, 0, 1)).z(), -1.0, 1.0));
    if (r.projection != ViewProjection::kRectilinear || turn <= kMaxTangentAngleRad) continue;
    throw inputError(
        {.where = cameraNames(cameras),
         .found = "the axis of camera '" + cameras[i]->name + "' is " +
                  std::to_string(std::lround(turn * kDegreesPerRadian)) +
                  " degrees from the common one, which is normal to the line through both cameras",
         .expected =
             "at most " + std::to_string(std::lround(kMaxTangentAngleRad * kDegreesPerRadian)) + " degrees",
         .next_step = "use the equirectangular projection, or points instead: alidade rig triangulate"});
  }
}

// Pixels per radian on the axis of the camera: the geometric mean of both directions.
double scaleOnAxis(const MountedCamera& camera) {
  const auto [pixel, focal] = detail::axisOf(camera.camera, "camera '" + camera.name + "'",
                                             "give the field of view with --fov, or use --keep all");
  return std::sqrt(focal.x() * focal.y());
}

double scaleOfField(const Rectification& r, double field_rad) {
  // Along the baseline, a cylindrical view is as flat as a rectilinear one, and an equirectangular one ends
  // at the baseline.
  const bool is_flat = r.projection == ViewProjection::kRectilinear ||
                       (r.projection == ViewProjection::kCylindrical && !r.is_vertical);
  const bool ends_at_pole = r.projection == ViewProjection::kEquirectangular && !r.is_vertical;
  const double largest = is_flat ? 2 * kMaxTangentAngleRad : (ends_at_pole ? 1 : 2) * std::numbers::pi;
  return 0.5 * r.size.width /
         detail::halfWidthOf(field_rad, is_flat, largest,
                             "more than 0 and at most " +
                                 std::to_string(std::lround(largest * kDegreesPerRadian)) + " degrees in " +
                                 std::string(projectionName(r.projection)) + " views",
                             "use the equirectangular projection for a larger field of view");
}

// Place of each image centre on the plane, or of its axis if the centre has no ray there.
std::array<Vector2d, 2> centresOf(const Rectification& r, const CameraPair& cameras) {
  std::array<Vector2d, 2> centres;
  for (std::size_t i = 0; i < 2; ++i) {
    const SO3& turn = r.views[i].rectified_from_camera;
    const auto ray = cameras[i]->camera.unproject(detail::middleOf(cameras[i]->image_size));
    auto plane = ray ? planeOf(r, turn * *ray) : std::nullopt;
    if (!plane) plane = planeOf(r, turn * Vector3d(0, 0, 1));
    centres[i] = plane.value_or(Vector2d::Zero());
  }
  return centres;
}

// Chooses the scale at which the views show all. @returns their middles on the plane
std::array<Vector2d, 2> showAll(const CameraPair& cameras, bool has_own_centres, Rectification& r) {
  const Eigen::Index along = r.alongIndex();
  std::array<Eigen::AlignedBox2d, 2> boxes;
  Eigen::AlignedBox2d both;
  for (std::size_t i = 0; i < 2; ++i) {
    const SO3& turn = r.views[i].rectified_from_camera;
    // The search expects jumps in the first coordinate, the longitude.
    const detail::PlaneBox box =
        detail::boxOfAll(cameras[i]->camera, cameras[i]->image_size, [&](const Vector3d& ray) {
          const auto plane = planeOf(r, turn * ray);
          return plane ? std::optional(inViewOrder(r, *plane)) : std::nullopt;
        });
    if (!(box.shown.sizes().minCoeff() > 0)) {
      throw inputError({.where = "camera '" + cameras[i]->name + "'",
                        .found = "almost no pixel with a ray that this projection can show",
                        .expected = "a camera that looks at right angles to the line through both",
                        .next_step = "use --projection equirectangular"});
    }
    boxes[i] = {inViewOrder(r, box.shown.min()), inViewOrder(r, box.shown.max())};
    both.extend(boxes[i]);
    r.cut_share = std::max(r.cut_share, static_cast<double>(box.num_cut) / (box.num_shown + box.num_cut));
  }
  Vector2d extent = both.sizes();
  std::array<Vector2d, 2> middles = {both.center(), both.center()};
  if (has_own_centres) {
    extent[along] = std::max(boxes[0].sizes()[along], boxes[1].sizes()[along]);
    for (std::size_t i = 0; i < 2; ++i) middles[i][along] = boxes[i].center()[along];
  }
  r.scale_px = detail::scaleOfAll(r.size, extent);
  return middles;
}

void showValid(const CameraPair& cameras, const std::array<Vector2d, 2>& middles, Rectification& r) {
  const auto has_source = [&](const Vector2d& offset) {
    for (std::size_t i = 0; i < 2; ++i) {
      const Vector2d plane = middles[i] + offset;
      if (!detail::isLaidOut(r.projection, inViewOrder(r, plane))) return false;
      const auto ray = rayOf(r, plane);
      if (!ray) return false;
      const Projection source = cameras[i]->camera.project(r.views[i].rectified_from_camera.inverse() * *ray);
      if (!source.ok() || !detail::isBetweenPixelCentres(source.pixel, cameras[i]->image_size)) return false;
    }
    return true;
  };
  if (!has_source(Vector2d::Zero())) {
    throw inputError(
        {.where = cameraNames(cameras),
         .found = "no common view: what is in the middle of one is outside the image of the other",
         .expected = "cameras that see the same distant things",
         .next_step = "use --own-centres for cameras that look towards each other, or --keep all"});
  }
  const double limit = 2 * detail::farthestMultiple(r.projection, inViewOrder(r, detail::middleOf(r.size)));
  constexpr double kMargin = 1e-9;  // for rounding of pixel positions
  r.scale_px = (1 + kMargin) / detail::largestWindow(detail::borderOffsets(r.size), limit, has_source);
}

// Pixel in the rectified image; nothing outside the image.
std::optional<Vector2d> shownPixel(const Rectification& r, std::size_t i, const Vector3d& ray) {
  const auto pixel = r.pixelFromRay(i, ray);
  const Vector2d size(r.size.width, r.size.height);
  if (!pixel || !(pixel->array() >= -0.5).all() || !(pixel->array() < size.array() - 0.5).all())
    return std::nullopt;
  return pixel;
}

cv::Mat matOf(const Eigen::MatrixXd& matrix) {
  cv::Mat mat;
  cv::eigen2cv(matrix, mat);
  return mat;
}

}  // namespace

std::optional<Vector3d> Rectification::rayFromPixel(std::size_t i, const Vector2d& pixel) const {
  return rayOf(*this, (pixel - views.at(i).axis_px) / scale_px);
}

std::optional<Vector2d> Rectification::pixelFromRay(std::size_t i, const Vector3d& ray) const {
  const auto plane = planeFromRay(projection, inViewOrder(*this, ray));
  if (!plane) return std::nullopt;
  return views.at(i).axis_px + scale_px * inViewOrder(*this, *plane);
}

Eigen::Matrix<double, 3, 4> Rectification::projectionMatrix(std::size_t i) const {
  expect(projection == ViewProjection::kRectilinear, "only rectilinear views have a projection matrix");
  Eigen::Matrix<double, 3, 4> P = Eigen::Matrix<double, 3, 4>::Zero();
  P(0, 0) = P(1, 1) = scale_px;
  P.block<2, 1>(0, 2) = views.at(i).axis_px;
  P(2, 2) = 1;
  if (i == 1) P(alongIndex(), 3) = -scale_px * baseline_m;
  return P;
}

Eigen::Matrix4d Rectification::disparityToDepth() const {
  expect(projection == ViewProjection::kRectilinear, "only rectilinear views have such a matrix");
  Eigen::Matrix4d Q = Eigen::Matrix4d::Zero();
  Q(0, 0) = Q(1, 1) = 1;
  Q.block<2, 1>(0, 3) = -views[0].axis_px;
  Q(2, 3) = scale_px;
  Q(3, 2) = 1 / baseline_m;
  Q(3, 3) = (0 - disparityAtInfinity()) / baseline_m;  // no -0
  return Q;
}

AnyCamera Rectification::pinhole(std::size_t i) const {
  expect(projection == ViewProjection::kRectilinear, "only rectilinear views are a pinhole camera's");
  return pinholeOf({.projection = projection,
                    .size = size,
                    .scale_px = Vector2d::Constant(scale_px),
                    .axis_px = views.at(i).axis_px});
}

Rectification rectify(const AnyRig& rig, std::size_t first, std::size_t second, const ViewRequest& request) {
  if (first == second) {
    throw usageError({.where = "rectification",
                      .found = "camera '" + rig.camera(first).name + "' twice",
                      .expected = "two different cameras"});
  }
  const CameraPair cameras = {&rig.camera(first), &rig.camera(second)};
  Rectification r;
  r.projection = request.projection;
  r.size = request.size.value_or(cameras[0]->image_size);
  for (const MountedCamera* camera : cameras) detail::checkViewSizes(camera->image_size, r.size);
  orient(cameras, r);
  std::array<Vector2d, 2> middles = request.extent == ViewExtent::kAll
                                        ? showAll(cameras, request.has_own_centres, r)
                                        : centresOf(r, cameras);
  if (request.extent != ViewExtent::kAll) {
    const Vector2d mean = 0.5 * (middles[0] + middles[1]);
    for (Vector2d& middle : middles) {
      const double own = middle[r.alongIndex()];
      middle = mean;
      if (request.has_own_centres) middle[r.alongIndex()] = own;
    }
  }
  if (request.extent == ViewExtent::kValid) {
    showValid(cameras, middles, r);
  } else if (request.extent == ViewExtent::kFieldOfView) {
    r.scale_px = scaleOfField(r, request.horizontal_field_rad);
    if (!request.has_own_centres) middles.fill(Vector2d::Zero());
  } else if (request.extent == ViewExtent::kSameScale) {
    const double resize = static_cast<double>(r.size.width) / cameras[0]->image_size.width;
    r.scale_px = resize * std::sqrt(scaleOnAxis(*cameras[0]) * scaleOnAxis(*cameras[1]));
  }
  for (std::size_t i = 0; i < 2; ++i) r.views[i].axis_px = detail::middleOf(r.size) - r.scale_px * middles[i];
  return r;
}

RemapTable makeRemapTable(const Rectification& rectification, std::size_t i, const MountedCamera& camera,
                          int num_jobs, const CancelFlag* cancel) {
  const SO3 camera_from_rectified = rectification.views.at(i).rectified_from_camera.inverse();
  const auto rays_of = [&](std::size_t row, const RayColumns& rays) {
    for (std::size_t u = 0; u < rays.x.size(); ++u) {
      auto ray = rectification.rayFromPixel(i, Vector2d(u, row));
      if (ray) ray = camera_from_rectified * *ray;
      rays.set(u, ray);
    }
  };
  return makeRemapTable(camera.camera, camera.image_size, rectification.size, rays_of, num_jobs, cancel);
}

EpipolarErrors epipolarErrors(const Rectification& rectification, const MountedCamera& first,
                              const MountedCamera& second, std::span<const EpipolarPair> pairs) {
  const Eigen::Index across = 1 - rectification.alongIndex();
  EpipolarErrors errors;
  double curve_sum = 0;
  double row_sum = 0;
  for (const EpipolarPair& pair : pairs) {
    const auto first_ray = first.camera.unproject(pair[0]);
    const auto second_ray = second.camera.unproject(pair[1]);
    if (!first_ray || !second_ray) continue;
    const std::array<Vector3d, 2> rays = {rectification.views[0].rectified_from_camera * *first_ray,
                                          rectification.views[1].rectified_from_camera * *second_ray};
    const auto distance = epipolarDistance(first, second, pair[0], pair[1]);
    if (!distance) continue;
    curve_sum += *distance * *distance;
    ++errors.num_pairs;
    const auto first_pixel = shownPixel(rectification, 0, rays[0]);
    const auto second_pixel = shownPixel(rectification, 1, rays[1]);
    if (!first_pixel || !second_pixel) continue;
    const double row = (*first_pixel)[across] - (*second_pixel)[across];
    row_sum += row * row;
    errors.row_mean_px += row;
    errors.row_max_px = std::max(errors.row_max_px, std::abs(row));
    ++errors.num_shown;
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, errors.num_shown));
  errors.curve_rms_px =
      std::sqrt(curve_sum / static_cast<double>(std::max<std::size_t>(1, errors.num_pairs)));
  errors.row_rms_px = std::sqrt(row_sum / count);
  errors.row_mean_px /= count;
  return errors;
}

std::string rectificationFileText(const Rectification& rectification) {
  cv::FileStorage file(".yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  file << "projection" << std::string(projectionName(rectification.projection));
  file << "direction" << (rectification.is_vertical ? "vertical" : "horizontal");
  file << "image_width" << rectification.size.width << "image_height" << rectification.size.height;
  file << "scale_px" << rectification.scale_px << "baseline_m" << rectification.baseline_m;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string number = std::to_string(i + 1);
    file << "axis" + number << matOf(rectification.views[i].axis_px);
    file << "R" + number << matOf(rectification.views[i].rectified_from_camera.matrix());
    if (rectification.projection == ViewProjection::kRectilinear)
      file << "P" + number << matOf(rectification.projectionMatrix(i));
  }
  if (rectification.projection == ViewProjection::kRectilinear)
    file << "Q" << matOf(rectification.disparityToDepth());
  return file.releaseAndGetString();
}

void writeRemapTable(const RemapTable& table, const std::string& x_path, const std::string& y_path) {
  constexpr float kNoSource = -10;
  for (const bool is_x : {true, false}) {
    cv::Mat map(table.size.height, table.size.width, CV_32F);
    for (int y = 0; y < map.rows; ++y) {
      for (int x = 0; x < map.cols; ++x) {
        const SourcePixel& pixel = table.at(x, y);
        map.at<float>(y, x) = !pixel.exists() ? kNoSource : is_x ? pixel.x : pixel.y;
      }
    }
    std::vector<std::uint8_t> bytes;
    expect(encodeImage(".tiff", map, bytes), "OpenCV writes TIFF files of floats");
    writeFileAtomically(is_x ? x_path : y_path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
}

}  // namespace alidade
