// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace rastro {

// What the viewer page shows of one run or map, as the plain arrays that scene_bytes() writes. Lengths are meters, or
// the map's own unit where its scale is arbitrary; the world is that of the map; camera axes: x right, y down, z ahead.
// Positions are x y z, orientations quaternions x y z w of world_from_camera, colors red green blue.

/// One entry per frame with a pose. An optional array is empty, or has an entry for each frame too; nan: unknown.
struct SceneFrames {
  std::vector<double> stamps_s;
  std::vector<float> positions, orientations;
  std::vector<float> online;         ///< Positions as first estimated.
  std::vector<std::uint8_t> states;  ///< Index into scene_state_names().
  std::vector<float> sigmas;         ///< Of the position as first estimated: root of the covariance's trace.
  std::vector<float> errors;         ///< Distance to the ground truth.
  std::vector<float> truth;          ///< Ground-truth positions, aligned with the map.
  std::vector<float> milliseconds;   ///< Time of the method.
};

/// "tracking", "weak", "lost", "relocalized", "initializing", "unknown".
const std::vector<std::string>& scene_state_names();

struct SceneEvent {
  static constexpr std::int64_t no_pose = -1;
  std::int64_t frame = no_pose;  ///< Row of the frames, or no_pose.
  double stamp_s = 0.0;
  std::string kind, detail;
};

/// One entry per keyframe; `rows` elsewhere are indices into these.
struct SceneKeyframes {
  std::vector<std::int32_t> ids;  ///< Number within its session.
  std::vector<double> stamps_s;
  std::vector<float> poses;  ///< Position and orientation: 7 numbers.
  std::vector<std::int32_t> sessions, submaps;
};

struct SceneCamera {
  int width = 0, height = 0;  ///< Pixels.
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;
};

struct SceneSession {
  int id = 0, robot = 0;
  std::string name;  ///< Of the recording, without its folder.
  double first_s = 0.0, last_s = 0.0;
};

struct SceneEdges {
  std::string name;
  std::vector<std::uint32_t> pairs;  ///< Two rows of keyframes each.
};

/// An octree of tiles of a layer whose points are too many to be sent at once. Each tile is an even sample of what its
/// cube holds, without the points of its parents; the page fetches those that it needs. Row 0 is the root, whose points
/// are the layer's own arrays.
struct SceneTiles {
  std::uint32_t layer = 0;            ///< Number among the tiled layers of the scene, as tiles are asked for.
  std::size_t count = 0;              ///< Points of all tiles.
  std::vector<float> cubes;           ///< Center, and half of the edge: 4 numbers a tile.
  std::vector<float> spacings;        ///< Distance of neighbors in the sample; 0: nothing finer lies below.
  std::vector<std::int32_t> parents;  ///< Rows; -1 of the root. A parent comes before its children.
  std::vector<std::uint32_t> counts;  ///< Points of each.
};

struct ScenePoints {
  std::string name;
  std::vector<float> positions;
  std::vector<std::uint8_t> colors;      ///< Or empty.
  std::vector<float> sigmas;             ///< Or empty; nan: unknown.
  std::vector<std::uint32_t> keyframes;  ///< Rows; or empty.
  std::optional<SceneTiles> tiles;       ///< The points are those of the root alone.
};

struct SceneMesh {
  std::string name;
  std::vector<float> positions;
  std::vector<std::uint8_t> colors;
  std::vector<std::uint32_t> triangles;  ///< Three indices of vertices each.
};

struct SceneCubes {
  std::string name;
  std::vector<float> centers, sizes;  ///< Sizes are edge lengths.
  std::vector<std::uint8_t> colors;   ///< Or empty.
};

struct SceneGrid {
  std::string name;
  int width = 0, height = 0;
  double cell = 0.0;                  ///< Edge length.
  std::array<double, 2> origin{};     ///< Of the corner with the smallest x and y.
  std::vector<std::uint8_t> cells{};  ///< Row by row from the smallest y: 0 free to 254 occupied, 255 unknown.
};

struct SceneEllipsoids {
  std::string name;
  std::vector<float> centers;
  std::vector<float> axes;  ///< Three semi-axes of one sigma each, 9 numbers.
};

using SceneLayer = std::variant<SceneEdges, ScenePoints, SceneMesh, SceneCubes, SceneGrid, SceneEllipsoids>;

/// Image of a keyframe, small.
struct SceneImage {
  std::uint32_t keyframe = 0;  ///< Row.
  int width = 0, height = 0;
  std::vector<std::uint8_t> jpeg;
};

/// A measured length with a name.
struct SceneLength {
  std::string name;
  std::array<double, 3> a{}, b{};  ///< Ends of the line that is drawn: as far apart as the length.
  double length = 0.0, sigma = 0.0;
};

struct ViewScene {
  std::string title, method;
  std::int64_t revision = 0;
  bool metric = false;
  double scale_sigma = 0.0;  ///< Relative; 0: unknown.
  std::string scale_origin;
  std::array<double, 3> up{0.0, -1.0, 0.0};  ///< Unit vector in the world.
  bool planar = false;                       ///< Of a planar method: seen from above first.
  std::vector<SceneSession> sessions;
  SceneFrames frames;
  std::vector<SceneEvent> events;
  SceneKeyframes keyframes;
  std::optional<SceneCamera> camera;
  std::vector<SceneLayer> layers;
  std::vector<SceneLength> lengths;
  std::vector<SceneImage> images;
};

/// A scene as the page reads it, and what it is listed as.
struct NamedScene {
  std::string name;
  std::string bytes;  ///< Of scene_bytes().
  /// Measures in the map of the scene as a page asks (the query of its request), and answers in JSON; empty where there
  /// is no map to measure in. Called by one thread at a time, beside which the server goes on; it is to end within
  /// seconds.
  std::function<std::string(std::string_view query)> measure = nullptr;
  /// Of a recording: the block of a frame by its number (frame_block()), read on request; empty where there is none.
  /// Throws Error for a frame that cannot be read. Called by one thread at a time.
  std::function<std::string(std::int64_t frame)> frame_block = nullptr;
  /// Of a scene with tiled layers: the block of a tile (PointTiles::block()); nullopt where there is no such one. Must
  /// be quick: the server waits for it.
  std::function<std::optional<std::string>(std::uint64_t layer, std::uint64_t tile)> tile_block = nullptr;
};

}  // namespace rastro
