// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/depth_map.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "rastro/slam/lsd/depth/depth_kernels.h"

namespace rastro {
namespace {

constexpr int border = 4;  // pixels at the edge without room for samples
constexpr int row_grain = 8;
constexpr std::int8_t confirmed = -3;  // what was known before counts as seen so often

GrayImage copy_of(GrayView image) {
  GrayImage copy(image.width, image.height);
  for (int y = 0; y < image.height; ++y) std::copy(image.row(y), image.row(y) + image.width, copy.row(y));
  return copy;
}

float gradient_at(GrayView image, int x, int y) {
  const auto dx = 0.5F * static_cast<float>(image.at(x + 1, y) - image.at(x - 1, y)),
             dy = 0.5F * static_cast<float>(image.at(x, y + 1) - image.at(x, y - 1));
  return dx * dx + dy * dy;
}

/// Pixels next to a strong gradient take part as well.
/// Of a window of samples around the pixel.
bool is_usable(GrayView mask, int x, int y) {
  constexpr int reach = epipolar_samples / 2;
  if (mask.empty()) return true;
  for (int v = y - reach; v <= y + reach; ++v)
    for (int u = x - reach; u <= x + reach; ++u)
      if (mask.at(u, v) == 0) return false;
  return true;
}

Image<std::uint8_t> gradient_mask(GrayView image, float least, GrayView usable) {
  Image<std::uint8_t> strong(image.width, image.height), mask(image.width, image.height);
  for (int y = border - 1; y < image.height - border + 1; ++y)
    for (int x = border - 1; x < image.width - border + 1; ++x)
      strong.at(x, y) = gradient_at(image, x, y) >= least * least ? 1 : 0;
  for (int y = border; y < image.height - border; ++y)
    for (int x = border; x < image.width - border; ++x)
      mask.at(x, y) =
          strong.at(x, y) | strong.at(x - 1, y) | strong.at(x + 1, y) | strong.at(x, y - 1) | strong.at(x, y + 1);
  for (int y = border; y < image.height - border && !usable.empty(); ++y)
    for (int x = border; x < image.width - border; ++x)
      if (mask.at(x, y) != 0 && !is_usable(usable, x, y)) mask.at(x, y) = 0;
  return mask;
}

void for_rows(int height, TaskPool* pool, const std::function<void(int begin, int end)>& rows) {
  pool ? pool->for_chunks(border, height - border, row_grain, rows) : rows(border, height - border);
}

bool agree(float a, float b, float variance, float sigmas = 2.0F) {
  return (a - b) * (a - b) <= sigmas * sigmas * variance;
}

}  // namespace

DepthUpdate& DepthUpdate::operator+=(const DepthUpdate& other) {
  updated += other.updated, created += other.created, contradicted += other.contradicted;
  for (std::size_t i = 0; i < by_result.size(); ++i) by_result[i] += other.by_result[i];
  return *this;
}

DepthMap::DepthMap(GrayView image, const Camera& camera, const DepthMapOptions& options, GrayView mask)
    : options_(options),
      camera_(camera),
      image_(copy_of(image)),
      has_gradient_(gradient_mask(image, options.min_gradient, mask)),
      depth_(image.width, image.height),
      smoothed_(image.width, image.height),
      failures_(image.width, image.height) {}

void DepthMap::start_random(std::uint64_t seed) {
  Random random(seed);
  const double sigma = options_.start_sigma;
  for (int y = border; y < image_.height() - border; ++y)
    for (int x = border; x < image_.width() - border; ++x) {
      if (has_gradient_.at(x, y) == 0) continue;
      depth_.mean.at(x, y) = static_cast<float>(random.uniform(1.0 - sigma, 1.0 + sigma));
      depth_.variance.at(x, y) = static_cast<float>(sigma * sigma);
      failures_.at(x, y) = confirmed;
    }
}

void DepthMap::start_from(const InverseDepthMap& depth) {
  for (int y = border; y < image_.height() - border; ++y)
    for (int x = border; x < image_.width() - border; ++x) {
      if (has_gradient_.at(x, y) == 0 || !depth.is_known(x, y)) continue;
      depth_.mean.at(x, y) = depth.mean.at(x, y);
      depth_.variance.at(x, y) = depth.variance.at(x, y);
      failures_.at(x, y) = confirmed;
    }
}

DepthUpdate DepthMap::observe(GrayView image, const SE3& image_from_keyframe, double gain, double offset,
                              TaskPool* pool, GrayView mask) {
  ++observations_;
  EpipolarSearch search(image_.view(), image, camera_, image_from_keyframe, gain, offset, options_.search);
  search.leave_out(mask);
  return for_batches([&](const EpipolarQueries& queries, EpipolarMatches& matches) { search.find(queries, matches); },
                     false, pool);
}

DepthUpdate DepthMap::measure(const DepthSearch& sensor, TaskPool* pool) { return for_batches(sensor, true, pool); }

DepthUpdate DepthMap::for_batches(const DepthSearch& search, bool is_sensor, TaskPool* pool) {
  std::vector<DepthUpdate> of_chunks(static_cast<std::size_t>(image_.height()));
  for_rows(image_.height(), pool, [&](int begin, int end) {
    of_chunks[static_cast<std::size_t>(begin)] = update_rows(begin, end, search, is_sensor);
  });
  DepthUpdate update;
  for (const DepthUpdate& each : of_chunks) update += each;
  return update;
}

DepthUpdate DepthMap::update_rows(int begin, int end, const DepthSearch& search, bool is_sensor) {
  DepthUpdate update;
  EpipolarQueries known, unknown;
  known.known = true;
  EpipolarMatches matches;
  const auto flush = [&](EpipolarQueries& queries) {
    search(queries, matches);
    take(queries, matches, is_sensor, update);
    queries.count = 0;
  };
  for (int y = begin; y < end; ++y)
    for (int x = border; x < image_.width() - border; ++x) {
      if (has_gradient_.at(x, y) == 0) continue;
      EpipolarQueries& queries = depth_.is_known(x, y) ? known : unknown;
      DepthPrior prior = prior_of(x, y);
      if (is_sensor) prior.worthwhile_variance = std::numeric_limits<double>::infinity();
      add_query(x, y, prior, queries);
      if (queries.count == epipolar_batch) flush(queries);
    }
  flush(known);
  flush(unknown);
  return update;
}

void DepthMap::take(const EpipolarQueries& queries, const EpipolarMatches& matches, bool is_sensor,
                    DepthUpdate& update) {
  constexpr std::int8_t seen = -1;  // a sensor confirms what it says itself
  for (int i = 0; i < queries.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const int x = static_cast<int>(queries.x[k]), y = static_cast<int>(queries.y[k]);
    take(x, y, match_at(matches, i), update);
    if (is_sensor && !queries.known && depth_.is_known(x, y)) failures_.at(x, y) = seen;
  }
}

void DepthMap::take(int x, int y, const EpipolarMatch& match, DepthUpdate& update) {
  ++update.by_result[static_cast<std::size_t>(match.result)];
  if (match.result == EpipolarResult::matched)
    fuse(x, y, match, update);
  else if (match.result == EpipolarResult::poor_match && depth_.is_known(x, y))
    fail(x, y);
}

DepthPrior DepthMap::prior_of(int x, int y) const {
  if (!depth_.is_known(x, y)) return {0.0, expected_, expected_ * options_.search.max_inverse_depth};
  const auto mean = static_cast<double>(depth_.mean.at(x, y)), variance = static_cast<double>(depth_.variance.at(x, y));
  const double reach = 2.0 * std::sqrt(variance);
  DepthPrior prior{std::max(0.0, mean - reach), mean, mean + reach, true};
  // Beyond that, fuse() would leave the variance as it is: a part of the pixels in turn finds out what is wrong.
  constexpr int turns = 3;
  if ((x + y + observations_) % turns != 0) prior.worthwhile_variance = variance / options_.common_share;
  return prior;
}

/// As in a Kalman filter (equations 14 and 15).
void DepthMap::fuse(int x, int y, const EpipolarMatch& match, DepthUpdate& update) {
  float &mean = depth_.mean.at(x, y), &variance = depth_.variance.at(x, y);
  if (!depth_.is_known(x, y)) {
    const auto most = static_cast<float>(options_.max_relative_sigma) * match.mean;
    if (match.variance > most * most || failures_.at(x, y) > 0) {
      failures_.at(x, y) = static_cast<std::int8_t>(std::max(0, failures_.at(x, y) - 1));
      return;
    }
    mean = match.mean, variance = match.variance;
    ++update.created;
    return;
  }
  const float prior = static_cast<float>(options_.growth) * variance;
  if (!agree(mean, match.mean, prior + match.variance, static_cast<float>(options_.max_sigmas))) {
    ++update.contradicted;
    return fail(x, y);
  }
  mean = (match.variance * mean + prior * match.mean) / (prior + match.variance);
  // Frames at about the same place err alike: many of them tell little more than one.
  const float fused = prior * match.variance / (prior + match.variance);
  variance = std::max(fused, std::min(prior, static_cast<float>(options_.common_share) * match.variance));
  failures_.at(x, y) = static_cast<std::int8_t>(std::max(-10, failures_.at(x, y) - 1));
  ++update.updated;
}

void DepthMap::fail(int x, int y) {
  depth_.variance.at(x, y) *= 1.1F;
  if (++failures_.at(x, y) > options_.most_failures) forget(x, y);
}

void DepthMap::forget(int x, int y) {
  depth_.mean.at(x, y) = depth_.variance.at(x, y) = 0.0F;
  failures_.at(x, y) = 2;
}

void DepthMap::regularize(TaskPool* pool) {
  const InverseDepthMap before = depth_;
  for_rows(image_.height(), pool, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) fill_row(y, before);
  });
  for_rows(image_.height(), pool, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) smooth_row(y);
  });
}

/// A hole with enough neighbors that agree gets their mean.
void DepthMap::fill_row(int y, const InverseDepthMap& before) {
  constexpr int fewest = 6;
  for (int x = border; x < image_.width() - border; ++x) {
    if (has_gradient_.at(x, y) == 0 || before.is_known(x, y) || failures_.at(x, y) > 0) continue;
    float sum = 0.0F, weights = 0.0F, squares = 0.0F;
    int count = 0;
    for (int v = y - 1; v <= y + 1; ++v)
      for (int u = x - 1; u <= x + 1; ++u) {
        if (!before.is_known(u, v)) continue;
        const float weight = 1.0F / before.variance.at(u, v), mean = before.mean.at(u, v);
        sum += weight * mean, weights += weight, squares += weight * mean * mean;
        ++count;
      }
    if (count < fewest) continue;
    const float mean = sum / weights, spread = std::max(0.0F, squares / weights - mean * mean);
    depth_.mean.at(x, y) = mean;
    depth_.variance.at(x, y) = 4.0F * (static_cast<float>(count) / weights + spread);
  }
}

/// A depth that was seen only once, or that no neighbor supports, is shown to nobody.
void DepthMap::smooth_row(int y) {
  const SmoothingOptions smoothing{.border = border, .fewest = options_.least_support};
  float *mean = smoothed_.mean.row(y), *variance = smoothed_.variance.row(y);
  depth_kernels().smooth_row(depth_, y, smoothing, mean);
  for (int x = border; x < image_.width() - border; ++x) {
    if (failures_.at(x, y) >= 0) mean[x] = 0.0F;
    variance[x] = mean[x] > 0.0F ? depth_.variance.at(x, y) : 0.0F;
  }
}

DepthMap DepthMap::propagate(GrayView new_image, const SE3& new_from_keyframe, GrayView new_mask) const {
  DepthMap result(new_image, camera_, options_, new_mask);
  const Eigen::Matrix3d rotation = new_from_keyframe.rotation().matrix();
  const double added = options_.propagation_sigma * options_.propagation_sigma;
  for (int y = border; y < image_.height() - border; ++y)
    for (int x = border; x < image_.width() - border; ++x) {
      if (!smoothed_.is_known(x, y)) continue;
      const auto mean = static_cast<double>(smoothed_.mean.at(x, y));
      const Eigen::Vector3d ray((x - camera_.cx) / camera_.fx, (y - camera_.cy) / camera_.fy, 1.0);
      const Eigen::Vector3d point = rotation * ray + mean * new_from_keyframe.translation();
      if (!(point.z() > 0.1)) continue;
      const int u = static_cast<int>(std::lround(camera_.fx * point.x() / point.z() + camera_.cx)),
                v = static_cast<int>(std::lround(camera_.fy * point.y() / point.z() + camera_.cy));
      if (u < border || v < border || u >= image_.width() - border || v >= image_.height() - border) continue;
      const double there = mean / point.z(), ratio = there / mean;
      const double variance =
          ratio * ratio * ratio * ratio * static_cast<double>(depth_.variance.at(x, y)) + added * there * there;
      result.receive(u, v, static_cast<float>(there), static_cast<float>(variance));
    }
  return result;
}

void DepthMap::receive(int x, int y, float mean, float variance) {
  if (has_gradient_.at(x, y) == 0) return;
  float &there = depth_.mean.at(x, y), &there_variance = depth_.variance.at(x, y);
  failures_.at(x, y) = confirmed;
  if (depth_.is_known(x, y) && agree(there, mean, there_variance + variance)) {
    there = (variance * there + there_variance * mean) / (variance + there_variance);
    there_variance = std::min(there_variance, variance);  // not independent: both come from the same images
  } else if (mean > there) {                              // the nearer one, or the first: nothing is farther than 0
    there = mean, there_variance = variance;
  }
}

double DepthMap::mean() const {
  double sum = 0.0, count = 0.0;
  for (int y = border; y < image_.height() - border; ++y)
    for (int x = border; x < image_.width() - border; ++x) {
      if (!depth_.is_known(x, y)) continue;
      sum += static_cast<double>(depth_.mean.at(x, y));
      count += 1.0;
    }
  return count > 0.0 ? sum / count : 0.0;
}

void DepthMap::rescale(double factor) {
  const auto of_mean = static_cast<float>(factor), of_variance = static_cast<float>(factor * factor);
  for (InverseDepthMap* map : {&depth_, &smoothed_})
    for (int y = 0; y < map->height(); ++y)
      for (int x = 0; x < map->width(); ++x) map->mean.at(x, y) *= of_mean, map->variance.at(x, y) *= of_variance;
}

}  // namespace rastro
