// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/match_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/export/drawing.h"

namespace rastro {
namespace {

GrayImage copy_of(GrayView image) {
  GrayImage copy(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    std::memcpy(copy.row(y), image.row(y), static_cast<std::size_t>(image.width));
  }
  return copy;
}

std::vector<drawing::Piece> legend(std::int64_t first, std::int64_t second, const MatchCounts& counts) {
  const int found = counts.followed + counts.reidentified;
  const double percent = counts.in_first > 0 ? 100.0 * found / counts.in_first : 0.0;
  return {{fmt::format("frame {} -> {}    ", first, second), drawing::white},
          {fmt::format("{} followed by KLT    ", counts.followed), drawing::magenta},
          {fmt::format("{} lost and re-identified    ", counts.reidentified), drawing::green},
          {fmt::format("{} of {} found again ({:.2f} %)", found, counts.in_first, percent), drawing::white}};
}

void draw_match(cv::Mat& pair, cv::Point2f from, cv::Point2f to, const cv::Scalar& color) {
  cv::line(pair, from, to, color, 1, cv::LINE_AA);
  cv::circle(pair, from, 3, color, 1, cv::LINE_AA);
  cv::circle(pair, to, 3, color, 1, cv::LINE_AA);
}

}  // namespace

MatchImage::MatchImage(std::filesystem::path path, std::int64_t first, std::int64_t second)
    : path_(std::move(path)), first_(first), second_(second) {
  if (first < 0 || first >= second) {
    throw Error(fmt::format("{}:{} is not a pair of frames", first, second), "match image",
                "give two frame numbers, the earlier one first, such as 1:29");
  }
}

void MatchImage::write(const TrackFrame& frame, GrayView image) {
  if (frame.index == first_) {
    begin(frame, image);
  } else if (begun_ && !counts_ && frame.index <= second_) {
    follow(frame);
    if (frame.index == second_) draw(frame, image);
  }
}

void MatchImage::begin(const TrackFrame& frame, GrayView image) {
  first_image_ = copy_of(image);
  for (const TrackedFeature& feature : frame.features) starts_.emplace(feature.id, Start{feature.pixel, false});
  begun_ = true;
}

void MatchImage::follow(const TrackFrame& frame) {
  // Features are in ascending order of id, and so is the map.
  auto feature = frame.features.begin();
  for (auto& [id, start] : starts_) {
    while (feature != frame.features.end() && feature->id < id) ++feature;
    const bool here = feature != frame.features.end() && feature->id == id;
    if (!here || feature->state == TrackState::reidentified) start.was_lost = true;
  }
}

void MatchImage::draw(const TrackFrame& frame, GrayView image) {
  const drawing::Canvas left = drawing::canvas_of(first_image_);
  const drawing::Canvas right = drawing::canvas_of(image);
  constexpr int gap_px = 6;
  const int offset = left.image.cols + gap_px;
  cv::Mat pair(std::max(left.image.rows, right.image.rows), offset + right.image.cols, CV_8UC3, cv::Scalar(32, 32, 32));
  left.image.copyTo(pair(cv::Rect(0, 0, left.image.cols, left.image.rows)));
  right.image.copyTo(pair(cv::Rect(offset, 0, right.image.cols, right.image.rows)));
  MatchCounts counts;
  counts.in_first = static_cast<int>(starts_.size());
  for (const TrackedFeature& feature : frame.features) {
    const auto start = starts_.find(feature.id);
    if (start == starts_.end()) continue;
    const bool was_lost = start->second.was_lost;
    ++(was_lost ? counts.reidentified : counts.followed);
    draw_match(pair, left.at(start->second.pixel),
               right.at(feature.pixel) + cv::Point2f(static_cast<float>(offset), 0.0F),
               was_lost ? drawing::green : drawing::magenta);
  }
  drawing::save(path_.string(), drawing::with_caption(pair, legend(first_, second_, counts)));
  counts_ = counts;
}

void MatchImage::finish() {
  if (counts_) return;
  log_warning(fmt::format("no match image: frame {} was not in the run; frames are numbered as in the recording",
                          begun_ ? second_ : first_));
}

}  // namespace rastro
