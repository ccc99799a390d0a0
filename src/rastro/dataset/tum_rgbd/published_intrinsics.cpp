// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/tum_rgbd/published_intrinsics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string>

#include "rastro/camera/calibration_file.h"

namespace rastro {
namespace {

bool is_letter_or_digit(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

/// 1, 2 or 3 where the name holds "freiburgN" or "frN" as a word of its own; 0 otherwise.
int freiburg_number(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  for (int number = 1; number <= 3; ++number) {
    if (name.find(fmt::format("freiburg{}", number)) != std::string::npos) return number;
    const std::string word = fmt::format("fr{}", number);
    const auto at = name.find(word);
    if (at == std::string::npos) continue;
    const bool begins = at == 0 || !is_letter_or_digit(name[at - 1]);
    const bool ends = at + word.size() == name.size() || !is_letter_or_digit(name[at + word.size()]);
    if (begins && ends) return number;
  }
  return 0;
}

}  // namespace

std::optional<CalibratedCamera> tum_camera_of_folder(const std::filesystem::path& folder) {
  // Of the folder above too: recordings are unpacked as freiburg1/rgbd.
  const auto whole = (std::filesystem::absolute(folder) / "x").lexically_normal().parent_path();
  int number = freiburg_number(whole.filename().string());
  if (number == 0) number = freiburg_number(whole.parent_path().filename().string());
  if (number == 0) return std::nullopt;
  const auto camera = published_tum_camera(fmt::format("freiburg{}", number));
  if (!camera) return std::nullopt;
  return CalibratedCamera{"rgb", camera, std::nullopt, fmt::format("published TUM fr{} intrinsics", number)};
}

}  // namespace rastro
