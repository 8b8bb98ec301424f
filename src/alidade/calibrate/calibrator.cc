// SPDX-License-Identifier: MIT
#include "alidade/calibrate/calibrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "alidade/calibrate/corner_noise.h"
#include "alidade/calibrate/covariance.h"
#include "alidade/calibrate/leverage.h"
#include "alidade/calibrate/local_sigma.h"
#include "alidade/calibrate/start.h"
#include "alidade/camera/model_list.h"
#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/init/pose_from_homography.h"

namespace alidade {
namespace {

// Huber's threshold in standard deviations of a coordinate: 1.1 % of clean corners lie beyond it.
constexpr double kLossSigmas = 3.0;
// Beyond this many standard deviations a corner is not noise (chance 1e-14) and is left out by name.
constexpr double kOutlierSigmas = 8.0;
constexpr int kMaxRounds = 10;
// Weights that have not come to rest by then are kept: any weights give an unbiased estimate.
constexpr int kMaxWeightRounds = 6;
constexpr std::size_t kMinCornersPerView = 6;

using Observations = std::vector<std::vector<Observation>>;
using Errors = std::vector<std::vector<Eigen::Vector2d>>;

void checkView(const Checkerboard& board, const View& view, ImageSize size) {
  if (view.size != size) {
    throw inputError({.where = view.image,
                      .found = "an image of " + sizeText(view.size),
                      .expected = sizeText(size) + " as in the other views",
                      .next_step = "calibrate images of one size at a time"});
  }
  for (const Corner& corner : view.corners) {
    if (corner.id < 0 || corner.id >= board.numCorners()) {
      throw inputError(
          {.where = view.image,
           .found = "corner id " + std::to_string(corner.id),
           .expected = "0 to " + std::to_string(board.numCorners() - 1) + " on " + specText(board)});
    }
    if (corner.sigma_px < 0) {
      throw inputError({.where = view.image,
                        .found = "corner " + std::to_string(corner.id) + " with a negative sigma",
                        .expected = "a standard deviation in pixels, or NaN where it is unknown"});
    }
    if (corner.pixel.allFinite()) continue;
    throw inputError(
        {.where = view.image,
         .found = "corner " + std::to_string(corner.id) + " with a position that is not a number",
         .expected = "finite pixel coordinates"});
  }
}

void prepare(const Checkerboard& board, std::vector<View>& views) {
  if (views.size() < kMinViews) {
    throw inputError(
        {.where = "calibration",
         .found = std::to_string(views.size()) + " view" + (views.size() == 1 ? "" : "s") + " of the board",
         .expected = "at least " + std::to_string(kMinViews),
         .next_step =
             "take more photographs of the whole board, tilted by 20 to 50 degrees, all over the image"});
  }
  std::sort(views.begin(), views.end(),
            [](const View& a, const View& b) { return naturalLess(a.image, b.image); });
  for (View& view : views) {
    checkView(board, view, views.front().size);
    std::sort(view.corners.begin(), view.corners.end(),
              [](const Corner& a, const Corner& b) { return a.id < b.id; });
  }
  const auto twin = std::adjacent_find(views.begin(), views.end(),
                                       [](const View& a, const View& b) { return a.image == b.image; });
  if (twin == views.end()) return;
  throw inputError(
      {.where = twin->image, .found = "two views with this name", .expected = "one view an image"});
}

// The model that contains `model` and comes next after it in size, or nothing.
template <CameraModel... Models>
std::optional<std::string> nextLargerModel(ModelList<Models...>, std::string_view model) {
  const std::array<std::string_view, sizeof...(Models)> ids = {Models::kId...};
  const auto here = std::find(ids.begin(), ids.end(), model);
  if (here == ids.end() || here + 1 == ids.end()) return std::nullopt;
  return std::string(*(here + 1));
}

// The whole estimation: state that the steps below hand on.
class Estimator {
 public:
  Estimator(const Checkerboard& board, std::vector<View> views, const CalibratorOptions& options)
      : board_(board), views_(std::move(views)), options_(options) {}

  CalibrationResult run() {
    start();
    solveRobustly();
    leaveOutOutliers();
    return result();
  }

  // After run(): the next larger model, if it says beyond doubt that this one lacks something. It is solved
  // from this one's answer, on the same corners and with the same loss, so that the two costs compare.
  [[nodiscard]] std::optional<BetterModel> betterModel() const {
    const auto id = nextLargerModel(NestedModels{}, options_.model);
    if (!id || summary_.termination == Termination::kFailed) return std::nullopt;
    BundleState larger = state_;
    larger.params = enlargedParameters(*id);
    // A few steps tell whether there is anything to gain; most often there is not.
    constexpr int kGlance = 5;
    const BundleSummary glance = solveLarger(*id, larger, kGlance);
    if (!isGain(glance.cost, larger.params.size())) return std::nullopt;
    // Where the larger model has parameters that these views cannot tell apart, the solver drifts without
    // end.
    constexpr int kPatience = 100;
    const BundleSummary summary = solveLarger(*id, larger, kPatience);
    if (summary.termination != Termination::kConverged || !isGain(summary.cost, larger.params.size()) ||
        !isSound(*id, larger)) {
      return std::nullopt;
    }
    // Both by the weights of this model, as the comparison was.
    double sum = 0;
    std::size_t num_corners = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const auto errors =
          reprojectionErrors(*id, larger.params, larger.camera_from_board[v], observations_[v]);
      for (std::size_t i = 0; i < errors.size(); ++i) {
        sum += observations_[v][i].weight * errors[i].squaredNorm();
        ++num_corners;
      }
    }
    return BetterModel{.id = *id,
                       .rms_px = std::sqrt(sum / static_cast<double>(num_corners)),
                       .lean_rms_px = std::sqrt(meanWeightedSquare())};
  }

 private:
  // Mean over the corners in use of weight (dx^2 + dy^2), px^2.
  [[nodiscard]] double meanWeightedSquare() const {
    double sum = 0;
    int count = 0;
    for (std::size_t v = 0; v < errors_.size(); ++v) {
      for (std::size_t i = 0; i < errors_[v].size(); ++i) {
        sum += observations_[v][i].weight * errors_[v][i].squaredNorm();
        ++count;
      }
    }
    return sum / count;
  }

  // The same camera as one of the larger model: its further parameters are zero.
  [[nodiscard]] std::vector<double> enlargedParameters(const std::string& id) const {
    const auto names = parameterNames(options_.model);
    std::vector<double> params;
    for (const std::string_view name : parameterNames(id)) {
      const auto at = std::find(names.begin(), names.end(), name);
      params.push_back(at == names.end() ? 0.0 : state_.params[static_cast<std::size_t>(at - names.begin())]);
    }
    return params;
  }

  [[nodiscard]] BundleSummary solveLarger(const std::string& id, BundleState& larger,
                                          int max_iterations) const {
    constexpr double kFunctionTolerance = 1e-8;  // of the cost: far below a gain that counts
    return solveBundle(id, observations_, larger,
                       {.loss = loss_,
                        .max_iterations = max_iterations,
                        .function_tolerance = kFunctionTolerance,
                        .cancel = options_.cancel});
  }

  // Is the gain real? F test of the further parameters: the drop of the sum of squares for each of them over
  // the variance that the larger model leaves; 1 on average if they are not needed. A lens without distortion
  // is a strong claim, and that decides it. Among distortions nobody's lens follows any formula to the last
  // digit, and with corners enough that shows: there the gain must be worth the trouble as well.
  [[nodiscard]] bool isGain(double larger_cost, std::size_t num_larger_params) const {
    constexpr double kNeededF = 10;           // chance alone exceeds this once in a billion times
    constexpr double kWorthwhileShare = 0.1;  // of the sum of squares: 5 % of the RMS
    const bool has_distortion = state_.params.size() > kAffineParamNames.size();
    const double needed_share = has_distortion ? kWorthwhileShare : 0.0;
    std::size_t num_corners = 0;
    for (const auto& view : observations_) num_corners += view.size();
    const auto extra = static_cast<double>(num_larger_params - state_.params.size());
    const double freedom = 2.0 * static_cast<double>(num_corners) - static_cast<double>(num_larger_params) -
                           6.0 * static_cast<double>(views_.size());
    const double floor = 2 * kMinSigmaPx * kMinSigmaPx * static_cast<double>(num_corners);
    const double drop = 2 * (summary_.cost - larger_cost);
    return drop / extra > kNeededF * std::max(2 * larger_cost, floor) / freedom &&
           drop > needed_share * 2 * summary_.cost;
  }

  // A larger model is only worth recommending if these views determine it and it sees the whole image.
  [[nodiscard]] bool isSound(const std::string& id, const BundleState& larger) const {
    constexpr double kMinCondition = 1e-11;  // of parameters scaled to the same size
    const IntrinsicsInformation information = intrinsicsInformation(id, observations_, larger);
    if (!information.inverse || information.scaled_condition < kMinCondition) return false;
    const AnyCamera camera = AnyCamera::make(id, larger.params);
    if (!certifyDomain(camera, views_.front().size).full_image) return false;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      for (const Observation& observation : observations_[v]) {
        if (!camera.project(larger.camera_from_board[v] * observation.p_board).ok()) return false;
      }
    }
    return true;
  }

  void exclude(std::size_t v, std::string reason) {
    excluded_.push_back({views_[v].image, std::move(reason)});
    const auto at = static_cast<std::ptrdiff_t>(v);
    views_.erase(views_.begin() + at);
    if (v < observations_.size()) observations_.erase(observations_.begin() + at);
    if (v < state_.camera_from_board.size())
      state_.camera_from_board.erase(state_.camera_from_board.begin() + at);
  }

  void requireViews() const {
    if (views_.size() >= kMinViews) return;
    std::vector<std::string> reasons;
    for (const ExcludedView& view : excluded_) reasons.push_back(view.image + ": " + view.reason);
    throw inputError({.where = "calibration",
                      .found = std::to_string(views_.size()) + " usable views (" + join(reasons, "; ") + ")",
                      .expected = "at least " + std::to_string(kMinViews),
                      .next_step = "check the board's size and that all images are of the same camera"});
  }

  // Copies of one image see the same noise and would feign more certainty than there is.
  void excludeTwins() {
    const auto position = [](const View& view) {
      const Corner& first = view.corners.front();
      return std::tuple(first.pixel.x(), first.pixel.y(), first.id);
    };
    std::vector<std::size_t> order(views_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return position(views_[a]) < position(views_[b]); });
    const auto is_same = [&](std::size_t a, std::size_t b) {
      return std::equal(views_[a].corners.begin(), views_[a].corners.end(), views_[b].corners.begin(),
                        views_[b].corners.end(),
                        [](const Corner& x, const Corner& y) { return x.id == y.id && x.pixel == y.pixel; });
    };
    std::vector<std::pair<std::size_t, std::string>> twins;
    std::size_t original = 0;  // of the run of equal views, as an index into `order`
    for (std::size_t i = 1; i < order.size(); ++i) {
      if (is_same(order[original], order[i])) {
        twins.emplace_back(order[i], views_[order[original]].image);
      } else {
        original = i;
      }
    }
    std::sort(twins.rbegin(), twins.rend());
    for (const auto& [v, image] : twins) exclude(v, "shows exactly the corners of " + image);
  }

  void start() {
    for (std::size_t v = views_.size(); v-- > 0;) {
      if (views_[v].corners.size() < kMinCornersPerView) {
        exclude(v, std::to_string(views_[v].corners.size()) + " corners; at least " +
                       std::to_string(kMinCornersPerView) + " are needed");
      }
    }
    excludeTwins();
    requireViews();
    const auto params = findStart(options_.model, board_, views_, options_.cancel);
    if (!params) {
      throw inputError({.where = "calibration",
                        .found = "no " + options_.model + " camera that explains these views even roughly",
                        .expected = "views of one flat board by one camera",
                        .next_step = "check the board's size; a wide-angle lens may need another model"});
    }
    state_.params = *params;
    const AnyCamera camera = AnyCamera::make(options_.model, state_.params);
    observations_ = observationsOf(board_, views_);
    for (std::size_t v = 0; v < views_.size();) {
      const auto pose = poseFromView(camera, board_, views_[v].corners);
      if (pose && allProject(*pose, observations_[v])) {
        state_.camera_from_board.push_back(*pose);
        ++v;
      } else {
        exclude(v, "no pose of the board explains its corners");
      }
    }
    requireViews();
  }

  bool allProject(const SE3& pose, const std::vector<Observation>& view) const {
    const auto errors = reprojectionErrors(options_.model, state_.params, pose, view);
    return std::all_of(errors.begin(), errors.end(), [](const auto& e) { return e.allFinite(); });
  }

  void solve(double function_tolerance = BundleOptions().function_tolerance) {
    summary_ =
        solveBundle(options_.model, observations_, state_,
                    {.loss = loss_, .function_tolerance = function_tolerance, .cancel = options_.cancel});
    errors_.clear();
    for (std::size_t v = 0; v < views_.size(); ++v) {
      errors_.push_back(
          reprojectionErrors(options_.model, state_.params, state_.camera_from_board[v], observations_[v]));
    }
  }

  // Gives each corner its weight; the largest relative change of one.
  double weigh(Observations& views) const {
    double change = 0;
    for (auto& view : views) {
      for (Observation& observation : view) {
        const double weight = noise_.weight(observation.sigma_px);
        change = std::max(change, std::abs(weight / observation.weight - 1));
        observation.weight = weight;
      }
    }
    return change;
  }

  // Weights from the errors of the fit so far; the largest relative change of one.
  double updateWeights() {
    if (noise_.isUniform()) return 0;
    noise_.estimateUnexplained(observations_, errors_, leverages(options_.model, observations_, state_));
    return weigh(observations_);
  }

  // The standard deviation of a coordinate of a corner of weight 1 from the median error, which outliers
  // hardly move. The error of a clean corner follows Rayleigh's distribution, whose median is
  // sqrt(2 ln 2) sigma.
  [[nodiscard]] double robustSigma() const {
    std::vector<double> lengths;
    for (std::size_t v = 0; v < errors_.size(); ++v) {
      for (std::size_t i = 0; i < errors_[v].size(); ++i) {
        lengths.push_back(std::sqrt(observations_[v][i].weight) * errors_[v][i].norm());
      }
    }
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    return std::max(kMinSigmaPx, *middle / std::sqrt(2 * std::log(2.0)));
  }

  // The weights and the loss need the noise and the noise needs a fit: all settle together, and only then is
  // the fit made exact.
  void solveRobustly() {
    constexpr double kLoose = 1e-6;  // of the cost: enough to read the noise off the errors
    // A change of the threshold or of a weight by 2 % moves no parameter visibly.
    constexpr double kSteady = 0.02;
    const ImageSize size = views_.front().size;
    loss_.threshold_px = 0.005 * std::hypot(size.width, size.height);
    noise_ = CornerNoise(observations_);
    solve(kLoose);
    is_settled_ = false;
    for (int round = 0; round < kMaxRounds; ++round) {
      const double weight_change = round < kMaxWeightRounds ? updateWeights() : 0.0;
      const double threshold = kLossSigmas * robustSigma();
      is_settled_ = weight_change < kSteady && std::abs(threshold / loss_.threshold_px - 1) < kSteady;
      if (is_settled_) break;
      loss_.threshold_px = threshold;
      solve(kLoose);
    }
    solve();
  }

  // Outliers are judged anew in each round, among all corners, until the same ones come out.
  void leaveOutOutliers() {
    const double limit = kOutlierSigmas * loss_.threshold_px / kLossSigmas;
    for (int round = 0; round < kMaxRounds; ++round) {
      std::vector<Outlier> outliers;
      Observations kept;
      std::vector<std::size_t> foreign;
      Observations all = observationsOf(board_, views_);
      weigh(all);
      for (std::size_t v = 0; v < views_.size(); ++v) {
        const auto errors =
            reprojectionErrors(options_.model, state_.params, state_.camera_from_board[v], all[v]);
        std::vector<Observation> good;
        for (std::size_t i = 0; i < errors.size(); ++i) {
          if (std::sqrt(all[v][i].weight) * errors[i].norm() <= limit) {
            good.push_back(all[v][i]);
          } else {
            outliers.push_back({views_[v].image, views_[v].corners[i].id, errors[i]});
          }
        }
        if (2 * good.size() < errors.size() || good.size() < kMinCornersPerView) foreign.push_back(v);
        kept.push_back(std::move(good));
      }
      if (!foreign.empty()) {
        for (auto v = foreign.rbegin(); v != foreign.rend(); ++v) {
          kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(*v));
          std::erase_if(outliers, [&](const Outlier& o) { return o.image == views_[*v].image; });
          exclude(*v, "most of its corners do not fit the camera that the other views agree on");
        }
        requireViews();
      }
      const bool is_same =
          foreign.empty() && outliers.size() == outliers_.size() &&
          std::equal(outliers.begin(), outliers.end(), outliers_.begin(), [](const auto& a, const auto& b) {
            return a.image == b.image && a.corner_id == b.corner_id;
          });
      outliers_ = std::move(outliers);
      if (is_same) return;
      observations_ = std::move(kept);
      solve();
    }
    is_settled_ = false;
  }

  [[nodiscard]] ViewResult viewResult(std::size_t v) const {
    ViewResult view;
    view.image = views_[v].image;
    view.camera_from_board = state_.camera_from_board[v];
    view.num_corners = static_cast<int>(errors_[v].size());
    view.num_outliers = static_cast<int>(views_[v].corners.size() - errors_[v].size());
    double sum = 0;
    for (const auto& error : errors_[v]) {
      sum += error.squaredNorm();
      view.max_error_px = std::max(view.max_error_px, error.norm());
    }
    view.rms_px = std::sqrt(sum / view.num_corners);
    return view;
  }

  // Corners that are all stated to be equal need no weights, and tau is what their variance leaves.
  [[nodiscard]] double unexplainedSigma(double variance) const {
    if (!noise_.isStated()) return std::numeric_limits<double>::quiet_NaN();
    if (!noise_.isUniform()) return noise_.unexplainedSigma();
    return std::sqrt(std::max(0.0, variance - noise_.statedVariance(observations_[0][0].sigma_px)));
  }

  [[nodiscard]] CalibrationResult result() {
    CalibrationResult result(AnyCamera::make(options_.model, state_.params));
    result.image_size = views_.front().size;
    std::vector<Eigen::Vector2d> weighted_errors;
    result.local_sigma_px = localSigma(board_, observations_, errors_);
    double sum = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      result.views.push_back(viewResult(v));
      for (std::size_t i = 0; i < errors_[v].size(); ++i) {
        sum += errors_[v][i].squaredNorm();
        weighted_errors.emplace_back(std::sqrt(observations_[v][i].weight) * errors_[v][i]);
      }
    }
    result.num_corners = static_cast<int>(weighted_errors.size());
    result.rms_px = std::sqrt(sum / result.num_corners);
    result.weighted_rms_px = std::sqrt(meanWeightedSquare());
    std::sort(excluded_.begin(), excluded_.end(),
              [](const auto& a, const auto& b) { return naturalLess(a.image, b.image); });
    result.excluded_views = std::move(excluded_);
    result.outliers = std::move(outliers_);

    const int num_free = static_cast<int>(state_.params.size() + 6 * views_.size());
    const double variance = coordinateVariance(weighted_errors, loss_, num_free);
    result.coordinate_sigma_px = std::sqrt(variance);
    result.unexplained_sigma_px = unexplainedSigma(variance);
    const IntrinsicsInformation information = intrinsicsInformation(options_.model, observations_, state_);
    result.scaled_condition = information.scaled_condition;
    if (information.inverse) result.covariance = variance * *information.inverse;
    result.view_robust_covariance =
        viewRobustCovariance(options_.model, observations_, state_, loss_, meanSlope(weighted_errors, loss_));

    result.domain = certifyDomain(result.camera, result.image_size);
    for (std::size_t v = 0; v < views_.size(); ++v) {
      for (const Observation& observation : observations_[v]) {
        const Projection projection =
            result.camera.project(state_.camera_from_board[v] * observation.p_board);
        if (!projection.ok()) ++result.num_corners_outside;
      }
    }
    result.solver = summary_;
    result.loss = loss_;
    result.is_settled = is_settled_;
    return result;
  }

  const Checkerboard& board_;
  std::vector<View> views_;
  const CalibratorOptions& options_;
  Observations observations_;  // of the corners in use
  CornerNoise noise_;
  BundleState state_;
  HuberLoss loss_{.threshold_px = 0};
  BundleSummary summary_;
  bool is_settled_ = false;
  Errors errors_;  // of the corners in use
  std::vector<Outlier> outliers_;
  std::vector<ExcludedView> excluded_;
};

}  // namespace

CalibrationResult calibrate(const Checkerboard& board, std::vector<View> views,
                            const CalibratorOptions& options) {
  static_cast<void>(parameterNames(options.model));  // throws for an unknown model
  prepare(board, views);
  Estimator estimator(board, std::move(views), options);
  CalibrationResult result = estimator.run();
  result.better_model = estimator.betterModel();
  result.findings = judge(result);
  return result;
}

}  // namespace alidade
