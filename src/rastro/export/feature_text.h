// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "rastro/track/track_frame.h"

namespace rastro {

/// The columns of one feature in every text format, in this order.
inline constexpr std::array<std::string_view, 8> feature_columns = {"id",    "x_px", "y_px",  "ray_x",
                                                                    "ray_y", "age",  "state", "last_seen"};

/// Shortest text that reads back to the same float, never with an exponent (some YAML readers take those for words).
void append_float(std::string& text, float value, std::string_view not_a_number);

/// The columns of a feature between separators.
void append_feature(std::string& text, const TrackedFeature& feature, std::string_view separator,
                    std::string_view not_a_number);

/// Reads the columns back; nullopt when any of them is not what append_feature writes.
std::optional<TrackedFeature> parse_feature(std::span<const std::string_view> columns);

std::optional<TrackHealth> parse_health(std::string_view name);

/// Adds a feature to a frame and counts its state.
void add_feature(TrackFrame& frame, const TrackedFeature& feature);

}  // namespace rastro
