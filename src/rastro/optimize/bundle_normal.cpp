// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/bundle_normal.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <optional>

namespace rastro {
namespace {

/// Chunks of points with separate sums, so that the order of summation is the same for any pool.
constexpr int most_chunks = 16, least_grain = 128;

int grain_of(int points) { return std::max(least_grain, (points + most_chunks - 1) / most_chunks); }

/// Up to this number of free cameras the matrix is small and full enough for a dense factorization.
constexpr int most_dense = 60;

}  // namespace

/// The cameras' matrix: the nonzero blocks of its lower half, row by row.
class BundleNormal::Reduced {
 public:
  /// `columns[row]`: ascending, the last is the row itself.
  explicit Reduced(std::vector<std::vector<int>> columns) : columns_(std::move(columns)) {
    begin_.push_back(0);
    for (const auto& row : columns_) begin_.push_back(begin_.back() + row.size());
    blocks_.resize(begin_.back());
    right_.setZero(6 * size());
    if (size() > most_dense) lay_out();
  }

  int size() const { return static_cast<int>(columns_.size()); }
  const std::vector<int>& columns(int row) const { return columns_[static_cast<std::size_t>(row)]; }
  Matrix6d* blocks(int row) { return blocks_.data() + begin_[static_cast<std::size_t>(row)]; }
  auto right(int row) { return right_.segment<6>(6 * row); }

  bool solve(Eigen::VectorXd& result) {
    if (size() == 0) {
      result.resize(0);
      return true;
    }
    return (size() <= most_dense ? solve_dense(result) : solve_sparse(result)) && result.allFinite();
  }

 private:
  bool solve_dense(Eigen::VectorXd& result) {
    dense_.setZero(6 * size(), 6 * size());
    for (int row = 0; row < size(); ++row) {
      const Matrix6d* block = blocks(row);
      for (const int column : columns(row)) dense_.block<6, 6>(6 * row, 6 * column) = *block++;
    }
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> solver(dense_);
    if (solver.info() != Eigen::Success) return false;
    result = solver.solve(right_);
    return true;
  }

  /// The sparse matrix, column by column, diagonal blocks in full.
  void lay_out() {
    std::vector<int> count(columns_.size(), 0);
    for (const auto& row : columns_) {
      for (const int column : row) index_in_column_.push_back(count[static_cast<std::size_t>(column)]++);
    }
    sparse_.resize(6 * size(), 6 * size());
    sparse_.resizeNonZeros(static_cast<Eigen::Index>(36 * begin_.back()));
    int* outer = sparse_.outerIndexPtr();
    for (int column = 0, at = 0; column < size(); ++column) {
      column_begin_.push_back(at);
      for (int k = 0; k < 6; ++k, at += 6 * count[static_cast<std::size_t>(column)]) outer[6 * column + k] = at;
    }
    outer[6 * size()] = static_cast<int>(36 * begin_.back());
    height_ = std::move(count);
    for (int row = 0; row < size(); ++row) {
      for (std::size_t k = begin_[static_cast<std::size_t>(row)]; k < begin_[static_cast<std::size_t>(row) + 1]; ++k) {
        for (int j = 0; j < 6; ++j) {
          int* inner = sparse_.innerIndexPtr() + offset_of(k, column_of(row, k), j);
          for (int i = 0; i < 6; ++i) inner[i] = 6 * row + i;
        }
      }
    }
    solver_.emplace();
    solver_->analyzePattern(sparse_);
  }

  int column_of(int row, std::size_t k) const { return columns(row)[k - begin_[static_cast<std::size_t>(row)]]; }
  std::ptrdiff_t offset_of(std::size_t k, int column, int j) const {
    const auto at = static_cast<std::size_t>(column);
    return column_begin_[at] + 6 * (static_cast<std::ptrdiff_t>(j) * height_[at] + index_in_column_[k]);
  }

  bool solve_sparse(Eigen::VectorXd& result) {
    for (int row = 0; row < size(); ++row) {
      for (std::size_t k = begin_[static_cast<std::size_t>(row)]; k < begin_[static_cast<std::size_t>(row) + 1]; ++k) {
        for (int j = 0; j < 6; ++j)
          Eigen::Map<Vector6d>(sparse_.valuePtr() + offset_of(k, column_of(row, k), j)) = blocks_[k].col(j);
      }
    }
    solver_->factorize(sparse_);
    if (solver_->info() != Eigen::Success) return false;
    result = solver_->solve(right_);
    return true;
  }

  std::vector<std::vector<int>> columns_;
  std::vector<std::size_t> begin_;
  std::vector<Matrix6d> blocks_;
  Eigen::VectorXd right_;
  Eigen::MatrixXd dense_;
  Eigen::SparseMatrix<double> sparse_;
  std::optional<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower>> solver_;
  std::vector<int> index_in_column_;  ///< By block: index in its column.
  std::vector<int> column_begin_;     ///< In the values.
  std::vector<int> height_;           ///< Blocks of a column.
};

BundleNormal::BundleNormal(const Bundle& bundle, const BundleOptions& options, TaskPool* pool)
    : options_(options), pool_(pool), free_index_(bundle.fixed.size(), -1), points_(bundle.points.size()) {
  for (std::size_t i = 0; i < free_index_.size(); ++i) {
    if (bundle.fixed[i] == 0) free_index_[i] = free_++;
  }
  sort(bundle);
  find_rows(bundle);
}

BundleNormal::~BundleNormal() = default;

void BundleNormal::sort(const Bundle& bundle) {
  const auto& seen = bundle.observations;
  point_begin_.assign(bundle.points.size() + 1, 0);
  for (const BundleObservation& one : seen) ++point_begin_[one.point + 1];
  for (std::size_t i = 1; i < point_begin_.size(); ++i) point_begin_[i] += point_begin_[i - 1];
  std::vector<std::size_t> next(point_begin_.begin(), point_begin_.end() - 1);
  order_.resize(seen.size());
  point_of_.resize(seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const std::size_t at = next[seen[i].point]++;
    order_[at] = static_cast<std::uint32_t>(i);
    point_of_[at] = seen[i].point;
  }
  links_.resize(seen.size());
  link_camera_.resize(seen.size());
  for (std::size_t k = 0; k < order_.size(); ++k) link_camera_[k] = free_index_[seen[order_[k]].camera];
}

void BundleNormal::find_rows(const Bundle& bundle) {
  row_begin_.assign(static_cast<std::size_t>(free_) + 1, 0);
  for (const int index : link_camera_) {
    if (index >= 0) ++row_begin_[static_cast<std::size_t>(index) + 1];
  }
  for (std::size_t i = 1; i < row_begin_.size(); ++i) row_begin_[i] += row_begin_[i - 1];
  row_link_.resize(row_begin_.back());
  std::vector<std::size_t> next(row_begin_.begin(), row_begin_.end() - 1);
  for (std::size_t k = 0; k < link_camera_.size(); ++k) {
    if (link_camera_[k] >= 0)
      row_link_[next[static_cast<std::size_t>(link_camera_[k])]++] = static_cast<std::uint32_t>(k);
  }
  std::vector<std::vector<int>> linked(static_cast<std::size_t>(free_));
  for (const BundleRelativePose& measured : bundle.relative_poses) {
    const int from = free_index_[measured.from], to = free_index_[measured.to];
    if (from >= 0 && to >= 0) linked[static_cast<std::size_t>(std::max(from, to))].push_back(std::min(from, to));
  }
  std::vector<std::vector<int>> columns(static_cast<std::size_t>(free_));
  std::vector<int> last_row(static_cast<std::size_t>(free_), -1);
  for (int row = 0; row < free_; ++row) {
    auto& mine = columns[static_cast<std::size_t>(row)];
    const auto add = [&](int index) {
      if (index < 0 || index > row || last_row[static_cast<std::size_t>(index)] == row) return;
      last_row[static_cast<std::size_t>(index)] = row;
      mine.push_back(index);
    };
    add(row);
    for (const int other : linked[static_cast<std::size_t>(row)]) add(other);
    for (std::size_t r = row_begin_[static_cast<std::size_t>(row)]; r < row_begin_[static_cast<std::size_t>(row) + 1];
         ++r) {
      const std::uint32_t point = point_of_[row_link_[r]];
      for (std::size_t k = point_begin_[point]; k < point_begin_[point + 1]; ++k) add(link_camera_[k]);
    }
    std::sort(mine.begin(), mine.end());
  }
  reduced_ = std::make_unique<Reduced>(std::move(columns));
}

template <int Rows>
void BundleNormal::add_observation(const Bundle& bundle, std::size_t k, Eigen::Matrix3d& normal, Eigen::Vector3d& right,
                                   CameraSums& sums) {
  const BundleObservation& seen = bundle.observations[order_[k]];
  const CameraMatrix& camera = cameras_[seen.camera];
  link_camera_[k] = -1;
  const Eigen::Vector3d p = camera.rotation * bundle.points[seen.point] + camera.translation;
  if (!(p.z() > least_bundle_depth)) return;
  const double inverse = 1.0 / p.z(), unit = 1.0 / seen.sigma, x = p.x() * inverse, y = p.y() * inverse;
  Eigen::Matrix<double, Rows, 3> by_translation;
  Eigen::Matrix<double, Rows, 1> error;
  const double along = unit * inverse;
  by_translation.row(0) << along, 0.0, -x * along;
  by_translation.row(1) << 0.0, along, -y * along;
  error[0] = unit * (x - seen.ray.x());
  error[1] = unit * (y - seen.ray.y());
  if constexpr (Rows == 3) {
    const double right_x = x - bundle.baseline * inverse;
    by_translation.row(2) << along, 0.0, -right_x * along;
    error[2] = unit * (right_x - seen.right_x);
  }
  const double weight = bundle_kernel(seen, options_).weight(error.squaredNorm());
  const Eigen::Matrix<double, Rows, 3> by_point = by_translation * camera.rotation;
  const Eigen::Matrix<double, 3, Rows> weighted_point = weight * by_point.transpose();
  normal.noalias() += weighted_point * by_point;
  right.noalias() -= weighted_point * error;
  const int index = free_index_[seen.camera];
  if (index < 0) return;
  Eigen::Matrix<double, Rows, 6> by_camera;
  by_camera.template leftCols<3>() = by_translation;
  for (int row = 0; row < Rows; ++row)
    by_camera.template block<1, 3>(row, 3) = p.cross(by_translation.row(row).transpose()).transpose();
  const Eigen::Matrix<double, 6, Rows> weighted = weight * by_camera.transpose();
  sums.blocks[static_cast<std::size_t>(index)].noalias() += weighted * by_camera;
  sums.right[static_cast<std::size_t>(index)].noalias() -= weighted * error;
  links_[k].noalias() = weighted * by_point;
  link_camera_[k] = index;
}

void BundleNormal::add_points(const Bundle& bundle, int begin, int end, double damping, CameraSums& sums) {
  sums.blocks.assign(static_cast<std::size_t>(free_), Matrix6d::Zero());
  sums.right.assign(static_cast<std::size_t>(free_), Vector6d::Zero());
  for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Point& point = points_[i];
    point.right.setZero();
    for (std::size_t k = point_begin_[i]; k < point_begin_[i + 1]; ++k) {
      const bool stereo = !std::isnan(bundle.observations[order_[k]].right_x);
      if (stereo) {
        add_observation<3>(bundle, k, normal, point.right, sums);
      } else {
        add_observation<2>(bundle, k, normal, point.right, sums);
      }
    }
    // If the views do not determine its depth, a point stays: its position would be rounding error.
    const double size = normal.trace() / 3.0;
    const bool held = normal.determinant() > 1e-14 * size * size * size;
    normal.diagonal() *= 1.0 + damping;
    point.inverse = held ? normal.inverse().eval() : Eigen::Matrix3d::Zero().eval();
  }
}

/// The residual is small where it counts, so that its derivatives are those at zero.
void BundleNormal::add_relative_poses(const Bundle& bundle) {
  pose_links_.clear();
  for (const BundleRelativePose& measured : bundle.relative_poses) {
    PoseLink link;
    link.from = free_index_[measured.from], link.to = free_index_[measured.to];
    if (link.from < 0 && link.to < 0) continue;
    const SE3 &from_from_world = bundle.camera_from_world[measured.from],
              &to_from_world = bundle.camera_from_world[measured.to];
    const Vector6d error = relative_pose_error(measured, from_from_world, to_from_world);
    const double weight = relative_pose_kernel(options_).weight(error.dot(measured.information * error));
    const Matrix6d information = weight * measured.information;
    const Matrix6d by_from = -(to_from_world * from_from_world.inverse()).adjoint();
    link.of_to = information;
    link.right_to = -information * error;
    link.between = information * by_from;
    link.of_from = by_from.transpose() * link.between;
    link.right_from = by_from.transpose() * link.right_to;
    pose_links_.push_back(link);
  }
}

void BundleNormal::reduce_row(int row, double damping) {
  const auto& columns = reduced_->columns(row);
  Matrix6d* blocks = reduced_->blocks(row);
  std::vector<int> slot(static_cast<std::size_t>(row) + 1, -1);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    slot[static_cast<std::size_t>(columns[i])] = static_cast<int>(i);
    blocks[i].setZero();
  }
  Vector6d right = Vector6d::Zero();
  Matrix6d& own = blocks[columns.size() - 1];
  for (const CameraSums& sums : sums_) {
    own += sums.blocks[static_cast<std::size_t>(row)];
    right += sums.right[static_cast<std::size_t>(row)];
  }
  for (const PoseLink& link : pose_links_) {
    if (link.from == row) own += link.of_from, right += link.right_from;
    if (link.to == row) own += link.of_to, right += link.right_to;
    if (std::min(link.from, link.to) < 0 || std::max(link.from, link.to) != row) continue;
    Matrix6d& block = blocks[slot[static_cast<std::size_t>(std::min(link.from, link.to))]];
    if (link.to == row)
      block += link.between;
    else
      block += link.between.transpose();
  }
  own.diagonal() *= 1.0 + damping;
  own.diagonal().array() += 1e-12 * own.trace() + 1e-30;
  for (std::size_t r = row_begin_[static_cast<std::size_t>(row)]; r < row_begin_[static_cast<std::size_t>(row) + 1];
       ++r) {
    const std::uint32_t k = row_link_[r], i = point_of_[k];
    if (link_camera_[k] < 0) continue;
    const Matrix63 scaled = links_[k] * points_[i].inverse;
    right.noalias() -= scaled * points_[i].right;
    for (std::size_t other = point_begin_[i]; other < point_begin_[i + 1]; ++other) {
      const int index = link_camera_[other];
      if (index < 0 || index > row) continue;
      blocks[slot[static_cast<std::size_t>(index)]].noalias() -= scaled * links_[other].transpose();
    }
  }
  reduced_->right(row) = right;
}

bool BundleNormal::solve(const Bundle& bundle, double damping, BundleStep& step) {
  cameras_.clear();
  for (const SE3& pose : bundle.camera_from_world) cameras_.push_back({pose.rotation().matrix(), pose.translation()});
  const int count = static_cast<int>(points_.size()), grain = grain_of(count);
  sums_.resize(static_cast<std::size_t>((count + grain - 1) / grain));
  const auto over = [&](int end, int chunk, const std::function<void(int, int)>& body) {
    if (pool_ != nullptr) return pool_->for_chunks(0, end, chunk, body);
    for (int begin = 0; begin < end; begin += chunk) body(begin, std::min(end, begin + chunk));
  };
  over(count, grain, [&](int begin, int end) {
    add_points(bundle, begin, end, damping, sums_[static_cast<std::size_t>(begin / grain)]);
  });
  add_relative_poses(bundle);
  over(free_, 2, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) reduce_row(row, damping);
  });
  if (!reduced_->solve(step.cameras)) return false;
  step.points.resize(points_.size());
  in_chunks(pool_, count, [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      Eigen::Vector3d right = points_[i].right;
      for (std::size_t k = point_begin_[i]; k < point_begin_[i + 1]; ++k) {
        if (link_camera_[k] >= 0)
          right.noalias() -= links_[k].transpose() * step.cameras.segment<6>(6 * link_camera_[k]);
      }
      step.points[i] = points_[i].inverse * right;
    }
  });
  return true;
}

}  // namespace rastro
