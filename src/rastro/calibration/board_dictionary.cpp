// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/board_dictionary.h"

#include <array>
#include <opencv2/aruco/dictionary.hpp>

#include "rastro/base/error.h"

namespace rastro {
namespace {

struct Dictionary {
  std::string_view name;
  int number;
  int size;
};

constexpr std::array<Dictionary, 20> dictionaries = {
    {{"4x4_50", cv::aruco::DICT_4X4_50, 50},          {"4x4_100", cv::aruco::DICT_4X4_100, 100},
     {"4x4_250", cv::aruco::DICT_4X4_250, 250},       {"4x4_1000", cv::aruco::DICT_4X4_1000, 1000},
     {"5x5_50", cv::aruco::DICT_5X5_50, 50},          {"5x5_100", cv::aruco::DICT_5X5_100, 100},
     {"5x5_250", cv::aruco::DICT_5X5_250, 250},       {"5x5_1000", cv::aruco::DICT_5X5_1000, 1000},
     {"6x6_50", cv::aruco::DICT_6X6_50, 50},          {"6x6_100", cv::aruco::DICT_6X6_100, 100},
     {"6x6_250", cv::aruco::DICT_6X6_250, 250},       {"6x6_1000", cv::aruco::DICT_6X6_1000, 1000},
     {"7x7_50", cv::aruco::DICT_7X7_50, 50},          {"7x7_100", cv::aruco::DICT_7X7_100, 100},
     {"7x7_250", cv::aruco::DICT_7X7_250, 250},       {"7x7_1000", cv::aruco::DICT_7X7_1000, 1000},
     {"16h5", cv::aruco::DICT_APRILTAG_16h5, 30},     {"25h9", cv::aruco::DICT_APRILTAG_25h9, 35},
     {"36h10", cv::aruco::DICT_APRILTAG_36h10, 2320}, {"36h11", cv::aruco::DICT_APRILTAG_36h11, 587}}};

const Dictionary* find(std::string_view name) {
  for (const Dictionary& dictionary : dictionaries)
    if (dictionary.name == name) return &dictionary;
  return nullptr;
}

}  // namespace

std::optional<int> dictionary_number(std::string_view name) {
  const Dictionary* dictionary = find(name);
  return dictionary == nullptr ? std::nullopt : std::optional<int>(dictionary->number);
}

int dictionary_size(std::string_view name) {
  const Dictionary* dictionary = find(name);
  return dictionary == nullptr ? 0 : dictionary->size;
}

bool is_apriltag_family(std::string_view name) {
  return find(name) != nullptr && name.find('h') != std::string_view::npos;
}

std::vector<std::vector<bool>> tag_cells(std::string_view name, int id) {
  RASTRO_CHECK(id >= 0 && id < dictionary_size(name), "a tag to draw is in its dictionary");
  const auto dictionary = cv::aruco::getPredefinedDictionary(*dictionary_number(name));
  const int side = dictionary->markerSize + 2;
  cv::Mat image;
  dictionary->drawMarker(id, side, image, 1);
  std::vector<std::vector<bool>> cells(static_cast<std::size_t>(side));
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) cells[static_cast<std::size_t>(y)].push_back(image.at<std::uint8_t>(y, x) < 128);
  return cells;
}

}  // namespace rastro
