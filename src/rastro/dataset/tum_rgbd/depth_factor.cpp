// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/tum_rgbd/depth_factor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/dataset/folder.h"
#include "rastro/dataset/image_file.h"

namespace rastro {
namespace {

constexpr std::array<std::string_view, 6> keys = {"depth_factor",        "depth_scale", "depthmapfactor",
                                                  "rgbd.depthmapfactor", "depthfactor", "m_depthshift"};
constexpr std::array<const char*, 9> files = {"calibration.yaml", "calibration.yml", "calibration.txt",
                                              "calibration",      "camera.yaml",     "camera.yml",
                                              "camera.txt",       "info.txt",        "_info.txt"};

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

/// Counts of raw numbers over the images, without the two that mean "none".
struct RawStatistics {
  std::size_t measured = 0;
  std::size_t multiples_of_5 = 0;
  std::size_t saturated = 0;
  std::vector<std::size_t> histogram = std::vector<std::size_t>(65536, 0);

  void add(const Image<std::uint16_t>& image) {
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) ++histogram[image.at(x, y)];
    }
  }
  void sum_up() {
    saturated = histogram[65535];
    for (std::size_t value = 1; value < 65535; ++value) {
      measured += histogram[value];
      if (value % 5 == 0) multiples_of_5 += histogram[value];
    }
  }
  std::size_t percentile_99() const {
    std::size_t below = 0;
    for (std::size_t value = 1; value < 65535; ++value) {
      below += histogram[value];
      if (static_cast<double>(below) >= 0.99 * static_cast<double>(measured)) return value;
    }
    return 0;
  }
};

}  // namespace

std::optional<double> parse_depth_factor(std::string_view text, std::string_view where) {
  for (const auto& line : content_lines(text)) {
    const auto separator = line.text.find_first_of(":=");
    if (separator == std::string_view::npos) continue;
    if (std::find(keys.begin(), keys.end(), lower(trim(line.text.substr(0, separator)))) == keys.end()) continue;
    auto value_text = line.text.substr(separator + 1);
    value_text = value_text.substr(0, value_text.find('#'));
    const auto value = parse_finite(value_text);
    if (!value || *value <= 0.0) {
      throw Error(fmt::format("the depth factor {} is not a positive number", in_quotes(trim(value_text))),
                  at_line(where, line.number), "");
    }
    // "depth_scale: 0.001" means meters a unit.
    return *value < 1.0 ? 1.0 / *value : *value;
  }
  return std::nullopt;
}

double parse_depth_offset(std::string_view text, std::string_view where) {
  for (const auto& line : content_lines(text)) {
    const auto separator = line.text.find(':');
    if (separator == std::string_view::npos || trim(line.text.substr(0, separator)) != "depth_offset_m") continue;
    const auto value = parse_finite(line.text.substr(separator + 1));
    if (!value || std::abs(*value) > 1.0)
      throw Error(fmt::format("the depth offset {} is no number of meters from -1 to 1",
                              in_quotes(trim(line.text.substr(separator + 1)))),
                  at_line(where, line.number), "");
    return *value;
  }
  return 0.0;
}

DepthFactor guess_depth_factor(std::span<const Image<std::uint16_t>> images) {
  RawStatistics raw;
  for (const auto& image : images) raw.add(image);
  raw.sum_up();
  if (raw.measured == 0) return {5000.0, "no depth image with measurements was found, 5000 is TUM's", true};
  const double fives = static_cast<double>(raw.multiples_of_5) / static_cast<double>(raw.measured);
  if (fives > 0.95) return {5000.0, fmt::format("{:.0f} % of the numbers are multiples of 5", 100.0 * fives), true};
  const std::size_t far = raw.percentile_99();
  if (raw.saturated > 0) return {1000.0, "65535 means no measurement, as in 7-Scenes", true};
  if (far < 12000)
    return {1000.0, fmt::format("99 % of the numbers are below {}, which would be {:.1f} m at 5000", far, far / 5000.0),
            true};
  return {5000.0, fmt::format("99 % of the numbers are below {}, which would be {:.0f} m at 1000", far, far / 1000.0),
          true};
}

std::optional<DepthFactor> read_depth_factor(const std::filesystem::path& file) {
  const std::string text = read_text_file(file.string());
  const auto factor = parse_depth_factor(text, file.string());
  if (!factor) return std::nullopt;
  return DepthFactor{*factor, file.string(), false, parse_depth_offset(text, file.string())};
}

std::optional<DepthFactor> depth_factor_in(const std::filesystem::path& folder) {
  for (const char* name : files) {
    const auto file = folder / name;
    if (!is_file(file)) continue;
    if (auto factor = read_depth_factor(file)) return factor;
  }
  return std::nullopt;
}

DepthFactor guess_depth_factor_of(const std::vector<std::string>& depth_files) {
  constexpr std::size_t samples = 5;
  std::vector<Image<std::uint16_t>> images;
  for (std::size_t k = 0; k < std::min(samples, depth_files.size()); ++k) {
    try {
      images.push_back(read_raw_depth(depth_files[k * depth_files.size() / std::min(samples, depth_files.size())]));
    } catch (const Error&) {
      // A broken depth image is reported by the frame that needs it.
    }
  }
  return guess_depth_factor(images);
}

}  // namespace rastro
