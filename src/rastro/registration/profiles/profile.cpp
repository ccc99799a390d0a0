// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/profiles/profile.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace rastro {
namespace {

// Number of rows of 255 that fit a 16-bit sum.
constexpr int rows_per_block = 256;

void add_rows(GrayView image, int first_row, int end_row, std::uint16_t* sums) {
  for (int y = first_row; y < end_row; ++y) {
    const std::uint8_t* row = image.row(y);
    for (int x = 0; x < image.width; ++x) sums[x] = static_cast<std::uint16_t>(sums[x] + row[x]);
  }
}

std::int16_t mean_in_units(std::int64_t sum, int count) {
  return static_cast<std::int16_t>((sum * profile_units + count / 2) / count);
}

}  // namespace

void column_profile(GrayView image, int first_row, int end_row, Profile& profile) {
  const auto width = static_cast<std::size_t>(image.width);
  profile.assign(width, 0);
  first_row = std::clamp(first_row, 0, image.height);
  end_row = std::clamp(end_row, first_row, image.height);
  if (first_row == end_row) return;
  std::vector<std::uint32_t> sums(width, 0);
  std::vector<std::uint16_t> block(width);
  for (int y = first_row; y < end_row; y += rows_per_block) {
    std::fill(block.begin(), block.end(), std::uint16_t{0});
    add_rows(image, y, std::min(y + rows_per_block, end_row), block.data());
    for (std::size_t x = 0; x < width; ++x) sums[x] += block[x];
  }
  for (std::size_t x = 0; x < width; ++x) profile[x] = mean_in_units(sums[x], end_row - first_row);
}

void row_profile(GrayView image, int first_column, int end_column, Profile& profile) {
  profile.assign(static_cast<std::size_t>(image.height), 0);
  first_column = std::clamp(first_column, 0, image.width);
  end_column = std::clamp(end_column, first_column, image.width);
  if (first_column == end_column) return;
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* row = image.row(y);
    std::uint32_t sum = 0;
    for (int x = first_column; x < end_column; ++x) sum += row[x];
    profile[static_cast<std::size_t>(y)] = mean_in_units(sum, end_column - first_column);
  }
}

AngleScale AngleScale::across(const Camera& camera, int width) { return along(camera, {1.0, 0.0}, width); }
AngleScale AngleScale::upright(const Camera& camera, int height) { return along(camera, {0.0, 1.0}, height); }

AngleScale AngleScale::along(const Camera& camera, const Eigen::Vector2d& axis, int pixels) {
  const double focal = axis.dot(Eigen::Vector2d(camera.fx, camera.fy));
  AngleScale scale;
  // Outwards from the optical axis on both sides, until a step leaves the image or the camera's model.
  const auto entry_at = [&](int step, Entry& entry) {
    const double angle = step / focal;
    if (std::abs(angle) > 1.4) return false;
    const Eigen::Vector2d ray = std::tan(angle) * axis;
    const auto pixel = camera.project(Eigen::Vector3d(ray.x(), ray.y(), 1.0));
    if (!pixel) return false;
    const double position = axis.dot(*pixel);
    if (!(position >= 0.0 && position < pixels - 1)) return false;
    entry.pixel = static_cast<std::int32_t>(position);
    entry.fraction = static_cast<std::int32_t>((position - entry.pixel) * 256.0);
    return true;
  };
  Entry entry{};
  for (int step = 0; entry_at(step, entry); ++step) scale.entries_.push_back(entry);
  std::vector<Entry> before;
  for (int step = -1; entry_at(step, entry); --step) before.push_back(entry);
  scale.zero_step_ = static_cast<int>(before.size());
  scale.entries_.insert(scale.entries_.begin(), before.rbegin(), before.rend());
  return scale;
}

void AngleScale::resample(const Profile& pixels, Profile& angles) const {
  angles.resize(entries_.size());
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const auto at = static_cast<std::size_t>(entries_[i].pixel);
    const std::int32_t left = pixels[at], right = pixels[at + 1];
    angles[i] = static_cast<std::int16_t>(left + (((right - left) * entries_[i].fraction + 128) >> 8));
  }
}

void subtract_mean(Profile& profile) {
  if (profile.empty()) return;
  const std::int64_t sum = std::accumulate(profile.begin(), profile.end(), std::int64_t{0});
  const auto mean = static_cast<std::int16_t>(sum / static_cast<std::int64_t>(profile.size()));
  for (auto& value : profile) value = static_cast<std::int16_t>(value - mean);
}

void take_gradient(Profile& profile, int reach) {
  const auto size = static_cast<std::ptrdiff_t>(profile.size());
  const Profile values = profile;
  for (std::ptrdiff_t i = 0; i < size; ++i) {
    const bool inside = i >= reach && i + reach < size;
    profile[static_cast<std::size_t>(i)] = inside
                                               ? static_cast<std::int16_t>(values[static_cast<std::size_t>(i + reach)] -
                                                                           values[static_cast<std::size_t>(i - reach)])
                                               : std::int16_t{0};
  }
}

}  // namespace rastro
