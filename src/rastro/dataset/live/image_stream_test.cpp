// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "rastro/base/clock.h"
#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/live/camera_image.h"
#include "rastro/dataset/live/jpeg_stream.h"
#include "rastro/dataset/live/pipe.h"
#include "rastro/dataset/live/stream.h"
#include "rastro/dataset/live/y4m.h"

namespace rastro {
namespace {

using testing::HasSubstr;

std::span<const unsigned char> bytes_of(const std::string& text) {
  return {reinterpret_cast<const unsigned char*>(text.data()), text.size()};
}

/// Two images of 6x4 (odd chroma is rounded up): luma 10 and 20.
std::string y4m(const std::string& tags = " F30:1 C420jpeg", std::size_t chroma_bytes = 2 * 3 * 2) {
  std::string text = "YUV4MPEG2 W6 H4" + tags + "\n";
  for (const char luma : {10, 20}) text += "FRAME\n" + std::string(24, luma) + std::string(chroma_bytes, '\x80');
  return text;
}

TEST(Y4m, IsReadInPiecesOfAnyLength) {
  for (const std::size_t piece : {1UL, 7UL, 1000UL}) {
    Y4mStream stream;
    std::vector<int> lumas;
    const std::string text = y4m();
    for (std::size_t at = 0; at < text.size(); at += piece) {
      stream.feed(bytes_of(text.substr(at, piece)));
      while (const auto planes = stream.next()) {
        EXPECT_EQ(planes->size(), 36U);
        lumas.push_back(planes->front());
      }
    }
    EXPECT_EQ(lumas, (std::vector<int>{10, 20}));
    EXPECT_EQ(stream.header()->rate_hz, 30.0);
  }
}

TEST(Y4m, KnowsTheChromaOfEachKind) {
  const auto bytes = [](const char* colors) {
    return parse_y4m_header(std::string("YUV4MPEG2 W5 H3 C") + colors).frame_bytes();
  };
  EXPECT_EQ(bytes("420mpeg2"), 15U + 2 * 3 * 2);
  EXPECT_EQ(bytes("422"), 15U + 2 * 3 * 3);
  EXPECT_EQ(bytes("444"), 15U + 2 * 5 * 3);
  EXPECT_EQ(bytes("mono"), 15U);
}

TEST(Y4m, RefusesWhatItCannotRead) {
  const auto refused = [](const std::string& header) { return error_of([&] { parse_y4m_header(header); }); };
  EXPECT_THAT(refused("RIFF"), HasSubstr("YUV4MPEG2"));
  EXPECT_THAT(refused("YUV4MPEG2 W6"), HasSubstr("width or height"));
  EXPECT_THAT(refused("YUV4MPEG2 W6 H4 C420p10"), HasSubstr("420p10"));
  EXPECT_THAT(refused("YUV4MPEG2 W6 H4 It"), HasSubstr("interlaced"));
  EXPECT_THAT(refused("YUV4MPEG2 W99999999 H4"), HasSubstr("99999999"));
  Y4mStream stream;
  stream.feed(bytes_of("YUV4MPEG2 W6 H4\nFRAMF" + std::string(100, '\n')));
  EXPECT_THAT(error_of([&] { stream.next(); }), HasSubstr("FRAME"));
}

TEST(Y4m, ColorsAreThoseOfOpenCv) {
  // OpenCV's own I420 is limited range too, and takes the nearest chroma.
  const int width = 16, height = 8;
  cv::Mat color(height, width, CV_8UC3, cv::Scalar(40, 120, 200)), planes, back;
  cv::cvtColor(color, planes, cv::COLOR_BGR2YUV_I420);
  cv::cvtColor(planes, back, cv::COLOR_YUV2BGR_I420);
  const Y4mHeader header = parse_y4m_header("YUV4MPEG2 W16 H8 C420");
  Frame frame;
  convert_y4m(header, {planes.data, header.frame_bytes()}, true, frame);
  for (int channel = 0; channel < 3; ++channel)
    EXPECT_NEAR(frame.color.rgb.at(3 * 5 + channel, 4), back.at<cv::Vec3b>(4, 5)[2 - channel], 2);
}

std::string jpeg(int value) {
  std::vector<unsigned char> bytes;
  cv::Mat image(24, 32, CV_8U, cv::Scalar(value));
  cv::rectangle(image, {4, 4}, {20, 12}, cv::Scalar(255 - value), cv::FILLED);
  cv::imencode(".jpg", image, bytes);
  return {bytes.begin(), bytes.end()};
}

TEST(JpegStream, GivesFileAfterFileAndSkipsWhatIsBetween) {
  const std::string first = jpeg(10), second = jpeg(200);
  const std::string text =
      "--boundary\r\n" + first + "\r\n\xFF" + second.substr(0, 40) + second + jpeg(90).substr(0, 200);
  for (const std::size_t piece : {1UL, 13UL, 10'000UL}) {
    JpegStream stream;
    std::vector<std::string> files;
    for (std::size_t at = 0; at < text.size(); at += piece) {
      stream.feed(bytes_of(text.substr(at, piece)));
      while (const auto file = stream.next()) files.emplace_back(file->begin(), file->end());
    }
    ASSERT_GE(files.size(), 2U);
    EXPECT_EQ(files.front(), first);
    EXPECT_EQ(files.back(), second);
  }
}

TEST(JpegStream, TellsWholeFilesFromOthers) {
  const std::string file = jpeg(10);
  EXPECT_EQ(jpeg_length(bytes_of(file + "more")), file.size());
  for (std::size_t length = 0; length < file.size(); ++length)
    EXPECT_EQ(jpeg_length(bytes_of(file.substr(0, length))), std::nullopt) << length;
  EXPECT_EQ(jpeg_length(bytes_of("no JPEG")), 0U);
}

/// A pipe that holds the bytes and is closed behind them.
class FullPipe {
 public:
  explicit FullPipe(const std::string& bytes) {
    if (::pipe(ends_) != 0 || ::write(ends_[1], bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
      throw Error("no pipe");
    ::close(ends_[1]);
  }
  ~FullPipe() { ::close(ends_[0]); }
  int end() const { return ends_[0]; }

 private:
  int ends_[2];
};

std::vector<Frame> read_pipe(const std::string& bytes, const OpenOptions& options) {
  const FullPipe pipe(bytes);
  SteadyClock clock;
  const auto source = open_pipe("pipe:", pipe.end(), options, clock);
  std::vector<Frame> frames;
  while (source->condition().state != LiveState::ended)
    if (auto arrived = source->next(ns_per_second)) frames.push_back(std::move(arrived->frame));
  return frames;
}

TEST(Pipe, GivesTheImagesOfEitherKindToTheirEnd) {
  OpenOptions options;
  options.rate_hz = 10.0;
  const auto planes = read_pipe(y4m(), options);
  ASSERT_EQ(planes.size(), 2U);
  EXPECT_EQ(planes[1].image.at(5, 3), 20);
  EXPECT_EQ(planes[1].stamp, ns_per_second / 10);
  EXPECT_EQ(planes[1].index, 1);
  options.rate_hz = 0.0;
  options.want_color = true;
  const auto files = read_pipe(jpeg(10) + jpeg(200), options);
  ASSERT_EQ(files.size(), 2U);
  EXPECT_NEAR(files[1].image.at(30, 20), 200, 3);
  EXPECT_EQ(files[1].color.width(), 32);
  EXPECT_GT(files[1].stamp, 1'700'000'000 * ns_per_second) << "a date";
}

TEST(Pipe, StopsWaitingForAFirstImageWhenAsked) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  SteadyClock clock;
  const std::atomic<bool> stop = true;
  EXPECT_THAT(error_of([&] { open_pipe("pipe:", ends[0], {}, clock, &stop); }), HasSubstr("interrupted"));
  for (const int end : ends) ::close(end);
}

TEST(Pipe, RefusesWhatIsNeither) {
  const auto refused = [](const std::string& bytes) { return error_of([&] { read_pipe(bytes, {}); }); };
  EXPECT_THAT(refused("RIFF"), HasSubstr("neither Y4M nor MJPEG"));
  EXPECT_THAT(refused(""), HasSubstr("no images"));
  EXPECT_THAT(refused("YUV4MPEG2 W6 H4\nFRAME\n"), HasSubstr("no whole image"));
}

TEST(Stream, IsGivenMoreTimeWithEachTryToOpenItAgain) {
  ReopenLimit limit(1500, 5000);
  for (const int expected : {1500, 3000, 5000, 5000}) EXPECT_EQ(limit.take_ms(), expected);
  limit.reset();
  EXPECT_EQ(limit.take_ms(), 1500);
}

}  // namespace
}  // namespace rastro
