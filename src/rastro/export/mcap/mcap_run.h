// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/base/time.h"
#include "rastro/camera/camera.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

/// What an MCAP file shows of one run or map. Any part may be empty. Lengths are in the unit of the map; the world is
/// that of the map; positions are x y z.
struct McapRun {
  enum class Level { info, warning, error };
  struct Note {
    TimeNs stamp = 0;
    Level level = Level::info;
    std::string kind, text;
  };
  struct Keyframe {
    std::string name;
    StampedPose pose;
  };
  struct Edges {
    std::string name;
    std::vector<std::array<std::uint32_t, 2>> pairs;  ///< Rows of keyframes.
  };
  struct Points {
    std::string name;  ///< Becomes the topic /NAME.
    std::vector<float> positions;
    std::vector<std::uint8_t> colors;  ///< Red green blue; or empty.
    std::vector<float> sigmas;         ///< Or empty; nan: unknown.
  };
  struct Grid {
    std::string name;  ///< Becomes the topic /NAME.
    int width = 0, height = 0;
    double cell = 0.0;                ///< Edge length.
    std::array<double, 2> origin{};   ///< Of the corner with the smallest x and y.
    std::vector<std::uint8_t> cells;  ///< Row by row from the smallest y: 0 free to 254 occupied, 255 unknown.
  };
  struct Ellipsoids {
    std::string name;
    std::vector<Eigen::Vector3d> centers;
    std::vector<Eigen::Matrix3d> covariances;  ///< Of the positions; shown at one sigma.
  };
  struct Image {
    TimeNs stamp = 0;
    std::function<std::string()> jpeg;  ///< Its bytes; called once, while the file is written.
  };

  std::map<std::string, std::string> facts;  ///< Name, method, unit: a metadata record "rastro".
  bool of_camera = true;                     ///< Poses are of the frame "camera" (z ahead), else of "body" (x ahead).
  Eigen::Vector3d up = -Eigen::Vector3d::UnitY();  ///< Unit vector in the world.
  Trajectory trajectory;                           ///< In the order of time, as all that has stamps.
  Trajectory online;                               ///< As first estimated.
  std::vector<Eigen::Vector3d> truth;              ///< Ground truth, aligned with the map.
  std::vector<Note> notes;
  std::vector<Keyframe> keyframes;
  std::vector<Edges> edges;
  std::vector<Points> points;
  std::vector<Grid> grids;
  std::vector<Ellipsoids> ellipsoids;
  std::optional<Camera> camera;  ///< Of the images.
  std::vector<Image> images;
};

/// A topic as written.
struct McapTopic {
  std::string topic;
  std::string schema;  ///< "foxglove.PoseInFrame".
  std::uint64_t messages = 0;
};

/// Writes an MCAP file with Foxglove's Protobuf schemas. What has a time is logged at it: poses (/pose), transforms
/// (/tf), notes (/log), images (/camera/image, /camera/calibration). What the whole run led to (/trajectory, points,
/// grids, /keyframes, /graph, /covariances) is logged at the first stamp of all, so that it is there at every time.
/// Returns the topics by name. Error for a stamp before 0, and where rastro was built without MCAP.
std::vector<McapTopic> put_mcap(const McapRun& run, const PutPiece& put);

/// The same of a run that goes on: what has a time is written as it comes, in chunks that a killed run keeps; readers
/// of such a file need no summary. Error as above, from the constructor and from what has the stamp.
class McapRecorder {
 public:
  /// Of `about` the facts, of_camera, up and camera count.
  McapRecorder(McapRun about, PutPiece put);
  ~McapRecorder();

  /// As first estimated.
  void add(const StampedPose& pose);
  void add(const McapRun::Note& note);
  void add_image(TimeNs stamp, const std::string& jpeg);
  /// What the whole run led to, at the last stamp; poses, notes and images of `run` are not written again. Nothing may
  /// be added afterwards.
  std::vector<McapTopic> finish(const McapRun& run);

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
