// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/v4l2_system.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

#include "rastro/base/text.h"

namespace rastro {
namespace {

class Machine final : public V4l2System {
 public:
  std::vector<std::string> device_files() const override {
    constexpr std::string_view begin = "video";
    std::vector<std::int64_t> numbers;
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator("/dev", ignored)) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with(begin)) continue;
      if (const auto number = parse_int64(std::string_view(name).substr(begin.size()))) numbers.push_back(*number);
    }
    std::sort(numbers.begin(), numbers.end());
    std::vector<std::string> files;
    for (const std::int64_t number : numbers) files.push_back("/dev/video" + std::to_string(number));
    return files;
  }
  int open(const std::string& path) override { return ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC); }
  int close(int descriptor) override { return ::close(descriptor); }
  int ioctl(int descriptor, unsigned long request, void* argument) override {
    int result = 0;
    do result = ::ioctl(descriptor, request, argument);
    while (result < 0 && errno == EINTR);
    return result;
  }
  void* map(int descriptor, std::size_t length, std::size_t offset) override {
    void* address = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, static_cast<off_t>(offset));
    return address == MAP_FAILED ? nullptr : address;
  }
  int unmap(void* address, std::size_t length) override { return ::munmap(address, length); }
  int wait(int descriptor, int milliseconds) override {
    pollfd waiting{descriptor, POLLIN, 0};
    const int result = ::poll(&waiting, 1, milliseconds);
    return result < 0 && errno == EINTR ? 0 : result;
  }
};

}  // namespace

V4l2System& v4l2_system() {
  static Machine machine;
  return machine;
}

}  // namespace rastro
