// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/depth_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/export/drawing.h"
#include "rastro/export/video_file.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/sensor/stamp_text.h"

namespace rastro {
namespace {

const cv::Scalar dark(32, 32, 32);

float quantile(std::vector<float> values, double share) {
  if (values.empty()) return 0.0F;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// As large as the camera's images, or as the pixels need.
cv::Size size_of(const Map& map, const Keyframe& keyframe, const SemiDenseDepth& depth) {
  cv::Size size(1, 1);
  const auto camera = static_cast<std::size_t>(keyframe.camera);
  if (camera < map.cameras.size())
    size = {std::max(1, map.cameras[camera].intrinsics.width), std::max(1, map.cameras[camera].intrinsics.height)};
  for (const SemiDenseDepth::Pixel& pixel : depth.pixels)
    size = {std::max(size.width, pixel.x + 1), std::max(size.height, pixel.y + 1)};
  return size;
}

cv::Mat intensity_view(const SemiDenseDepth& depth, const cv::Size& size) {
  cv::Mat view(size, CV_8UC3, dark);
  for (const SemiDenseDepth::Pixel& pixel : depth.pixels)
    view.at<cv::Vec3b>(pixel.y, pixel.x) = {pixel.intensity, pixel.intensity, pixel.intensity};
  return view;
}

/// The scale ends at the nearest twentieth of the pixels, so that a few wrong ones do not decide about it.
cv::Mat depth_view(const SemiDenseDepth& depth, const cv::Size& size) {
  constexpr double in_scale = 0.95;
  std::vector<float> inverse_depths;
  for (const SemiDenseDepth::Pixel& pixel : depth.pixels) inverse_depths.push_back(pixel.inverse_depth);
  const float most = std::max(1e-9F, quantile(std::move(inverse_depths), in_scale));
  cv::Mat levels(size, CV_8UC1, cv::Scalar(0)), known(size, CV_8UC1, cv::Scalar(0)), colors;
  for (const SemiDenseDepth::Pixel& pixel : depth.pixels) {
    const float share = std::clamp(pixel.inverse_depth / most, 0.0F, 1.0F);
    levels.at<std::uint8_t>(pixel.y, pixel.x) = static_cast<std::uint8_t>(std::lround(255.0F * share));
    known.at<std::uint8_t>(pixel.y, pixel.x) = 255;
  }
  cv::applyColorMap(levels, colors, cv::COLORMAP_JET);
  cv::Mat view(size, CV_8UC3, dark);
  colors.copyTo(view, known);
  return view;
}

std::string heading(const Keyframe& keyframe, const SemiDenseDepth& depth) {
  std::vector<float> shares;
  for (const SemiDenseDepth::Pixel& pixel : depth.pixels)
    shares.push_back(std::sqrt(pixel.variance) / pixel.inverse_depth);
  constexpr double middle = 0.5;
  return fmt::format("keyframe {}    frame {}    {} s    {} pixels    median sigma {:.1f} % of the inverse depth",
                     keyframe.id, keyframe.frame, seconds_text(keyframe.stamp), depth.pixels.size(),
                     100.0F * quantile(std::move(shares), middle));
}

cv::Mat picture(const Map& map, const Keyframe& keyframe, const SemiDenseDepth& depth) {
  const cv::Size size = size_of(map, keyframe, depth);
  cv::Mat pair;
  cv::hconcat(intensity_view(depth, size), depth_view(depth, size), pair);
  cv::vconcat(pair, drawing::caption_strip(pair.cols, {{heading(keyframe, depth), drawing::white}}), pair);
  return pair;
}

using DrawnKeyframe = std::pair<const Keyframe*, std::shared_ptr<const SemiDenseDepth>>;

std::vector<DrawnKeyframe> keyframes_with_depth(const Map& map) {
  std::vector<DrawnKeyframe> found;
  const auto layer = map.layer<SemiDenseLayer>();
  if (!layer) return found;
  for (const Keyframe& keyframe : map.keyframes) {
    const auto depth = layer->of.find(keyframe.id);
    if (depth != layer->of.end() && !depth->second->pixels.empty()) found.emplace_back(&keyframe, depth->second);
  }
  return found;
}

std::vector<DrawnKeyframe> drawable_keyframes(const Map& map, const std::filesystem::path& out) {
  std::vector<DrawnKeyframe> keyframes = keyframes_with_depth(map);
  if (keyframes.empty())
    throw Error("the map has no semi-dense depth", out.string(), "'rastro slam DATA --method lsd' makes a map with it");
  return keyframes;
}

/// At regular steps over the run.
cv::Mat strip(const Map& map, const std::vector<DrawnKeyframe>& keyframes) {
  constexpr std::size_t most = 12, columns = 4;
  constexpr int width = 320;
  const std::size_t count = std::min(most, keyframes.size());
  const cv::Size first = size_of(map, *keyframes.front().first, *keyframes.front().second);
  const cv::Size cell(width, std::max(1, width * first.height / first.width));
  const auto rows = static_cast<int>((count + columns - 1) / columns);
  cv::Mat sheet(rows * cell.height, static_cast<int>(std::min(count, columns)) * cell.width, CV_8UC3, dark);
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [keyframe, depth] = keyframes[i * keyframes.size() / count];
    cv::Mat view;
    cv::resize(depth_view(*depth, size_of(map, *keyframe, *depth)), view, cell, 0.0, 0.0, cv::INTER_AREA);
    drawing::put_text(view, fmt::format("{}", keyframe->id), {6.0F, 18.0F}, drawing::white, 0.5);
    const cv::Point corner(static_cast<int>(i % columns) * cell.width, static_cast<int>(i / columns) * cell.height);
    view.copyTo(sheet(cv::Rect(corner, cell)));
  }
  return sheet;
}

}  // namespace

std::size_t write_depth_video(const Map& map, const std::filesystem::path& file,
                              const std::function<void(std::size_t, std::size_t)>& progress) {
  constexpr TimeNs interval = ns_per_second / 10;
  constexpr int longest = 100;  // intervals: pauses are cut to 10 s
  const std::vector<DrawnKeyframe> keyframes = drawable_keyframes(map, file);
  detail::VideoFile video(file);
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const auto& [keyframe, depth] = keyframes[k];
    const TimeNs begin = keyframe->stamp;
    const TimeNs end = k + 1 < keyframes.size() ? keyframes[k + 1].first->stamp : begin + interval;
    const auto ticks = std::clamp<std::int64_t>(end / interval - begin / interval, 1, longest);
    const cv::Mat shown = picture(map, *keyframe, *depth);
    for (std::int64_t tick = 0; tick < ticks; ++tick)
      video.write(shown, to_seconds(ns_per_second) / to_seconds(interval));
    if (progress) progress(k + 1, keyframes.size());
  }
  video.finish();
  return keyframes.size();
}

std::size_t write_depth_images(const Map& map, const std::filesystem::path& folder, TaskPool& pool,
                               const std::function<void(std::size_t, std::size_t)>& progress) {
  const std::vector<DrawnKeyframe> keyframes = drawable_keyframes(map, folder);
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) throw Error("the folder cannot be made (" + code.message() + ")", folder.string(), "choose another --out");
  constexpr int group = 16;  // between two reports of progress
  const int count = static_cast<int>(keyframes.size());
  for (int first = 0; first < count; first += group) {
    const int end = std::min(count, first + group);
    pool.for_chunks(first, end, 1, [&](int begin, int last) {
      for (int k = begin; k < last; ++k) {
        const auto& [keyframe, depth] = keyframes[static_cast<std::size_t>(k)];
        drawing::save((folder / fmt::format("{:06}.jpg", keyframe->id)).string(), picture(map, *keyframe, *depth));
      }
    });
    if (progress) progress(static_cast<std::size_t>(end), keyframes.size());
  }
  drawing::save((folder / "strip.png").string(), strip(map, keyframes));
  return keyframes.size();
}

}  // namespace rastro
