// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/initialization/two_view_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "rastro/multiview/absolute_pose.h"

namespace rastro {
namespace {

Tracker start_tracker(const TwoViewStartOptions& options, const Camera& camera, TaskPool* pool) {
  TrackOptions tracks;
  tracks.features = options.features;
  tracks.min_distance_px = 12.0;
  tracks.seed = options.seed;
  return Tracker(tracks, camera, pool);
}

}  // namespace

double mean_inverse_depth(const InverseDepthMap& depth) {
  // Sums side by side, which the compiler adds at once. Unknown pixels add zero.
  constexpr int columns = 8;
  std::array<float, columns> count{}, of_row{};
  double sum = 0.0;
  for (int y = 0; y < depth.height(); ++y) {
    const float *mean = depth.mean.row(y), *variance = depth.variance.row(y);
    of_row.fill(0.0F);
    for (int x = 0; x < depth.width(); x += columns)
      for (int i = 0; i < std::min(columns, depth.width() - x); ++i) {
        const auto column = static_cast<std::size_t>(i);
        of_row[column] += variance[x + i] > 0.0F ? mean[x + i] : 0.0F;
        count[column] += variance[x + i] > 0.0F ? 1.0F : 0.0F;
      }
    for (const float each : of_row) sum += static_cast<double>(each);
  }
  const auto known = static_cast<double>(std::accumulate(count.begin(), count.end(), 0.0F));
  return known > 0.0 ? sum / known : 0.0;
}

void scale_inverse_depth(InverseDepthMap& depth, double factor) {
  const auto of_mean = static_cast<float>(factor), of_variance = static_cast<float>(factor * factor);
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) depth.mean.at(x, y) *= of_mean, depth.variance.at(x, y) *= of_variance;
}

TwoViewStart::TwoViewStart(const TwoViewStartOptions& options, const Camera& camera, TaskPool* pool)
    : options_(options), camera_(camera), pool_(pool), tracker_(start_tracker(options, camera, pool)) {}

void TwoViewStart::reset() {
  tracker_.emplace(start_tracker(options_, camera_, pool_));
  frames_.clear();
  first_ = 0;
  detail_.clear();
}

std::optional<TwoViewStart::Result> TwoViewStart::take(std::int64_t index, TimeNs stamp, GrayImage image,
                                                       GrayImage mask) {
  const TrackFrame tracked = tracker_->process(image.view(), stamp, mask.view());
  KeptFrame frame{index, stamp, std::move(image), std::move(mask), {}};
  for (const TrackedFeature& feature : tracked.features)
    if (feature.ray.allFinite()) frame.features.emplace(feature.id, feature);
  frames_.push_back(std::move(frame));
  if (frames_.size() > static_cast<std::size_t>(options_.frames)) {
    frames_.pop_front();
    first_ -= first_ > 0 ? 1 : 0;
  }
  detail_ = "the first frame";
  // A first view that shares too little with the newest frame is replaced by a later one.
  const auto needed = static_cast<std::size_t>(options_.min_matches);
  while (first_ + 1 < frames_.size() && matches_with(first_).pairs.size() < needed) {
    detail_ = fmt::format("fewer than {} features were followed since the first view", needed);
    ++first_;
  }
  if (first_ + 1 == frames_.size()) return std::nullopt;
  Attempt attempt = try_first(first_);
  detail_ = attempt.detail;
  return attempt.status == TwoViewStatus::no_model ? nearer_first() : attempt.start;
}

/// Of what was followed over many frames, much may have slipped. The first view is replaced by one nearer to the newest
/// frame that shares a motion with it. If there is none, the newest frame is the problem.
std::optional<TwoViewStart::Result> TwoViewStart::nearer_first() {
  const std::size_t newest = frames_.size() - 1;
  for (std::size_t gap = (newest - first_) / 2; gap > 0; gap /= 2) {
    Attempt attempt = try_first(newest - gap);
    if (attempt.status == TwoViewStatus::no_model || attempt.status == TwoViewStatus::too_few_pairs) continue;
    first_ = newest - gap;
    detail_ = attempt.detail;
    return attempt.start;
  }
  return std::nullopt;
}

TwoViewStart::Matches TwoViewStart::matches_with(std::size_t first) const {
  Matches matches;
  for (const auto& [id, feature] : frames_.back().features) {
    const auto before = frames_[first].features.find(id);
    if (before == frames_[first].features.end()) continue;
    matches.tracks.push_back(id);
    matches.pairs.push_back(
        {before->second.ray.cast<double>(), feature.ray.cast<double>(), options_.pixel_sigma, options_.pixel_sigma});
    matches.pixels.push_back(before->second.pixel);
  }
  return matches;
}

TwoViewStart::Attempt TwoViewStart::try_first(std::size_t first) const {
  const Matches matches = matches_with(first);
  TwoViewOptions options;
  options.focal_px = camera_.fx;
  options.min_parallax_deg = options_.min_parallax_deg;
  options.seed = options_.seed;
  const TwoViewFit fit = find_two_view_motion(matches.pairs, options);
  if (fit.status != TwoViewStatus::found) return {fit.status, fit.detail, std::nullopt};
  const std::optional<double> confirmed = confirmed_share(first, matches, fit);
  if (!confirmed) return {TwoViewStatus::ambiguous, "no third view has seen enough of what two views share", {}};
  if (*confirmed < options_.min_confirmed_share)
    return {TwoViewStatus::ambiguous,
            fmt::format("other views confirm {:.0f} % of the points, need {:.0f} %", 100.0 * *confirmed,
                        100.0 * options_.min_confirmed_share),
            std::nullopt};
  Result start{first, fit.second_from_first, depths_of(matches, fit)};
  const double mean = mean_inverse_depth(start.depth);
  if (!(mean > 0.0)) return {TwoViewStatus::too_few_points, "no depth is known", std::nullopt};
  scale_inverse_depth(start.depth, 1.0 / mean);
  start.second_from_first = SE3(fit.second_from_first.rotation(), mean * fit.second_from_first.translation());
  return {fit.status, {}, std::move(start)};
}

/// Share of the points that lie where the other frames saw them, over all frames that saw enough of them; nullopt:
/// none did.
std::optional<double> TwoViewStart::confirmed_share(std::size_t first, const Matches& matches,
                                                    const TwoViewFit& fit) const {
  constexpr std::size_t fewest_points = 30;
  AbsolutePoseOptions options;
  options.focal_px = camera_.fx;
  options.max_error_px = 3.0 * options_.pixel_sigma;
  options.seed = options_.seed;
  std::size_t seen = 0, confirmed = 0;
  for (std::size_t k = 0; k + 1 < frames_.size(); ++k) {
    if (k == first) continue;
    std::vector<Eigen::Vector3d> points;
    std::vector<Eigen::Vector2d> rays;
    for (std::size_t i = 0; i < matches.tracks.size(); ++i) {
      const auto feature = frames_[k].features.find(matches.tracks[i]);
      if (!fit.points[i] || feature == frames_[k].features.end()) continue;
      points.push_back(*fit.points[i]);
      rays.push_back(feature->second.ray.cast<double>());
    }
    if (points.size() < fewest_points) continue;
    const auto pose = estimate_absolute_pose(points, rays, options);
    seen += points.size();
    confirmed += pose ? static_cast<std::size_t>(pose->inliers) : 0;
  }
  if (seen == 0) return std::nullopt;
  return static_cast<double>(confirmed) / static_cast<double>(seen);
}

/// The depth of a feature is that of the pixels around it too, but less surely.
InverseDepthMap TwoViewStart::depths_of(const Matches& matches, const TwoViewFit& fit) const {
  constexpr int reach = 2;
  constexpr double relative_sigma = 0.1;
  const GrayImage& image = frames_.front().image;
  InverseDepthMap depth(image.width(), image.height());
  for (std::size_t i = 0; i < matches.pairs.size(); ++i) {
    if (!fit.points[i]) continue;
    const double mean = 1.0 / fit.points[i]->z(), sigma = relative_sigma * mean;
    const auto cx = static_cast<int>(std::lround(matches.pixels[i].x())),
               cy = static_cast<int>(std::lround(matches.pixels[i].y()));
    for (int y = std::max(0, cy - reach); y <= std::min(image.height() - 1, cy + reach); ++y)
      for (int x = std::max(0, cx - reach); x <= std::min(image.width() - 1, cx + reach); ++x) {
        depth.mean.at(x, y) = static_cast<float>(mean);
        depth.variance.at(x, y) = static_cast<float>(sigma * sigma);
      }
  }
  return depth;
}

}  // namespace rastro
