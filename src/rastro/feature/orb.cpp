// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/orb.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "rastro/base/error.h"
#include "rastro/feature/fast.h"
#include "rastro/feature/orb_blur.h"
#include "rastro/feature/orb_describe.h"
#include "rastro/feature/orb_resize.h"
#include "rastro/feature/orb_spread.h"

namespace rastro {
namespace {

constexpr int padding = fast_padding;
constexpr int border = orb_radius + 1;  // Described patches lie inside the image.
constexpr int band = 32;                // Rows processed at a time.
constexpr int smallest_side = 2 * border + 8;

void check(const OrbOptions& options) {
  const auto refuse = [](const char* name, double value, const char* range) {
    throw Error(fmt::format("{} {} is out of range", name, value), "the ORB features", fmt::format("use {}", range));
  };
  if (options.features < 1 || options.features > 100000) refuse("features", options.features, "1..100000");
  if (options.levels < 1 || options.levels > 16) refuse("levels", options.levels, "1..16");
  if (!(options.scale_factor > 1.0 && options.scale_factor <= 2.0))
    refuse("scale_factor", options.scale_factor, "more than 1, up to 2");
  if (options.fast_threshold < 1 || options.fast_threshold > 254)
    refuse("fast_threshold", options.fast_threshold, "1..254");
  if (options.least_fast_threshold < 1 || options.least_fast_threshold > options.fast_threshold)
    refuse("least_fast_threshold", options.least_fast_threshold, "1..fast_threshold");
}

/// Position of the vertex of a parabola through three scores, in -0.5..0.5 from the middle one.
float peak_offset(int before, int here, int after) {
  const int curvature = 2 * here - before - after;
  return curvature > 0 ? static_cast<float>(after - before) / static_cast<float>(2 * curvature) : 0.0F;
}

}  // namespace

std::vector<double> orb_level_scales(const OrbOptions& options) {
  std::vector<double> scales;
  for (int level = 0; level < options.levels; ++level) scales.push_back(std::pow(options.scale_factor, level));
  return scales;
}

/// One level of the pyramid with its results.
struct OrbLevel {
  PaddedImage image;
  GrayImage blurred;
  std::vector<FastCorner> corners;  ///< All, then the selected ones.
};

class OrbExtractor::State {
 public:
  explicit State(const OrbOptions& options) : options_(options), scales_(orb_level_scales(options)) { check(options); }

  void set_features(int features) {
    OrbOptions changed = options_;
    changed.features = features;
    check(changed);
    options_ = changed;
  }

  Features extract(GrayView image, GrayView mask, TaskPool* pool) {
    RASTRO_CHECK(mask.empty() || (mask.width == image.width && mask.height == image.height), "a mask of the same size");
    if (image.width != width_ || image.height != height_) plan(image.width, image.height);
    if (used_ == 0) return {};
    build_pyramid(image, pool);
    find_corners(mask, pool);
    choose(pool);
    return describe(pool);
  }

 private:
  /// A few rows of a level.
  struct Band {
    std::size_t level = 0;
    int begin = 0, end = 0;
    std::vector<FastCorner> corners;
  };

  static void run(TaskPool* pool, std::size_t count, int grain, const std::function<void(int, int)>& body) {
    if (pool) {
      pool->for_chunks(0, static_cast<int>(count), grain, body);
    } else {
      body(0, static_cast<int>(count));
    }
  }

  /// Sizes of the levels, and their bands, biggest levels first.
  void plan(int width, int height) {
    width_ = width;
    height_ = height;
    resizes_.clear();
    levels_.clear();
    bands_.clear();
    for (int level = 0; level < options_.levels && std::min(width, height) >= smallest_side; ++level) {
      OrbLevel& made = levels_.emplace_back();
      made.image.reset(width, height, padding);
      made.blurred = GrayImage(width, height);
      for (int y = border; y < height - border; y += band)
        bands_.push_back({levels_.size() - 1, y, std::min(y + band, height - border), {}});
      const OrbResize& next = resizes_.emplace_back(width, height, options_.scale_factor);
      width = next.width();
      height = next.height();
    }
    used_ = levels_.size();
  }

  void build_pyramid(GrayView image, TaskPool* pool) {
    PaddedImage& whole = levels_[0].image;
    for (int y = 0; y < height_; ++y) std::memcpy(whole.row(y), image.row(y), static_cast<std::size_t>(width_));
    whole.fill_padding();
    for (std::size_t level = 1; level < used_; ++level) {
      const PaddedImage& finer = levels_[level - 1].image;
      PaddedImage& coarser = levels_[level].image;
      run(pool, static_cast<std::size_t>(coarser.height()), 2 * band,
          [&](int begin, int end) { resizes_[level - 1].run(finer, coarser, begin, end); });
      coarser.fill_padding();
    }
  }

  /// Image pixels of a position on a level.
  float in_image(double at, std::size_t level) const { return static_cast<float>((at + 0.5) * scales_[level] - 0.5); }

  bool is_masked(const FastCorner& corner, std::size_t level, GrayView mask) const {
    const auto x = static_cast<int>(std::lround(in_image(corner.x, level)));
    const auto y = static_cast<int>(std::lround(in_image(corner.y, level)));
    return mask.at(std::clamp(x, 0, width_ - 1), std::clamp(y, 0, height_ - 1)) == 0;
  }

  void find_corners(GrayView mask, TaskPool* pool) {
    run(pool, bands_.size(), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        Band& here = bands_[static_cast<std::size_t>(i)];
        OrbLevel& level = levels_[here.level];
        here.corners.clear();
        fast_corners(level.image, border, level.image.width() - border, here.begin, here.end,
                     options_.least_fast_threshold, here.corners);
        if (!mask.empty())
          std::erase_if(here.corners, [&](const FastCorner& corner) { return is_masked(corner, here.level, mask); });
        // Rows without corner detection are needed too: described patches reach into them.
        const bool first = here.begin == border, last = here.end == level.image.height() - border;
        orb_blur(level.image, level.blurred, first ? 0 : here.begin, last ? level.image.height() : here.end);
      }
    });
    for (OrbLevel& level : levels_) level.corners.clear();
    for (const Band& here : bands_) {
      auto& corners = levels_[here.level].corners;
      corners.insert(corners.end(), here.corners.begin(), here.corners.end());
    }
  }

  void choose(TaskPool* pool) {
    std::vector<std::size_t> available(used_);
    const auto wanted = orb_quotas(static_cast<std::size_t>(options_.features), options_.scale_factor,
                                   std::vector<std::size_t>(used_, static_cast<std::size_t>(options_.features)));
    std::vector<std::unique_ptr<OrbCells>> cells(used_);
    run(pool, used_, 1, [&](int begin, int end) {
      for (auto level = static_cast<std::size_t>(begin); level < static_cast<std::size_t>(end); ++level) {
        const PaddedImage& image = levels_[level].image;
        cells[level] = std::make_unique<OrbCells>(levels_[level].corners, border, image.width() - border, border,
                                                  image.height() - border, static_cast<int>(wanted[level]),
                                                  options_.fast_threshold);
        available[level] = cells[level]->size();
      }
    });
    const auto quotas = orb_quotas(static_cast<std::size_t>(options_.features), options_.scale_factor, available);
    for (std::size_t level = 0; level < used_; ++level) levels_[level].corners = cells[level]->take(quotas[level]);
  }

  Features describe(TaskPool* pool) {
    Features features;
    std::vector<FastCorner> corners;
    for (std::size_t level = 0; level < used_; ++level) {
      corners.insert(corners.end(), levels_[level].corners.begin(), levels_[level].corners.end());
      features.levels.resize(corners.size(), static_cast<std::uint8_t>(level));
    }
    features.keypoints.resize(corners.size());
    features.descriptors.resize(corners.size());
    run(pool, corners.size(), 64, [&](int begin, int end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
        describe_one(corners[i], features.levels[i], features.keypoints[i], features.descriptors[i]);
    });
    return features;
  }

  void describe_one(const FastCorner& corner, std::size_t index, Keypoint& keypoint, Descriptor& descriptor) const {
    const OrbLevel& level = levels_[index];
    const OrbDirection direction = orb_direction(level.image.row(corner.y) + corner.x, level.image.stride());
    descriptor = orb_describe(level.blurred.row(corner.y) + corner.x, level.blurred.stride(), direction);
    keypoint.x = in_image(corner.x + peak_offset(corner.left, corner.score, corner.right), index);
    keypoint.y = in_image(corner.y + peak_offset(corner.above, corner.score, corner.below), index);
    keypoint.size_px = static_cast<float>((2 * orb_radius + 1) * scales_[index]);
    keypoint.angle_rad = direction.angle_rad;
    keypoint.response = corner.score;
  }

  OrbOptions options_;
  std::vector<double> scales_;
  int width_ = 0, height_ = 0;
  std::size_t used_ = 0;  ///< Levels for which the image is large enough.
  std::vector<OrbResize> resizes_;
  std::vector<OrbLevel> levels_;
  std::vector<Band> bands_;
};

OrbExtractor::OrbExtractor(const OrbOptions& options) : state_(std::make_unique<State>(options)) {}
OrbExtractor::~OrbExtractor() = default;
void OrbExtractor::set_features(int features) { state_->set_features(features); }

Features OrbExtractor::extract(GrayView image, GrayView mask, TaskPool* pool) {
  return state_->extract(image, mask, pool);
}

}  // namespace rastro
