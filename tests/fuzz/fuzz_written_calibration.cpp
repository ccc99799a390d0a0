// SPDX-License-Identifier: Apache-2.0
// The files that `rastro calibrate` writes and every command reads: whatever is read with a size is written in each
// format and read again with the same numbers; the keys of depth are read or refused in one line.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/camera/calibration_file.h"
#include "rastro/camera/write_calibration.h"
#include "rastro/dataset/tum_rgbd/depth_factor.h"

namespace {

void expect(bool promise) {
  if (!promise) std::abort();
}

void expect_same(const rastro::Camera& a, const rastro::Camera& b) {
  expect(a.width == b.width && a.height == b.height);
  expect(a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy);
  expect(a.distortion == b.distortion && a.coefficients == b.coefficients);
}

/// Kalibr has no model with five coefficients.
void expect_refused(const rastro::CalibratedCameraEntry& entry) {
  try {
    rastro::kalibr_calibration_text({entry});
  } catch (const rastro::Error& error) {
    return expect(std::string_view(error.what()).find('\n') == std::string_view::npos);
  }
  std::abort();
}

void expect_round_trips(rastro::Calibration read) {
  for (auto& entry : read.cameras) {
    if (entry.camera.width <= 0 || entry.camera.height <= 0) return;
    entry.camera.readout_s = read.cameras.front().camera.readout_s;
    entry.name = "camera";
  }
  const rastro::CalibratedCameraEntry& first = read.cameras.front();
  std::string text = rastro::ros_calibration_text({first}, 0);
  if (read.depth) text += rastro::depth_registration_text(*read.depth);
  const rastro::Calibration ros = rastro::parse_calibration(text, "ros");
  expect_same(ros.cameras.at(0).camera, first.camera);
  expect(ros.cameras[0].camera.readout_s == first.camera.readout_s);
  expect(ros.depth.has_value() == read.depth.has_value());
  if (read.depth) expect_same(ros.depth->depth_camera, read.depth->depth_camera);
  expect_same(rastro::parse_calibration(rastro::opencv_calibration_text({first}), "opencv").cameras.at(0).camera,
              first.camera);
  if (first.camera.distortion == rastro::Distortion::rational) return;
  if (first.camera.coefficient_count() == 5) return expect_refused(first);
  const auto chain = rastro::parse_calibration(rastro::kalibr_calibration_text({first}), "kalibr");
  expect_same(chain.cameras.at(0).camera, first.camera);
}

template <typename Read>
void expect_value_or_line(const Read& read) {
  try {
    read();
  } catch (const rastro::Error& error) {
    expect(std::string_view(error.what()).find('\n') == std::string_view::npos);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  std::optional<rastro::Calibration> read;
  expect_value_or_line([&] { read = rastro::parse_calibration(text, "input"); });
  // What was read can be written: no Error here.
  if (read) expect_round_trips(*read);
  expect_value_or_line([&] { expect(rastro::parse_depth_factor(text, "input").value_or(1.0) > 0.0); });
  expect_value_or_line([&] { expect(std::abs(rastro::parse_depth_offset(text, "input")) <= 1.0); });
  return 0;
}
