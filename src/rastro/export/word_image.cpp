// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/word_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <system_error>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/export/drawing.h"
#include "rastro/export/word_kinds.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/map/images/pack_images.h"
#include "rastro/map/signatures/signature_layer.h"
#include "rastro/sensor/stamp_text.h"

namespace rastro {
namespace {

using Kinds = std::vector<std::optional<WordKind>>;

struct KindStyle {
  const char* name;
  cv::Scalar color;
};

/// By index_of(kind).
const std::array<KindStyle, word_kinds>& styles() {
  static const std::array<KindStyle, word_kinds> all = {{{"in the vocabulary", drawing::red},
                                                         {"new", drawing::green},
                                                         {"several times", {0, 230, 255}},
                                                         {"in the previous image", {255, 140, 40}},
                                                         {"shared", {230, 120, 255}}}};
  return all;
}

constexpr int gap_px = 6;
constexpr std::uint8_t missing_gray = 110;
const cv::Scalar dark(32, 32, 32);
const cv::Scalar dim(150, 150, 150);

/// A gray canvas as large as the camera's images, or as the features need.
GrayImage missing_image(const Map& map, const Keyframe& keyframe, const ImageFeatures& features) {
  int width = 0, height = 0;
  const auto camera = static_cast<std::size_t>(keyframe.camera);
  if (camera < map.cameras.size()) {
    width = map.cameras[camera].intrinsics.width;
    height = map.cameras[camera].intrinsics.height;
  }
  for (const Keypoint& point : features.features.keypoints) {
    width = std::max(width, static_cast<int>(std::lround(point.x)) + 1);
    height = std::max(height, static_cast<int>(std::lround(point.y)) + 1);
  }
  GrayImage image(std::max(width, 1), std::max(height, 1));
  for (int y = 0; y < image.height(); ++y) std::fill_n(image.row(y), image.width(), missing_gray);
  return image;
}

GrayImage image_of(const Map& map, const Keyframe& keyframe, const ImageFeatures& features) {
  const auto layer = map.layer<ImageLayer>();
  if (!layer || !std::binary_search(layer->keyframes.begin(), layer->keyframes.end(), keyframe.id))
    return missing_image(map, keyframe, features);
  PackedImages packed = layer->store->read(keyframe.id);
  if (packed.color.empty()) return missing_image(map, keyframe, features);
  packed.depth.clear();
  return gray_from_color(unpack_images(packed, fmt::format("keyframe {}", keyframe.id)).color);
}

/// The rarer a kind, the later it is drawn.
void draw_words(drawing::Canvas& canvas, const ImageFeatures& features, const Kinds& kinds) {
  for (std::size_t drawn = 0; drawn < word_kinds; ++drawn)
    for (std::size_t k = 0; k < kinds.size(); ++k) {
      if (!kinds[k] || index_of(*kinds[k]) != drawn) continue;
      const Keypoint& point = features.features.keypoints[k];
      const cv::Point2f at = canvas.at({point.x, point.y});
      cv::circle(canvas.image, at, 5, cv::Scalar(0, 0, 0), cv::FILLED, cv::LINE_AA);
      cv::circle(canvas.image, at, 4, styles()[drawn].color, cv::FILLED, cv::LINE_AA);
    }
}

/// The pictures of one map.
class Album {
 public:
  explicit Album(const Map& map) : map_(map), signatures_(map.layer<SignatureLayer>()->store) {}

  cv::Mat picture(const LocationWords& location) const {
    const Signature own = signatures_->read(location.location);
    const cv::Mat left = view(location.location, own, location.kinds);
    const cv::Mat right = location.closure ? match_view(location, own) : no_match(left.size());
    cv::Mat pair(std::max(left.rows, right.rows), left.cols + gap_px + right.cols, CV_8UC3, dark);
    left.copyTo(pair(cv::Rect(0, 0, left.cols, left.rows)));
    right.copyTo(pair(cv::Rect(left.cols + gap_px, 0, right.cols, right.rows)));
    cv::vconcat(std::vector<cv::Mat>{pair, drawing::caption_strip(pair.cols, heading(location)),
                                     drawing::caption_strip(pair.cols, legend(location))},
                pair);
    return pair;
  }

 private:
  cv::Mat view(KeyframeId id, const Signature& signature, const Kinds& kinds) const {
    drawing::Canvas canvas = drawing::canvas_of(image_of(map_, *map_.find(id), *signature.image));
    draw_words(canvas, *signature.image, kinds);
    drawing::put_text(canvas.image, fmt::format("{}", id), {6.0F, 18.0F}, drawing::white, 0.5);
    return canvas.image;
  }

  cv::Mat match_view(const LocationWords& location, const Signature& own) const {
    const Signature matched = signatures_->read(location.matched);
    return view(location.matched, matched, kinds_seen_from(own.words, matched.words));
  }

  static cv::Mat no_match(const cv::Size& size) {
    cv::Mat empty(size, CV_8UC3, dark);
    drawing::put_text(empty, "no loop closure",
                      {0.5F * static_cast<float>(size.width) - 60.0F, 0.5F * static_cast<float>(size.height)}, dim,
                      0.5);
    return empty;
  }

  std::vector<drawing::Piece> heading(const LocationWords& location) const {
    const Keyframe& keyframe = *map_.find(location.location);
    std::string text =
        fmt::format("location {}    frame {}    {} s", keyframe.id, keyframe.frame, seconds_text(keyframe.stamp));
    if (location.closure) {
      const Constraint& edge = *location.closure;
      text += fmt::format("    {} with location {}: keyframes {} and {}, {} inliers, weight {:.2f}", name_of(edge.kind),
                          location.matched, edge.from, edge.to, edge.inliers, edge.weight);
    }
    return {{text, drawing::white}};
  }

  static std::vector<drawing::Piece> legend(const LocationWords& location) {
    const auto counts = location.counts();
    std::vector<drawing::Piece> pieces = {{fmt::format("{} words    ", location.kinds.size()), drawing::white}};
    for (const WordKind kind :
         {WordKind::fresh, WordKind::repeated, WordKind::known, WordKind::previous, WordKind::shared})
      pieces.push_back({fmt::format("{} {}    ", counts[index_of(kind)], styles()[index_of(kind)].name),
                        styles()[index_of(kind)].color});
    return pieces;
  }

  const Map& map_;
  std::shared_ptr<const SignatureStore> signatures_;
};

void make_folder(const std::filesystem::path& folder) {
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) throw Error("the folder cannot be made (" + code.message() + ")", folder.string(), "choose another --out");
}

}  // namespace

WordImageCounts write_word_images(const Map& map, const std::filesystem::path& folder, TaskPool& pool,
                                  const std::function<void(std::size_t, std::size_t)>& progress) {
  const std::vector<LocationWords> locations = words_of_locations(map);
  if (locations.empty())
    throw Error("the map has no locations with visual words", folder.string(),
                "'rastro slam DATA --method rtabmap' makes a map with them");
  make_folder(folder);
  const Album album(map);
  constexpr int group = 16;  // between two reports of progress
  const int count = static_cast<int>(locations.size());
  for (int first = 0; first < count; first += group) {
    const int end = std::min(count, first + group);
    pool.for_chunks(first, end, 1, [&](int begin, int last) {
      for (int k = begin; k < last; ++k) {
        const LocationWords& location = locations[static_cast<std::size_t>(k)];
        drawing::save((folder / fmt::format("{:06}.jpg", location.location)).string(), album.picture(location));
      }
    });
    if (progress) progress(static_cast<std::size_t>(end), locations.size());
  }
  WordImageCounts counts{locations.size(), 0};
  for (const LocationWords& location : locations) counts.loop_closures += location.closure ? 1 : 0;
  return counts;
}

}  // namespace rastro
