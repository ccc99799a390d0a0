// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/dataset_testing.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr const char* euroc_sensor =
    "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0, 0.0, {}, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, "
    "0.0, 0.0, "
    "0.0, 0.0, 1.0]\nrate_hz: 20\nresolution: [8, 6]\ncamera_model: pinhole\nintrinsics: [6.0, 6.0, 3.5, 2.5]\n"
    "distortion_model: radial-tangential\ndistortion_coefficients: [0.0, 0.0, 0.0, 0.0]\n";

void write_mat(const std::string& path, const cv::Mat& mat) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  if (!cv::imwrite(path, mat)) throw std::runtime_error("cannot write " + path);
}

}  // namespace

ScratchFolder::ScratchFolder() {
  static std::atomic<int> next{0};
  path_ = std::filesystem::temp_directory_path() / fmt::format("rastro_dataset_test_{}_{}", getpid(), next++);
  std::filesystem::create_directories(path_);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string ScratchFolder::path(const std::string& name) const {
  return (name.empty() ? path_ : path_ / name).string();
}

void ScratchFolder::write(const std::string& name, const std::string& text) const {
  std::filesystem::create_directories((path_ / name).parent_path());
  std::ofstream(path(name), std::ios::binary) << text;
}

void ScratchFolder::write_gray(const std::string& name, int value, int width, int height) const {
  write_mat(path(name), cv::Mat(height, width, CV_8UC1, cv::Scalar(value)));
}

void ScratchFolder::write_color(const std::string& name, int value, int width, int height) const {
  write_mat(path(name), cv::Mat(height, width, CV_8UC3, cv::Scalar(value, static_cast<int>(value / 2), 0)));
}

void ScratchFolder::write_depth(const std::string& name, int raw, int width, int height) const {
  write_mat(path(name), cv::Mat(height, width, CV_16UC1, cv::Scalar(raw)));
}

void ScratchFolder::truncate(const std::string& name, double share) const {
  const auto size = std::filesystem::file_size(path(name));
  std::filesystem::resize_file(path(name), static_cast<std::uintmax_t>(static_cast<double>(size) * share));
}

void write_euroc(const ScratchFolder& folder, int frames, int cameras) {
  for (int camera = 0; camera < cameras; ++camera) {
    const std::string base = fmt::format("mav0/cam{}/", camera);
    std::string list = "#timestamp [ns],filename\n";
    for (int k = 0; k < frames; ++k) {
      const std::int64_t stamp = 1'400'000'000'000'000'000 + k * 50'000'000LL;
      list += fmt::format("{},{}.png\n", stamp, stamp);
      folder.write_gray(fmt::format("{}data/{}.png", base, stamp), 10 + k + 100 * camera);
    }
    folder.write(base + "data.csv", list);
    folder.write(base + "sensor.yaml", fmt::format(euroc_sensor, fmt::format("{:.1f}", 0.1 * camera)));
  }
}

void write_tum(const ScratchFolder& folder, int frames) {
  std::string color = "# color images\n", depth = "# depth maps\n", ground_truth = "# tx ty tz qx qy qz qw\n";
  for (int k = 0; k < frames; ++k) {
    color += fmt::format("{:.6f} rgb/{}.png\n", 1000.0 + 0.05 * k, k);
    depth += fmt::format("{:.6f} depth/{}.png\n", 1000.004 + 0.05 * k, k);
    ground_truth += fmt::format("{:.6f} {} 0 0 0 0 0 1\n", 1000.0 + 0.05 * k, k);
    folder.write_color(fmt::format("rgb/{}.png", k), 10 + k);
    folder.write_depth(fmt::format("depth/{}.png", k), 5000 + 5 * k);
  }
  folder.write("rgb.txt", color);
  folder.write("depth.txt", depth);
  folder.write("groundtruth.txt", ground_truth);
}

void write_kitti(const ScratchFolder& folder, int frames, int pairs) {
  std::string times, poses;
  for (int k = 0; k < frames; ++k) {
    times += fmt::format("{:e}\n", 0.05 * k);
    poses += fmt::format("1 0 0 0 0 1 0 0 0 0 1 {}\n", k);
    folder.write_gray(fmt::format("image_0/{:06}.png", k), 10 + k);
    if (k < pairs) folder.write_gray(fmt::format("image_1/{:06}.png", k), 110 + k);
  }
  folder.write("times.txt", times);
  folder.write("poses.txt", poses);
  folder.write("calib.txt", "P0: 6 0 3.5 0 0 6 2.5 0 0 0 1 0\nP1: 6 0 3.5 -3 0 6 2.5 0 0 0 1 0\n");
}

void write_kitti_raw(const ScratchFolder& folder, int frames) {
  std::string stamps;
  for (int k = 0; k < frames; ++k) {
    stamps += fmt::format("2011-09-26 13:02:{:02}.500000000\n", k);
    folder.write_gray(fmt::format("image_00/data/{:010}.png", k), 10 + k);
  }
  folder.write("image_00/timestamps.txt", stamps);
  folder.write("oxts/timestamps.txt", stamps);
}

namespace {

/// An element of EBML (RFC 8794): id, size in eight bytes, content.
std::string element(std::uint32_t id, const std::string& content) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8)
    if (const auto byte = static_cast<char>(id >> shift & 0xFFU); byte != 0 || !bytes.empty()) bytes += byte;
  bytes += '\x01';
  for (int shift = 48; shift >= 0; shift -= 8) bytes += static_cast<char>(content.size() >> shift & 0xFFU);
  return bytes + content;
}

std::string number(std::uint32_t id, std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xFFU);
  return element(id, bytes);
}

std::string jpeg(int value) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", cv::Mat(6, 8, CV_8UC3, cv::Scalar::all(value)), bytes);
  return {bytes.begin(), bytes.end()};
}

}  // namespace

void write_matroska(const ScratchFolder& folder, const std::string& name, const std::vector<std::int64_t>& stamps_ms) {
  const std::string head = element(0x1A45DFA3, element(0x4282, "matroska") + number(0x4287, 4) + number(0x4285, 2));
  const std::string info = element(0x1549A966, number(0x2AD7B1, 1'000'000));  // ticks of a millisecond
  const std::string size = element(0xE0, number(0xB0, 8) + number(0xBA, 6));
  const std::string track =
      element(0xAE, number(0xD7, 1) + number(0x73C5, 1) + number(0x83, 1) + element(0x86, "V_MJPEG") + size);
  std::string clusters;
  int value = 0;
  for (const std::int64_t stamp : stamps_ms) {
    const std::string block = std::string("\x81\0\0\x80", 4) + jpeg(value += 10);  // track 1, at its cluster's time
    clusters += element(0x1F43B675, number(0xE7, static_cast<std::uint32_t>(stamp)) + element(0xA3, block));
  }
  folder.write(name, head + element(0x18538067, info + element(0x1654AE6B, track) + clusters));
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace rastro
