// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/tracks_jsonl.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <string>

#include "rastro/export/feature_text.h"

namespace rastro {
namespace {

void append_pair(std::string& text, const Eigen::Vector2f& pair) {
  text += '[';
  append_float(text, pair.x(), "null");
  text += ',';
  append_float(text, pair.y(), "null");
  text += ']';
}

void append_object(std::string& text, const TrackedFeature& feature) {
  fmt::format_to(std::back_inserter(text), R"({{"id":{},"pixel":)", feature.id);
  append_pair(text, feature.pixel);
  text += R"(,"ray":)";
  if (std::isfinite(feature.ray.x()) && std::isfinite(feature.ray.y())) {
    append_pair(text, feature.ray);
  } else {
    text += "null";
  }
  fmt::format_to(std::back_inserter(text), R"(,"age":{},"state":"{}","last_seen":{}}})", feature.age,
                 name_of(feature.state), feature.last_seen);
}

}  // namespace

void TracksJsonl::write(const TrackFrame& frame, GrayView) {
  std::string line = fmt::format(
      R"({{"frame":{},"stamp_ns":{},"tracked":{},"reidentified":{},"new":{},"lost":{},"masked":{},"health":"{}","features":[)",
      frame.index, frame.stamp, frame.tracked, frame.reidentified, frame.fresh, frame.lost, frame.masked,
      name_of(frame.health));
  for (const TrackedFeature& feature : frame.features) {
    if (line.back() == '}') line += ',';
    append_object(line, feature);
  }
  line += "]}\n";
  file_.append(line);
}

}  // namespace rastro
