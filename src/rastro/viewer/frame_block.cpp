// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/frame_block.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include "rastro/viewer/block_writer.h"
#include "rastro/viewer/feature_block.h"
#include "rastro/viewer/scene_parts.h"
#include "rastro/viewer/small_image.h"

namespace rastro {
namespace {

struct FramePoints {
  std::vector<float> positions;
  std::vector<std::uint8_t> colors;  ///< Or empty.
};

/// Where color and depth differ in size, the points have no colors.
FramePoints points_of_depth(const Frame& frame, const Camera& camera) {
  constexpr int most_points = 60'000;
  FramePoints points;
  const DepthImage& depth = frame.depth;
  int step = 1;
  while (depth.width() / step * (depth.height() / step) > most_points) ++step;
  const bool colored = frame.color.width() == depth.width() && frame.color.height() == depth.height();
  const bool gray = !colored && frame.image.width() == depth.width() && frame.image.height() == depth.height();
  for (int y = 0; y < depth.height(); y += step) {
    for (int x = 0; x < depth.width(); x += step) {
      const auto meters = static_cast<double>(depth.at(x, y));
      const auto ray = meters > 0.0 && std::isfinite(meters) ? camera.unproject({x, y}) : std::nullopt;
      if (!ray) continue;
      detail::append(points.positions, meters * ray->homogeneous());
      if (colored)
        for (int channel = 0; channel < 3; ++channel) points.colors.push_back(frame.color.rgb.at(3 * x + channel, y));
      if (gray) points.colors.insert(points.colors.end(), 3, frame.image.at(x, y));
    }
  }
  return points;
}

FramePoints points_of_scan(const LaserScan& scan) {
  FramePoints points;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.is_return(beam)) continue;
    const auto range = static_cast<double>(scan.ranges[beam]);
    const double angle = scan.angle_of(beam);
    const Eigen::Vector2d in_body =
        scan.body_from_laser * Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle));
    detail::append(points.positions, {in_body.x(), in_body.y(), 0.0});
  }
  return points;
}

}  // namespace

std::string frame_block(const Frame& frame, const SourceInfo& recording, const LiveFeatures* features) {
  constexpr int longest_side_px = 960;
  detail::BlockBody body;
  nlohmann::ordered_json header{{"type", "frame"}, {"index", frame.index}, {"name", frame.name}};
  if (!frame.image.empty() || !frame.color.empty()) {
    header["width"] = frame.color.empty() ? frame.image.width() : frame.color.width();
    header["height"] = frame.color.empty() ? frame.image.height() : frame.color.height();
    header["jpeg"] = body.put(detail::small_image(frame, longest_side_px).jpeg);
  }
  if (features != nullptr) detail::put_features(*features, header, body);
  FramePoints points;
  const bool calibrated = !recording.cameras.empty() && recording.cameras.front().camera;
  if (!frame.depth.empty() && calibrated) points = points_of_depth(frame, *recording.cameras.front().camera);
  if (frame.scan) points = points_of_scan(*frame.scan);
  body.put_if_any(header, "points", points.positions);
  body.put_if_any(header, "colors", points.colors);
  return detail::block_of(header, body);
}

}  // namespace rastro
