// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/depth_map.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "rastro/slam/lsd/depth/depth_kernels.h"
#include "rastro/slam/lsd/depth/gradient_mask.h"
#include "rastro/slam/lsd/depth/shown_alike.h"

namespace rastro {
namespace {

constexpr int border = depth_border;
constexpr int row_grain = 8;
constexpr double pose_variance_px = 1.0;  // of where another keyframe shows a point, by its pose and between pixels
constexpr std::int8_t confirmed = -3;     // what was known before counts as seen so often
constexpr std::int8_t measured = -1;      // a sensor confirms what it says itself

GrayImage copy_of(GrayView image) {
  GrayImage copy(image.width, image.height);
  for (int y = 0; y < image.height; ++y) std::copy(image.row(y), image.row(y) + image.width, copy.row(y));
  return copy;
}

void for_rows(int height, TaskPool* pool, const std::function<void(int begin, int end)>& rows) {
  pool ? pool->for_chunks(border, height - border, row_grain, rows) : rows(border, height - border);
}

bool agree(float a, float b, float variance, float sigmas = 2.0F) {
  return (a - b) * (a - b) <= sigmas * sigmas * variance;
}

/// Pixels by which a point, given times its inverse depth, moves per unit of that, squared.
double squared_shift(const Camera& camera, const Eigen::Vector3d& point, const Eigen::Vector3d& translation) {
  const Eigen::Vector2d normalized = point.head<2>() / point.z();
  const Eigen::Vector2d shift = (translation.head<2>() - normalized * translation.z()) / point.z();
  return camera.fx * camera.fx * shift.squaredNorm();
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
  for (int y = begin; y < end; ++y) {
    const std::uint8_t* has_gradient = has_gradient_.row(y);
    for (int x = border; x < image_.width() - border; ++x) {
      if (has_gradient[x] == 0) continue;
      EpipolarQueries& queries = depth_.is_known(x, y) ? known : unknown;
      add_query(x, y, is_sensor, queries);
      if (queries.count == epipolar_batch) flush(queries);
    }
  }
  flush(known);
  flush(unknown);
  return update;
}

void DepthMap::add_query(int x, int y, bool is_sensor, EpipolarQueries& queries) const {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  const auto i = static_cast<std::size_t>(queries.count++);
  queries.x[i] = static_cast<float>(x), queries.y[i] = static_cast<float>(y);
  queries.worthwhile_variance[i] = infinite;
  if (!queries.known) {
    const auto expected = static_cast<float>(expected_);
    queries.least[i] = 0.0F, queries.expected[i] = expected;
    queries.most[i] = expected * static_cast<float>(options_.search.max_inverse_depth);
    return;
  }
  const float mean = depth_.mean.at(x, y), variance = depth_.variance.at(x, y), reach = 2.0F * std::sqrt(variance);
  queries.least[i] = std::max(0.0F, mean - reach), queries.expected[i] = mean, queries.most[i] = mean + reach;
  // Beyond that, fuse() would leave the variance as it is: a part of the pixels in turn finds out what is wrong.
  constexpr int turns = 3;
  if (!is_sensor && (x + y + observations_) % turns != 0)
    queries.worthwhile_variance[i] = variance / static_cast<float>(options_.common_share);
}

void DepthMap::take(const EpipolarQueries& queries, const EpipolarMatches& matches, bool is_sensor,
                    DepthUpdate& update) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(queries.count); ++i) {
    const int x = static_cast<int>(queries.x[i]), y = static_cast<int>(queries.y[i]);
    const auto result = static_cast<EpipolarResult>(matches.result[i]);
    ++update.by_result[static_cast<std::size_t>(result)];
    if (result == EpipolarResult::matched)
      fuse(x, y, matches.mean[i], matches.variance[i], is_sensor, update);
    else if (result == EpipolarResult::poor_match && queries.known)
      fail(x, y);
    if (is_sensor && !queries.known && depth_.is_known(x, y)) failures_.at(x, y) = measured;
  }
}

/// As in a Kalman filter (equations 14 and 15).
void DepthMap::fuse(int x, int y, float found, float found_variance, bool is_sensor, DepthUpdate& update) {
  float &mean = depth_.mean.at(x, y), &variance = depth_.variance.at(x, y);
  if (!depth_.is_known(x, y)) {
    const auto most = static_cast<float>(options_.max_relative_sigma) * found;
    if (found_variance > most * most || failures_.at(x, y) > 0) {
      failures_.at(x, y) = static_cast<std::int8_t>(std::max(0, failures_.at(x, y) - 1));
      return;
    }
    mean = found, variance = found_variance;
    ++update.created;
    return;
  }
  const float prior = static_cast<float>(options_.growth) * variance;
  if (!agree(mean, found, prior + found_variance, static_cast<float>(options_.max_sigmas))) {
    ++update.contradicted;
    if (!is_sensor) return fail(x, y);
    // What was propagated may be hidden here; a match along a line may be wrong, a measurement of this image is not.
    mean = found, variance = found_variance;
    failures_.at(x, y) = measured;
    return;
  }
  mean = (found_variance * mean + prior * found) / (prior + found_variance);
  // Frames at about the same place err alike: many of them tell little more than one.
  const float fused = prior * found_variance / (prior + found_variance);
  variance = std::max(fused, std::min(prior, static_cast<float>(options_.common_share) * found_variance));
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
  std::vector<std::vector<Filling>> of_chunks(static_cast<std::size_t>(image_.height()));
  for_rows(image_.height(), pool, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) find_fillings(y, of_chunks[static_cast<std::size_t>(begin)]);
  });
  for (const std::vector<Filling>& fillings : of_chunks)
    for (const Filling& filling : fillings) {
      depth_.mean.at(filling.x, filling.y) = filling.mean;
      depth_.variance.at(filling.x, filling.y) = filling.variance;
    }
  for_rows(image_.height(), pool, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) smooth_row(y);
  });
}

/// A hole with enough neighbors that agree gets their mean.
void DepthMap::find_fillings(int y, std::vector<Filling>& fillings) const {
  constexpr int fewest = 6;
  std::vector<int> holes(static_cast<std::size_t>(image_.width()));
  const int count = depth_kernels().find_holes(depth_, y, border, image_.width() - border, fewest, holes.data());
  for (int i = 0; i < count; ++i) {
    const int x = holes[static_cast<std::size_t>(i)];
    if (has_gradient_.at(x, y) != 0 && failures_.at(x, y) <= 0) fillings.push_back(mean_around(x, y));
  }
}

DepthMap::Filling DepthMap::mean_around(int x, int y) const {
  float sum = 0.0F, weights = 0.0F, squares = 0.0F;
  int count = 0;
  for (int v = y - 1; v <= y + 1; ++v)
    for (int u = x - 1; u <= x + 1; ++u) {
      if (!depth_.is_known(u, v)) continue;
      const float weight = 1.0F / depth_.variance.at(u, v), mean = depth_.mean.at(u, v);
      sum += weight * mean, weights += weight, squares += weight * mean * mean;
      ++count;
    }
  const float mean = sum / weights, spread = std::max(0.0F, squares / weights - mean * mean);
  return {x, y, mean, 4.0F * (static_cast<float>(count) / weights + spread)};
}

/// A depth that was seen only once, or that no neighbor supports, is shown to nobody.
void DepthMap::smooth_row(int y) {
  const SmoothingOptions smoothing{.border = border, .fewest = options_.least_support};
  float *mean = smoothed_.mean.row(y), *variance = smoothed_.variance.row(y);
  depth_kernels().smooth_row(depth_, y, smoothing, mean);
  const float* unsmoothed = depth_.variance.row(y);
  const std::int8_t* failures = failures_.row(y);
  for (int x = border; x < image_.width() - border; ++x) {
    const float shown = failures[x] < 0 ? mean[x] : 0.0F;
    mean[x] = shown;
    variance[x] = shown > 0.0F ? unsmoothed[x] : 0.0F;
  }
}

DepthMap DepthMap::propagate(GrayView new_image, const SE3& new_from_keyframe, double gain, double offset,
                             GrayView new_mask) const {
  DepthMap result(new_image, camera_, options_, new_mask);
  const Eigen::Matrix3d rotation = new_from_keyframe.rotation().matrix();
  const double added = options_.propagation_sigma * options_.propagation_sigma;
  ShownAlikeOptions alike{gain, offset, options_.search.intensity_sigma, 1.0, options_.most_changed};
  for (int y = border; y < image_.height() - border; ++y)
    for (int x = border; x < image_.width() - border; ++x) {
      if (!smoothed_.is_known(x, y)) continue;
      const auto mean = static_cast<double>(smoothed_.mean.at(x, y)),
                 own_variance = static_cast<double>(depth_.variance.at(x, y));
      const Eigen::Vector3d ray((x - camera_.cx) / camera_.fx, (y - camera_.cy) / camera_.fy, 1.0);
      const Eigen::Vector3d point = rotation * ray + mean * new_from_keyframe.translation();
      if (!(point.z() > 0.1)) continue;
      const Eigen::Vector2d pixel(camera_.fx * point.x() / point.z() + camera_.cx,
                                  camera_.fy * point.y() / point.z() + camera_.cy);
      const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
      if (u < border || v < border || u >= image_.width() - border || v >= image_.height() - border) continue;
      alike.position_variance =
          pose_variance_px + own_variance * squared_shift(camera_, point, new_from_keyframe.translation());
      if (!is_shown_alike(image_.view(), x, y, new_image, pixel, alike)) continue;
      const double there = mean / point.z(), ratio = there / mean;
      const double variance = ratio * ratio * ratio * ratio * own_variance + added * there * there;
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
