// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "rastro/base/error.h"
#include "rastro/cli/command.h"
#include "rastro/dataset/live/freenect_system.h"
#include "rastro/dataset/live/openni2.h"
#include "rastro/dataset/live/usb_cameras.h"
#include "rastro/dataset/live/v4l2.h"

namespace rastro::cli {
namespace {

constexpr const char* devices_footer = R"(
Cameras of Video4Linux2 with their sizes and rates, depth cameras that OpenNI2 and libfreenect (Kinect 1) find, and
depth cameras on the USB that lack their driver. A camera that cannot be used says why and what to do.

Examples:
  rastro devices
  rastro slam v4l2:/dev/video0,640x480@30 --method orb --calibration camera.yaml --out run)";

struct Devices {
  std::vector<V4l2Listing> cameras;
  std::vector<Openni2Listing> depth_cameras;
  std::vector<std::string> kinects;  ///< Serial numbers of those that libfreenect finds.
  bool has_freenect = false;
  std::string depth_problem;  ///< Why OpenNI2 could not be asked; empty if it could.
  std::vector<UsbCamera> usb;
};

Devices find_devices() {
  Devices devices;
  devices.cameras = list_v4l2(v4l2_system());
  devices.usb = list_usb_cameras();
  devices.has_freenect = freenect_system() != nullptr;
  if (devices.has_freenect) devices.kinects = freenect_system()->serials();
  if (!has_openni2()) devices.depth_problem = "this build does not use OpenNI2 (RASTRO_WITH_OPENNI2)";
  try {
    devices.depth_cameras = list_openni2();
  } catch (const Error& error) {
    devices.depth_problem = error.what();
  }
  return devices;
}

std::string rates_text(const std::vector<double>& rates) {
  std::string text;
  for (const double rate : rates) text += fmt::format("{}{:g}", text.empty() ? "" : ", ", rate);
  return text.empty() ? "" : " at " + text + " Hz";
}

std::string camera_text(const V4l2Listing& camera) {
  std::string text = fmt::format("v4l2:{}  {}\n", camera.file, camera.name);
  if (!camera.problem.empty()) text += "  cannot be used: " + camera.problem + "\n";
  for (const V4l2Mode& mode : camera.modes)
    text += fmt::format("  {} {}x{}{}\n", mode.format, mode.size.width, mode.size.height, rates_text(mode.rates_hz));
  return text;
}

std::string text_of(const Devices& devices) {
  std::string text;
  for (const V4l2Listing& camera : devices.cameras) text += camera_text(camera);
  for (const Openni2Listing& camera : devices.depth_cameras)
    text += fmt::format("openni2:  {} ({})\n", camera.name, camera.uri);
  for (std::size_t k = 0; k < devices.kinects.size(); ++k)
    text += fmt::format("freenect:{}  Kinect 1 ({})\n", k, devices.kinects[k]);
  if (devices.depth_cameras.empty() && devices.kinects.empty())
    for (const UsbCamera& camera : devices.usb)
      text +=
          fmt::format("{}  {} on the USB, but no driver for it: needs {}\n", camera.address, camera.name, camera.needs);
  if (text.empty()) text = "no camera is connected\n";
  if (!devices.has_freenect) text += "freenect: this build does not use libfreenect (RASTRO_WITH_FREENECT)\n";
  if (!devices.depth_problem.empty()) text += "OpenNI2: " + devices.depth_problem + "\n";
  return text;
}

std::string json_of(const Devices& devices) {
  nlohmann::ordered_json json{{"v4l2", nlohmann::json::array()},
                              {"openni2", nlohmann::json::array()},
                              {"freenect", nlohmann::json::array()},
                              {"usb", nlohmann::json::array()}};
  for (const V4l2Listing& camera : devices.cameras) {
    nlohmann::ordered_json modes = nlohmann::json::array();
    for (const V4l2Mode& mode : camera.modes)
      modes.push_back(
          {{"format", mode.format}, {"size_px", {mode.size.width, mode.size.height}}, {"rates_hz", mode.rates_hz}});
    json["v4l2"].push_back({{"source", "v4l2:" + camera.file},
                            {"name", camera.name},
                            {"problem", camera.problem},
                            {"modes", std::move(modes)}});
  }
  for (const Openni2Listing& camera : devices.depth_cameras)
    json["openni2"].push_back({{"source", "openni2:"}, {"name", camera.name}, {"uri", camera.uri}});
  for (std::size_t k = 0; k < devices.kinects.size(); ++k)
    json["freenect"].push_back({{"source", fmt::format("freenect:{}", k)}, {"serial", devices.kinects[k]}});
  json["openni2_problem"] = devices.depth_problem;
  for (const UsbCamera& camera : devices.usb)
    json["usb"].push_back({{"source", camera.address}, {"name", camera.name}, {"needs", camera.needs}});
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace

void add_devices_command(CLI::App& app, Context&) {
  CLI::App* command = app.add_subcommand("devices", "Lists connected cameras with their modes, and what is missing");
  const auto as_json = std::make_shared<bool>(false);
  command->add_flag("--json", *as_json, "Print the list as JSON");
  command->footer(devices_footer);
  command->callback([as_json] {
    const Devices devices = find_devices();
    fmt::print("{}", *as_json ? json_of(devices) : text_of(devices));
  });
}

}  // namespace rastro::cli
