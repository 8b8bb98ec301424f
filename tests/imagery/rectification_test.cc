// SPDX-License-Identifier: MIT
// Pairs of cameras of different lenses: a point has one row in both views, and comes back from its disparity.
#include "alidade/imagery/rectification.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <Eigen/Geometry>

#include "alidade/core/error.h"
#include "alidade/core/random.h"
#include "support/message_of.h"
#include "support/scratch_folder.h"

namespace alidade {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;

constexpr double kRadians = std::numbers::pi / 180;
const std::vector<double> kRadtan = {520, 522, 318, 241, -0.2, 0.05, 1e-3, -5e-4, 0};
const std::vector<double> kFisheye = {190, 191, 320, 240, 0.01, -0.003, 0.001, 0};
const std::vector<double> kDoubleSphere = {420, 421, 519, 382, -0.15, 0.6};

MountedCamera mounted(const std::string& name, std::string_view model, const std::vector<double>& params,
                      ImageSize size, const Vector3d& turn, const Vector3d& at) {
  const SE3 rig_from_camera{SO3::exp(turn), at};
  return {.name = name,
          .camera = AnyCamera::make(model, params),
          .image_size = size,
          .camera_from_rig = rig_from_camera.inverse()};
}

// Two ordinary cameras, turned against each other and against the baseline.
AnyRig ordinaryPair() {
  const std::vector<double> thin = {480, 481, 322, 239, -0.1, 0.02, 0, 1e-4, 0, 0.01, 0, 0, 1e-4, 0, 2e-4, 0};
  return AnyRig({mounted("left", "radtan", kRadtan, {640, 480}, {0.03, 0.06, -0.02}, {0.02, 0, 0}),
                 mounted("right", "thin_prism", thin, {640, 480}, {-0.01, -0.05, 0.02}, {0.22, 0.01, 0.03})});
}

// A fisheye and a camera of another model and resolution, one above the other.
AnyRig uprightPair() {
  return AnyRig(
      {mounted("above", "kannala_brandt", kFisheye, {640, 480}, {0.1, 0.02, 0.03}, {0, -0.1, 0}),
       mounted("below", "double_sphere", kDoubleSphere, {1040, 766}, {-0.1, 0, -0.04}, {0.02, 0.15, 0.01})});
}

AnyRig fisheyePair() {
  return AnyRig(
      {mounted("left", "kannala_brandt", kFisheye, {640, 480}, {0.05, 0.3, 0}, {-0.1, 0, 0}),
       mounted("right", "kannala_brandt", kFisheye, {640, 480}, {0, -0.3, 0.1}, {0.15, 0.02, 0.01})});
}

struct PairCase {
  const char* name;
  AnyRig rig;
  ViewProjection projection;
  bool is_vertical;
};

std::vector<PairCase> pairCases() {
  return {{"ordinary", ordinaryPair(), ViewProjection::kRectilinear, false},
          {"ordinary, around", ordinaryPair(), ViewProjection::kCylindrical, false},
          {"upright", uprightPair(), ViewProjection::kRectilinear, true},
          {"upright, around", uprightPair(), ViewProjection::kCylindrical, true},
          {"upright, all", uprightPair(), ViewProjection::kEquirectangular, true},
          {"fisheyes", fisheyePair(), ViewProjection::kRectilinear, false},
          {"fisheyes, around", fisheyePair(), ViewProjection::kCylindrical, false},
          {"fisheyes, all", fisheyePair(), ViewProjection::kEquirectangular, false}};
}

// The point, in the rectified frame at the first camera (metres), of a pixel of the first view whose match in
// the second is at pixel - disparity along the baseline. Nothing without a ray or at infinity or beyond.
std::optional<Vector3d> pointFromDisparity(const Rectification& r, const Vector2d& pixel, double disparity) {
  const auto ray = r.rayFromPixel(0, pixel);
  if (!ray) return std::nullopt;
  // x / z, or x / hypot(y, z) around the baseline: what differs by baseline / depth between the views.
  const auto tangentAt = [&](std::size_t view, double place) {
    const double plane = (place - r.views[view].axis_px[r.alongIndex()]) / r.scale_px;
    return r.projection == ViewProjection::kEquirectangular ? std::tan(plane) : plane;
  };
  const double place = pixel[r.alongIndex()];
  const double depth = r.baseline_m / (tangentAt(0, place) - tangentAt(1, place - disparity));
  if (!(depth > 0) || !std::isfinite(depth)) return std::nullopt;
  const double across = r.is_vertical ? ray->x() : ray->y();
  const bool is_flat = r.projection == ViewProjection::kRectilinear;
  return *ray * (depth / (is_flat ? ray->z() : std::hypot(across, ray->z())));
}

TEST(Rectification, GivesMatchesOneRowAndTheirPointFromTheDisparity) {
  Random random(5);
  int num_wide = 0;
  for (const PairCase& c : pairCases()) {
    for (const bool has_own_centres : {false, true}) {
      const Rectification r =
          rectify(c.rig, 0, 1, {.projection = c.projection, .has_own_centres = has_own_centres});
      EXPECT_EQ(r.is_vertical, c.is_vertical) << c.name;
      EXPECT_EQ(r.disparityAtInfinity() != 0, has_own_centres) << c.name;
      const Eigen::Index along = r.alongIndex();
      const SE3 rig_from_first = c.rig.camera(0).camera_from_rig.inverse();
      int num_points = 0;
      for (int i = 0; i < 2000; ++i) {
        const Vector3d point =
            Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-0.5, 1)) *
            random.uniform(0.3, 5);
        const auto pixels = c.rig.project(point);
        if (!pixels[0].ok() || !pixels[1].ok()) continue;
        std::array<std::optional<Vector2d>, 2> rectified;
        for (std::size_t k = 0; k < 2; ++k) {
          const auto ray = c.rig.camera(k).camera.unproject(pixels[k].pixel);
          if (ray) rectified[k] = r.pixelFromRay(k, r.views[k].rectified_from_camera * *ray);
        }
        if (!rectified[0] || !rectified[1]) continue;
        if (!(rectified[0]->norm() < 1e4 && rectified[1]->norm() < 1e4)) continue;
        EXPECT_NEAR((*rectified[0])[1 - along], (*rectified[1])[1 - along], 1e-7) << c.name;
        const auto found = pointFromDisparity(r, *rectified[0], (*rectified[0] - *rectified[1])[along]);
        ASSERT_TRUE(found) << c.name << " " << point.transpose();
        // From the rectified frame at the first camera to the rig.
        const Vector3d p_rig = rig_from_first * (r.views[0].rectified_from_camera.inverse() * *found);
        EXPECT_LT((p_rig - point).norm(), 1e-7 * point.norm()) << c.name;
        if ((c.rig.camera(0).camera_from_rig * point).z() < 0) ++num_wide;
        ++num_points;
      }
      EXPECT_GT(num_points, 200) << c.name;
    }
  }
  EXPECT_GT(num_wide, 200);
}

TEST(Rectification, ChangesBothViewsLeast) {
  int num_checked = 0;
  for (const PairCase& c : pairCases()) {
    const Rectification r = rectify(c.rig, 0, 1, {.projection = c.projection});
    const Vector3d axis = Vector3d::Unit(r.alongIndex());
    const auto change = [&](double angle) {
      double sum = 0;
      for (const RectifiedView& view : r.views)
        sum += ((SO3::exp(angle * axis) * view.rectified_from_camera).matrix() - Matrix3d::Identity())
                   .squaredNorm();
      return sum;
    };
    EXPECT_LT(change(0), change(1e-3)) << c.name;
    EXPECT_LT(change(0), change(-1e-3)) << c.name;
    EXPECT_NEAR(change(1e-3), change(-1e-3), 1e-9) << c.name;
    // Upright: no camera is turned by more than a right angle.
    for (const RectifiedView& view : r.views) EXPECT_LT(view.rectified_from_camera.log().norm(), 1) << c.name;
    // The frames of both are parallel, and the second camera stands where the baseline says.
    const SE3 second_from_first = c.rig.camera(1).camera_from_rig * c.rig.camera(0).camera_from_rig.inverse();
    const Vector3d at = r.views[0].rectified_from_camera * second_from_first.inverse().translation;
    EXPECT_LT((at - r.baseline_m * axis).norm(), 1e-12) << c.name;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 8);
}

TEST(Rectification, KeepsImagesUprightWhenTheCamerasAreExchanged) {
  const Rectification there = rectify(ordinaryPair(), 0, 1, {});
  const Rectification back = rectify(ordinaryPair(), 1, 0, {});
  EXPECT_GT(there.baseline_m, 0.19);
  EXPECT_DOUBLE_EQ(back.baseline_m, -there.baseline_m);
  EXPECT_LT(
      (there.views[0].rectified_from_camera.inverse() * back.views[1].rectified_from_camera).log().norm(),
      1e-12);
}

TEST(Rectification, ShowsWhatIsAskedFor) {
  int num_checked = 0;
  int num_at_limit = 0;
  int num_uncut = 0;
  for (const PairCase& c : pairCases()) {
    const ViewRequest valid{
        .projection = c.projection, .extent = ViewExtent::kValid, .size = ImageSize{320, 240}};
    const Rectification inside = rectify(c.rig, 0, 1, valid);
    std::size_t num_black = 0;
    for (std::size_t i = 0; i < 2; ++i)
      num_black += makeRemapTable(inside, i, c.rig.camera(i)).num_without_source;
    EXPECT_EQ(num_black, 0u) << c.name;
    // A view that is a hundredth larger has some, or leaves the part of the plane that views are laid out on.
    const Vector2d middle(159.5, 119.5);
    Rectification larger = inside;
    larger.scale_px *= 0.99;
    for (RectifiedView& view : larger.views) view.axis_px = middle + 0.99 * (view.axis_px - middle);
    bool is_at_limit = false;
    for (std::size_t i = 0; i < 2; ++i) {
      num_black += makeRemapTable(larger, i, c.rig.camera(i)).num_without_source;
      for (const double u : {0.0, 319.0}) {
        for (const double v : {0.0, 239.0}) {
          const auto ray = larger.rayFromPixel(i, {u, v});
          const bool is_flat = c.projection == ViewProjection::kRectilinear;
          is_at_limit = is_at_limit || (is_flat && ray->normalized().z() < std::cos(kMaxTangentAngleRad));
        }
      }
    }
    EXPECT_TRUE(num_black > 0 || is_at_limit) << c.name;
    num_at_limit += is_at_limit ? 1 : 0;

    ViewRequest all = valid;
    all.extent = ViewExtent::kAll;
    const Rectification outside = rectify(c.rig, 0, 1, all);
    double cut_share = 0;
    for (std::size_t i = 0; i < 2; ++i) {
      const MountedCamera& camera = c.rig.camera(i);
      int num_pixels = 0;
      int num_outside = 0;
      for (int y = 0; y < camera.image_size.height; y += 10) {
        for (int x = 0; x < camera.image_size.width; x += 10) {
          const auto ray = camera.camera.unproject(Vector2d(x, y));
          if (!ray) continue;
          ++num_pixels;
          const auto pixel = outside.pixelFromRay(i, outside.views[i].rectified_from_camera * *ray);
          const bool is_inside =
              pixel && (pixel->array() >= 0).all() && pixel->x() <= 319 && pixel->y() <= 239;
          num_outside += is_inside ? 0 : 1;
        }
      }
      EXPECT_GT(num_pixels, 2000) << c.name;
      cut_share = std::max(cut_share, static_cast<double>(num_outside) / num_pixels);
    }
    // The search counts on a coarser grid, and the window holds more than what it counts on.
    if (outside.cut_share == 0) {
      EXPECT_EQ(cut_share, 0) << c.name;
    } else {
      EXPECT_LT(cut_share, outside.cut_share + 0.02) << c.name;
    }
    num_uncut += cut_share == 0 ? 1 : 0;

    ViewRequest field = valid;
    field.extent = ViewExtent::kFieldOfView;
    field.horizontal_field_rad = 60 * kRadians;
    const Rectification wide = rectify(c.rig, 0, 1, field);
    const auto left = wide.rayFromPixel(0, {-0.5, 119.5});
    const auto right = wide.rayFromPixel(1, {319.5, 119.5});
    ASSERT_TRUE(left && right) << c.name;
    EXPECT_NEAR(std::acos(left->normalized().dot(right->normalized())), 60 * kRadians, 1e-9) << c.name;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 8);
  EXPECT_LE(num_at_limit, 2);  // fisheyes in rectilinear views
  EXPECT_GE(num_uncut, 4);
}

cv::Mat matrixIn(const cv::FileStorage& file, const char* name) {
  cv::Mat matrix;
  file[name] >> matrix;
  return matrix;
}

// What the file holds is what OpenCV's functions want.
TEST(Rectification, WritesWhatOpenCvReads) {
  const AnyRig rig(
      {ordinaryPair().camera(0), mounted("right", "radtan", {500, 502, 316, 244, -0.15, 0.03, 0, 1e-3, 0},
                                         {640, 480}, {0.01, -0.06, 0.01}, {0.2, 0.01, 0})});
  const Rectification r = rectify(rig, 0, 1, {.size = ImageSize{600, 420}, .has_own_centres = true});
  const cv::FileStorage file(rectificationFileText(r), cv::FileStorage::READ | cv::FileStorage::MEMORY);
  EXPECT_EQ(static_cast<std::string>(file["projection"]), "rectilinear");
  EXPECT_EQ(static_cast<double>(file["baseline_m"]), r.baseline_m);
  double worst = 0;
  int num_pixels = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto p = rig.camera(i).camera.parameters();
    const cv::Matx33d K(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
    const std::vector<double> D(p.begin() + 4, p.end());
    const std::string number = std::to_string(i + 1);
    cv::Mat x;
    cv::Mat y;
    cv::initUndistortRectifyMap(K, D, matrixIn(file, ("R" + number).c_str()),
                                matrixIn(file, ("P" + number).c_str()), {600, 420}, CV_32FC1, x, y);
    const RemapTable table = makeRemapTable(r, i, rig.camera(i));
    for (int v = 0; v < 420; ++v) {
      for (int u = 0; u < 600; ++u) {
        const SourcePixel& pixel = table.at(u, v);
        if (!pixel.exists()) continue;
        worst = std::max<double>(
            {worst, std::abs(pixel.x - x.at<float>(v, u)), std::abs(pixel.y - y.at<float>(v, u))});
        ++num_pixels;
      }
    }
  }
  EXPECT_GT(num_pixels, 300'000);
  EXPECT_LT(worst, 1e-3);  // OpenCV sums up 32-bit steps along the rows
  const cv::Mat Q = matrixIn(file, "Q");
  for (const Vector3d& point : {Vector3d(0.1, -0.2, 2), Vector3d(-1, 0.5, 4)}) {
    const Eigen::Vector4d p(point.x(), point.y(), point.z(), 1);
    const Vector3d first = r.projectionMatrix(0) * p;
    const Vector3d second = r.projectionMatrix(1) * p;
    const Vector2d pixel = first.hnormalized();
    const double disparity = pixel.x() - second.hnormalized().x();
    const cv::Mat w = Q * cv::Mat(cv::Vec4d(pixel.x(), pixel.y(), disparity, 1));
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(w.at<double>(k) / w.at<double>(3), point[k], 1e-9);
    EXPECT_LT((*pointFromDisparity(r, pixel, disparity) - point).norm(), 1e-9);
  }
  EXPECT_FALSE(pointFromDisparity(r, {300, 200}, r.disparityAtInfinity() - 1));
}

// Ours and OpenCV's choice of a common frame are alike; both give matches one row.
TEST(Rectification, ResemblesOpenCvsForAnOrdinaryPair) {
  const AnyRig rig = ordinaryPair();
  const SE3 second_from_first = rig.camera(1).camera_from_rig * rig.camera(0).camera_from_rig.inverse();
  cv::Matx33d R;
  cv::Vec3d t;
  for (int row = 0; row < 3; ++row) {
    t(row) = second_from_first.translation[row];
    for (int col = 0; col < 3; ++col) R(row, col) = second_from_first.rotation.matrix()(row, col);
  }
  cv::Matx33d R1;
  cv::Matx33d R2;
  cv::Matx34d P1;
  cv::Matx34d P2;
  cv::Matx44d Q;
  const cv::Matx33d K(520, 0, 318, 0, 522, 241, 0, 0, 1);
  cv::stereoRectify(K, cv::noArray(), K, cv::noArray(), {640, 480}, R, t, R1, R2, P1, P2, Q);
  const Rectification r = rectify(rig, 0, 1, {});
  double sum = 0;
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) {
      sum += std::pow(R1(row, col) - r.views[0].rectified_from_camera.matrix()(row, col), 2) +
             std::pow(R2(row, col) - r.views[1].rectified_from_camera.matrix()(row, col), 2);
    }
  }
  EXPECT_LT(std::sqrt(sum), 0.02);
  EXPECT_NEAR(-P2(0, 3) / P2(0, 0), r.baseline_m, 1e-12);
}

TEST(Rectification, WritesTablesThatOpenCvReads) {
  const ScratchFolder scratch;
  const AnyRig rig = ordinaryPair();
  const Rectification r = rectify(rig, 0, 1, {.extent = ViewExtent::kAll, .size = ImageSize{200, 150}});
  const RemapTable table = makeRemapTable(r, 0, rig.camera(0));
  ASSERT_GT(table.num_without_source, 0u);
  writeRemapTable(table, scratch.path("x.tiff"), scratch.path("y.tiff"));
  const cv::Mat x = cv::imread(scratch.path("x.tiff"), cv::IMREAD_UNCHANGED);
  const cv::Mat y = cv::imread(scratch.path("y.tiff"), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(x.type(), CV_32FC1);
  ASSERT_EQ(y.size(), cv::Size(200, 150));
  int num_same = 0;
  for (int v = 0; v < 150; ++v) {
    for (int u = 0; u < 200; ++u) {
      const SourcePixel pixel = table.at(u, v).exists() ? table.at(u, v) : SourcePixel{-10, -10};
      num_same += x.at<float>(v, u) == pixel.x && y.at<float>(v, u) == pixel.y ? 1 : 0;
    }
  }
  EXPECT_EQ(num_same, 200 * 150);
}

TEST(Rectification, MeasuresEpipolarErrors) {
  Random random(31);
  int num_checked = 0;
  for (const PairCase& c : pairCases()) {
    const Rectification r = rectify(c.rig, 0, 1, {.projection = c.projection});
    std::vector<EpipolarPair> exact;
    std::vector<EpipolarPair> noisy;
    while (exact.size() < 4000) {
      const Vector3d point(random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), random.uniform(1, 3));
      const auto pixels = c.rig.project(point);
      if (!pixels[0].ok() || !pixels[1].ok()) continue;
      exact.push_back({pixels[0].pixel, pixels[1].pixel});
      noisy.push_back(exact.back());
      for (Vector2d& pixel : noisy.back()) pixel += 0.2 * Vector2d(random.normal(), random.normal());
    }
    const EpipolarErrors none = epipolarErrors(r, c.rig.camera(0), c.rig.camera(1), exact);
    EXPECT_EQ(none.num_pairs, exact.size());
    EXPECT_LE(none.num_shown, exact.size());
    EXPECT_GT(none.num_shown, 1000u) << c.name;
    EXPECT_LT(none.curve_rms_px, 1e-7) << c.name;
    EXPECT_LT(none.row_max_px, 1e-7) << c.name;
    const EpipolarErrors some = epipolarErrors(r, c.rig.camera(0), c.rig.camera(1), noisy);
    // Against a curve counts the noise across it, of this pixel and of the other by way of its own curve.
    EXPECT_GT(some.curve_rms_px, 0.2) << c.name;
    EXPECT_LT(some.curve_rms_px, 0.6) << c.name;
    EXPECT_GT(some.row_rms_px, 0.1) << c.name;
    EXPECT_LT(std::abs(some.row_mean_px), 0.05) << c.name;
    EXPECT_GT(some.row_max_px, 2 * some.row_rms_px) << c.name;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 8);
  // Where rows are rows from the start, a pixel moved down is that far from its curve.
  const std::vector<double> pinhole = {500, 500, 320, 240};
  const AnyRig plain({mounted("left", "pinhole", pinhole, {640, 480}, {0, 0, 0}, {0, 0, 0}),
                      mounted("right", "pinhole", pinhole, {640, 480}, {0, 0, 0}, {0.1, 0, 0})});
  const Rectification r = rectify(plain, 0, 1, {});
  const EpipolarErrors errors =
      epipolarErrors(r, plain.camera(0), plain.camera(1),
                     std::vector{EpipolarPair{Vector2d(300, 200), Vector2d(280, 200.5)}});
  EXPECT_NEAR(errors.curve_rms_px, 0.5, 1e-6);
  EXPECT_NEAR(errors.row_mean_px, -0.5, 1e-9);
}

TEST(Rectification, RefusesPairsWithoutACommonView) {
  const auto camera = [](const std::string& name, const Vector3d& turn, const Vector3d& at) {
    return mounted(name, "radtan", kRadtan, {640, 480}, turn, at);
  };
  const Vector3d none = Vector3d::Zero();
  const auto pair = [&](const Vector3d& turn, const Vector3d& at) {
    return AnyRig({camera("a", none, none), camera("b", turn, at)});
  };
  EXPECT_THAT(messageOf([&] { (void)rectify(pair(none, none), 0, 1, {}); }), HasSubstr("same place"));
  EXPECT_THAT(messageOf([&] {
                (void)rectify(pair(none, {0.01, 0, 0.5}), 0, 1, {});
              }),
              AllOf(HasSubstr("'a' and 'b'"), HasSubstr("rig triangulate")));
  const AnyRig crossing = pair({0, -1.2, 0}, {0.5, 0, 0.3});
  EXPECT_THAT(messageOf([&] { (void)rectify(crossing, 0, 1, {.extent = ViewExtent::kValid}); }),
              HasSubstr("--own-centres"));
  EXPECT_GT(rectify(crossing, 0, 1, {.extent = ViewExtent::kValid, .has_own_centres = true}).scale_px, 0);
  int num_refused = 0;
  for (const double degrees : {0.0, -1.0, 151.0, std::nan("")}) {
    try {
      (void)rectify(ordinaryPair(), 0, 1,
                    {.extent = ViewExtent::kFieldOfView, .horizontal_field_rad = degrees * kRadians});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
      ++num_refused;
    }
  }
  EXPECT_EQ(num_refused, 4);
  EXPECT_THROW((void)rectify(ordinaryPair(), 0, 0, {}), Error);
}

}  // namespace
}  // namespace alidade
