// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/tracked_window.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rastro/feature/corner.h"
#include "rastro/math/median.h"
#include "rastro/track/klt.h"

namespace rastro {
namespace {

constexpr int followed_features = 220, window_levels = 4;
constexpr std::size_t fewest_alive = 55, least_frames = 4, most_frames = 30;
constexpr double enough_motion = 0.08;  // Share of the image's width.
constexpr KltOptions window_klt{.window_px = 15, .iterations = 20, .epsilon_px = 0.02, .coarse_epsilon_px = 0.05};

bool has_depth(const Frame& frame) {
  return frame.depth.width() == frame.image.width() && frame.depth.height() == frame.image.height();
}

}  // namespace

std::vector<std::size_t> TrackedWindow::survivors() const {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < tracks.size(); ++i)
    if (tracks[i].size() == frames) found.push_back(i);
  return found;
}

double TrackedWindow::motion_px() const {
  std::vector<double> lengths;
  for (const std::size_t i : survivors())
    lengths.push_back(static_cast<double>((tracks[i].back() - tracks[i].front()).norm()));
  return upper_median_or(std::move(lengths), 0.0);
}

bool WindowTracker::add(const Frame& frame) {
  const std::int64_t number = number_++;
  const bool same_size = frame.image.width() == last_size_.x() && frame.image.height() == last_size_.y();
  if (frame.image.empty() || (open_ && !same_size)) {
    open_ = false;
    return false;
  }
  if (!open_) {
    if (schedule_.is_due(number)) start(frame);
    return false;
  }
  follow(frame);
  if (!ended()) return false;
  open_ = false;
  add_end_depths(frame);
  schedule_.taken(number);
  return true;
}

void WindowTracker::start(const Frame& frame) {
  open_ = true;
  last_size_ = {frame.image.width(), frame.image.height()};
  last_.build(frame.image, window_levels, klt_padding);
  GrayImage free(frame.image.width(), frame.image.height());
  for (int y = 0; y < free.height(); ++y) std::fill_n(free.row(y), free.width(), std::uint8_t{255});
  const double distance = std::max(8.0, frame.image.width() / 40.0);
  CornerDetector detector;
  window_ = {};
  alive_.clear();
  for (const Corner& corner : detector.detect(last_.level(0), free, followed_features,
                                              {.quality = 0.01, .min_distance_px = distance, .border_px = 10})) {
    alive_.push_back(window_.tracks.size());
    window_.tracks.push_back({{static_cast<float>(corner.x), static_cast<float>(corner.y)}});
    window_.first_depths.push_back(has_depth(frame) ? frame.depth.at(corner.x, corner.y) : 0.0F);
    window_.mirrored_depths.push_back(has_depth(frame) ? frame.depth.at(frame.depth.width() - 1 - corner.x, corner.y)
                                                       : 0.0F);
  }
  window_.frames = 1;
  std::vector<Eigen::Vector2f> pixels;
  for (const auto& track : window_.tracks) pixels.push_back(track.front());
  window_.start_depths = depths_at(pixels, frame, last_);
}

void WindowTracker::follow(const Frame& frame) {
  current_.build(frame.image, window_levels, klt_padding);
  std::vector<Eigen::Vector2f> points, guesses;
  for (const std::size_t i : alive_) {
    const auto& track = window_.tracks[i];
    points.push_back(track.back());
    guesses.push_back(track.size() < 2 ? track.back() : Eigen::Vector2f(2.0F * track.back() - track[track.size() - 2]));
  }
  std::vector<KltResult> results(points.size());
  klt_follow(last_, current_, points, guesses, window_klt, nullptr, results);
  std::vector<std::size_t> still;
  for (std::size_t k = 0; k < alive_.size(); ++k) {
    if (!results[k].followed) continue;
    window_.tracks[alive_[k]].push_back(results[k].pixel);
    still.push_back(alive_[k]);
  }
  alive_ = std::move(still);
  std::swap(last_, current_);
  ++window_.frames;
}

std::vector<float> WindowTracker::depths_at(const std::vector<Eigen::Vector2f>& pixels, const Frame& frame,
                                            const Pyramid& image) {
  if (!has_depth(frame))
    return pair_ ? pair_->depths(image, frame.right, pixels) : std::vector<float>(pixels.size(), 0.0F);
  std::vector<float> depths;
  for (const Eigen::Vector2f& pixel : pixels) {
    const auto x = static_cast<int>(std::lround(pixel.x())), y = static_cast<int>(std::lround(pixel.y()));
    const bool inside = x >= 0 && y >= 0 && x < frame.depth.width() && y < frame.depth.height();
    depths.push_back(inside ? frame.depth.at(x, y) : 0.0F);
  }
  return depths;
}

void WindowTracker::add_end_depths(const Frame& frame) {
  std::vector<Eigen::Vector2f> pixels;
  for (const std::size_t i : alive_) pixels.push_back(window_.tracks[i].back());
  const std::vector<float> depths = depths_at(pixels, frame, last_);
  window_.end_depths.assign(window_.tracks.size(), 0.0F);
  for (std::size_t k = 0; k < alive_.size(); ++k) window_.end_depths[alive_[k]] = depths[k];
  if (!has_depth(frame) && pair_) window_.depth_error_growth = pair_->error_growth();
}

bool WindowTracker::ended() const {
  if (window_.frames >= most_frames || alive_.size() < fewest_alive) return true;
  return window_.frames >= least_frames && window_.motion_px() > enough_motion * last_size_.x();
}

}  // namespace rastro
