// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace rastro {

struct UsbCamera {
  std::string name;     ///< "Kinect 1".
  std::string address;  ///< How it is given as a source, once its driver is there: "openni2:".
  std::string needs;    ///< Which driver, in words.
};

/// Depth cameras on the USB by their numbers, whether a driver is there or not. `devices` lists them: the kernel's
/// /sys/bus/usb/devices.
std::vector<UsbCamera> list_usb_cameras(const std::filesystem::path& devices = "/sys/bus/usb/devices");

}  // namespace rastro
