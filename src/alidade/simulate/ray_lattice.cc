// SPDX-License-Identifier: MIT
#include "alidade/simulate/ray_lattice.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

// The corners of a block, by the ends of its sides along x and y, in order around the block, so that
// neighbours are the ends of a side.
constexpr std::array<std::array<int, 2>, 4> kCorners = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

int divideUp(int a, int b) {
  return (a + b - 1) / b;
}

// Expansion from the rays at(dx, dy) of a pixel and its neighbours, dx and dy in {-1, 0, 1}.
template <class RayAt>
RayExpansion expandByDifferences(const RayAt& at) {
  RayExpansion pixel;
  pixel.has_ray = at(0, 0).has_value();
  if (!pixel.has_ray) return pixel;
  pixel.terms.col(0) = *at(0, 0);
  for (const int dy : {-1, 0, 1}) {
    for (const int dx : {-1, 0, 1}) {
      if (!at(dx, dy)) return pixel;
    }
  }
  pixel.terms.col(1) = 0.5 * (*at(1, 0) - *at(-1, 0));
  pixel.terms.col(2) = 0.5 * (*at(0, 1) - *at(0, -1));
  pixel.terms.col(3) = 0.5 * (*at(1, 0) + *at(-1, 0)) - *at(0, 0);
  pixel.terms.col(4) = 0.25 * (*at(1, 1) - *at(1, -1) - *at(-1, 1) + *at(-1, -1));
  pixel.terms.col(5) = 0.5 * (*at(0, 1) + *at(0, -1)) - *at(0, 0);
  return pixel;
}

}  // namespace

RayLattice::Basis::Basis() {
  // Chebyshev nodes keep the interpolation error uniform over the block.
  Eigen::MatrixXd vandermonde(kNumNodes, kNumNodes);
  for (int k = 0; k < kNumNodes; ++k) {
    nodes[k] = -std::cos((2 * k + 1) * std::numbers::pi / (2 * kNumNodes));
    for (int m = 0; m < kNumNodes; ++m) vandermonde(k, m) = std::pow(nodes[k], m);
  }
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(kNumNodes, kNumNodes);
  // Row k: coefficients of t^m for the weight of node k.
  const Eigen::Matrix<double, kNumNodes, kNumNodes> powers = leastSquares(vandermonde, one).transpose();
  constexpr double kPixel = 2.0 / kBlock;  // in t
  const auto weightsAt = [&](double t) -> Eigen::Matrix<double, kNumNodes, 3> {
    Eigen::Matrix<double, kNumNodes, 3> monomials;
    for (int m = 0; m < kNumNodes; ++m) {
      monomials(m, 0) = std::pow(t, m);
      monomials(m, 1) = m < 1 ? 0 : m * std::pow(t, m - 1) * kPixel;
      monomials(m, 2) = m < 2 ? 0 : 0.5 * m * (m - 1) * std::pow(t, m - 2) * kPixel * kPixel;
    }
    return powers * monomials;
  };
  at_ends << weightsAt(-1).col(0), weightsAt(1).col(0);
  for (int i = 0; i < kBlock; ++i) at_pixel[static_cast<std::size_t>(i)] = weightsAt((i + 0.5) * kPixel - 1);
}

RayLattice::RayLattice(const AnyCamera& camera, ImageSize size, int num_jobs)
    : camera_(camera), size_(size), num_blocks_x_(divideUp(size.width, kBlock)) {
  expect(size.width > 0 && size.height > 0, "an image with pixels");
  const int num_blocks_y = divideUp(size.height, kBlock);
  blocks_.resize(static_cast<std::size_t>(num_blocks_x_) * static_cast<std::size_t>(num_blocks_y));
  parallelFor(static_cast<std::size_t>(num_blocks_y), num_jobs, [&](std::size_t block_y) {
    for (int block_x = 0; block_x < num_blocks_x_; ++block_x) {
      blocks_[block_y * static_cast<std::size_t>(num_blocks_x_) + static_cast<std::size_t>(block_x)] =
          makeBlock(block_x, static_cast<int>(block_y));
    }
  });
}

RayLattice::Block RayLattice::makeBlock(int block_x, int block_y) const {
  const Eigen::Vector2d middle((block_x + 0.5) * kBlock - 0.5, (block_y + 0.5) * kBlock - 0.5);
  const auto unprojectAt = [&](double tx, double ty) {
    return camera_.unproject(middle + 0.5 * kBlock * Eigen::Vector2d(tx, ty));
  };
  Block block;
  int num_rays = 0;
  for (int ky = 0; ky < kNumNodes; ++ky) {
    for (int kx = 0; kx < kNumNodes; ++kx) {
      const auto ray = unprojectAt(basis_.nodes[kx], basis_.nodes[ky]);
      if (!ray) continue;
      block.rays[static_cast<std::size_t>(ky)].col(kx) = *ray;
      ++num_rays;
    }
  }
  std::array<Eigen::Vector3d, 4> corner_rays;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto ray = unprojectAt(2 * kCorners[i][0] - 1, 2 * kCorners[i][1] - 1);
    if (!ray) continue;
    corner_rays[i] = *ray;
    ++num_rays;
  }
  // Nodes are 0.4 pixels from the sides of the block and at most 5 pixels apart. To pass between them and
  // reach the centres of the outermost pixels (0.5 pixels inside), the edge of a domain would need a radius
  // of curvature below 25 pixels.
  if (num_rays == 0) return block;
  if (num_rays == kNumNodes * kNumNodes + 4 && matchesAt(block, corner_rays)) {
    block.kind = Block::Kind::kSmooth;
  } else {
    block.kind = Block::Kind::kRim;
    block.pixels = expandAtRim(block_x * kBlock, block_y * kBlock);
  }
  return block;
}

bool RayLattice::matchesAt(const Block& block, const std::array<Eigen::Vector3d, 4>& corner_rays) const {
  constexpr double kTolerancePx = 1e-5;
  double error = 0;
  double shortest_side = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [end_x, end_y] = kCorners[i];
    Eigen::Vector3d ray = Eigen::Vector3d::Zero();
    for (int k = 0; k < kNumNodes; ++k)
      ray += basis_.at_ends(k, end_y) * (block.rays[static_cast<std::size_t>(k)] * basis_.at_ends.col(end_x));
    error = std::max(error, (ray - corner_rays[i]).norm());
    shortest_side = std::min(shortest_side, (corner_rays[(i + 1) % 4] - corner_rays[i]).norm());
  }
  return error <= kTolerancePx * shortest_side / kBlock;
}

void RayLattice::expandRow(int y, std::vector<RayExpansion>& out) const {
  expect(y >= 0 && y < size_.height, "a row of the image");
  out.assign(static_cast<std::size_t>(size_.width), {});
  for (int block_x = 0; block_x < num_blocks_x_; ++block_x) {
    const Block& block =
        blocks_[static_cast<std::size_t>(y / kBlock) * static_cast<std::size_t>(num_blocks_x_) +
                static_cast<std::size_t>(block_x)];
    const int first_x = block_x * kBlock;
    if (block.kind == Block::Kind::kSmooth) {
      expandSmooth(block, first_x, y, out);
    } else if (block.kind == Block::Kind::kRim) {
      const auto row = block.pixels.begin() + std::ptrdiff_t{y % kBlock} * kBlock;
      std::copy_n(row, std::min(kBlock, size_.width - first_x), out.begin() + first_x);
    }
  }
}

void RayLattice::expandSmooth(const Block& block, int first_x, int y, std::vector<RayExpansion>& out) const {
  // Interpolates along y for the whole row first: the rays at the columns of the nodes and their derivatives
  // by y.
  const auto& weights_y = basis_.at_pixel[static_cast<std::size_t>(y % kBlock)];
  std::array<Eigen::Matrix<double, 3, kNumNodes>, 3> by_y;
  for (int d = 0; d < 3; ++d) {
    auto& columns = by_y[static_cast<std::size_t>(d)];
    columns.setZero();
    for (int k = 0; k < kNumNodes; ++k) {
      columns += weights_y(k, d) * block.rays[static_cast<std::size_t>(k)];
    }
  }
  const int num_pixels = std::min(kBlock, size_.width - first_x);
  for (int i = 0; i < num_pixels; ++i) {
    const auto& weights_x = basis_.at_pixel[static_cast<std::size_t>(i)];
    RayExpansion& pixel = out[static_cast<std::size_t>(first_x) + static_cast<std::size_t>(i)];
    pixel.has_ray = true;
    pixel.terms.col(0).noalias() = by_y[0] * weights_x.col(0);
    pixel.terms.col(1).noalias() = by_y[0] * weights_x.col(1);
    pixel.terms.col(2).noalias() = by_y[1] * weights_x.col(0);
    pixel.terms.col(3).noalias() = by_y[0] * weights_x.col(2);
    pixel.terms.col(4).noalias() = by_y[1] * weights_x.col(1);
    pixel.terms.col(5).noalias() = by_y[2] * weights_x.col(0);
  }
}

std::vector<RayExpansion> RayLattice::expandAtRim(int first_x, int first_y) const {
  constexpr int kSide = kBlock + 2;  // including the neighbours
  std::vector<std::optional<Eigen::Vector3d>> rays;
  rays.reserve(static_cast<std::size_t>(kSide) * kSide);
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) rays.push_back(camera_.unproject({first_x + i - 1.0, first_y + j - 1.0}));
  }
  std::vector<RayExpansion> pixels;
  pixels.reserve(static_cast<std::size_t>(kBlock) * kBlock);
  for (int j = 1; j <= kBlock; ++j) {
    for (int i = 1; i <= kBlock; ++i) {
      const auto at = [&](int dx, int dy) -> const std::optional<Eigen::Vector3d>& {
        return rays[static_cast<std::size_t>(j + dy) * kSide + static_cast<std::size_t>(i + dx)];
      };
      pixels.push_back(expandByDifferences(at));
    }
  }
  return pixels;
}

}  // namespace alidade
