// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/writer_thread.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <stdexcept>

namespace rastro {
namespace {

/// Records its input; can be blocked, or fail at a frame.
class Notes : public TrackSink {
 public:
  void write(const TrackFrame& frame, GrayView image) override {
    if (gate.valid()) gate.wait();
    if (frame.index == fails_at) throw std::runtime_error("disk full");
    frames.push_back(frame.index);
    first_pixels.push_back(image.at(0, 0));
    ++written;
  }
  void finish() override { ++finished; }

  std::shared_future<void> gate;
  std::int64_t fails_at = -1;
  std::vector<std::int64_t> frames;
  std::vector<int> first_pixels;
  std::atomic<int> written = 0;
  int finished = 0;
};

TrackFrame frame_of(std::int64_t index) {
  TrackFrame frame;
  frame.index = index;
  return frame;
}

GrayImage image_of(std::int64_t index) {
  GrayImage image(4, 4);
  image.at(0, 0) = static_cast<std::uint8_t>(index);
  return image;
}

TEST(WriterThread, GivesEverySinkEveryFrameInOrder) {
  Notes a, b;
  WriterThread writer({&a, &b}, 3);
  for (std::int64_t k = 0; k < 100; ++k) writer.write(frame_of(k), image_of(k));
  writer.finish();
  for (const Notes* notes : {&a, &b}) {
    ASSERT_EQ(notes->frames.size(), 100U);
    for (std::int64_t k = 0; k < 100; ++k) {
      EXPECT_EQ(notes->frames[static_cast<std::size_t>(k)], k);
      EXPECT_EQ(notes->first_pixels[static_cast<std::size_t>(k)], k);
    }
    EXPECT_EQ(notes->finished, 1);
  }
}

/// While the sink is blocked, no more frames fit than the queue's length; the next write must wait.
TEST(WriterThread, HoldsNoMoreThanItsQueue) {
  Notes notes;
  std::promise<void> open;
  notes.gate = open.get_future().share();
  WriterThread writer({&notes}, 3);
  std::atomic<int> accepted = 0;
  std::promise<void> three;
  std::thread producer([&] {
    for (std::int64_t k = 0; k < 10; ++k) {
      writer.write(frame_of(k), image_of(k));
      if (++accepted == 3) three.set_value();
    }
  });
  three.get_future().wait();
  EXPECT_LE(accepted.load(), 3);
  EXPECT_EQ(notes.written.load(), 0);
  open.set_value();
  producer.join();
  writer.finish();
  EXPECT_EQ(notes.frames.size(), 10U);
}

TEST(WriterThread, AFailureComesOutOfFinishOrOfALaterWrite) {
  Notes notes;
  notes.fails_at = 5;
  WriterThread writer({&notes}, 2);
  const auto write_all = [&] {
    for (std::int64_t k = 0; k < 50; ++k) writer.write(frame_of(k), image_of(k));
  };
  EXPECT_THROW(write_all(), std::runtime_error);
  EXPECT_THROW(writer.finish(), std::runtime_error);
  EXPECT_EQ(notes.frames, (std::vector<std::int64_t>{0, 1, 2, 3, 4})) << "nothing after what failed";
  EXPECT_EQ(notes.finished, 0);
  Notes last;
  last.fails_at = 2;
  WriterThread other({&last}, 8);
  for (std::int64_t k = 0; k < 3; ++k) {
    try {
      other.write(frame_of(k), image_of(k));
    } catch (const std::runtime_error&) {
    }
  }
  EXPECT_THROW(other.finish(), std::runtime_error) << "of the very last frame too";
}

TEST(WriterThread, WithoutSinksOrFramesThereIsNothingToDo) {
  WriterThread none({}, 1);
  for (std::int64_t k = 0; k < 20; ++k) none.write(frame_of(k), image_of(k));
  none.finish();
  Notes notes;
  WriterThread empty({&notes}, 1);
  empty.finish();
  EXPECT_TRUE(notes.frames.empty());
  EXPECT_EQ(notes.finished, 1);
}

TEST(WriterThread, MayBeLeftWithoutFinishing) {
  Notes notes;
  {
    WriterThread writer({&notes}, 4);
    for (std::int64_t k = 0; k < 4; ++k) writer.write(frame_of(k), image_of(k));
  }
  EXPECT_LE(notes.frames.size(), 4U);
  for (std::size_t k = 0; k < notes.frames.size(); ++k) EXPECT_EQ(notes.frames[k], static_cast<std::int64_t>(k));
  EXPECT_EQ(notes.finished, 0);
}

}  // namespace
}  // namespace rastro
