// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/kinect_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/math/se3.h"
#include "rastro/synthetic/renderer.h"

namespace rastro {
namespace {

constexpr int rows_per_task = 16;
constexpr std::uint64_t lattice_stream = 1, row_stream = 2, glass_stream = 3;

class KinectShot {
 public:
  KinectShot(const RenderedFrame& exact, const Renderer& renderer, const SE3& world_from_camera,
             const KinectModel& model, std::uint64_t noise_seed)
      : exact_(exact),
        renderer_(renderer),
        world_from_camera_(world_from_camera),
        rotation_(world_from_camera.rotation().matrix()),
        model_(model),
        seed_(noise_seed),
        focal_(static_cast<float>(renderer.camera().fx)),
        width_(exact.depth.width()),
        height_(exact.depth.height()) {}

  Image<std::uint16_t> measure(TaskPool& pool) {
    make_lattice();
    find_glass();
    Image<std::uint16_t> result(width_, height_);
    pool.for_chunks(0, height_, rows_per_task, [&](int begin, int end) {
      std::vector<char> in_shadow(static_cast<std::size_t>(width_));
      for (int y = begin; y < end; ++y) measure_row(y, in_shadow, result.row(y));
    });
    return result;
  }

 private:
  /// Standard normal to the precision of disparities (Irwin and Hall).
  static float quick_normal(std::uint64_t bits) {
    const auto sum =
        static_cast<std::int32_t>((bits & 0xFFFF) + ((bits >> 16) & 0xFFFF) + ((bits >> 32) & 0xFFFF) + (bits >> 48));
    return static_cast<float>(sum - 131070) * (1.0F / 37837.2F);
  }

  void make_lattice() {
    lattice_ = Image<float>(width_ / model_.patch_px + 2, height_ / model_.patch_px + 2);
    Random random(seed_for(seed_, lattice_stream));
    for (int y = 0; y < lattice_.height(); ++y)
      for (int x = 0; x < lattice_.width(); ++x) lattice_.at(x, y) = quick_normal(random.next());
  }

  float coarse_noise(int x, int y) const {
    const int column = x / model_.patch_px, row = y / model_.patch_px;
    const float u = static_cast<float>(x % model_.patch_px) / static_cast<float>(model_.patch_px);
    const float v = static_cast<float>(y % model_.patch_px) / static_cast<float>(model_.patch_px);
    const float* upper = lattice_.row(row) + column;
    const float* lower = lattice_.row(row + 1) + column;
    const float above = upper[0] + u * (upper[1] - upper[0]), below = lower[0] + u * (lower[1] - lower[0]);
    return above + v * (below - above);
  }

  void measure_row(int y, std::vector<char>& in_shadow, std::uint16_t* result) {
    Random random(seed_for(seed_for(seed_, row_stream), static_cast<std::uint64_t>(y)));
    const float* depth = exact_.depth.row(y);
    find_shadows(depth, in_shadow);
    for (int x = 0; x < width_; ++x) {
      const std::uint64_t bits = random.next();
      const bool edge = on_edge(x, y);
      // At an edge the matching takes the depth of either side equally often.
      const int seen_x = edge ? std::clamp(x + static_cast<int>((bits >> 32) % 3) - 1, 0, width_ - 1) : x;
      result[x] = 0;
      const float z = depth[seen_x];
      if (in_shadow[static_cast<std::size_t>(x)] != 0 || lost(x, y, z, edge, random.next())) continue;
      result[x] = raw(z, static_cast<float>(model_.fine_noise_px) * quick_normal(random.next()) +
                             static_cast<float>(model_.coarse_noise_px) * coarse_noise(x, y));
    }
  }

  /// The projector is to the right: in its view a row is ordered by x - d, in the camera's by x.
  void find_shadows(const float* depth, std::vector<char>& in_shadow) const {
    const float strength = focal_ * static_cast<float>(model_.baseline_m);
    float leftmost = std::numeric_limits<float>::infinity();
    for (int x = width_ - 1; x >= 0; --x) {
      const float projector_x = static_cast<float>(x) - (depth[x] > 0.0F ? strength / depth[x] : 0.0F);
      in_shadow[static_cast<std::size_t>(x)] = projector_x > leftmost + 0.5F ? 1 : 0;
      leftmost = std::min(leftmost, projector_x);
    }
  }

  bool on_edge(int x, int y) const {
    const float z = exact_.depth.at(x, y);
    const auto jumps = [&](int other_x, int other_y) {
      other_x = std::clamp(other_x, 0, width_ - 1), other_y = std::clamp(other_y, 0, height_ - 1);
      // On one face depth changes smoothly; only a step to another one is an edge.
      return exact_.surface.at(other_x, other_y) != exact_.surface.at(x, y) &&
             std::abs(exact_.depth.at(other_x, other_y) - z) > 0.03F * z;
    };
    return jumps(x - 1, y) || jumps(x + 1, y) || jumps(x, y - 1) || jumps(x, y + 1);
  }

  bool lost(int x, int y, float z, bool edge, std::uint64_t bits) const {
    if (!(z >= static_cast<float>(model_.nearest_m) && z <= static_cast<float>(model_.farthest_m))) return true;
    const std::uint32_t seen = exact_.surface.at(x, y);
    if (seen == no_surface) return true;  // z is that of a pixel beside it
    const float chance = static_cast<float>(bits >> 40) * 0x1.0p-24F;
    if (edge && chance < 0.4F) return true;
    // Whole patches are missing, not single pixels: the matching uses windows.
    const float patch = std::clamp(0.5F + 0.2F * coarse_noise(x, y) + 0.3F * (chance - 0.5F), 0.001F, 0.999F);
    const Surface& surface = renderer_.scene().surfaces()[seen];
    if (surface.material.infrared < 1.0F && patch > surface.material.infrared) return true;
    const float steep = steepness(x, y, z) / static_cast<float>(model_.steepest);
    if (steep > 1.0F && patch > 1.0F / (steep * steep)) return true;
    return !renderer_.scene().glass().empty() && lost_in_glass(x, y, z, chance);
  }

  /// Approximate tangent of the angle between the line of sight and the surface's normal.
  float steepness(int x, int y, float z) const {
    const auto slope = [&](int other_x, int other_y) {
      if (exact_.surface.at(other_x, other_y) != exact_.surface.at(x, y)) return 0.0F;
      return std::abs(exact_.depth.at(other_x, other_y) - z) * focal_ / z;
    };
    const float along_x = slope(x > 0 ? x - 1 : x + 1, y), along_y = slope(x, y > 0 ? y - 1 : y + 1);
    return std::sqrt(along_x * along_x + along_y * along_y);
  }

  /// Patches of 3 cm that change with the viewing direction.
  bool lost_in_glass(int x, int y, float z, float chance) const {
    if (!may_show_glass(x, y)) return false;
    const Eigen::Vector3d direction = rotation_ * renderer_.ray(x, y);
    for (const GlassSheet& sheet : renderer_.scene().glass()) {
      const double t = sheet.intersect(world_from_camera_.translation(), direction);
      if (!(t < static_cast<double>(z))) continue;
      const Eigen::Vector3d offset = world_from_camera_.translation() + t * direction - sheet.center;
      const auto cell = [](double meters, double size) {
        return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(meters / size)));
      };
      const std::uint64_t u = cell(offset.dot(sheet.right.normalized()), 0.03),
                          v = cell(offset.dot(sheet.down.normalized()), 0.03),
                          view = cell(direction.dot(sheet.right.normalized()), 0.2);
      const std::uint64_t item = u + 1000 * v + 1000000 * view;
      const double lost = Random(seed_for(seed_for(renderer_.scene().surfaces().size(), glass_stream), item)).uniform();
      if (lost + 0.25 * (static_cast<double>(chance) - 0.5) < model_.glass_lost) return true;
    }
    return false;
  }

  bool may_show_glass(int x, int y) const {
    return x >= glass_low_.x() && y >= glass_low_.y() && x <= glass_high_.x() && y <= glass_high_.y();
  }

  /// Bounds of all glass in the image; the whole image if a sheet reaches behind the camera.
  void find_glass() {
    const SE3 camera_from_world = world_from_camera_.inverse();
    for (const GlassSheet& sheet : renderer_.scene().glass())
      for (const double right : {-0.5, 0.5})
        for (const double down : {-0.5, 0.5}) {
          const Eigen::Vector3d corner = camera_from_world * (sheet.center + right * sheet.right + down * sheet.down);
          const auto pixel = renderer_.camera().project(corner);
          if (corner.z() < 0.05 || !pixel) {
            glass_low_ = {0, 0}, glass_high_ = {width_, height_};
            return;
          }
          glass_low_ = glass_low_.cwiseMin((*pixel - Eigen::Vector2d(1, 1)).cast<int>());
          glass_high_ = glass_high_.cwiseMax((*pixel + Eigen::Vector2d(1, 1)).cast<int>());
        }
  }

  std::uint16_t raw(float z, float disparity_noise) const {
    const float strength = focal_ * static_cast<float>(model_.baseline_m), step = static_cast<float>(model_.step_px);
    const float disparity = std::round((strength / z + disparity_noise) / step) * step;
    if (!(disparity > 0.0F)) return 0;
    const float meters = strength / disparity;
    if (meters < static_cast<float>(model_.nearest_m) || meters > static_cast<float>(model_.farthest_m)) return 0;
    return static_cast<std::uint16_t>(std::min(65535.0F, meters * static_cast<float>(model_.units_per_meter) + 0.5F));
  }

  const RenderedFrame& exact_;
  const Renderer& renderer_;
  const SE3& world_from_camera_;
  Eigen::Matrix3d rotation_;
  const KinectModel& model_;
  std::uint64_t seed_;
  float focal_;
  int width_, height_;
  Image<float> lattice_;
  Eigen::Vector2i glass_low_{1 << 20, 1 << 20}, glass_high_{-1, -1};
};

}  // namespace

Image<std::uint16_t> kinect_depth(const RenderedFrame& exact, const Renderer& renderer, const SE3& world_from_camera,
                                  const KinectModel& model, std::uint64_t noise_seed, TaskPool& pool) {
  return KinectShot(exact, renderer, world_from_camera, model, noise_seed).measure(pool);
}

}  // namespace rastro
