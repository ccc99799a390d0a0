// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/images/images.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/dataset/calibration.h"
#include "rastro/dataset/folder.h"
#include "rastro/sensor/stamp_text.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr double usual_rate_hz = 30.0;

struct Listing {
  fs::path folder;
  std::vector<std::string> names;
};

bool is_pattern(const std::string& path) { return path.find_first_of("*?[") != std::string::npos; }

std::optional<Listing> list_images(const std::string& path) {
  if (is_folder(path)) return Listing{path, image_names(path)};
  if (is_file(path)) {
    if (!has_image_ending(path)) return std::nullopt;
    return Listing{fs::path(path).parent_path(), {fs::path(path).filename().string()}};
  }
  if (!is_pattern(path)) return std::nullopt;
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
  if (is_pattern(folder.string()))
    throw Error("patterns are understood in the file name only", path, "name one folder");
  require_folder(folder);
  Listing listing{folder, image_names(folder)};
  const std::string pattern = fs::path(path).filename().string();
  std::erase_if(listing.names, [&](const auto& name) { return !matches_pattern(name, pattern); });
  if (listing.names.empty()) throw Error("no image matches the pattern", path, "");
  return listing;
}

/// The part of a name before its number: images of two cameras in one folder differ there.
std::vector<std::string> series(const std::vector<std::string>& names) {
  std::map<std::string, int> counts;
  for (const auto& name : names) ++counts[name.substr(0, name.find_first_of("0123456789"))];
  std::vector<std::string> prefixes;
  for (const auto& [prefix, count] : counts)
    if (count > 1) prefixes.push_back(prefix + "*");
  return prefixes;
}

enum class NameKind { no_stamp, whole, fraction };

/// Of a name that is a time: 13 digits (milliseconds since 1970) or more, or seconds with a fraction as TUM has them.
NameKind kind_of_name(const std::string& name) {
  constexpr std::size_t fewest_digits = 13, fewest_s_digits = 9;
  const std::string stem = fs::path(name).stem().string();
  const auto point = stem.find('.');
  const std::string rest = point == std::string::npos ? stem : stem.substr(0, point) + stem.substr(point + 1);
  if (!std::all_of(rest.begin(), rest.end(), [](char c) { return c >= '0' && c <= '9'; })) return NameKind::no_stamp;
  if (point != std::string::npos) return point >= fewest_s_digits ? NameKind::fraction : NameKind::no_stamp;
  return stem.size() >= fewest_digits ? NameKind::whole : NameKind::no_stamp;
}

/// Nanoseconds since the start of a device may look like milliseconds or microseconds since 1970, but for their steps.
StampUnit unit_of_times(const std::vector<double>& stamps) {
  constexpr double shortest_step_s = 5e-4, longest_step_s = 20.0;
  constexpr std::array<double, 4> units_s = {1.0, 1e-3, 1e-6, 1e-9};
  const StampUnit guessed = guess_stamp_unit(stamps, StampUnit::nanoseconds);
  const double step = (stamps.back() - stamps.front()) / std::max(1.0, static_cast<double>(stamps.size() - 1));
  const double as_guessed_s = step * units_s[static_cast<std::size_t>(guessed)], as_ns_s = step * units_s.back();
  const bool is_uptime = as_guessed_s > longest_step_s && as_ns_s >= shortest_step_s && as_ns_s <= longest_step_s;
  return is_uptime ? StampUnit::nanoseconds : guessed;
}

/// The unit of all names together; nullopt where any is no time, or of another kind than the others.
std::optional<StampUnit> unit_of_names(const std::vector<std::string>& names) {
  const NameKind kind = kind_of_name(names.front());
  if (kind == NameKind::no_stamp) return std::nullopt;
  std::vector<double> stamps;
  for (const auto& name : names) {
    const auto stamp = parse_finite(fs::path(name).stem().string());
    if (kind_of_name(name) != kind || !stamp) return std::nullopt;
    stamps.push_back(*stamp);
  }
  if (kind == NameKind::fraction) return StampUnit::seconds;
  if (names.front().front() != '0') return unit_of_times(stamps);
  // Filled up with zeros: nanoseconds since some start, unless the steps are those of numbers of images.
  constexpr double shortest_step_ns = 5e5;
  const auto steps = static_cast<double>(stamps.size() - 1);
  const bool are_times = steps > 0.0 && stamps.back() - stamps.front() >= shortest_step_ns * steps;
  return are_times ? std::optional(StampUnit::nanoseconds) : std::nullopt;
}

std::string_view long_name(StampUnit unit) {
  constexpr std::array<std::string_view, 4> names = {"seconds", "milliseconds", "microseconds", "nanoseconds"};
  return names[static_cast<std::size_t>(unit)];
}

void set_stamps(Recording& recording, const Listing& listing, double wanted_rate_hz) {
  const auto stamps = wanted_rate_hz > 0.0 ? std::nullopt : stamps_from_names(listing.names);
  const double rate_hz = wanted_rate_hz > 0.0 ? wanted_rate_hz : usual_rate_hz;
  for (std::size_t k = 0; k < recording.frames.size(); ++k) {
    recording.frames[k].stamp = stamps ? (*stamps)[k] : made_up_stamp(static_cast<std::int64_t>(k), rate_hz);
  }
  recording.info.has_stamps = stamps.has_value();
  if (stamps) {
    const auto unit = unit_of_names(listing.names).value_or(StampUnit::nanoseconds);
    recording.info.warnings.push_back(fmt::format("stamps are taken from the file names, as {}", long_name(unit)));
  }
  if (!stamps && wanted_rate_hz <= 0.0) {
    recording.info.warnings.push_back(
        fmt::format("no stamps; they are made up at {:g} Hz, --rate HZ changes that", rate_hz));
  }
}

}  // namespace

std::optional<std::vector<TimeNs>> stamps_from_names(const std::vector<std::string>& names) {
  if (names.empty()) return std::nullopt;
  const auto unit = unit_of_names(names);
  if (!unit) return std::nullopt;
  std::vector<TimeNs> stamps;
  for (const auto& name : names) {
    const auto stamp = parse_stamp(fs::path(name).stem().string(), *unit);
    if (!stamp || *stamp > largest_stamp) return std::nullopt;
    if (!stamps.empty() && *stamp <= stamps.back()) return std::nullopt;
    stamps.push_back(*stamp);
  }
  return stamps;
}

std::optional<Recording> index_images(const std::string& path, const OpenOptions& options) {
  const auto listing = list_images(path);
  if (!listing || listing->names.empty()) return std::nullopt;
  const auto file = calibration_is_given(options) ? fs::path() : find_calibration_file(listing->folder);
  if (!options.camera.empty() && options.calibration_file.empty() && file.empty())
    throw Error("a folder of images has no named cameras", "--camera", "omit it, or name a calibration file that has");
  Recording recording;
  recording.info.path = path;
  recording.info.format = "images";
  for (const auto& name : listing->names) recording.frames.push_back({0, (listing->folder / name).string(), "", "", 0});
  set_stamps(recording, *listing, options.rate_hz);
  if (const auto prefixes = series(listing->names); prefixes.size() > 1) {
    recording.info.warnings.push_back(fmt::format("the names fall into series ({}); a pattern such as '{}' chooses one",
                                                  fmt::join(prefixes, ", "),
                                                  (listing->folder / prefixes.front()).string()));
  }
  if (file.empty()) {
    recording.info.cameras.push_back(uncalibrated("images"));
  } else {
    read_unnamed_camera(recording.info, file, "images", options.camera);
  }
  return recording;
}

}  // namespace rastro
