// SPDX-License-Identifier: Apache-2.0
#include "rastro/sensor/trajectory_columns.h"

#include <algorithm>
#include <cctype>
#include <vector>

#include "rastro/base/text.h"

namespace rastro {
namespace {

/// The lines up to the first one with a pose.
constexpr std::size_t most_lines = 30, longest_line = 1000;

/// In lower case, without a unit in brackets.
std::string plain(std::string_view name) {
  std::string text;
  for (const char c : name.substr(0, std::min(name.find('['), name.find('('))))
    if (std::isspace(static_cast<unsigned char>(c)) == 0 && c != '"' && c != '\'')
      text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// 0 to 2: position; 3 to 6: orientation, x y z w.
std::optional<std::size_t> part_named(std::string_view name) {
  if (name.empty()) return std::nullopt;
  const std::size_t axis = std::string_view("xyzw").find(name.back());
  if (axis == std::string_view::npos) return std::nullopt;
  const auto has = [&](std::string_view part) { return name.find(part) != std::string_view::npos; };
  if (has("vel") || has("twist") || has("linear") || has("acc") || has("ang") || has("bias") || name.starts_with("v") ||
      name.starts_with("b"))
    return std::nullopt;
  if (name.starts_with("q") || has("orientation") || has("quat")) return 3 + axis;
  const bool of_position =
      name.size() == 1 || name.starts_with("p") || name.starts_with("t") || has("position") || has("translation");
  return of_position && axis < 3 ? std::optional(axis) : std::nullopt;
}

std::optional<TrajectoryColumns> columns_named_by(std::string_view line) {
  if (line.starts_with('#')) line.remove_prefix(1);
  const std::vector<std::string_view> names =
      line.find(',') != std::string_view::npos ? split(line, ',') : split_words(line);
  constexpr std::size_t unnamed = 0;  // the first one is the stamp
  std::array<std::size_t, 7> found{};
  for (std::size_t column = 1; column < names.size(); ++column) {
    const auto part = part_named(plain(names[column]));
    if (part && found[*part] == unnamed) found[*part] = column;
  }
  if (std::find(found.begin(), found.end(), unnamed) != found.end()) return std::nullopt;
  return TrajectoryColumns{{found[0], found[1], found[2]}, {found[3], found[4], found[5], found[6]}};
}

std::string_view line_at(std::string_view text, std::size_t start) {
  const std::string_view rest = text.substr(start, text.find('\n', start) - start);
  return rest.substr(0, longest_line);
}

/// Calls `take` with the start of each line before the first that begins like a number, until it returns true.
template <typename Take>
void each_line_before_poses(std::string_view text, Take take) {
  std::size_t start = 0;
  for (std::size_t k = 0; k < most_lines && start < text.size(); ++k) {
    const std::string_view line = line_at(text, start);
    if (!line.empty() && (std::isdigit(static_cast<unsigned char>(line.front())) != 0 || line.front() == '-')) return;
    if (take(start, line)) return;
    const std::size_t end = text.find('\n', start);
    if (end == std::string_view::npos) return;
    start = end + 1;
  }
}

}  // namespace

std::size_t TrajectoryColumns::last() const {
  return std::max(*std::max_element(position.begin(), position.end()),
                  *std::max_element(orientation.begin(), orientation.end()));
}

std::optional<TrajectoryColumns> named_columns(std::string_view text) {
  std::optional<TrajectoryColumns> named;
  each_line_before_poses(text, [&](std::size_t, std::string_view line) {
    named = columns_named_by(line);
    return named.has_value();
  });
  return named;
}

std::string with_commented_names(std::string text) {
  std::optional<std::size_t> names;
  each_line_before_poses(text, [&](std::size_t start, std::string_view line) {
    if (line.starts_with('#') || !columns_named_by(line)) return false;
    names = start;
    return true;
  });
  if (names) text[*names] = '#';
  return text;
}

}  // namespace rastro
