// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "rastro/map/graph/map.h"
#include "rastro/sensor/frame.h"
#include "rastro/viewer/build_scene.h"
#include "rastro/viewer/live_messages.h"
#include "rastro/viewer/scene.h"
#include "rastro/viewer/seen_images.h"
#include "rastro/viewer/view_server.h"

namespace rastro {

/// An image of the run and the features found in it, as they are.
struct SeenImage {
  Frame frame;  ///< Gray or color image alone.
  LiveFeatures features;
};

/// A run that goes on, as a page shows it. The run hands over what it has and goes on at once: images are packed, and
/// scenes built, by threads of their own with less priority, the latest ones alone. Without a page that watches,
/// nothing is done. It changes nothing of the run: what the page shows depends on the clock, the run does not.
class LiveView {
 public:
  /// What to show of a map beside its scene, if anything. Called in a thread of its own, one map after the other.
  using PlaceOf = std::function<std::optional<LivePlace>(const Map&, const SeenImages&)>;

  LiveView(const ViewServerOptions& server, const LiveHello& run, const ViewSceneOptions& scene, PlaceOf place_of = {});
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  std::string url() const { return server_.url(); }
  bool is_watched() const { return server_.clients() > 0; }
  void show(const LiveFrame& frame) { server_.send(frame); }
  void say(const LiveStatus& status) { server_.send(status); }
  void show(const LiveCalibration& calibration) { server_.send(calibration); }
  /// Whether an image is due: ten a second at most, and none while the last one is being packed.
  bool wants_image() const;
  void show(SeenImage image);
  /// Whether a map is due: `milliseconds`, which the last one took to copy, are at most 2 % of the time, what it took
  /// to make a scene of it a tenth; one a second at most.
  bool wants_map(double milliseconds) const;
  void show(std::shared_ptr<const Map> map);
  /// The last map, shown in any case; returns at once.
  void finish(std::shared_ptr<const Map> map);
  /// The run began another map: the maps so far are shown no more, not even one whose scene is being built.
  void forget_map();
  /// A scene that needs no building: that of a run without a map.
  void show(const ViewScene& scene);
  std::optional<LiveCommand> next_command(std::chrono::milliseconds at_most) { return server_.next_command(at_most); }

 private:
  using Clock = std::chrono::steady_clock;
  /// What waits for a thread; the latest one alone.
  template <typename Item>
  struct Slot {
    std::optional<Item> next;
    bool busy = false;
    Clock::time_point last;  ///< When the last one was handed over.
    bool is_free() const { return !busy && !next; }
  };
  template <typename Item>
  void put(Slot<Item>& slot, Item item);
  /// Until the end: does `work` with each item of the slot.
  template <typename Item, typename Work>
  void serve(Slot<Item>& slot, Work work);
  void stop();
  void pack(const SeenImage& image);
  /// A map, and how many were forgotten before it was handed over.
  struct MapToBuild {
    std::shared_ptr<const Map> map;
    int forgotten = 0;
  };
  void build(const MapToBuild& of);

  std::string title_;
  ViewSceneOptions scene_options_;
  PlaceOf place_of_;
  SeenImages seen_;
  ViewServer server_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Slot<SeenImage> image_;
  Slot<MapToBuild> map_;
  int forgotten_ = 0;
  double scene_seconds_ = 0.0;  ///< That the last one took.
  std::atomic<bool> stopping_ = false;
  std::thread packer_, builder_;  // Apart, since a scene can take seconds.
};

}  // namespace rastro
