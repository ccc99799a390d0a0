// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/appearance_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>

#include "rastro/map/images/pack_images.h"

namespace rastro {
namespace {

constexpr int side = 8, margin = 1;  // A patch may be off by the margin: poses are not exact.
constexpr int wide = side + 2 * margin;
constexpr double nearest_m = 0.3, farthest_m = 8.0;
// The other view sees something else there: by this share of the depth, and by more than the noise explains.
constexpr double hidden_share = 0.08, hidden_sigmas = 3.0;
constexpr double least_texture = 2.0;  // squared intensity per coarse pixel, along the weaker direction
constexpr double alike_score = 0.7;    // of the normalized cross-correlation

float sample(const Image<float>& image, double x, double y) {
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const auto right_share = static_cast<float>(x - left), low_share = static_cast<float>(y - top);
  const auto across = [&](int row) {
    return image.at(left, row) + right_share * (image.at(left + 1, row) - image.at(left, row));
  };
  return across(top) + low_share * (across(top + 1) - across(top));
}

/// Pixels of an image along a coarse one, which is about 160 wide.
int coarse_px_of(const Camera& camera) {
  constexpr double coarse_width = 160.0;
  return std::max(1, static_cast<int>(std::lround(camera.width / coarse_width)));
}

float nearest_depth(const DepthImage& depth, int left, int top, int coarse_px) {
  float nearest = 0.0F;
  for (int y = top; y < top + coarse_px; ++y)
    for (int x = left; x < left + coarse_px; ++x) {
      const float here = depth.at(x, y);
      if (here > 0.0F && (nearest == 0.0F || here < nearest)) nearest = here;
    }
  return nearest;
}

/// Of what a coarse pixel averages, as much as decoding a JPEG does by itself.
int shrink_of(int coarse_px) {
  for (const int shrink : {8, 4, 2})
    if (coarse_px % shrink == 0) return shrink;
  return 1;
}

float mean(const GrayImage& image, int left, int top, int across_px) {
  float sum = 0.0F;
  for (int y = top; y < top + across_px; ++y)
    for (int x = left; x < left + across_px; ++x) sum += static_cast<float>(image.at(x, y));
  return sum / static_cast<float>(across_px * across_px);
}

}  // namespace

/// The same surface in both views, in the pixels of one.
struct AppearanceCheck::Patch {
  int left = 0, top = 0;
  float seen[side][side], there[wide][wide];

  /// The smaller eigenvalue of the mean structure tensor (Shi and Tomasi 1994) of what at(x, y) shows.
  template <typename At>
  static double texture(const At& at) {
    double xx = 0.0, yy = 0.0, xy = 0.0;
    for (int y = 1; y + 1 < side; ++y)
      for (int x = 1; x + 1 < side; ++x) {
        const double dx = 0.5 * (at(x + 1, y) - at(x - 1, y)), dy = 0.5 * (at(x, y + 1) - at(x, y - 1));
        xx += dx * dx, yy += dy * dy, xy += dx * dy;
      }
    constexpr double count = (side - 2) * (side - 2);
    return (0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy)) / count;
  }

  bool has_texture() const {
    return texture([this](int x, int y) { return seen[y][x]; }) >= least_texture ||
           texture([this](int x, int y) { return there[y + margin][x + margin]; }) >= least_texture;
  }

  /// Normalized cross-correlation with the other view shifted.
  double score(int shift_x, int shift_y) const {
    double a = 0.0, b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const double p = seen[y][x], q = there[y + shift_y][x + shift_x];
        a += p, b += q, aa += p * p, bb += q * q, ab += p * q;
      }
    constexpr double count = side * side;
    const double spread = (aa - a * a / count) * (bb - b * b / count);
    return spread > 0.0 ? (ab - a * b / count) / std::sqrt(spread) : 0.0;
  }

  bool is_alike() const {
    for (int shift_y = 0; shift_y <= 2 * margin; ++shift_y)
      for (int shift_x = 0; shift_x <= 2 * margin; ++shift_x)
        if (score(shift_x, shift_y) >= alike_score) return true;
    return false;
  }
};

AppearanceCheck::AppearanceCheck(const Camera& camera, const DepthNoise& noise)
    : coarse_px_(coarse_px_of(camera)), camera_(camera.scaled(1.0 / coarse_px_)), noise_(noise) {
  for (int y = 0; y < camera_.height; ++y)
    for (int x = 0; x < camera_.width; ++x) {
      const auto ray = camera_.unproject({static_cast<double>(x), static_cast<double>(y)});
      constexpr double none = std::numeric_limits<double>::quiet_NaN();
      rays_.push_back(ray ? Eigen::Vector3d(ray->x(), ray->y(), 1.0) : Eigen::Vector3d(none, none, none));
    }
}

KeyframeAppearance AppearanceCheck::appearance_of(const PackedImages& images, const std::string& where) const {
  const int shrink = shrink_of(coarse_px_), gray_px = coarse_px_ / shrink;
  const GrayImage gray = unpack_gray(images, shrink, where);
  const DepthImage depth = unpack_depth(images, where);
  KeyframeAppearance result{Image<float>(camera_.width, camera_.height), DepthImage(camera_.width, camera_.height)};
  const int width = std::min({camera_.width, gray.width() / gray_px, depth.width() / coarse_px_});
  const int height = std::min({camera_.height, gray.height() / gray_px, depth.height() / coarse_px_});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      result.brightness.at(x, y) = mean(gray, gray_px * x, gray_px * y, gray_px);
      result.depth.at(x, y) = nearest_depth(depth, coarse_px_ * x, coarse_px_ * y, coarse_px_);
    }
  return result;
}

KeyframeAppearance AppearanceCheck::appearance_of(const Frame& frame) const {
  return appearance_of(pack_images(frame), "frame");
}

/// False where a part of it is outside the other view, or hidden there.
bool AppearanceCheck::fill(const KeyframeAppearance& a, const KeyframeAppearance& b, const SE3& a_from_b,
                           Patch& patch) const {
  for (int v = 0; v < wide; ++v)
    for (int u = 0; u < wide; ++u) {
      const int x = patch.left + u - margin, y = patch.top + v - margin;
      const double depth = b.depth.at(x, y);
      if (!(depth > 0.0 && depth < farthest_m)) return false;
      const Eigen::Vector3d point = a_from_b * (depth * rays_[static_cast<std::size_t>(y * camera_.width + x)]);
      if (!(point.z() > nearest_m)) return false;
      const auto pixel = camera_.project(point);
      if (!pixel || !(pixel->x() >= 0.0 && pixel->y() >= 0.0 && pixel->x() < camera_.width - 1.0 &&
                      pixel->y() < camera_.height - 1.0))
        return false;
      const double measured = a.depth.at(static_cast<int>(pixel->x() + 0.5), static_cast<int>(pixel->y() + 0.5));
      const double hidden_m = std::max(hidden_share * point.z(), hidden_sigmas * noise_.sigma(point.z()));
      if (!(measured > 0.0 && std::abs(measured - point.z()) < hidden_m)) return false;
      patch.there[v][u] = sample(a.brightness, pixel->x(), pixel->y());
      const bool inner = u >= margin && v >= margin && u < side + margin && v < side + margin;
      if (inner) patch.seen[v - margin][u - margin] = b.brightness.at(x, y);
    }
  return true;
}

AppearanceAgreement AppearanceCheck::compare(const KeyframeAppearance& a, const KeyframeAppearance& b,
                                             const SE3& a_from_b) const {
  constexpr int across = 8, down = 6;
  AppearanceAgreement result;
  std::bitset<across * down> cells;
  Patch patch;
  for (patch.top = margin; patch.top + side + margin <= camera_.height; patch.top += side)
    for (patch.left = margin; patch.left + side + margin <= camera_.width; patch.left += side) {
      if (!fill(a, b, a_from_b, patch) || !patch.has_texture()) continue;
      if (!patch.is_alike()) {
        ++result.contradict;
        continue;
      }
      ++result.agree;
      const int x = patch.left + side / 2, y = patch.top + side / 2;
      cells.set(static_cast<std::size_t>(y * down / camera_.height * across + x * across / camera_.width));
      result.center += b.depth.at(x, y) * rays_[static_cast<std::size_t>(y * camera_.width + x)];
    }
  result.cells = static_cast<int>(cells.count());
  if (result.agree > 0) result.center /= result.agree;
  return result;
}

std::shared_ptr<const KeyframeAppearance> AppearanceStore::appearance(std::int64_t keyframe) {
  if (auto recent = recent_.find(keyframe)) return recent;
  return recent_.add(keyframe, check_.appearance_of(images_->read(keyframe), fmt::format("keyframe {}", keyframe)));
}

}  // namespace rastro
