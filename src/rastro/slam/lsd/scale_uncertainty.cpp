// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/scale_uncertainty.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>
#include <optional>

namespace rastro {
namespace {

/// By keyframe: the first one that links connect it with.
std::vector<std::size_t> first_of_each(std::size_t keyframes, const std::vector<ScaleLink>& links) {
  std::vector<std::size_t> parent(keyframes);
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root_of = [&](std::size_t k) {
    while (parent[k] != k) k = parent[k] = parent[parent[k]];
    return k;
  };
  for (const ScaleLink& link : links) {
    const std::size_t a = root_of(link.a), b = root_of(link.b);
    parent[std::max(a, b)] = std::min(a, b);
  }
  for (std::size_t k = 0; k < keyframes; ++k) parent[k] = root_of(k);
  return parent;
}

/// Of keyframes 1 to size - 1 relative to keyframe 0, all connected.
Eigen::SparseMatrix<double> information_of(std::size_t size, const std::vector<ScaleLink>& links) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](std::size_t row, std::size_t column, double value) {
    if (row > 0 && column > 0) entries.emplace_back(static_cast<int>(row - 1), static_cast<int>(column - 1), value);
  };
  for (const ScaleLink& link : links) {
    const double information = 1.0 / link.variance;
    add(link.a, link.a, information), add(link.b, link.b, information);
    add(link.a, link.b, -information), add(link.b, link.a, -information);
  }
  const auto rows = static_cast<Eigen::Index>(size - 1);
  Eigen::SparseMatrix<double> information(rows, rows);
  information.setFromTriplets(entries.begin(), entries.end());
  return information;
}

/// Relative to the mean of all, which are connected. nullopt where numbers are too far apart.
std::optional<std::vector<double>> about_mean(std::size_t size, const std::vector<ScaleLink>& links) {
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(information_of(size, links));
  if (solver.info() != Eigen::Success) return std::nullopt;
  const auto rows = static_cast<Eigen::Index>(size - 1);
  // With C the covariance relative to keyframe 0: C_kk - 2 (C 1)_k / size + 1^T C 1 / size^2.
  const Eigen::VectorXd with_mean = solver.solve(Eigen::VectorXd::Ones(rows)) / static_cast<double>(size);
  const double of_mean = with_mean.sum() / static_cast<double>(size);
  std::vector<double> variances{of_mean};
  for (Eigen::Index k = 0; k < rows; ++k) {
    const Eigen::VectorXd column = solver.solve(Eigen::VectorXd::Unit(rows, k));
    variances.push_back(std::max(0.0, column[k] - 2.0 * with_mean[k] + of_mean));
  }
  return variances;
}

}  // namespace

std::vector<double> scale_variances(std::size_t keyframes, const std::vector<ScaleLink>& links) {
  const std::vector<std::size_t> first = first_of_each(keyframes, links);
  std::vector<std::size_t> index(keyframes);  // among those connected
  std::vector<std::vector<std::size_t>> members(keyframes);
  for (std::size_t k = 0; k < keyframes; ++k) {
    index[k] = members[first[k]].size();
    members[first[k]].push_back(k);
  }
  std::vector<std::vector<ScaleLink>> links_of(keyframes);
  for (const ScaleLink& link : links) links_of[first[link.a]].push_back({index[link.a], index[link.b], link.variance});
  std::vector<double> variances(keyframes, 0.0);
  for (std::size_t k = 0; k < keyframes; ++k) {
    if (members[k].size() < 2) continue;
    if (const auto connected = about_mean(members[k].size(), links_of[k]))
      for (std::size_t i = 0; i < connected->size(); ++i) variances[members[k][i]] = (*connected)[i];
  }
  return variances;
}

}  // namespace rastro
