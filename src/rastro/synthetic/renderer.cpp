// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/renderer.h"

#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/synthetic/intersect.h"
#include "rastro/synthetic/tiles.h"

namespace rastro {
namespace {

constexpr int tile_px = 16;
constexpr int tiles_per_block = 4;  // Blocks of tiles are culled first, so that a tile tests few solids.

struct PixelHit {
  double depth = 0.0;
  std::uint32_t surface = no_surface;
};

/// One image being rendered.
class Shot {
 public:
  enum class Want { depth, gray, color };

  Shot(const Scene& scene, const Renderer& renderer, const SE3& world_from_camera, Want want, double time_s)
      : scene_(scene),
        renderer_(renderer),
        rotation_(world_from_camera.rotation().matrix()),
        center_(world_from_camera.translation()),
        step_x_(rotation_.col(0) / renderer.camera().fx),
        step_y_(rotation_.col(1) / renderer.camera().fy),
        viewed_(view_primitives(scene, world_from_camera)),
        columns_((renderer.camera().width + tile_px - 1) / tile_px),
        rows_((renderer.camera().height + tile_px - 1) / tile_px),
        lists_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)),
        want_(want),
        time_s_(time_s),
        light(light_width(renderer.camera().width, want), renderer.camera().height) {
    frame.depth = DepthImage(renderer.camera().width, renderer.camera().height);
    frame.surface = Image<std::uint32_t>(renderer.camera().width, renderer.camera().height);
  }

  void cast(TaskPool& pool) {
    pool.for_chunks(0, (rows_ + tiles_per_block - 1) / tiles_per_block, 1, [&](int begin, int end) {
      for (int block_row = begin; block_row < end; ++block_row) cast_block_row(block_row);
    });
  }

  /// Averages several rays in pixels with more than one surface.
  void smooth_edges(TaskPool& pool) {
    pool.for_chunks(0, light.height(), tile_px, [&](int begin, int end) {
      for (int y = begin; y < end; ++y)
        for (int x = 0; x < frame.depth.width(); ++x) {
          if (!on_edge(x, y)) continue;
          if (want_ == Want::color)
            smooth(channels(x, y), x, y, [&](const PixelHit& hit, const Vector3d& ray) { return color(hit, ray); });
          else
            smooth(light.at(x, y), x, y, [&](const PixelHit& hit, const Vector3d& ray) { return shade(hit, ray); });
        }
    });
  }

 private:
  using Channels = Eigen::Array4f;
  using Vector3d = Eigen::Vector3d;

  static int light_width(int width, Want want) {
    return want == Want::depth ? 0 : want == Want::color ? 4 * width : width;
  }
  Eigen::Map<Channels, Eigen::Aligned16> channels(int x, int y) {
    return Eigen::Map<Channels, Eigen::Aligned16>(light.row(y) + 4 * x);
  }

  void cast_block_row(int block_row) {
    std::vector<const ViewedPrimitive*> all;
    for (const ViewedPrimitive& viewed : viewed_) all.push_back(&viewed);
    const int first_row = block_row * tiles_per_block, end_row = std::min(rows_, first_row + tiles_per_block);
    for (int first = 0; first < columns_; first += tiles_per_block) {
      const int end = std::min(columns_, first + tiles_per_block);
      const auto candidates = seen_in(window_of(first, first_row, end, end_row), all);
      for (int row = first_row; row < end_row; ++row)
        for (int column = first; column < end; ++column) {
          auto& list = lists_[static_cast<std::size_t>(row * columns_ + column)];
          list = seen_in(window_of(column, row, column + 1, row + 1), candidates);
          cast_tile(column, row, list);
        }
    }
  }

  /// Bounds of the rays of a range of tiles, with a margin of half a pixel and more for the rays of smooth_edges().
  ViewWindow window_of(int column, int row, int end_column, int end_row) const {
    const Camera& camera = renderer_.camera();
    const int x0 = column * tile_px, x1 = std::min(camera.width, end_column * tile_px) - 1;
    const int y0 = row * tile_px, y1 = std::min(camera.height, end_row * tile_px) - 1;
    ViewWindow window{1e9, 1e9, -1e9, -1e9};
    const auto include = [&](int x, int y) {
      const Eigen::Vector3d ray = renderer_.ray(x, y);
      window = {std::min(window.x0, ray.x()), std::min(window.y0, ray.y()), std::max(window.x1, ray.x()),
                std::max(window.y1, ray.y())};
    };
    // Rays bend smoothly, so the extremes lie on the border.
    for (int x = x0; x <= x1; ++x) include(x, y0), include(x, y1);
    for (int y = y0; y <= y1; ++y) include(x0, y), include(x1, y);
    const double margin_x = 1.5 / camera.fx, margin_y = 1.5 / camera.fy;
    return {window.x0 - margin_x, window.y0 - margin_y, window.x1 + margin_x, window.y1 + margin_y};
  }

  void cast_tile(int column, int row, const std::vector<const ViewedPrimitive*>& list) {
    const int x_end = std::min(frame.depth.width(), (column + 1) * tile_px),
              y_end = std::min(frame.depth.height(), (row + 1) * tile_px);
    for (int y = row * tile_px; y < y_end; ++y)
      for (int x = column * tile_px; x < x_end; ++x) {
        const Eigen::Vector3d direction = rotation_ * renderer_.ray(x, y);
        const PixelHit hit = nearest(list, direction);
        frame.depth.at(x, y) = static_cast<float>(hit.depth);
        frame.surface.at(x, y) = hit.surface;
        if (want_ == Want::gray) light.at(x, y) = shade(hit, direction);
        if (want_ == Want::color) channels(x, y) = color(hit, direction);
      }
  }

  static PixelHit nearest(const std::vector<const ViewedPrimitive*>& list, const Eigen::Vector3d& direction) {
    Intersection best;
    const Primitive* met = nullptr;
    const Eigen::Vector3d inverse = detail::inverse_of(direction);
    for (const ViewedPrimitive* viewed : list) {
      if (viewed->nearest_depth > best.t) break;
      const Intersection meeting = intersect(*viewed->primitive, viewed->origin_in_local, direction, inverse);
      if (meeting.t >= best.t) continue;
      best = meeting;
      met = viewed->primitive;
    }
    if (met == nullptr) return {};
    return {best.t, met->first_surface + static_cast<std::uint32_t>(best.face)};
  }

  /// Texture coordinates of a ray, and the footprint of a pixel: in texels.
  struct Footprint {
    float x, y, dx_dx, dy_dx, dx_dy, dy_dy;
    float light;  ///< Of the light field at the point.
  };

  float shade(const PixelHit& hit, const Eigen::Vector3d& direction) const {
    if (hit.surface == no_surface) return 0.0F;
    return sample(scene_.surfaces()[hit.surface].texture, footprint(hit, direction, center_));
  }

  static float sample(const Texture& texture, const Footprint& at) {
    return at.light * texture.sample(at.x, at.y, at.dx_dx, at.dy_dx, at.dx_dy, at.dy_dy);
  }

  Footprint footprint(const PixelHit& hit, const Eigen::Vector3d& direction, const Eigen::Vector3d& origin) const {
    const FacePoint point = scene_.face_point(hit.surface, origin + hit.depth * direction);
    const Surface& surface = scene_.surfaces()[hit.surface];
    const double facing = point.normal.dot(direction);
    const double safe = std::abs(facing) < 1e-4 ? 1e-4 : facing;
    const double along_u = point.along_u.dot(direction) / safe, along_v = point.along_v.dot(direction) / safe;
    const double normal_x = point.normal.dot(step_x_), normal_y = point.normal.dot(step_y_);
    const double scale_x = hit.depth * surface.texels_x, scale_y = hit.depth * surface.texels_y;
    const auto du_dx = static_cast<float>(scale_x * (point.along_u.dot(step_x_) - along_u * normal_x));
    const auto dv_dx = static_cast<float>(scale_y * (point.along_v.dot(step_x_) - along_v * normal_x));
    const auto du_dy = static_cast<float>(scale_x * (point.along_u.dot(step_y_) - along_u * normal_y));
    const auto dv_dy = static_cast<float>(scale_y * (point.along_v.dot(step_y_) - along_v * normal_y));
    return {static_cast<float>(point.u * surface.texels_x),
            static_cast<float>(point.v * surface.texels_y),
            du_dx,
            dv_dx,
            du_dy,
            dv_dy,
            light_at(origin + hit.depth * direction, facing > 0.0 ? Vector3d(-point.normal) : point.normal)};
  }

  float light_at(const Vector3d& point, const Vector3d& normal) const {
    return renderer_.light() ? renderer_.light()(point, normal, time_s_) : 1.0F;
  }

  /// Through glass in front of the surface.
  Channels color(const PixelHit& hit, const Eigen::Vector3d& direction) const {
    Channels result = opaque_color(hit, direction, center_);
    for (const GlassSheet& sheet : scene_.glass()) {
      const double glass = sheet.intersect(center_, direction);
      if (hit.surface == no_surface || glass < hit.depth) result = behind_glass(sheet, glass, direction, result);
    }
    return result;
  }

  Channels opaque_color(const PixelHit& hit, const Eigen::Vector3d& direction, const Eigen::Vector3d& origin) const {
    if (hit.surface == no_surface) return Channels::Zero();
    const Surface& surface = scene_.surfaces()[hit.surface];
    const Footprint at = footprint(hit, direction, origin);
    if (surface.colors.empty()) return sample(surface.texture, at) * Channels(1.0F, 1.0F, 1.0F, 0.0F);
    return at.light * surface.colors.sample(at.x, at.y, at.dx_dx, at.dy_dx, at.dx_dy, at.dy_dy);
  }

  /// A pane absorbs a tenth of the light, more of its red, and reflects more at grazing angles (Schlick 1994).
  Channels behind_glass(const GlassSheet& sheet, double t, const Eigen::Vector3d& direction,
                        const Channels& behind) const {
    const Eigen::Vector3d normal = sheet.right.cross(sheet.down).normalized();
    const double slope = std::abs(normal.dot(direction)) / direction.norm();
    const auto mirrored = static_cast<float>(0.08 + 0.92 * std::pow(1.0 - slope, 5.0));
    const Eigen::Vector3d origin = center_ + t * direction, away = direction - 2.0 * normal.dot(direction) * normal;
    const std::optional<RayHit> hit = scene_.trace(origin, away);
    const Channels reflection = hit ? opaque_color({hit->t, hit->surface}, away, origin) : Channels(Channels::Zero());
    return (1.0F - mirrored) * behind * Channels(0.86F, 0.93F, 0.90F, 0.0F) + mirrored * reflection;
  }

  bool on_edge(int x, int y) const {
    const std::uint32_t here = frame.surface.at(x, y);
    return (x > 0 && frame.surface.at(x - 1, y) != here) ||
           (x + 1 < frame.surface.width() && frame.surface.at(x + 1, y) != here) ||
           (y > 0 && frame.surface.at(x, y - 1) != here) ||
           (y + 1 < frame.surface.height() && frame.surface.at(x, y + 1) != here);
  }

  /// `value` is that of the pixel's center, which becomes the mean.
  template <typename Value, typename Shader>
  void smooth(Value&& value, int x, int y, Shader&& shader) const {
    // A rotated square: four different offsets along x and along y resolve edges near both directions best.
    constexpr double offsets[4][2] = {{-0.125, -0.375}, {0.375, -0.125}, {0.125, 0.375}, {-0.375, 0.125}};
    const auto& list = lists_[static_cast<std::size_t>((y / tile_px) * columns_ + x / tile_px)];
    const Eigen::Vector3d middle = rotation_ * renderer_.ray(x, y);
    std::decay_t<decltype(shader(PixelHit(), middle))> sum = value;
    for (const auto& offset : offsets) {
      const Eigen::Vector3d direction = middle + offset[0] * step_x_ + offset[1] * step_y_;
      sum += shader(nearest(list, direction), direction);
    }
    value = sum / 5.0F;
  }

  const Scene& scene_;
  const Renderer& renderer_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d center_, step_x_, step_y_;
  std::vector<ViewedPrimitive> viewed_;
  int columns_, rows_;
  std::vector<std::vector<const ViewedPrimitive*>> lists_;
  Want want_;
  double time_s_;

 public:
  Image<float> light;
  RenderedFrame frame;
};

}  // namespace

Renderer::Renderer(const Scene& scene, const Camera& camera, LightField light)
    : scene_(&scene), camera_(camera), light_(std::move(light)) {
  if (camera.width < 2 || camera.height < 2)
    throw Error("the camera has no image size", "renderer", "give a width and height of at least 2");
  rays_.reserve(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const std::optional<Eigen::Vector2d> ray = camera.unproject({x, y});
      if (!ray)
        throw Error("the lens distortion cannot be inverted in the whole image", "renderer",
                    "use weaker distortion coefficients");
      rays_.push_back(*ray);
    }
}

RenderedFrame Renderer::render(const SE3& world_from_camera, const SensorModel& sensor, const ShutterMotion& shutter,
                               std::uint64_t noise_seed, TaskPool& pool, double time_s, bool in_color) const {
  const std::optional<Scene> moved = scene_->moves() ? std::optional(scene_->at(time_s)) : std::nullopt;
  Shot shot(moved ? *moved : *scene_, *this, world_from_camera, in_color ? Shot::Want::color : Shot::Want::gray,
            time_s);
  shot.cast(pool);
  shot.smooth_edges(pool);
  if (in_color) {
    shot.frame.color = expose_color(shot.light, shot.frame.depth, camera_, sensor, shutter, noise_seed, pool);
    shot.frame.gray = gray_from_color(shot.frame.color);
  } else {
    shot.frame.gray = expose(shot.light, shot.frame.depth, camera_, sensor, shutter, noise_seed, pool);
  }
  return std::move(shot.frame);
}

RenderedFrame Renderer::cast(const SE3& world_from_camera, TaskPool& pool, double time_s) const {
  const std::optional<Scene> moved = scene_->moves() ? std::optional(scene_->at(time_s)) : std::nullopt;
  Shot shot(moved ? *moved : *scene_, *this, world_from_camera, Shot::Want::depth, time_s);
  shot.cast(pool);
  return std::move(shot.frame);
}

}  // namespace rastro
