// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/feature_text.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>

#include "rastro/base/text.h"

namespace rastro {
namespace {

std::optional<TrackState> parse_state(std::string_view name) {
  for (const TrackState state : {TrackState::tracked, TrackState::fresh, TrackState::reidentified}) {
    if (name == name_of(state)) return state;
  }
  return std::nullopt;
}

/// NaN is allowed only where `may_be_missing`; infinities never are.
std::optional<float> parse_float(std::string_view text, bool may_be_missing) {
  const auto value = parse_double(text.starts_with('.') ? text.substr(1) == "nan" ? "nan" : text : text);
  if (!value || std::isinf(*value) || (std::isnan(*value) && !may_be_missing)) return std::nullopt;
  if (std::abs(*value) > std::numeric_limits<float>::max()) return std::nullopt;
  return static_cast<float>(*value);
}

}  // namespace

void append_float(std::string& text, float value, std::string_view not_a_number) {
  if (!std::isfinite(value)) {
    text += not_a_number;
    return;
  }
  std::array<char, 64> digits{};
  const auto [end, error] =
      std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed);
  text.append(digits.data(), error == std::errc() ? end : digits.data());
}

void append_feature(std::string& text, const TrackedFeature& feature, std::string_view separator,
                    std::string_view not_a_number) {
  fmt::format_to(std::back_inserter(text), "{}", feature.id);
  for (const float value : {feature.pixel.x(), feature.pixel.y(), feature.ray.x(), feature.ray.y()}) {
    text += separator;
    append_float(text, value, not_a_number);
  }
  fmt::format_to(std::back_inserter(text), "{0}{1}{0}{2}{0}{3}", separator, feature.age, name_of(feature.state),
                 feature.last_seen);
}

std::optional<TrackedFeature> parse_feature(std::span<const std::string_view> columns) {
  if (columns.size() != feature_columns.size()) return std::nullopt;
  const auto id = parse_int64(columns[0]);
  const auto x = parse_float(columns[1], false);
  const auto y = parse_float(columns[2], false);
  const auto ray_x = parse_float(columns[3], true);
  const auto ray_y = parse_float(columns[4], true);
  const auto age = parse_int64(columns[5]);
  const auto state = parse_state(columns[6]);
  const auto last_seen = parse_int64(columns[7]);
  if (!id || *id < 0 || !x || !y || !ray_x || !ray_y || !state || !last_seen || *last_seen < -1) return std::nullopt;
  if (!age || *age < 1 || *age > std::numeric_limits<std::int32_t>::max()) return std::nullopt;
  TrackedFeature feature;
  feature.id = *id;
  feature.pixel = {*x, *y};
  feature.ray = {*ray_x, *ray_y};
  feature.age = static_cast<std::int32_t>(*age);
  feature.state = *state;
  feature.last_seen = *last_seen;
  return feature;
}

std::optional<TrackHealth> parse_health(std::string_view name) {
  for (const TrackHealth health :
       {TrackHealth::good, TrackHealth::few_corners, TrackHealth::dark_or_blank, TrackHealth::abrupt_motion}) {
    if (name == name_of(health)) return health;
  }
  return std::nullopt;
}

void add_feature(TrackFrame& frame, const TrackedFeature& feature) {
  frame.features.push_back(feature);
  frame.tracked += feature.state == TrackState::tracked ? 1 : 0;
  frame.fresh += feature.state == TrackState::fresh ? 1 : 0;
  frame.reidentified += feature.state == TrackState::reidentified ? 1 : 0;
}

}  // namespace rastro
