// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/map_uncertainty.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

namespace rastro {
namespace {

/// The mixture of both informations with the smallest determinant: a volume has no units to weigh against each other.
Eigen::MatrixXd covariance_intersection(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  constexpr int weights = 20;
  const Eigen::MatrixXd of_a = a.inverse(), of_b = b.inverse();
  Eigen::MatrixXd most = of_a;
  for (int k = 1; k <= weights; ++k) {
    const double weight = static_cast<double>(k) / weights;
    const Eigen::MatrixXd mixture = (1.0 - weight) * of_a + weight * of_b;
    if (mixture.determinant() > most.determinant()) most = mixture;
  }
  return most.inverse();
}

}  // namespace

MapUncertainty::Matrix7d MapUncertainty::moved_to(const Entry& part, const Eigen::Vector3d& position) const {
  // A rotation of the part moves what is seen from it, and so does its scale.
  const Eigen::Vector3d away = position - part.position;
  Matrix7d lever = Matrix7d::Identity();
  lever.block<3, 3>(0, 3) = -hat(away);
  lever.block<3, 1>(0, 6) = away;
  return lever * part.covariance * lever.transpose();
}

MapUncertainty::Matrix7d MapUncertainty::covariance_of(std::int64_t part, const Eigen::Vector3d& position) const {
  const auto found = parts_.find(part);
  return found == parts_.end() ? Matrix7d::Zero() : moved_to(found->second, position);
}

Matrix6d MapUncertainty::of_pose(std::int64_t part, const Eigen::Vector3d& position, const Matrix6d& tracked) const {
  if (!parts_.contains(part)) return tracked;
  const Matrix6d sum = covariance_of(part, position).topLeftCorner<6, 6>() + tracked;
  return 0.5 * (sum + sum.transpose());
}

void MapUncertainty::add(std::int64_t part, std::int64_t from, const Eigen::Vector3d& position, const Matrix6d& tracked,
                         double scale_variance) {
  Matrix7d sum = covariance_of(from, position);
  sum.topLeftCorner<6, 6>() += tracked;
  sum(6, 6) += scale_variance;
  parts_.insert_or_assign(part, Entry{position, 0.5 * (sum + sum.transpose())});
}

void MapUncertainty::set(std::int64_t part, const Eigen::Vector3d& position, const Matrix6d& covariance) {
  Matrix7d whole = Matrix7d::Zero();
  whole.topLeftCorner<6, 6>() = covariance;
  parts_.insert_or_assign(part, Entry{position, whole});
}

void MapUncertainty::reduce(std::int64_t part, const Eigen::Vector3d& position, const Matrix6d& covariance) {
  if (!parts_.contains(part)) return;
  Matrix6d reduced = of_pose(part, position, Matrix6d::Zero());
  std::vector<int> uncertain;
  for (int axis = 0; axis < 6; ++axis)
    if (reduced(axis, axis) > 0.0) uncertain.push_back(axis);
  const Eigen::MatrixXd known = reduced(uncertain, uncertain), other = covariance(uncertain, uncertain);
  if (known.llt().info() != Eigen::Success || other.llt().info() != Eigen::Success) return;
  reduced(uncertain, uncertain) = covariance_intersection(known, other);
  set(part, position, 0.5 * (reduced + reduced.transpose()));
}

void MapUncertainty::join(std::int64_t part, std::int64_t joined_to, const Eigen::Vector3d& position,
                          const Sim3& new_from_old) {
  const auto [found, is_new] = parts_.try_emplace(part, Entry{position, Matrix7d::Zero()});
  Entry& entry = found->second;
  if (!is_new) entry.position = new_from_old * entry.position;
  Matrix7d turned = Matrix7d::Identity();
  turned.block<3, 3>(0, 0) = new_from_old.scale() * new_from_old.rotation().matrix();
  turned.block<3, 3>(3, 3) = new_from_old.rotation().matrix();
  const Matrix7d own = turned * entry.covariance * turned.transpose();
  entry.covariance = own + covariance_of(joined_to, entry.position);
}

std::vector<std::pair<std::int64_t, Eigen::Vector3d>> MapUncertainty::after(std::int64_t part) const {
  std::vector<std::pair<std::int64_t, Eigen::Vector3d>> later;
  for (auto entry = parts_.upper_bound(part); entry != parts_.end(); ++entry)
    later.emplace_back(entry->first, entry->second.position);
  return later;
}

void MapUncertainty::contradict(std::int64_t part, const SE3& before, const SE3& after) {
  constexpr double chi_square_99 = 16.81;  // six degrees of freedom
  constexpr double certain = 1e-12;        // variance, m^2 and rad^2: what was certain is so up to rounding
  const auto found = parts_.find(part);
  if (found == parts_.end()) return;
  Vector6d moved;
  moved << after.translation() - before.translation(), (after.rotation() * before.rotation().inverse()).log();
  auto claimed = found->second.covariance.topLeftCorner<6, 6>();
  Eigen::LDLT<Matrix6d> errors(claimed);
  // Without an inverse: a solution would leave out the directions that were certain.
  if (!(errors.vectorD().minCoeff() > 1e-12 * certain)) errors.compute(claimed + certain * Matrix6d::Identity());
  const double squared_sigmas = moved.dot(errors.solve(moved));
  if (squared_sigmas > chi_square_99) claimed += (1.0 - chi_square_99 / squared_sigmas) * moved * moved.transpose();
}

void MapUncertainty::close_loop(std::int64_t earlier, std::int64_t later) {
  // Rotations tell the share: positions have the levers of places as well.
  const auto variance = [](const Matrix7d& covariance) { return covariance.block<3, 3>(3, 3).trace(); };
  const auto end = parts_.find(later);
  if (end == parts_.end()) return;
  const Entry start = parts_.contains(earlier) ? parts_.at(earlier) : Entry{end->second.position, Matrix7d::Zero()};
  const double whole = variance(end->second.covariance) - variance(start.covariance);
  if (!(whole > 0.0)) return;
  for (auto& [id, part] : parts_) {
    const double share = std::clamp((variance(part.covariance) - variance(start.covariance)) / whole, 0.0, 1.0);
    part.covariance = ((1.0 - share) * part.covariance + share * moved_to(start, part.position)).eval();
  }
}

}  // namespace rastro
