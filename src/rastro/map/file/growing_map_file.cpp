// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/growing_map_file.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/map/file/contents.h"
#include "rastro/map/file/file_pictures.h"
#include "rastro/map/file/landmark_keeper.h"
#include "rastro/map/file/save_map.h"

namespace rastro {
namespace {

constexpr auto commit_every = std::chrono::milliseconds(400);

bool same(const KeyframePose& a, const KeyframePose& b) {
  const SE3 &x = a.world_from_camera, &y = b.world_from_camera;
  return a.submap == b.submap && x.translation() == y.translation() &&
         x.rotation().quaternion().coeffs() == y.rotation().quaternion().coeffs();
}

}  // namespace

/// All of it but the way is guarded by the mutex of the pictures, which are read over the same connection: what is not
/// yet committed can only be seen there. Time decides when a row reaches the disk and nothing else.
class GrowingMapFile::State {
 public:
  explicit State(std::filesystem::path file) : file_(std::move(file)) {}

  ~State() {
    stop_committing();
    // A second failure has nobody to be told to; the first was.
    if (pictures_->database && !finished_ && !failure_) guarded([this] { commit(); });
  }

  void begin(const RgbdMap& map) {
    const std::lock_guard lock(pictures_->mutex);
    RASTRO_CHECK(!head_, "a map is begun once");
    head_ = head_body(map);
  }

  template <typename Work>
  void change(Work work) {
    const std::lock_guard lock(pictures_->mutex);
    RASTRO_CHECK(head_ && !finished_, "a map is begun and not finished when something is added");
    if (failure_) std::rethrow_exception(failure_);
    if (!pictures_->database) create();
    changed_ = true;
    work(*pictures_->database);
  }

  void add_keyframe(const RgbdKeyframe& keyframe, const KeyframePose& pose, const PackedPictures& pictures) {
    change([&](Database& database) {
      database.put(MapTable::keyframes, keyframe.id, body_of(keyframe));
      database.put(MapTable::pictures, keyframe.id, body_of(pictures));
      database.put(MapTable::poses, keyframe.id, body_of(pose));
      const auto count = static_cast<std::size_t>(keyframe.id) + 1;
      if (written_poses_.size() < count) written_poses_.resize(count);
      written_poses_[count - 1] = pose;
      if (poses_.size() < count) poses_.resize(count);
      poses_[count - 1] = pose;
    });
  }

  void add_edge(const PoseEdge& edge) {
    change([&](Database& database) { database.put(MapTable::edges, edges_++, body_of(edge)); });
  }

  void set_poses(const std::vector<KeyframePose>& poses) {
    change([&](Database&) {
      RASTRO_CHECK(poses.size() <= poses_.size(), "only keyframes that were added have poses");
      std::copy(poses.begin(), poses.end(), poses_.begin());
    });
  }

  void add_pose(const StampedPose& pose) {
    const std::lock_guard lock(way_mutex_);
    way_.push_back(pose);
  }

  void finish(const RgbdMap& map) {
    const std::filesystem::path aside = write_map_beside(map, file_);
    stop_committing();
    const std::lock_guard lock(pictures_->mutex);
    finished_ = true;
    if (pictures_->database) {
      commit();
      pictures_->database->run("COMMIT");
      // Closed before it is replaced: its log must not stay beside a file that it does not belong to.
      pictures_->database.reset();
    }
    replace_file(aside, file_);
    pictures_->database.emplace(Database::open(file_));
  }

  std::shared_ptr<const PictureStore> pictures() const { return pictures_; }

 private:
  void create() {
    Database& database = pictures_->database.emplace(Database::create(file_));
    // The log is added to at its end and takes what is killed in its middle; 16 MB of it are kept before they are
    // moved.
    database.run("PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL; PRAGMA wal_autocheckpoint=4000; BEGIN");
    database.put(MapTable::head, 0, *head_);
    database.put(MapTable::contents, second_head_row, *head_);
    committer_ = std::thread([this] { commit_now_and_then(); });
  }

  void commit() {
    Database& database = *pictures_->database;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (same(poses_[i], written_poses_[i])) continue;
      database.put(MapTable::poses, static_cast<std::int64_t>(i), body_of(poses_[i]));
      written_poses_[i] = poses_[i];
    }
    for (const StampedPose& pose : take_way()) database.put(MapTable::way, ways_written_++, body_of(pose));
    database.run("COMMIT; BEGIN");
    changed_ = false;
  }

  Trajectory take_way() {
    const std::lock_guard lock(way_mutex_);
    return std::exchange(way_, {});
  }

  bool has_way() {
    const std::lock_guard lock(way_mutex_);
    return !way_.empty();
  }

  template <typename Work>
  void guarded(Work work) {
    try {
      work();
    } catch (...) {
      failure_ = std::current_exception();
    }
  }

  void commit_now_and_then() {
    std::unique_lock lock(pictures_->mutex);
    while (!stopping_) {
      wake_.wait_for(lock, commit_every, [this] { return stopping_; });
      if ((changed_ || has_way()) && !failure_) guarded([this] { commit(); });
    }
  }

  void stop_committing() {
    {
      const std::lock_guard lock(pictures_->mutex);
      stopping_ = true;
    }
    wake_.notify_all();
    if (committer_.joinable()) committer_.join();
  }

  const std::filesystem::path file_;
  const std::shared_ptr<FilePictures> pictures_ = std::make_shared<FilePictures>();
  std::vector<KeyframePose> poses_, written_poses_;
  std::mutex way_mutex_;  ///< Its own: who follows the camera does not wait for the disk.
  Trajectory way_;        ///< Not yet written.
  std::optional<std::string> head_;
  std::int64_t edges_ = 0, ways_written_ = 0;
  bool changed_ = false, stopping_ = false, finished_ = false;
  std::exception_ptr failure_;
  std::condition_variable wake_;
  std::thread committer_;
};

GrowingMapFile::GrowingMapFile(std::filesystem::path file)
    : state_(std::make_unique<State>(file)), landmarks_(std::make_unique<LandmarkKeeper>(file)) {}
GrowingMapFile::~GrowingMapFile() = default;
void GrowingMapFile::begin(const RgbdMap& map) { state_->begin(map); }
void GrowingMapFile::add_keyframe(const RgbdKeyframe& keyframe, const KeyframePose& pose, PackedPictures pictures) {
  state_->add_keyframe(keyframe, pose, pictures);
}
void GrowingMapFile::add_edge(const PoseEdge& edge) { state_->add_edge(edge); }
void GrowingMapFile::set_poses(const std::vector<KeyframePose>& poses) { state_->set_poses(poses); }
void GrowingMapFile::add_pose(const StampedPose& world_from_camera) { state_->add_pose(world_from_camera); }
std::shared_ptr<const PictureStore> GrowingMapFile::pictures() const { return state_->pictures(); }
void GrowingMapFile::keep(std::shared_ptr<const LandmarkMap> map) { landmarks_->keep(std::move(map)); }
bool GrowingMapFile::wants_map() const { return landmarks_->wants_map(); }
void GrowingMapFile::finish(const RgbdMap& map) { state_->finish(map); }
void GrowingMapFile::finish(const LandmarkMap& map) { landmarks_->finish(map); }

}  // namespace rastro
