// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/usb_cameras.h"

#include <fstream>
#include <string_view>

namespace rastro {
namespace {

namespace fs = std::filesystem;

struct Known {
  std::string_view vendor, product;  ///< Hexadecimal; an empty product: all of the vendor.
  const char *name, *address, *needs;
};
constexpr Known known[] = {
    {"045e", "02ae", "Kinect 1", "freenect:0", "a build with libfreenect (RASTRO_WITH_FREENECT)"},
    {"045e", "02c4", "Kinect 2", "openni2:", "the driver of libfreenect2 for OpenNI2, and USB 3"},
    {"045e", "02d8", "Kinect 2", "openni2:", "the driver of libfreenect2 for OpenNI2, and USB 3"},
    {"1d27", "", "PrimeSense or Xtion", "openni2:", "OpenNI2, which has its driver"},
    {"2bc5", "", "Orbbec Astra", "openni2:", "the driver of Orbbec for OpenNI2"},
};

std::string first_word(const fs::path& file) {
  std::ifstream stream(file);
  std::string word;
  stream >> word;
  return word;
}

}  // namespace

std::vector<UsbCamera> list_usb_cameras(const fs::path& devices) {
  std::vector<UsbCamera> cameras;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(devices, ignored)) {
    const std::string vendor = first_word(entry.path() / "idVendor"), product = first_word(entry.path() / "idProduct");
    for (const Known& each : known)
      if (vendor == each.vendor && (each.product.empty() || product == each.product))
        cameras.push_back({each.name, each.address, each.needs});
  }
  return cameras;
}

}  // namespace rastro
