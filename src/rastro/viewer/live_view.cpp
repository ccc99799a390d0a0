// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/live_view.h"

#include <algorithm>
#include <exception>
#include <system_error>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/task_pool.h"
#include "rastro/viewer/scene_writer.h"
#include "rastro/viewer/small_image.h"
#include "rastro/viewer/thread_priority.h"

namespace rastro {
LiveView::LiveView(const ViewServerOptions& server, const LiveHello& run, const ViewSceneOptions& scene,
                   PlaceOf place_of)
    : title_(run.title), scene_options_(scene), place_of_(std::move(place_of)), server_(run, server) {
  builder_ = std::thread([this] { serve(map_, [this](const MapToBuild& of) { build(of); }); });
  try {
    packer_ = std::thread([this] { serve(image_, [this](const SeenImage& image) { pack(image); }); });
  } catch (const std::system_error&) {
    stop();
    throw;
  }
}

LiveView::~LiveView() { stop(); }

void LiveView::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  for (std::thread* thread : {&packer_, &builder_})
    if (thread->joinable()) thread->join();
}

bool LiveView::wants_image() const {
  constexpr auto least = std::chrono::milliseconds(100);
  if (!is_watched()) return false;
  const std::lock_guard lock(mutex_);
  return image_.is_free() && Clock::now() - image_.last >= least;
}

bool LiveView::wants_map(double milliseconds) const {
  constexpr double least_seconds = 1.0, most_share = 0.02, most_share_of_thread = 0.05;
  if (!is_watched()) return false;
  const std::lock_guard lock(mutex_);
  const std::chrono::duration<double> since = Clock::now() - map_.last;
  const double least =
      std::max({least_seconds, 1e-3 * milliseconds / most_share, scene_seconds_ / most_share_of_thread});
  return map_.is_free() && since.count() >= least;
}

void LiveView::show(SeenImage image) { put(image_, std::move(image)); }
void LiveView::show(std::shared_ptr<const Map> map) { put(map_, {std::move(map), forgotten_}); }

template <typename Item>
void LiveView::put(Slot<Item>& slot, Item item) {
  {
    const std::lock_guard lock(mutex_);
    slot.next = std::move(item);
    slot.last = Clock::now();
  }
  changed_.notify_all();
}

template <typename Item, typename Work>
void LiveView::serve(Slot<Item>& slot, Work work) {
  detail::lower_priority_of_this_thread();
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return stopping_ || slot.next; });
    if (stopping_) return;
    const Item item = *std::exchange(slot.next, std::nullopt);
    slot.busy = true;
    lock.unlock();
    try {
      work(item);
    } catch (const std::exception&) {  // no memory, say: the run goes on, and the next one may be shown
    }
    lock.lock();
    slot.busy = false;
    changed_.notify_all();
  }
}

void LiveView::pack(const SeenImage& image) {
  const Frame& frame = image.frame;
  LiveImage live;
  live.index = frame.index;
  live.width = frame.color.empty() ? frame.image.width() : frame.color.width();
  live.height = frame.color.empty() ? frame.image.height() : frame.color.height();
  constexpr int longest_side_px = 480;
  live.jpeg = detail::small_image(frame, longest_side_px).jpeg;
  live.features = image.features;
  server_.send(live);
  seen_.add(frame.stamp, std::move(live));
}

void LiveView::build(const MapToBuild& of) {
  const Map& map = *of.map;
  const auto begin = Clock::now();
  TaskPool pool(1);
  ViewScene scene = build_scene(map, scene_options_, pool, [this](std::size_t, std::size_t) {
    if (stopping_) throw Error("is not shown any more", title_, "");
  });
  scene.title = title_;
  NamedScene named{title_, scene_bytes(scene)};
  {
    const std::lock_guard lock(mutex_);
    if (of.forgotten != forgotten_) return;
    server_.set_scene(std::move(named), map.revision);
  }
  if (place_of_)
    if (const auto place = place_of_(map, seen_)) server_.send(*place);
  const std::lock_guard lock(mutex_);
  scene_seconds_ = std::chrono::duration<double>(Clock::now() - begin).count();
}

void LiveView::finish(std::shared_ptr<const Map> map) { show(std::move(map)); }

void LiveView::forget_map() {
  const std::lock_guard lock(mutex_);
  map_.next.reset();
  ++forgotten_;
  server_.forget_scene(title_);
}

void LiveView::show(const ViewScene& scene) { server_.set_scene({title_, scene_bytes(scene)}, scene.revision); }

}  // namespace rastro
