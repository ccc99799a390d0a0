// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/refinement/photometric_bundle.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <optional>

#include "rastro/slam/lsd/refinement/photometric_samples.h"

namespace rastro {
namespace {

constexpr double least_inverse_depth = 1e-6;

double huber_cost(double residual, double huber) {
  const double size = std::abs(residual);
  return size <= huber ? 0.5 * size * size : huber * (size - 0.5 * huber);
}

/// What one keyframe's points say of its own pose (first) and of its targets' (after it), their depths eliminated.
struct HostNormal {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double cost = 0.0;
  std::int64_t residuals = 0;
  /// By point: how its depth step follows from those of the poses.
  std::vector<double> depth_information, depth_right;
  std::vector<Eigen::VectorXf> depth_by_poses;
};

class HostLinearizer {
 public:
  HostLinearizer(const std::vector<PhotometricKeyframe>& keyframes, std::size_t host, const Camera& camera,
                 const PhotometricBundleOptions& options)
      : keyframes_(keyframes), host_(keyframes[host]), camera_(camera), options_(options) {
    for (const PhotometricPoint& point : host_.points)
      if (const auto squared_gradients = squared_gradients_around(host_, point))
        for (const double squared_gradient : *squared_gradients) weights_ += weight_of(squared_gradient);
  }

  double cost() const {
    double sum = 0.0;
    for (const std::int32_t target : host_.targets)
      sum += for_pair(target, [](const PhotometricSample&, double, double) {});
    for (const PhotometricPoint& point : host_.points) sum += measured_cost(point);
    return sum;
  }

  HostNormal linearize(double damping) const {
    HostNormal normal;
    const auto size = static_cast<Eigen::Index>(6 * (1 + host_.targets.size()));
    normal.matrix.setZero(size, size);
    normal.right.setZero(size);
    normal.depth_information.assign(host_.points.size(), 0.0);
    normal.depth_right.assign(host_.points.size(), 0.0);
    normal.depth_by_poses.assign(host_.points.size(), Eigen::VectorXf::Zero(size));
    for (std::size_t k = 0; k < host_.targets.size(); ++k) add_pair(k, normal);
    for (std::size_t i = 0; i < host_.points.size(); ++i) {
      const PhotometricPoint& point = host_.points[i];
      normal.cost += measured_cost(point);
      normal.depth_information[i] += measured_information(point);
      normal.depth_right[i] += measured_information(point) * (point.inverse_depth - point.measured);
      if (!(normal.depth_information[i] > 0.0)) continue;
      const double inverse = 1.0 / ((1.0 + damping) * normal.depth_information[i]);
      const Eigen::VectorXd across = normal.depth_by_poses[i].cast<double>();
      normal.matrix.noalias() -= inverse * across * across.transpose();
      normal.right -= inverse * normal.depth_right[i] * across;
    }
    return normal;
  }

 private:
  double measured_information(const PhotometricPoint& point) const {
    if (!(point.measured_sigma > 0.0)) return 0.0;
    const double ratio = options_.intensity_sigma / point.measured_sigma;
    return ratio * ratio;
  }
  double measured_cost(const PhotometricPoint& point) const {
    const double error = point.inverse_depth - point.measured;
    return 0.5 * measured_information(point) * error * error;
  }
  double weight_of(double squared_gradient) const {
    return 1.0 / (1.0 + squared_gradient / (options_.gradient_scale * options_.gradient_scale));
  }
  /// Calls `use` with each sample, its residual and its weight; returns the cost.
  template <typename Use>
  double for_pair(std::int32_t index, const Use& use) const {
    const PhotometricSampler sampler(host_, keyframes_[static_cast<std::size_t>(index)], camera_);
    std::vector<PhotometricSample> samples;
    samples.reserve(photometric_pattern_size * host_.points.size());
    for (std::size_t i = 0; i < host_.points.size(); ++i) sampler.add(i, samples);
    const PairBrightness brightness = brightness_of(samples, options_.outlier);
    const double most = huber_cost(options_.outlier, options_.huber);
    // What is out of view costs as much as a hidden point, so that nothing is gained by looking away.
    double cost = most * weights_;
    for (const PhotometricSample& sample : samples) {
      const double residual = brightness.residual(sample), size = std::abs(residual);
      const double weight = weight_of(sample.squared_gradient);
      cost += weight * (std::min(most, huber_cost(residual, options_.huber)) - most);
      if (size < options_.outlier)
        use(sample, residual, weight * (size <= options_.huber ? 1.0 : options_.huber / size));
    }
    return cost;
  }

  void add_pair(std::size_t k, HostNormal& normal) const {
    const PhotometricKeyframe& target = keyframes_[static_cast<std::size_t>(host_.targets[k])];
    const SE3 target_from_host = target.camera_from_world * host_.camera_from_world.inverse();
    const Eigen::Matrix3d rotation = target_from_host.rotation().matrix();
    const auto column = static_cast<Eigen::Index>(6 * (k + 1));
    normal.cost += for_pair(host_.targets[k], [&](const PhotometricSample& sample, double residual, double weight) {
      const double inverse_depth = host_.points[sample.point].inverse_depth, inverse_z = 1.0 / sample.direction.z();
      const double x = sample.direction.x() * inverse_z, y = sample.direction.y() * inverse_z;
      // Of the intensity by the direction in the target.
      Eigen::RowVector3d by_direction;
      by_direction << camera_.fx * sample.gradient.x(), camera_.fy * sample.gradient.y(), 0.0;
      by_direction.z() = -by_direction.x() * x - by_direction.y() * y;
      by_direction *= inverse_z;
      // exp(d) * pose moves a point by d's translation + rotation x point; directions are points times inverse_depth.
      Eigen::Matrix<double, 1, 6> by_target, by_host;
      by_target << inverse_depth * by_direction, sample.direction.transpose().cross(by_direction);
      const Eigen::RowVector3d in_host = by_direction * rotation;
      const Eigen::RowVector3d ray = sample.ray.homogeneous().transpose();
      by_host << -inverse_depth * in_host, -ray.cross(in_host);
      const double by_depth = by_direction.dot(target_from_host.translation());
      normal.matrix.block<6, 6>(0, 0).noalias() += weight * by_host.transpose() * by_host;
      normal.matrix.block<6, 6>(column, 0).noalias() += weight * by_target.transpose() * by_host;
      normal.matrix.block<6, 6>(0, column).noalias() += weight * by_host.transpose() * by_target;
      normal.matrix.block<6, 6>(column, column).noalias() += weight * by_target.transpose() * by_target;
      normal.right.head<6>() += weight * residual * by_host.transpose();
      normal.right.segment<6>(column) += weight * residual * by_target.transpose();
      normal.depth_information[sample.point] += weight * by_depth * by_depth;
      normal.depth_right[sample.point] += weight * residual * by_depth;
      Eigen::VectorXf& across = normal.depth_by_poses[sample.point];
      across.head<6>() += (weight * by_depth * by_host.transpose()).cast<float>();
      across.segment<6>(column) += (weight * by_depth * by_target.transpose()).cast<float>();
      ++normal.residuals;
    });
  }

  const std::vector<PhotometricKeyframe>& keyframes_;
  const PhotometricKeyframe& host_;
  const Camera& camera_;
  const PhotometricBundleOptions& options_;
  double weights_ = 0.0;  ///< Of all pixels around all points that are not masked, in view or not.
};

class PhotometricBundle {
 public:
  PhotometricBundle(std::vector<PhotometricKeyframe>& keyframes, const Camera& camera,
                    const PhotometricBundleOptions& options, TaskPool* pool)
      : keyframes_(keyframes), camera_(camera), options_(options), pool_(pool) {}

  PhotometricBundleResult adjust() {
    PhotometricBundleResult result;
    double damping = 1e-4;
    for (int iteration = 0; iteration < options_.iterations; ++iteration) {
      if (options_.begins) options_.begins(iteration);
      const std::vector<HostNormal> normals = linearize(damping);
      if (stopped()) break;
      ++result.iterations;
      note_sigmas(normals);
      double cost = 0.0;
      result.residuals = 0;
      for (const HostNormal& normal : normals) cost += normal.cost, result.residuals += normal.residuals;
      if (iteration == 0) result.first_cost = cost;
      result.last_cost = cost;
      const std::vector<PhotometricKeyframe> before = keyframes_;
      if (!step(normals, damping)) break;
      const double after = this->cost();
      if (stopped() || !(after < cost)) {
        keyframes_ = before;
        if (stopped()) break;
        damping *= 10.0;
        if (damping > 1e3) break;
        continue;
      }
      result.last_cost = after;
      damping = std::max(1e-6, 0.2 * damping);
      if (after > (1.0 - options_.least_gain) * cost) break;
    }
    return result;
  }

 private:
  bool stopped() const { return options_.stopped && options_.stopped(); }

  /// Of some keyframes alone once stopped.
  template <typename Body>
  void for_hosts(const Body& body) const {
    const auto some = [&](int begin, int end) {
      for (int i = begin; i < end && !stopped(); ++i) body(static_cast<std::size_t>(i));
    };
    const auto count = static_cast<int>(keyframes_.size());
    pool_ ? pool_->for_chunks(0, count, 1, some) : some(0, count);
  }

  double cost() const {
    std::vector<double> costs(keyframes_.size());
    for_hosts([&](std::size_t i) { costs[i] = HostLinearizer(keyframes_, i, camera_, options_).cost(); });
    double sum = 0.0;
    for (const double each : costs) sum += each;
    return sum;
  }

  std::vector<HostNormal> linearize(double damping) const {
    std::vector<HostNormal> normals(keyframes_.size());
    for_hosts([&](std::size_t i) { normals[i] = HostLinearizer(keyframes_, i, camera_, options_).linearize(damping); });
    return normals;
  }

  void note_sigmas(const std::vector<HostNormal>& normals) {
    for (std::size_t k = 0; k < normals.size(); ++k)
      for (std::size_t i = 0; i < normals[k].depth_information.size(); ++i) {
        const double information = normals[k].depth_information[i];
        keyframes_[k].points[i].sigma = information > 0.0 ? options_.intensity_sigma / std::sqrt(information) : 0.0;
      }
  }

  /// The keyframe of a block of the host's equations.
  std::size_t keyframe_of(std::size_t host, std::size_t block) const {
    return block == 0 ? host : static_cast<std::size_t>(keyframes_[host].targets[block - 1]);
  }

  bool step(const std::vector<HostNormal>& normals, double damping) {
    const auto poses = solve(normals, damping);
    if (!poses) return false;
    for (std::size_t i = 0; i < keyframes_.size(); ++i) move_points(i, normals[i], *poses, damping);
    for (std::size_t i = 0; i < keyframes_.size(); ++i) {
      const Vector6d move = poses->segment<6>(static_cast<Eigen::Index>(6 * i));
      if (!keyframes_[i].fixed) keyframes_[i].camera_from_world = SE3::exp(move) * keyframes_[i].camera_from_world;
    }
    return true;
  }

  std::optional<Eigen::VectorXd> solve(const std::vector<HostNormal>& normals, double damping) const {
    const auto size = static_cast<Eigen::Index>(6 * keyframes_.size());
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(size), diagonal = Eigen::VectorXd::Zero(size);
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const std::size_t blocks = 1 + keyframes_[i].targets.size();
      for (std::size_t a = 0; a < blocks; ++a) {
        const auto row = static_cast<Eigen::Index>(6 * keyframe_of(i, a)), from = static_cast<Eigen::Index>(6 * a);
        right.segment<6>(row) += normals[i].right.segment<6>(from);
        diagonal.segment<6>(row) += normals[i].matrix.diagonal().segment<6>(from);
        for (std::size_t b = 0; b < blocks; ++b)
          add_block(normals[i].matrix, from, 6 * b, row, keyframe_of(i, b), entries);
      }
    }
    constexpr double held = 1e12;
    for (Eigen::Index i = 0; i < size; ++i) {
      const bool fixed = keyframes_[static_cast<std::size_t>(i / 6)].fixed;
      entries.emplace_back(i, i, fixed ? held : damping * std::max(0.0, diagonal[i]) + 1e-3);
    }
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
    if (solver.info() != Eigen::Success) return std::nullopt;
    Eigen::VectorXd steps = solver.solve(-right);
    if (!steps.allFinite()) return std::nullopt;
    return steps;
  }

  /// The lower half is all that the solver reads.
  static void add_block(const Eigen::MatrixXd& from, Eigen::Index from_row, std::size_t from_column, Eigen::Index row,
                        std::size_t keyframe, std::vector<Eigen::Triplet<double>>& entries) {
    const auto column = static_cast<Eigen::Index>(6 * keyframe);
    if (column > row) return;
    for (Eigen::Index y = 0; y < 6; ++y)
      for (Eigen::Index x = 0; x < 6; ++x)
        if (column + x <= row + y)
          entries.emplace_back(row + y, column + x, from(from_row + y, static_cast<Eigen::Index>(from_column) + x));
  }

  void move_points(std::size_t host, const HostNormal& normal, const Eigen::VectorXd& poses, double damping) {
    PhotometricKeyframe& keyframe = keyframes_[host];
    Eigen::VectorXd local(normal.right.size());
    for (std::size_t a = 0; a <= keyframe.targets.size(); ++a) {
      const std::size_t moved = keyframe_of(host, a);
      local.segment<6>(static_cast<Eigen::Index>(6 * a)) =
          keyframes_[moved].fixed ? Vector6d(Vector6d::Zero())
                                  : Vector6d(poses.segment<6>(static_cast<Eigen::Index>(6 * moved)));
    }
    for (std::size_t i = 0; i < keyframe.points.size(); ++i) {
      if (!(normal.depth_information[i] > 0.0)) continue;
      double& depth = keyframe.points[i].inverse_depth;
      const double move = -(normal.depth_right[i] + normal.depth_by_poses[i].cast<double>().dot(local)) /
                          ((1.0 + damping) * normal.depth_information[i]);
      depth = std::clamp(depth + move, std::max(least_inverse_depth, 0.5 * depth), 2.0 * depth);
    }
  }

  std::vector<PhotometricKeyframe>& keyframes_;
  const Camera& camera_;
  PhotometricBundleOptions options_;
  TaskPool* pool_;
};

}  // namespace

PhotometricBundleResult adjust_photometric_bundle(std::vector<PhotometricKeyframe>& keyframes, const Camera& camera,
                                                  const PhotometricBundleOptions& options, TaskPool* pool) {
  return PhotometricBundle(keyframes, camera, options, pool).adjust();
}

}  // namespace rastro
