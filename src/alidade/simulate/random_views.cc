// SPDX-License-Identifier: MIT
#include "alidade/simulate/random_views.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include <Eigen/Geometry>

#include "alidade/camera/batch.h"
#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

constexpr double kFillReduction = 0.8;
constexpr double kRadPerDeg = std::numbers::pi / 180;

class ViewSampler {
 public:
  ViewSampler(const AnyCamera& camera, ImageSize size, const Board& board, const RandomViewOptions& options)
      : camera_(camera), size_(size), board_(board), options_(options) {
    for (int j = -1; j <= board.rows(); ++j) {
      for (int i = -1; i <= board.columns(); ++i) {
        const Eigen::Vector2d share((i + 1.0) / (board.columns() + 1), (j + 1.0) / (board.rows() + 1));
        const Eigen::Vector2d point = board.printed().min() + share.cwiseProduct(board.printed().sizes());
        points_board_.emplace_back(point.x(), point.y(), 0);
      }
    }
    middle_ = board.middle();
    for (Eigen::Vector3d& point : points_board_) point -= middle_;
    points_camera_.resize(points_board_.size());
    projections_.resize(points_board_.size());
  }

  // One placement with the given fill; nothing if it does not fit into the image.
  [[nodiscard]] std::optional<SE3> tryView(double fill, Random& random) {
    const double x = random.uniform(-0.5, size_.width - 0.5);
    const double y = random.uniform(-0.5, size_.height - 0.5);
    const SO3 tilt_and_roll = drawTiltAndRoll(random);
    const auto ray = camera_.unproject({x, y});
    if (!ray) return std::nullopt;
    const auto facing = SO3::fromQuaternion(shortestTurn(Eigen::Vector3d::UnitZ(), *ray));
    const SO3 camera_from_board = facing * tilt_and_roll;
    const auto distance = nearestDistance(camera_from_board, *ray, fill);
    if (!distance) return std::nullopt;
    const auto extent = project({camera_from_board, *distance * *ray});
    const Eigen::Array2d low = Eigen::Array2d::Constant(options_.margin_px - 0.5);
    const Eigen::Array2d high(size_.width - 0.5 - options_.margin_px,
                              size_.height - 0.5 - options_.margin_px);
    if (!extent || !(extent->min().array() >= low && extent->max().array() < high).all()) return std::nullopt;
    return SE3{camera_from_board, *distance * *ray - camera_from_board * middle_};
  }

 private:
  [[nodiscard]] SO3 drawTiltAndRoll(Random& random) const {
    const double tilt = options_.max_tilt_deg * kRadPerDeg * std::sqrt(random.uniform());
    const double azimuth = random.uniform(0, 2 * std::numbers::pi);
    const double roll = options_.max_roll_deg * kRadPerDeg * random.uniform(-1, 1);
    return SO3::exp(tilt * Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0)) * SO3::exp({0, 0, roll});
  }

  // The smallest box around all corners of squares in the image; nothing if one of them has no pixel.
  [[nodiscard]] std::optional<Eigen::AlignedBox2d> project(const SE3& camera_from_middle) {
    for (std::size_t i = 0; i < points_board_.size(); ++i) {
      points_camera_[i] = camera_from_middle * points_board_[i];
    }
    projectBatch(camera_, points_camera_, projections_);
    Eigen::AlignedBox2d extent;
    for (const Projection& projection : projections_) {
      if (!projection.ok()) return std::nullopt;
      extent.extend(projection.pixel);
    }
    return extent;
  }

  // The distance along `ray` at which the board spans `fill`. Closer boards span more or do not project.
  [[nodiscard]] std::optional<double> nearestDistance(const SO3& camera_from_board,
                                                      const Eigen::Vector3d& ray, double fill) {
    const auto isFarEnough = [&](double distance) {
      const auto extent = project({camera_from_board, distance * ray});
      return extent &&
             extent->sizes().cwiseQuotient(Eigen::Vector2d(size_.width, size_.height)).maxCoeff() <= fill;
    };
    constexpr int kMaxDoublings = 60;
    double far = board_.spacing();
    int num_doublings = 0;
    while (!isFarEnough(far)) {
      if (++num_doublings > kMaxDoublings) return std::nullopt;
      far *= 2;
    }
    double near = num_doublings == 0 ? 0 : 0.5 * far;
    constexpr int kNumBisections = 20;
    for (int i = 0; i < kNumBisections; ++i) {
      const double middle = 0.5 * (near + far);
      (isFarEnough(middle) ? far : near) = middle;
    }
    return far;
  }

  const AnyCamera& camera_;
  ImageSize size_;
  Board board_;
  RandomViewOptions options_;
  Eigen::Vector3d middle_;                      // of the squares, in the board frame
  std::vector<Eigen::Vector3d> points_board_;   // all corners of squares, relative to the middle
  std::vector<Eigen::Vector3d> points_camera_;  // of the last projection, like the next member
  std::vector<Projection> projections_;
};

}  // namespace

std::vector<SE3> randomViews(const AnyCamera& camera, ImageSize size, const Board& board, int count,
                             Random& random, const RandomViewOptions& options) {
  options.validate();
  expect(count >= 0, "a number of views that is not negative");
  expect(size.width > 0 && size.height > 0, "an image with pixels");
  expect(board.numCorners() > 0 && board.spacing() > 0, "a board with corners");
  ViewSampler sampler(camera, size, board, options);
  std::vector<SE3> poses;
  for (int i = 0; i < count; ++i) {
    std::optional<SE3> pose;
    double fill = random.uniform(options.min_fill, options.max_fill);
    for (; !pose && fill >= RandomViewOptions::kSmallestFill; fill *= kFillReduction) {
      for (int k = 0; !pose && k < options.max_attempts; ++k) pose = sampler.tryView(fill, random);
    }
    if (!pose) {
      throw inputError({.where = "view " + std::to_string(i + 1) + " of " + std::to_string(count),
                        .found = "no pose shows the whole board inside an image of " +
                                 std::to_string(size.width) + "x" + std::to_string(size.height) +
                                 " pixels with a margin of " + exactText(options.margin_px),
                        .next_step = "check the principal point and the focal length against the image size, "
                                     "or reduce margin_px or max_tilt_deg"});
    }
    poses.push_back(*pose);
  }
  return poses;
}

}  // namespace alidade
