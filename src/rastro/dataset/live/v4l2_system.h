// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace rastro {

/// The system calls by which a Video4Linux2 driver is spoken to; a test has one that plays a driver. All return what
/// the call returns and set errno as it does.
class V4l2System {
 public:
  virtual ~V4l2System() = default;
  virtual std::vector<std::string> device_files() const = 0;  ///< /dev/video0, /dev/video1, ... in order.
  virtual int open(const std::string& path) = 0;
  virtual int close(int descriptor) = 0;
  virtual int ioctl(int descriptor, unsigned long request, void* argument) = 0;
  virtual void* map(int descriptor, std::size_t length, std::size_t offset) = 0;
  virtual int unmap(void* address, std::size_t length) = 0;
  /// For an image; negative: error, 0: none within the time.
  virtual int wait(int descriptor, int milliseconds) = 0;
};

/// That of the machine.
V4l2System& v4l2_system();

}  // namespace rastro
