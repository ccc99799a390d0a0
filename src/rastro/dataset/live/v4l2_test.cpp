// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/v4l2.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#if __has_include(<linux/videodev2.h>)

#include <linux/videodev2.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <deque>
#include <opencv2/imgcodecs.hpp>

#include "rastro/base/clock_testing.h"
#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/live/usb_cameras.h"

namespace rastro {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr TimeNs ms = 1'000'000;
constexpr int width = 16, height = 8;

/// Plays a driver of a camera with 16x8 pixels: which formats it has, at which rates, and what happens to it.
class FakeDriver final : public V4l2System {
 public:
  explicit FakeDriver(FakeClock& clock) : clock_(clock) {}

  std::vector<std::pair<std::uint32_t, unsigned>> formats = {{V4L2_PIX_FMT_YUYV, 30}};  ///< With their highest rate.
  int open_error = 0;
  int failing_starts = 0;
  bool is_unplugged = false, is_silent = false, is_camera = true;
  std::uint32_t lost = 0;   ///< Before the next image.
  std::uint32_t flags = 0;  ///< Of the next image.
  int open_files = 0, mapped = 0, queued = 0;
  std::uint32_t format_in_use = 0;

  std::vector<std::string> device_files() const override { return {"/dev/video0", "/dev/video1"}; }

  int open(const std::string& path) override {
    if (path != "/dev/video0" || open_error != 0) return fail(open_error != 0 ? open_error : ENOENT);
    ++open_files;
    return 7;
  }
  int close(int) override { return --open_files, 0; }

  void* map(int, std::size_t, std::size_t offset) override {
    ++mapped;
    return buffers_.at(offset).data();
  }
  int unmap(void*, std::size_t) override { return --mapped, 0; }

  int wait(int, int milliseconds) override {
    if (is_unplugged) return fail(ENODEV);
    if (is_silent) return clock_.sleep_for(milliseconds * ms), 0;
    clock_.move(33 * ms);
    return 1;
  }

  int ioctl(int, unsigned long request, void* argument) override {
    if (is_unplugged) return fail(ENODEV);
    switch (request) {
      case VIDIOC_QUERYCAP:
        return query(*static_cast<v4l2_capability*>(argument));
      case VIDIOC_ENUM_FMT:
        return describe(*static_cast<v4l2_fmtdesc*>(argument));
      case VIDIOC_ENUM_FRAMESIZES:
        return describe(*static_cast<v4l2_frmsizeenum*>(argument));
      case VIDIOC_ENUM_FRAMEINTERVALS:
        return describe(*static_cast<v4l2_frmivalenum*>(argument));
      case VIDIOC_S_FMT:
        return set(*static_cast<v4l2_format*>(argument));
      case VIDIOC_S_PARM:
        return set(*static_cast<v4l2_streamparm*>(argument));
      case VIDIOC_REQBUFS:
        if (mapped > 0) return fail(EBUSY);
        return static_cast<v4l2_requestbuffers*>(argument)->count = 2, 0;
      case VIDIOC_QUERYBUF:
        return place(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_QBUF:
        return waiting_.push_back(static_cast<v4l2_buffer*>(argument)->index), ++queued, 0;
      case VIDIOC_DQBUF:
        return fill(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
        return failing_starts > 0 ? --failing_starts, fail(EPROTO) : 0;
      case VIDIOC_STREAMOFF:
        return 0;
      default:
        return fail(ENOTTY);
    }
  }

 private:
  static int fail(int code) { return errno = code, -1; }

  int query(v4l2_capability& capability) const {
    capability.capabilities = V4L2_CAP_DEVICE_CAPS;
    capability.device_caps = is_camera ? V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING : V4L2_CAP_META_CAPTURE;
    std::strcpy(reinterpret_cast<char*>(capability.card), "Fake Webcam");
    return 0;
  }
  int describe(v4l2_fmtdesc& description) const {
    if (description.index >= formats.size()) return fail(EINVAL);
    description.pixelformat = formats[description.index].first;
    return 0;
  }
  static int describe(v4l2_frmsizeenum& size) {
    if (size.index > 0) return fail(EINVAL);
    size.type = V4L2_FRMSIZE_TYPE_DISCRETE;
    size.discrete = {width, height};
    return 0;
  }
  int describe(v4l2_frmivalenum& interval) const {
    if (interval.index > 0) return fail(EINVAL);
    interval.type = V4L2_FRMIVAL_TYPE_DISCRETE;
    interval.discrete = {1, rate_of(interval.pixel_format)};
    return 0;
  }
  unsigned rate_of(std::uint32_t code) const {
    for (const auto& [each, rate] : formats)
      if (each == code) return rate;
    return 0;
  }
  int set(v4l2_format& format) {
    format_in_use = format.fmt.pix.pixelformat;
    format.fmt.pix.width = width;
    format.fmt.pix.height = height;
    format.fmt.pix.bytesperline = format_in_use == V4L2_PIX_FMT_YUYV ? 2 * width + 8 : 0;
    return 0;
  }
  int set(v4l2_streamparm& parameters) const {
    auto& interval = parameters.parm.capture.timeperframe;
    if (1.0 * interval.denominator / interval.numerator > rate_of(format_in_use))
      interval = {1, rate_of(format_in_use)};
    return 0;
  }
  int place(v4l2_buffer& buffer) const {
    buffer.length = static_cast<std::uint32_t>(buffers_[0].size());
    buffer.m.offset = buffer.index;
    return 0;
  }
  int fill(v4l2_buffer& buffer) {
    if (waiting_.empty()) return fail(EAGAIN);
    buffer.index = waiting_.front();
    waiting_.pop_front();
    buffer.bytesused = draw(buffers_[buffer.index]);
    sequence_ += 1 + std::exchange(lost, 0);
    buffer.sequence = sequence_;
    const TimeNs exposed = clock_.now() - 10 * ms;
    buffer.timestamp = {exposed / ns_per_second, exposed % ns_per_second / 1000};
    buffer.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | std::exchange(flags, 0);
    return 0;
  }
  /// Gray value 16 + 10 * x.
  std::uint32_t draw(std::array<unsigned char, 4096>& bytes) const {
    cv::Mat image(height, width, CV_8U);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) image.at<unsigned char>(y, x) = static_cast<unsigned char>(16 + 10 * x);
    if (format_in_use == V4L2_PIX_FMT_MJPEG) {
      std::vector<unsigned char> file;
      cv::imencode(".jpg", image, file);
      std::copy(file.begin(), file.end(), bytes.begin());
      return static_cast<std::uint32_t>(file.size());
    }
    const int step = format_in_use == V4L2_PIX_FMT_YUYV ? 2 : 1, stride = step == 2 ? 2 * width + 8 : width;
    bytes.fill(128);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        bytes.at(static_cast<std::size_t>(y * stride + step * x)) = image.at<unsigned char>(y, x);
    return static_cast<std::uint32_t>(height * stride);
  }

  FakeClock& clock_;
  std::array<std::array<unsigned char, 4096>, 2> buffers_{};
  std::deque<std::uint32_t> waiting_;
  std::uint32_t sequence_ = 0;
};

class V4l2 : public testing::Test {
 protected:
  void SetUp() override {
    if (list_v4l2(driver_).empty()) GTEST_SKIP() << "built without Video4Linux2";
  }
  std::unique_ptr<LiveSource> camera(const std::string& request, bool want_color = false) {
    OpenOptions options;
    options.want_color = want_color;
    return open_v4l2("v4l2:" + request, request, options, driver_, clock_);
  }
  std::string refused(const std::string& request) {
    return error_of([&] { camera(request); });
  }

  FakeClock clock_;
  FakeDriver driver_{clock_};
};

TEST_F(V4l2, ReadsEachFormatWithTheDriversStamps) {
  for (const auto& [code, name, tolerance] :
       {std::tuple{V4L2_PIX_FMT_YUYV, "YUYV", 0}, {V4L2_PIX_FMT_MJPEG, "MJPG", 4}, {V4L2_PIX_FMT_GREY, "GREY", 0}})
    for (const bool want_color : {false, true}) {
      driver_.formats = {{code, 30}};
      const auto source = camera("/dev/video0,16x8@30," + std::string(name), want_color);
      for (int k = 0; k < 5; ++k) {
        const auto arrived = source->next(50 * ms);
        ASSERT_TRUE(arrived) << name;
        EXPECT_EQ(arrived->exposed, clock_.now() - 10 * ms) << "the driver's own time";
        EXPECT_EQ(arrived->frame.color.empty(), !want_color);
        // With color, gray comes from red, green and blue of the full range.
        const double expected = want_color && code == V4L2_PIX_FMT_YUYV ? (16 + 70 - 16) * 255.0 / 219.0 : 16 + 70;
        EXPECT_NEAR(arrived->frame.image.at(7, 3), expected, tolerance + (want_color ? 2 : 0)) << name;
      }
    }
  EXPECT_EQ(driver_.open_files, 0);
  EXPECT_EQ(driver_.mapped, 0);
}

TEST_F(V4l2, TakesTheFirstFormatThatReachesTheRate) {
  driver_.formats = {{V4L2_PIX_FMT_MJPEG, 30}, {V4L2_PIX_FMT_YUYV, 10}, {V4L2_PIX_FMT_H264, 60}};
  camera("/dev/video0,16x8@30");
  EXPECT_EQ(driver_.format_in_use, V4L2_PIX_FMT_MJPEG);
  camera("/dev/video0,16x8@10");
  EXPECT_EQ(driver_.format_in_use, V4L2_PIX_FMT_YUYV) << "without loss";
  camera("/dev/video0,16x8@120");
  EXPECT_EQ(driver_.format_in_use, V4L2_PIX_FMT_MJPEG) << "the fastest";
}

TEST_F(V4l2, CountsWhatTheDriverLostAndSkipsDamagedImages) {
  const auto source = camera("/dev/video0");
  EXPECT_EQ(source->next(50 * ms)->lost_before, 0);
  driver_.lost = 3;
  EXPECT_EQ(source->next(50 * ms)->lost_before, 3);
  driver_.flags = V4L2_BUF_FLAG_ERROR;
  driver_.lost = 2;
  EXPECT_THAT(error_of([&] { source->next(50 * ms); }), HasSubstr("damaged"));
  driver_.lost = 1;
  EXPECT_EQ(source->next(50 * ms)->lost_before, 3) << "also those before the damaged one";
  EXPECT_EQ(source->next(50 * ms)->lost_before, 0);
  for (int k = 0; k < 5; ++k) EXPECT_TRUE(source->next(50 * ms)) << "its buffer is given back";
}

TEST_F(V4l2, IsGoneWhenUnpluggedAndGoesOnWhenItReturns) {
  const auto source = camera("/dev/video0");
  for (int run = 0; run < 20; ++run) {
    ASSERT_TRUE(source->next(50 * ms));
    driver_.is_unplugged = true;
    EXPECT_FALSE(source->next(50 * ms));
    EXPECT_EQ(source->condition().state, LiveState::gone);
    EXPECT_THAT(source->condition().line, HasSubstr("/dev/video0: unplugged; waiting for it"));
    driver_.is_unplugged = false;
    driver_.open_error = EACCES;
    for (int k = 0; k < 20; ++k) EXPECT_FALSE(source->next(50 * ms));
    EXPECT_THAT(source->condition().line, HasSubstr("group video"));
    driver_.open_error = 0;
    for (int k = 0; k < 20 && source->condition().state == LiveState::gone; ++k) source->next(50 * ms);
    EXPECT_EQ(source->condition().state, LiveState::delivering);
  }
  driver_.is_silent = true;
  for (int k = 0; k < 60; ++k) source->next(50 * ms);
  EXPECT_EQ(source->condition().state, LiveState::stalled);
}

TEST_F(V4l2, ACameraThatDoesNotStartIsNotKeptInUse) {
  driver_.failing_starts = 1;
  EXPECT_THAT(refused("/dev/video0"), HasSubstr("does not start"));
  EXPECT_EQ(driver_.mapped, 0);
  EXPECT_EQ(driver_.open_files, 0);
  EXPECT_TRUE(camera("/dev/video0")->next(50 * ms));
}

TEST_F(V4l2, SaysWhyItCannotBeUsed) {
  EXPECT_THAT(refused("/dev/video9"), HasSubstr("plugged in"));
  EXPECT_THAT(refused("/dev/video0,16x8@30,H264"), HasSubstr("is not a camera"));
  EXPECT_THAT(refused("/dev/video0,16"), HasSubstr("give v4l2:"));
  EXPECT_THAT(refused("/dev/video0,99x99"), HasSubstr("no mode that fits; it offers YUYV"));
  driver_.formats = {{V4L2_PIX_FMT_H264, 30}};
  EXPECT_THAT(refused("/dev/video0"), HasSubstr("it offers H264"));
  driver_.open_error = EBUSY;
  EXPECT_THAT(refused("/dev/video0"), HasSubstr("in use by another program"));
  driver_.open_error = 0;
  driver_.is_camera = false;
  EXPECT_THAT(refused("/dev/video0"), HasSubstr("is no camera"));
}

TEST_F(V4l2, IsListedWithItsModesOrWhatIsMissing) {
  auto list = list_v4l2(driver_);
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0].name, "Fake Webcam");
  ASSERT_EQ(list[0].modes.size(), 1U);
  EXPECT_EQ(list[0].modes[0].format, "YUYV");
  EXPECT_EQ(list[0].modes[0].size, (ImageSize{width, height}));
  EXPECT_THAT(list[0].modes[0].rates_hz, ElementsAre(30.0));
  EXPECT_THAT(list[1].problem, HasSubstr("/dev/video1"));
  driver_.open_error = EACCES;
  EXPECT_THAT(list_v4l2(driver_)[0].problem, HasSubstr("usermod -aG video"));
}

TEST(UsbCameras, AreKnownByTheirNumbers) {
  const ScratchFolder folder;
  folder.write("1-1/idVendor", "045e\n");
  folder.write("1-1/idProduct", "02ae\n");
  folder.write("1-2/idVendor", "046d\n");
  folder.write("1-2/idProduct", "0825\n");
  const auto cameras = list_usb_cameras(folder.path());
  ASSERT_EQ(cameras.size(), 1U);
  EXPECT_EQ(cameras[0].name, "Kinect 1");
  EXPECT_TRUE(list_usb_cameras(folder.path("nothing")).empty());
}

}  // namespace
}  // namespace rastro

#endif
