// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/surface_truth/surface_ground_truth_reader.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/dataset/open.h"
#include "rastro/synthetic/worlds/hall.h"
#include "rastro/synthetic/write_euroc.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

std::string contents(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

void write(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

/// A small recording on disk, written once for all tests here, and the world it shows.
class SurfaceGroundTruthTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    world_ = new World(make_hall({.seed = 3, .scale = 0.25, .distortion = true, .threads = 2}));
    folder_ = scratch_path("surface_truth");
    TaskPool pool(2);
    write_euroc(*world_, folder_, {.frames = 18}, pool);
  }
  static void TearDownTestSuite() {
    fs::remove_all(folder_);
    delete world_;
  }
  /// A copy of the ground truth that a test may break.
  static fs::path copy() {
    fs::path target = folder_ / "broken";
    fs::remove_all(target);
    fs::copy(folder_ / "mav0/truth", target, fs::copy_options::recursive);
    return target;
  }
  static inline World* world_ = nullptr;
  static inline fs::path folder_;
};

TEST_F(SurfaceGroundTruthTest, agrees_with_the_world_it_was_written_from) {
  const SurfaceGroundTruthReader ground_truth = read_surface_ground_truth(folder_.string());
  ASSERT_EQ(ground_truth.frame_count(), 18);
  Random random(1);
  int compared = 0, same = 0, same_view = 0;
  for (int i = 0; i < 600; ++i) {
    const int frame = static_cast<int>(random.below(18)), later = static_cast<int>(random.below(18));
    const Eigen::Vector2d pixel(random.uniform(0, 187), random.uniform(0, 119));
    const auto exact = world_->surface_at(frame, pixel);
    const auto read = ground_truth.surface_at(frame, pixel);
    ASSERT_TRUE(exact && read);
    if (exact->surface != read->surface) continue;
    ++compared;
    const auto exact_view = world_->view_of(later, exact->point);
    const RecordedView view = ground_truth.view_of(later, read->point_in_world);
    same += !exact_view.inside || (exact_view.pixel - view.pixel).norm() < 0.1 ? 1 : 0;
    same_view += exact_view.inside == view.inside && exact_view.visible == view.visible ? 1 : 0;
  }
  EXPECT_GT(compared, 540);  // The rest lies within half a pixel of an edge.
  EXPECT_GT(same, compared * 99 / 100);
  EXPECT_GT(same_view, compared * 96 / 100);
}

TEST_F(SurfaceGroundTruthTest, a_point_behind_a_nearer_surface_is_hidden) {
  const SurfaceGroundTruthReader ground_truth = read_surface_ground_truth((folder_ / "mav0").string());
  const Eigen::Vector2d pixel(90, 40);
  const auto first = ground_truth.surface_at(0, pixel);
  ASSERT_TRUE(first);
  EXPECT_TRUE(ground_truth.view_of(0, first->point_in_world).visible);
  const RecordedView later = ground_truth.view_of(16, first->point_in_world);
  EXPECT_TRUE(later.inside);
  EXPECT_FALSE(later.visible) << "the press hides the upper half at frame 16";
  EXPECT_FALSE(ground_truth.view_of(0, ground_truth.poses()[0].world_from_body * Eigen::Vector3d(0, 0, -2)).inside);
}

TEST_F(SurfaceGroundTruthTest, the_recording_opens_like_any_other) {
  const std::unique_ptr<Source> source = open(folder_.string());
  EXPECT_EQ(source->info().format, "euroc");
  EXPECT_EQ(source->info().frame_count, 18);
  EXPECT_TRUE(source->info().warnings.empty()) << source->info().warnings.front();
  ASSERT_TRUE(source->info().cameras.at(0).camera);
  EXPECT_NEAR(source->info().cameras.at(0).camera->fx, world_->camera().fx, 1e-9);
  ASSERT_TRUE(source->info().cameras.at(0).body_from_camera);
  ASSERT_EQ(source->info().ground_truth.size(), 18U);
  const SE3 camera = source->info().ground_truth[7].world_from_body * *source->info().cameras[0].body_from_camera;
  EXPECT_LT((camera.inverse() * world_->world_from_camera(7)).log().norm(), 1e-6);
  TaskPool pool(1);
  const GrayImage first = world_->render(0, pool).gray;
  const auto frame = source->next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->stamp, world_->stamp(0));
  for (int y = 0; y < first.height(); ++y)
    ASSERT_EQ(0, std::memcmp(frame->image.row(y), first.row(y), static_cast<std::size_t>(first.width())));
}

TEST_F(SurfaceGroundTruthTest, outside_is_nothing) {
  const SurfaceGroundTruthReader ground_truth = read_surface_ground_truth(folder_.string());
  EXPECT_FALSE(ground_truth.surface_at(0, {-0.6, 5}));
  EXPECT_FALSE(ground_truth.surface_at(0, {5, 119.6}));
  EXPECT_FALSE(ground_truth.surface_at(0, {std::nan(""), 5}));
  EXPECT_FALSE(ground_truth.surface_at(-1, {5, 5}));
  EXPECT_FALSE(ground_truth.surface_at(18, {5, 5}));
  EXPECT_FALSE(ground_truth.view_of(18, {5, 0, 1}).inside);
}

TEST_F(SurfaceGroundTruthTest, names_the_file_that_is_missing) {
  EXPECT_THROW(read_surface_ground_truth("/no/such/folder"), Error);
  const fs::path broken = copy();
  const std::string name = std::to_string(world_->stamp(2)) + ".png";
  fs::remove(broken / "depth" / name);
  const SurfaceGroundTruthReader ground_truth = read_surface_ground_truth(broken.string());
  try {
    ground_truth.surface_at(2, {5, 5});
    FAIL() << "a missing image must be an error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

TEST_F(SurfaceGroundTruthTest, broken_text_is_an_error_or_read_but_never_a_crash) {
  const fs::path broken = copy();
  Random random(7);
  int refused = 0;
  for (const char* name : {"camera.csv", "camera.yaml"}) {
    const std::string whole = contents(broken / name);
    for (int i = 0; i < 150; ++i) {
      std::string text = whole;
      const auto at = [&] { return random.below(static_cast<std::uint32_t>(text.size())); };
      if (random.uniform() < 0.3) text.resize(at());
      for (int change = 0; change < 3 && !text.empty(); ++change) text[at()] = static_cast<char>(random.below(256));
      if (random.uniform() < 0.2 && !text.empty()) text.insert(at(), random.uniform() < 0.5 ? "nan" : ",-1e999,");
      write(broken / name, text);
      try {
        const SurfaceGroundTruthReader ground_truth = read_surface_ground_truth(broken.string());
        ground_truth.surface_at(0, {5, 5});
        ground_truth.view_of(1, {5, 0, 1});
      } catch (const Error& error) {
        ++refused;
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      }
    }
    write(broken / name, whole);
  }
  EXPECT_GT(refused, 30);
}

TEST_F(SurfaceGroundTruthTest, broken_images_are_errors) {
  const fs::path broken = copy();
  const std::string name = std::to_string(world_->stamp(0)) + ".png";
  const std::string whole = contents(broken / "depth" / name);
  for (const std::string& text :
       {std::string(), whole.substr(0, 100), whole.substr(0, whole.size() / 2), std::string("no image")}) {
    write(broken / "depth" / name, text);
    const SurfaceGroundTruthReader ground_truth = read_surface_ground_truth(broken.string());
    EXPECT_THROW(ground_truth.surface_at(0, {5, 5}), Error);
  }
}

}  // namespace
}  // namespace rastro
