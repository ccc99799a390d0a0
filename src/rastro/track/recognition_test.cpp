// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/recognition.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "rastro/base/random.h"

namespace rastro {
namespace {

constexpr std::int64_t now = 6;
const Eigen::Vector2f per_frame(20.0F, -4.0F);

/// Forty features that move alike from frame 3 on, and lost ones that moved with them up to frame `last`. Corners are
/// not aligned, so that the image does not matter.
class LostAndFound {
 public:
  TrackOptions options;
  int most = 100;

  LostAndFound() {
    options.align = false;
    options.min_distance_px = 10.0;
    for (int i = 0; i < 40; ++i) {
      const Eigen::Vector2f start(static_cast<float>(random_.uniform(0.0, 500.0)),
                                  static_cast<float>(random_.uniform(50.0, 400.0)));
      const std::size_t track = observed(start, 3, now - 1, random_descriptor());
      const Eigen::Vector2f pixel = at(start, now);
      tracked_.push_back({track, pixel, pixel});
    }
    image_.build(GrayImage(640, 480).view(), 1, klt_padding, nullptr);
  }
  Descriptor random_descriptor() {
    Descriptor descriptor;
    for (auto& word : descriptor.words) word = random_.next();
    return descriptor;
  }
  static Descriptor flipped(Descriptor descriptor, int bits) {
    for (int bit = 0; bit < bits; ++bit)
      descriptor.words[static_cast<std::size_t>(bit / 64)] ^= std::uint64_t{1} << (bit % 64);
    return descriptor;
  }
  static Eigen::Vector2f at(const Eigen::Vector2f& start, std::int64_t frame) {
    return start + static_cast<float>(frame - 3) * per_frame;
  }
  std::size_t add_lost(const Eigen::Vector2f& start, const Descriptor& descriptor, std::int64_t last = now - 1,
                       std::int64_t first = 3) {
    const std::size_t track = observed(start, first, last, descriptor);
    store_.mark_lost(track);
    return track;
  }
  void add_corner(const Eigen::Vector2f& pixel, const Descriptor& descriptor) {
    corners_.push_back(pixel);
    descriptors_[{pixel.x(), pixel.y()}] = descriptor;
  }
  /// The image gets texture, with which the patches of lost features are aligned.
  void show_waves() {
    GrayImage waves(640, 480);
    for (int y = 0; y < waves.height(); ++y)
      for (int x = 0; x < waves.width(); ++x)
        waves.at(x, y) = static_cast<std::uint8_t>(
            std::lround(128.0 + 50.0 * std::sin(0.21 * x + 0.05 * y) + 40.0 * std::sin(0.17 * y - 0.08 * x)));
    image_.build(waves.view(), 1, klt_padding, nullptr);
    has_patches_ = true;
  }
  std::vector<Recognized> recognized(TaskPool* pool = nullptr) const {
    const Describe describe = [this](const Eigen::Vector2f& corner) {
      return std::vector<Descriptor>{descriptors_.at({corner.x(), corner.y()})};
    };
    TrackTimes times;
    return recognize(corners_, describe, tracked_, store_, now, image_, most, options, pool, times);
  }
  /// (corner, track), in their order.
  using Found = std::vector<std::pair<std::size_t, std::size_t>>;
  Found found(TaskPool* pool = nullptr) const {
    Found pairs;
    for (const Recognized& one : recognized(pool)) {
      EXPECT_EQ(one.pixel, corners_[one.corner]);
      pairs.emplace_back(one.corner, one.track);
    }
    return pairs;
  }

 private:
  std::size_t observed(const Eigen::Vector2f& start, std::int64_t first, std::int64_t last, const Descriptor& look) {
    const std::size_t track = store_.create();
    for (std::int64_t frame = first; frame <= last; ++frame)
      store_[track].observe(frame, at(start, frame), at(start, frame), look);
    if (has_patches_) store_[track].keep_patch(last, 1, image_, at(start, now), options.patch_window_px);
    return track;
  }

  Random random_{7};
  TrackStore store_{30};
  std::vector<Association> tracked_;
  std::vector<Eigen::Vector2f> corners_;
  std::map<std::pair<float, float>, Descriptor> descriptors_;
  Pyramid image_;
  bool has_patches_ = false;
};

const Eigen::Vector2f somewhere(200.0F, 200.0F), elsewhere(400.0F, 300.0F);

TEST(Recognition, ACornerIsALostFeatureThatLooksLikeItWhereTheOthersMoved) {
  LostAndFound scene;
  const Descriptor look = scene.random_descriptor();
  const std::size_t lost = scene.add_lost(somewhere, look);
  const Eigen::Vector2f there = LostAndFound::at(somewhere, now);
  scene.add_corner(there + Eigen::Vector2f(0.0F, 25.0F), look);
  scene.add_corner(there + Eigen::Vector2f(0.0F, -25.0F), scene.random_descriptor());
  scene.add_corner(there, LostAndFound::flipped(look, 30));
  EXPECT_EQ(scene.found(), (LostAndFound::Found{{2, lost}}));
  TaskPool pool(3);
  EXPECT_EQ(scene.found(&pool), (LostAndFound::Found{{2, lost}}));
  scene.most = 0;
  EXPECT_TRUE(scene.found().empty());
}

TEST(Recognition, OneLostForLongHasMovedAsFarAsTheOthers) {
  LostAndFound scene;
  const Descriptor look = scene.random_descriptor();
  const std::size_t lost = scene.add_lost(somewhere, look, 3);
  scene.options.max_travel_px = 30.0;  // it moved by 61
  scene.add_corner(LostAndFound::at(somewhere, now), look);
  EXPECT_EQ(scene.found(), (LostAndFound::Found{{0, lost}}));
}

TEST(Recognition, OfTwoCornersTheMoreVotesThenTheSmallerDistanceThenTheStrongerOneCounts) {
  const Eigen::Vector2f there = LostAndFound::at(somewhere, now), beside = there + Eigen::Vector2f(1.0F, 0.0F);
  for (const auto& [first, second, winner] : {std::tuple{20, 10, 1U}, {10, 20, 0U}, {10, 10, 0U}}) {
    LostAndFound scene;
    const Descriptor look = scene.random_descriptor();
    const std::size_t lost = scene.add_lost(somewhere, look);
    scene.add_corner(there, LostAndFound::flipped(look, first));
    scene.add_corner(beside, LostAndFound::flipped(look, second));
    EXPECT_EQ(scene.found(), (LostAndFound::Found{{winner, lost}})) << first << ' ' << second;
  }
}

TEST(Recognition, MoreVotesComeFirstAndOnlyAsManyAsAskedFor) {
  LostAndFound scene;
  const Descriptor one = scene.random_descriptor(), other = scene.random_descriptor();
  const std::size_t once = scene.add_lost(somewhere, one, now - 1, now - 1);
  const std::size_t often = scene.add_lost(elsewhere, other);
  scene.add_corner(LostAndFound::at(somewhere, now), one);
  scene.add_corner(LostAndFound::at(elsewhere, now), LostAndFound::flipped(other, 10));
  EXPECT_EQ(scene.found(), (LostAndFound::Found{{1, often}, {0, once}})) << "three votes against one";
  scene.most = 1;
  EXPECT_EQ(scene.found(), (LostAndFound::Found{{1, often}}));
}

TEST(Recognition, AFeatureReappearsOnlyOnce) {
  LostAndFound scene;
  scene.options.min_distance_px = 2.0;
  const Descriptor look = scene.random_descriptor();
  const std::size_t lost = scene.add_lost(somewhere, look);
  const Eigen::Vector2f there = LostAndFound::at(somewhere, now), aside(0.0F, 1.5F);
  scene.add_corner(there - aside, LostAndFound::flipped(look, 3));
  scene.add_corner(there + aside, look);
  EXPECT_EQ(scene.found(), (LostAndFound::Found{{1, lost}})) << "both are where it may be";
}

TEST(Recognition, ACornerIsAlignedWithThePatchInNoMoreStepsThanAllowed) {
  for (const int iterations : {1, 30}) {
    LostAndFound scene;
    scene.options.align = true;
    scene.options.flow_iterations = iterations;
    scene.show_waves();
    const Descriptor look = scene.random_descriptor();
    scene.add_lost(somewhere, look);
    const Eigen::Vector2f there = LostAndFound::at(somewhere, now);
    scene.add_corner(there + Eigen::Vector2f(3.0F, -2.0F), look);
    const std::vector<Recognized> found = scene.recognized();
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ((found.front().pixel - there).norm() < 0.05F, iterations > 1) << found.front().pixel.transpose();
  }
}

/// The newest patch is of the image as it is now; the one before is of `off_px` beside it, in another light, so that it
/// fits less well; or the other way round.
Eigen::Vector2f offset_of_older_and_newer(double max_residual_ratio, float off_px, bool newer_is_off = false) {
  const auto waves = [](bool disturbed) {
    GrayImage image(200, 200);
    for (int y = 0; y < 200; ++y) {
      for (int x = 0; x < 200; ++x) {
        const double other = disturbed ? 14.0 * std::sin(0.5 * x - 0.6 * y) : 0.0;
        image.at(x, y) = static_cast<std::uint8_t>(
            std::lround(128.0 + 50.0 * std::sin(0.21 * x + 0.05 * y) + 40.0 * std::sin(0.17 * y - 0.08 * x) + other));
      }
    }
    return image;
  };
  TrackOptions options;
  options.max_residual_ratio = max_residual_ratio;
  options.max_alignment_residual = 1.0;
  Pyramid now_seen, before;
  now_seen.build(waves(false).view(), 1, klt_padding, nullptr);
  before.build(waves(true).view(), 1, klt_padding, nullptr);
  const Eigen::Vector2f here(100.0F, 100.0F);
  TrackStore store(30);
  const std::size_t lost = store.create();
  store[lost].observe(1, here, here, {});
  for (const std::int64_t frame : {1, 2}) {
    const bool off = newer_is_off == (frame == 2);
    store[lost].observe(frame, here, here, {});
    store[lost].keep_patch(frame, 1, off ? before : now_seen, here + Eigen::Vector2f(off ? off_px : 0.0F, 0.0F),
                           options.patch_window_px);
  }
  store.mark_lost(lost);
  options.min_votes = 1;
  std::vector<Association> tracked;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector2f pixel(20.0F + 25.0F * static_cast<float>(i % 6), 20.0F + 25.0F * static_cast<float>(i / 6));
    tracked.push_back({store.create(), pixel, pixel});
    for (const std::int64_t frame : {1, 2}) store[tracked.back().track].observe(frame, pixel, pixel, {});
  }
  const std::vector<Eigen::Vector2f> corners{here};
  TrackTimes times;
  const auto found = recognize(
      corners, [](const Eigen::Vector2f&) { return std::vector<Descriptor>(1); }, tracked, store, now, now_seen, 1,
      options, nullptr, times);
  return found.empty() ? Eigen::Vector2f(1e3F, 1e3F) : Eigen::Vector2f(found.front().pixel - here);
}

TEST(Recognition, TheOlderPatchDecidesOnlyWhereItFitsAsWellAsATrackedFeature) {
  EXPECT_LT(offset_of_older_and_newer(0.001, 1.5F).norm(), 0.1F) << "by the newer one, which fits better";
  EXPECT_GT(offset_of_older_and_newer(1.0, 1.5F).norm(), 1.0F) << "by the older one";
  EXPECT_LT(offset_of_older_and_newer(1.0, 1.5F).norm(), 2.0F);
  EXPECT_LT(offset_of_older_and_newer(-1.0, 1.5F, true).norm(), 0.1F) << "by the older one, which fits better";
}

/// Two lost features that look alike, 6 px apart: the one taken first leaves the other corner to the other one.
TEST(Recognition, ATakenFeatureLeavesTheSecondBestCandidate) {
  LostAndFound scene;
  scene.options.min_distance_px = 4.0;
  const Descriptor look = scene.random_descriptor(), alike = LostAndFound::flipped(look, 12);
  const Eigen::Vector2f aside(0.0F, 2.0F);
  const std::size_t best = scene.add_lost(somewhere, look), second = scene.add_lost(somewhere + aside, alike);
  const Eigen::Vector2f there = LostAndFound::at(somewhere, now);
  scene.add_corner(there, look);
  scene.add_corner(there + 2.0F * aside, LostAndFound::flipped(look, 3));
  const LostAndFound::Found found = scene.found();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0], (std::pair<std::size_t, std::size_t>{0, best}));
  EXPECT_EQ(found[1], (std::pair<std::size_t, std::size_t>{1, second}));
  scene.options.min_distance_px = 4.5;
  EXPECT_EQ(scene.found().size(), 1U) << "too near to the first";
}

}  // namespace
}  // namespace rastro
