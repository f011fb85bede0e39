// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/demonstrations/hand_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "numerics/levenberg_marquardt.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::learning {
namespace {

using Eigen::Index;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using learning::HandKeypoints;

constexpr int kPose = learning::kHumanJoints;  // where the pose starts among the parameters
constexpr int kSize = kPose + 6;               // where the size starts
constexpr int kParameters = kSize + 1 + hand::kShadowFingers;
constexpr double kSmallest = 0.6, kLargest = 1.6;  // of the hand's size
constexpr double kFar = 10;                        // m, of the wrist
constexpr double kPerMetre = 1000;                 // depth is compared in mm
constexpr int kMinKeypoints = 6;

/// Parameters of a state: joints, turn and place of the wrist against the start, size.
VectorXd parameters_of(const HandState& state) {
  VectorXd x = VectorXd::Zero(kParameters);
  x.head<learning::kHumanJoints>() = state.joints;
  x.segment<3>(kPose + 3) = state.T_camera_wrist.translation();
  x[kSize] = state.shape.palm;
  for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
    x[kSize + 1 + finger] = state.shape.fingers[static_cast<std::size_t>(finger)];
  }
  return x;
}

HandState state_of(const VectorXd& x, const Eigen::Matrix3d& R_start) {
  HandState state;
  state.joints = x.head<learning::kHumanJoints>();
  state.T_camera_wrist.linear() = exp_so3(x.segment<3>(kPose)) * R_start;
  state.T_camera_wrist.translation() = x.segment<3>(kPose + 3);
  state.shape.palm = x[kSize];
  for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
    state.shape.fingers[static_cast<std::size_t>(finger)] = x[kSize + 1 + finger];
  }
  return state;
}

struct Bounds {
  VectorXd lower{kParameters}, upper{kParameters};
};

Bounds bounds(const VectorXd& start, bool fit_shape) {
  Bounds b;
  for (int i = 0; i < learning::kHumanJoints; ++i) {
    b.lower[i] = learning::human_ranges()[static_cast<std::size_t>(i)].low;
    b.upper[i] = learning::human_ranges()[static_cast<std::size_t>(i)].high;
  }
  b.lower.segment<6>(kPose).setConstant(-kFar);
  b.upper.segment<6>(kPose).setConstant(kFar);
  b.lower.tail<1 + hand::kShadowFingers>().setConstant(kSmallest);
  b.upper.tail<1 + hand::kShadowFingers>().setConstant(kLargest);
  if (!fit_shape) {
    b.lower.tail<1 + hand::kShadowFingers>() = b.upper.tail<1 + hand::kShadowFingers>() =
        start.tail<1 + hand::kShadowFingers>();
  }
  return b;
}

/// Residuals that keep joints and size plausible where the picture says nothing.
void add_prior(const VectorXd& x, const HandFitOptions& options, VectorXd& r, Index next) {
  for (int i = 0; i < learning::kHumanJoints; ++i) {
    const auto& range = learning::human_ranges()[static_cast<std::size_t>(i)];
    r[next++] = std::sqrt(options.rest) * (x[i] - (range.low + range.high) / 2);
  }
  for (int i = kSize; i < kParameters; ++i) r[next++] = std::sqrt(options.size) * (x[i] - 1);
}
constexpr Index kPrior = learning::kHumanJoints + 1 + hand::kShadowFingers;

/// Distance along a ray to a capsule's surface; 0 if it misses.
/// @param ray  unit direction from the origin
double ray_to_sphere(const Vector3d& ray, const Vector3d& center, double radius) {
  const double along = ray.dot(center);
  const double inside = along * along - center.squaredNorm() + radius * radius;
  return inside < 0 ? 0 : std::max(along - std::sqrt(inside), 0.0);
}

double ray_to_capsule(const Vector3d& ray, const Vector3d& a, const Vector3d& b, double radius) {
  const Vector3d axis = b - a;
  const double length2 = axis.squaredNorm();
  if (length2 > 0) {
    // Across the axis: |(t ray - a) - axis ((t ray - a).axis)/length2|^2 = radius^2.
    const Vector3d u = ray - axis * (ray.dot(axis) / length2);
    const Vector3d v = -a + axis * (a.dot(axis) / length2);
    const double qa = u.squaredNorm(), qb = u.dot(v), qc = v.squaredNorm() - radius * radius;
    const double inside = qb * qb - qa * qc;
    if (qa > 0 && inside >= 0) {
      const double t = (-qb - std::sqrt(inside)) / qa;
      const double place = (t * ray - a).dot(axis);
      if (t > 0 && place >= 0 && place <= length2) return t;
    }
  }
  const double at_a = ray_to_sphere(ray, a, radius), at_b = ray_to_sphere(ray, b, radius);
  if (at_a == 0 || at_b == 0) return std::max(at_a, at_b);
  return std::min(at_a, at_b);
}

/// Pixels that the fit compares in depth.
std::vector<Vector2d> compared_pixels(const HandImage& image, int stride) {
  std::vector<Vector2d> result;
  for (Index row = 0; row < image.depth.rows(); row += stride) {
    for (Index column = 0; column < image.depth.cols(); column += stride) {
      if (!image.mask(row, column) || !(image.depth(row, column) > 0)) continue;
      result.emplace_back(static_cast<double>(column), static_cast<double>(row));
    }
  }
  return result;
}

double depth_of(const HandImage& image, const Vector2d& pixel) {
  return image.depth(static_cast<Index>(pixel.y()), static_cast<Index>(pixel.x()));
}

void check(const PinholeCamera& camera, const HandImage& image) {
  if (image.depth.size() == 0) return;
  if (image.depth.rows() != camera.height || image.depth.cols() != camera.width ||
      image.mask.rows() != camera.height || image.mask.cols() != camera.width) {
    throw BadInput(
        fmt::format("a depth image of {} x {} with a mask of {} x {} of a camera of {} x {}",
                    image.depth.cols(), image.depth.rows(), image.mask.cols(), image.mask.rows(),
                    camera.width, camera.height));
  }
}

/// The picture's residuals: keypoints (pixels), then depth (mm), weighed.
class Picture {
 public:
  Picture(const PinholeCamera& camera, const HandImage& image, const HandFitOptions& options)
      : camera_(camera),
        image_(image),
        options_(options),
        compared_(compared_pixels(image, options.stride)) {}

  Index size() const { return 2 * learning::kHandKeypoints + std::ssize(compared_); }

  void write(const HandState& state, VectorXd& r) const {
    const HandKeypoints points = state.keypoints();
    for (int i = 0; i < learning::kHandKeypoints; ++i) {
      r.segment<2>(2 * i) = pixel_error(points, i);
    }
    for (std::size_t k = 0; k < compared_.size(); ++k) {
      r[2 * learning::kHandKeypoints + static_cast<Index>(k)] =
          std::sqrt(options_.lambda) * kPerMetre * gap(points, state.shape, compared_[k]);
    }
  }

  double pixel_rms(const HandState& state) const {
    const HandKeypoints points = state.keypoints();
    double sum = 0;
    int seen = 0;
    for (int i = 0; i < learning::kHandKeypoints; ++i) {
      sum += pixel_error(points, i).squaredNorm();
      seen += image_.pixels.col(i).allFinite();
    }
    return std::sqrt(sum / seen);
  }

  double depth_rms(const HandState& state) const {
    const HandKeypoints points = state.keypoints();
    double sum = 0;
    for (const auto& pixel : compared_) sum += std::pow(gap(points, state.shape, pixel), 2);
    return compared_.empty() ? 0 : std::sqrt(sum / static_cast<double>(compared_.size()));
  }

 private:
  Vector2d pixel_error(const HandKeypoints& points, int i) const {
    if (!image_.pixels.col(i).allFinite() || !(points(2, i) > 0)) return Vector2d::Zero();
    return camera_.project(points.col(i)) - image_.pixels.col(i);
  }

  /// Rendered less seen depth, m.
  double gap(const HandKeypoints& points, const learning::HumanShape& shape,
             const Vector2d& pixel) const {
    const double rendered = depth_at(camera_, points, shape, pixel);
    if (rendered == 0) return options_.largest_gap;
    return std::clamp(rendered - depth_of(image_, pixel), -options_.largest_gap,
                      options_.largest_gap);
  }

  const PinholeCamera& camera_;
  const HandImage& image_;
  const HandFitOptions& options_;
  std::vector<Vector2d> compared_;
};

using Residuals = std::function<VectorXd(const VectorXd&)>;

/// The parameters within their bounds that leave the least.
numerics::LeastSquaresFit<VectorXd> minimise(const Residuals& residuals, const HandState& start,
                                             const HandFitOptions& options) {
  constexpr double kWidth = 1e-3;  // of all parameters: rad, m, and of the size 1
  const VectorXd x = parameters_of(start);
  const Bounds b = bounds(x, options.fit_shape);
  const auto moved = [&](const VectorXd& from, const VectorXd& step) {
    return VectorXd((from + step).cwiseMax(b.lower).cwiseMin(b.upper));
  };
  return numerics::levenberg_marquardt(
      moved(x, VectorXd::Zero(x.size())), VectorXd::Constant(x.size(), kWidth), residuals, moved,
      {.iterations = options.iterations, .damping = 1e-3, .min_gain = 1e-6, .max_step = 1e3});
}

}  // namespace

double depth_at(const PinholeCamera& camera, const HandKeypoints& keypoints,
                const learning::HumanShape& shape, const Vector2d& pixel) {
  const Vector3d ray = camera.ray(pixel).normalized();
  double nearest = 0;
  for (const auto& bone : learning::human_bones()) {
    const double t = ray_to_capsule(ray, keypoints.col(bone.from), keypoints.col(bone.to),
                                    shape.palm * bone.radius);
    if (t > 0 && (nearest == 0 || t < nearest)) nearest = t;
  }
  return nearest * ray.z();
}

DepthImage render_depth(const PinholeCamera& camera, const HandState& state) {
  const HandKeypoints points = state.keypoints();
  DepthImage image(camera.height, camera.width);
  for (Index row = 0; row < image.rows(); ++row) {
    for (Index column = 0; column < image.cols(); ++column) {
      image(row, column) = depth_at(camera, points, state.shape,
                                    {static_cast<double>(column), static_cast<double>(row)});
    }
  }
  return image;
}

std::optional<Vector3d> masked_center(const PinholeCamera& camera, const HandImage& image) {
  check(camera, image);
  Vector3d sum = Vector3d::Zero();
  const auto pixels = compared_pixels(image, 1);
  for (const auto& pixel : pixels) sum += depth_of(image, pixel) * camera.ray(pixel);
  if (pixels.empty()) return {};
  return sum / static_cast<double>(pixels.size());
}

HandFit fit_hand(const PinholeCamera& camera, const HandImage& image, const HandState& start,
                 const HandFitOptions& options) {
  check(camera, image);
  HandFit fit{.state = start};
  int seen = 0;
  for (int i = 0; i < learning::kHandKeypoints; ++i) seen += image.pixels.col(i).allFinite();
  if (seen < kMinKeypoints) {
    fit.status = HandFitStatus::too_few_keypoints;
    return fit;
  }
  const Picture picture(camera, image, options);
  const Eigen::Matrix3d R = start.T_camera_wrist.linear();
  const Residuals residuals = [&](const VectorXd& x) {
    VectorXd r(picture.size() + kPrior);
    picture.write(state_of(x, R), r);
    add_prior(x, options, r, picture.size());
    return r;
  };
  const auto found = minimise(residuals, start, options);
  fit.state = state_of(found.state, R);
  fit.pixel_rms = picture.pixel_rms(fit.state);
  fit.depth_rms = picture.depth_rms(fit.state);
  fit.iterations = found.iterations;
  return fit;
}

HandFit fit_hand(const HandKeypoints& targets, const HandState& start,
                 const HandFitOptions& options) {
  const Eigen::Matrix3d R = start.T_camera_wrist.linear();
  const auto errors = [&](const HandState& state) {
    HandKeypoints difference = kPerMetre * (state.keypoints() - targets);
    for (double& value : difference.reshaped()) value = std::isfinite(value) ? value : 0;
    return difference;
  };
  constexpr Index kValues = 3 * learning::kHandKeypoints;
  const Residuals residuals = [&](const VectorXd& x) {
    VectorXd r(kValues + kPrior);
    r.head<kValues>() = errors(state_of(x, R)).reshaped();
    add_prior(x, options, r, kValues);
    return r;
  };
  const auto found = minimise(residuals, start, options);
  HandFit fit{.state = state_of(found.state, R)};
  const double wanted = static_cast<double>(targets.array().isFinite().count()) / 3;
  if (wanted < 1) fit.status = HandFitStatus::too_few_keypoints;
  fit.pixel_rms = errors(fit.state).norm() / std::sqrt(std::max(wanted, 1.0));
  fit.iterations = found.iterations;
  return fit;
}

}  // namespace palpate::learning
