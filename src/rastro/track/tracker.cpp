// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/tracker.h"

#include <algorithm>
#include <cmath>

#include "rastro/base/checked_options.h"
#include "rastro/base/random.h"
#include "rastro/base/stopwatch.h"
#include "rastro/feature/corner.h"
#include "rastro/feature/distance_grid.h"
#include "rastro/image/box_sum.h"
#include "rastro/image/equalize.h"
#include "rastro/image/pyramid.h"
#include "rastro/multiview/fundamental.h"
#include "rastro/track/free_area.h"
#include "rastro/track/klt.h"
#include "rastro/track/motion_history.h"
#include "rastro/track/reappearance.h"
#include "rastro/track/recognition.h"
#include "rastro/track/track_store.h"
#include "rastro/track/undistorted_camera.h"

namespace rastro {
namespace {

// Radius of the disc whose intensity centroid steers a descriptor (ORB 2011 uses 15 for patches of 31).
constexpr int orientation_radius = 15;
constexpr double blank_deviation = 3.0;
constexpr int descriptors_per_chunk = 32;

/// A feature of the current frame, before it is reported.
struct Live {
  std::size_t track = 0;
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
  Eigen::Vector2f ideal = Eigen::Vector2f::Zero();
  TrackState state = TrackState::tracked;
};

TrackOptions checked(const TrackOptions& options) {
  checked(options, "tracker options");
  if (options.flow_window_px % 2 == 0) throw Error("must be odd", "flow_window_px", "use the next odd number");
  if (options.brief_smoothing_px % 2 == 0) throw Error("must be odd", "brief_smoothing_px", "use the next odd number");
  return options;
}

KltOptions klt_options(const TrackOptions& options) {
  KltOptions klt;
  klt.window_px = options.flow_window_px;
  klt.iterations = options.flow_iterations;
  klt.epsilon_px = options.flow_epsilon_px;
  klt.coarse_epsilon_px = options.flow_coarse_epsilon_px;
  klt.max_backward_px = options.max_backward_px;
  klt.max_residual_ratio = options.max_residual_ratio;
  klt.min_eigenvalue = options.min_texture;
  return klt;
}

}  // namespace

class Tracker::State {
 public:
  State(const TrackOptions& options, std::optional<Camera> camera, TaskPool* pool)
      : options_(checked(options)),
        camera_(camera),
        pool_(pool),
        store_(options.window),
        history_(options_),
        brief_(options.brief_patch_px, options.seed) {}

  TrackFrame process(GrayView image, TimeNs stamp, GrayView mask);

 private:
  void begin_frame(GrayView image, GrayView mask);
  void follow(TrackFrame& frame, GrayView mask);
  void drop_outliers(TrackFrame& frame);
  bool foresees() const { return options_.mode != "klt" && options_.predict; }
  void drop_changed();
  void reappear(TrackFrame& frame, GrayView mask);
  void remove_live(const std::vector<char>& marked, TrackFrame& frame);
  bool may_be_at(const Eigen::Vector2f& pixel, GrayView mask) const;
  DescribeRotated describe_rotated() const;
  std::vector<Association> associations() const;
  std::vector<Eigen::Vector2f> detect(const TrackFrame& frame, GrayView mask);
  std::vector<Descriptor> describe(const Eigen::Vector2f& pixel, bool all_scales) const;
  void describe_tracked();
  bool verifies_corners(const TrackFrame& frame) const;
  bool near_a_loss(const Eigen::Vector2f& pixel) const;
  bool can_be_followed_back(const Eigen::Vector2f& pixel) const;
  void observe(const Live& feature, const Descriptor& descriptor);
  int most_displaced() const;
  void make_room(std::vector<Recognized>& recognized, TrackFrame& frame);
  void adopt(const std::vector<Eigen::Vector2f>& corners, TrackFrame& frame);
  void report(TrackFrame& frame) const;

  TrackOptions options_;
  UndistortedCamera camera_;
  TaskPool* pool_;
  TrackStore store_;
  MotionHistory history_;
  Brief brief_;
  CornerDetector detector_;
  FreeArea free_;
  Pyramid previous_, current_;
  Image<std::uint16_t> sums_;
  Brightness brightness_;
  std::int64_t index_ = -1;
  std::vector<Live> live_;    ///< Features of the current frame.
  std::vector<Live> before_;  ///< Those of the previous frame, in the order of `live_` before any was dropped.
};

TrackFrame Tracker::State::process(GrayView image, TimeNs stamp, GrayView mask) {
  Stopwatch whole, stage;
  TrackFrame frame;
  begin_frame(image, mask);
  frame.index = index_;
  frame.stamp = stamp;
  frame.times.pyramid_ms = stage.lap_ms();
  follow(frame, mask);
  frame.times.flow_ms = stage.lap_ms();
  drop_outliers(frame);
  frame.times.outlier_ms = stage.lap_ms();
  reappear(frame, mask);
  frame.times.predict_ms = stage.lap_ms();
  const std::vector<Eigen::Vector2f> corners = detect(frame, mask);
  frame.times.detect_ms = stage.lap_ms();
  describe_tracked();
  frame.times.describe_ms = stage.lap_ms();
  adopt(corners, frame);
  report(frame);
  frame.times.total_ms = whole.lap_ms();
  return frame;
}

void Tracker::State::begin_frame(GrayView image, GrayView mask) {
  if (image.empty()) throw Error("the image is empty", "tracker", "give an image with pixels");
  if (index_ >= 0 && (image.width != current_.level(0).width() || image.height != current_.level(0).height())) {
    throw Error("the image's size differs from that of the previous frames", "tracker",
                "start a new tracker for another size");
  }
  if (!mask.empty() && (mask.width != image.width || mask.height != image.height)) {
    throw Error("the mask's size differs from the image's", "tracker", "give a mask as large as the image");
  }
  ++index_;
  std::swap(previous_, current_);
  brightness_ = brightness(image);
  if (options_.equalize) {
    current_.build(equalized(image), options_.flow_levels, klt_padding, pool_);
  } else {
    current_.build(image, options_.flow_levels, klt_padding, pool_);
  }
  if (options_.mode != "klt") box_sums(current_.level(0), options_.brief_smoothing_px / 2, sums_);
}

void Tracker::State::follow(TrackFrame& frame, GrayView mask) {
  before_ = std::move(live_);
  live_.clear();
  std::vector<Eigen::Vector2f> points;
  for (const Live& feature : before_) points.push_back(feature.pixel);
  std::vector<KltResult> results(points.size());
  if (!points.empty()) klt_follow(previous_, current_, points, points, klt_options(options_), pool_, results);
  for (std::size_t i = 0; i < before_.size(); ++i) {
    const Eigen::Vector2f& pixel = results[i].pixel;
    if (!results[i].followed) continue;
    if (!mask.empty() &&
        mask.at(static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))) == 0) {
      ++frame.masked;
      continue;
    }
    live_.push_back({before_[i].track, pixel, camera_.from_pixel(pixel), TrackState::tracked});
  }
}

void Tracker::State::drop_outliers(TrackFrame& frame) {
  PointPairs pairs;
  for (const Live& feature : live_) {
    pairs.add(store_[feature.track].undistorted_in(index_ - 1), feature.ideal);
  }
  const RansacOptions ransac{options_.max_epipolar_error_px, 0.99, options_.ransac_iterations,
                             seed_for(options_.seed, static_cast<std::uint64_t>(index_))};
  // Fewer than this fit nearly any epipolar geometry, so it could not reveal an outlier.
  constexpr std::size_t fewest = 15;
  const auto fit = pairs.size() >= fewest ? estimate_fundamental(pairs, ransac) : std::nullopt;
  std::vector<Live> kept;
  const float limit = static_cast<float>(options_.max_epipolar_error_px * options_.max_epipolar_error_px);
  for (std::size_t i = 0; i < live_.size(); ++i) {
    if (!fit || fit->squared_errors[i] <= limit) kept.push_back(live_[i]);
  }
  live_ = std::move(kept);
  drop_changed();
  // Both lists have the same order, so what is missing from the second is lost.
  auto next = live_.begin();
  for (const Live& feature : before_) {
    if (next != live_.end() && next->track == feature.track) {
      ++next;
    } else {
      store_.mark_lost(feature.track);
    }
  }
  store_.forget_old(index_);
  frame.tracked = static_cast<int>(live_.size());
  frame.lost = static_cast<int>(before_.size()) - frame.tracked;
}

/// Drops features whose patch no longer matches that of some frames ago, rotated and scaled by the image motion since;
/// a patch that cannot be compared passes.
void Tracker::State::drop_changed() {
  const std::vector<Association> followed = associations();
  if (foresees()) history_.advance(index_, followed, store_);
  if (options_.max_reference_residual <= 0.0) return;
  std::erase_if(live_, [&](const Live& feature) {
    const Track& track = store_[feature.track];
    if (track.reference_patch().empty()) return false;
    Eigen::Matrix2f warp = Eigen::Matrix2f::Identity();
    if (foresees()) {
      const auto known = history_.rotated_since(track.patch_frame(), std::max(0, track.layer), track, followed, store_);
      if (known) warp = *known;
    }
    return track.reference_patch().residual_ratio(current_, feature.pixel, warp) > options_.max_reference_residual;
  });
}

std::vector<Association> Tracker::State::associations() const {
  std::vector<Association> associations;
  for (const Live& feature : live_) associations.push_back({feature.track, feature.pixel, feature.ideal});
  return associations;
}

/// Guided search: lost features that reappear at their predicted positions.
void Tracker::State::reappear(TrackFrame& frame, GrayView mask) {
  if (!foresees() || store_.lost().empty()) return;
  DistanceGrid grid(current_.level(0).width(), current_.level(0).height(), options_.min_distance_px);
  for (const Live& feature : live_) grid.add(feature.pixel.x(), feature.pixel.y());
  const HasRoom has_room = [&](const Eigen::Vector2f& pixel) {
    return may_be_at(pixel, mask) && grid.is_far(pixel.x(), pixel.y());
  };
  for (const Reappeared& found : find_reappeared(associations(), store_, index_, history_, camera_, current_, has_room,
                                                 describe_rotated(), options_)) {
    if (static_cast<int>(live_.size()) >= options_.features) break;
    if (!grid.add_if_far(found.pixel.x(), found.pixel.y())) continue;
    live_.push_back({found.track, found.pixel, camera_.from_pixel(found.pixel), TrackState::reidentified});
    store_.mark_found(found.track);
    ++frame.reidentified;
  }
}

/// Removes the marked tracked features for good.
void Tracker::State::remove_live(const std::vector<char>& marked, TrackFrame& frame) {
  std::vector<Live> kept;
  for (std::size_t i = 0; i < live_.size(); ++i) {
    if (marked[i] == 0) {
      kept.push_back(live_[i]);
      continue;
    }
    store_.discard(live_[i].track);
    --frame.tracked;
    ++frame.lost;
  }
  live_ = std::move(kept);
}

/// Inside the border and the mask.
bool Tracker::State::may_be_at(const Eigen::Vector2f& pixel, GrayView mask) const {
  const int x = static_cast<int>(std::lround(pixel.x())), y = static_cast<int>(std::lround(pixel.y()));
  const PaddedImage& image = current_.level(0);
  const int border = options_.corner_border_px;
  if (x < border || y < border || x >= image.width() - border || y >= image.height() - border) return false;
  return mask.empty() || mask.at(x, y) != 0;
}

DescribeRotated Tracker::State::describe_rotated() const {
  const bool steered = options_.descriptor == "steered" || options_.descriptor == "steered_scaled";
  return [this, steered](const Eigen::Vector2f& pixel, double angle, double scale) {
    return steered ? describe(pixel, false).front() : brief_.describe(sums_, pixel.x(), pixel.y(), angle, scale);
  };
}

std::vector<Eigen::Vector2f> Tracker::State::detect(const TrackFrame& frame, GrayView mask) {
  const int needed = options_.features - static_cast<int>(live_.size());
  const int wanted = std::max(needed, options_.mode != "klt" && options_.displace ? most_displaced() : 0);
  if (wanted <= 0) return {};
  const PaddedImage& image = current_.level(0);
  free_.reset(image.width(), image.height(), mask);
  for (const Live& feature : live_) free_.block(feature.pixel, options_.min_distance_px);
  CornerOptions corner_options{options_.corner_quality, options_.min_distance_px, options_.corner_border_px};
  // Some corners will be refused because they cannot be tracked back.
  const bool verifies = verifies_corners(frame);
  const bool recognizes = options_.mode != "klt" && !store_.lost().empty();
  if (recognizes && options_.candidates_distance_px > 0.0)
    corner_options.min_distance_px = options_.candidates_distance_px;
  const double factor = recognizes ? options_.candidates_factor : 1.0;
  const double most = std::max<double>(wanted, options_.max_candidates_factor * options_.features);
  const int asked = static_cast<int>(std::ceil(std::min(most, wanted * std::max(factor, verifies ? 2.0 : 1.0))));
  std::vector<Eigen::Vector2f> corners;
  for (const Corner& corner : detector_.detect(image, free_.view(), asked, corner_options, pool_)) {
    corners.emplace_back(static_cast<float>(corner.x), static_cast<float>(corner.y));
  }
  return corners;
}

std::vector<Descriptor> Tracker::State::describe(const Eigen::Vector2f& pixel, bool all_scales) const {
  if (options_.mode == "klt") return {Descriptor{}};
  const bool steered = options_.descriptor == "steered" || options_.descriptor == "steered_scaled";
  const bool scaled = options_.descriptor == "scaled" || options_.descriptor == "steered_scaled";
  const double angle =
      steered ? intensity_centroid_angle(current_.level(0).view(), pixel.x(), pixel.y(), orientation_radius) : 0.0;
  std::vector<Descriptor> views;
  for (const double scale : Brief::scales()) {
    views.push_back(brief_.describe(sums_, pixel.x(), pixel.y(), angle, scale));
    if (!scaled || !all_scales) break;
  }
  return views;
}

void Tracker::State::describe_tracked() {
  std::vector<Descriptor> descriptors(live_.size());
  const auto describe_some = [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      descriptors[i] = describe(live_[i].pixel, false).front();
    }
  };
  if (pool_) {
    pool_->for_chunks(0, static_cast<int>(live_.size()), descriptors_per_chunk, describe_some);
  } else {
    describe_some(0, static_cast<int>(live_.size()));
  }
  for (std::size_t i = 0; i < live_.size(); ++i) observe(live_[i], descriptors[i]);
}

/// Corners are tracked back only if most features could be tracked here, so that there is a frame to compare with.
bool Tracker::State::verifies_corners(const TrackFrame& frame) const {
  return options_.verify_corners && !before_.empty() && 2 * frame.tracked >= static_cast<int>(before_.size());
}

/// Whether the position is near one where a feature was just lost: its occluder is likely to move on.
bool Tracker::State::near_a_loss(const Eigen::Vector2f& pixel) const {
  return std::any_of(before_.begin(), before_.end(), [&](const Live& feature) {
    return store_[feature.track].last_seen < index_ &&
           static_cast<double>((feature.pixel - pixel).norm()) < options_.min_distance_px;
  });
}

bool Tracker::State::can_be_followed_back(const Eigen::Vector2f& pixel) const {
  KltResult result;
  klt_follow(current_, previous_, std::span(&pixel, 1), std::span(&pixel, 1), klt_options(options_), nullptr,
             std::span(&result, 1));
  return result.followed;
}

/// At most this many features of a full frame are replaced per frame.
int Tracker::State::most_displaced() const {
  return std::min(static_cast<int>(store_.lost().size()), std::max(1, options_.features / 10));
}

/// If there are more tracked and re-identified features than the limit, the youngest tracked ones that are younger than
/// the re-identified ones are removed; further re-identified ones stay lost.
void Tracker::State::make_room(std::vector<Recognized>& recognized, TrackFrame& frame) {
  const auto excess = [&] { return static_cast<int>(live_.size() + recognized.size()) - options_.features; };
  std::vector<std::size_t> youngest;
  for (std::size_t i = 0; i < live_.size(); ++i) {
    if (live_[i].state == TrackState::tracked) youngest.push_back(i);
  }
  std::sort(youngest.begin(), youngest.end(), [&](std::size_t a, std::size_t b) {
    const Track &first = store_[live_[a].track], &second = store_[live_[b].track];
    return first.age != second.age ? first.age < second.age : first.id > second.id;
  });
  std::vector<char> is_displaced(live_.size(), 0);
  int displaced = 0;
  const int most = std::min(most_displaced(), static_cast<int>(youngest.size()));
  while (excess() - displaced > 0) {
    const std::size_t next = displaced < most ? youngest[static_cast<std::size_t>(displaced)] : live_.size();
    if (next < live_.size() && store_[live_[next].track].age < store_[recognized.back().track].age) {
      is_displaced[next] = 1;
      ++displaced;
    } else {
      recognized.pop_back();
    }
  }
  remove_live(is_displaced, frame);
}

void Tracker::State::observe(const Live& feature, const Descriptor& descriptor) {
  Track& track = store_[feature.track];
  track.observe(index_, feature.pixel, feature.ideal, descriptor);
  track.keep_patch(index_, options_.reference_interval, current_, feature.pixel, options_.patch_window_px);
}

void Tracker::State::adopt(const std::vector<Eigen::Vector2f>& corners, TrackFrame& frame) {
  std::vector<Recognized> recognized;
  if (options_.mode != "klt") {
    const std::vector<Association> tracked = associations();
    const int room = options_.features - static_cast<int>(live_.size());
    const int most = options_.displace ? options_.features : room;
    const Describe views = [this](const Eigen::Vector2f& corner) { return describe(corner, true); };
    recognized = recognize(corners, views, tracked, store_, index_, current_, most, options_, pool_, frame.times);
    make_room(recognized, frame);
  }
  frame.reidentified += static_cast<int>(recognized.size());
  const PaddedImage& image = current_.level(0);
  DistanceGrid grid(image.width(), image.height(), options_.min_distance_px);
  std::vector<char> used(corners.size(), 0);
  for (const Recognized& match : recognized) {
    used[match.corner] = 1;
    grid.add_if_far(match.pixel.x(), match.pixel.y());
    store_.mark_found(match.track);
    live_.push_back({match.track, match.pixel, camera_.from_pixel(match.pixel), TrackState::reidentified});
    observe(live_.back(), describe(match.pixel, false).front());
  }
  const bool verify = verifies_corners(frame);
  for (std::size_t i = 0; i < corners.size() && static_cast<int>(live_.size()) < options_.features; ++i) {
    if (used[i] != 0 || (verify && near_a_loss(corners[i]))) continue;
    if (!grid.is_far(corners[i].x(), corners[i].y())) continue;
    if (verify && !can_be_followed_back(corners[i])) continue;
    grid.add_if_far(corners[i].x(), corners[i].y());
    live_.push_back({store_.create(), corners[i], camera_.from_pixel(corners[i]), TrackState::fresh});
    observe(live_.back(), describe(corners[i], false).front());
    ++frame.fresh;
  }
}

void Tracker::State::report(TrackFrame& frame) const {
  for (const Live& feature : live_) {
    const Track& track = store_[feature.track];
    frame.features.push_back(
        {track.id, feature.pixel, camera_.ray_of(feature.pixel), track.age, feature.state, track.seen_before});
  }
  std::sort(frame.features.begin(), frame.features.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  if (brightness_.deviation < blank_deviation) {
    frame.health = TrackHealth::dark_or_blank;
  } else if (!before_.empty() && 4 * frame.tracked < static_cast<int>(before_.size())) {
    frame.health = TrackHealth::abrupt_motion;
  } else if (2 * static_cast<int>(live_.size()) < options_.features) {
    frame.health = TrackHealth::few_corners;
  }
}

Tracker::Tracker(const TrackOptions& options, std::optional<Camera> camera, TaskPool* pool)
    : state_(std::make_unique<State>(options, camera, pool)) {}
Tracker::~Tracker() = default;
Tracker::Tracker(Tracker&&) noexcept = default;

TrackFrame Tracker::process(GrayView image, TimeNs stamp, GrayView mask) { return state_->process(image, stamp, mask); }

const char* name_of(TrackState state) {
  switch (state) {
    case TrackState::tracked:
      return "tracked";
    case TrackState::fresh:
      return "new";
    case TrackState::reidentified:
      return "reidentified";
  }
  return "unknown";
}

const char* name_of(TrackHealth health) {
  switch (health) {
    case TrackHealth::good:
      return "good";
    case TrackHealth::few_corners:
      return "few corners";
    case TrackHealth::dark_or_blank:
      return "dark or blank";
    case TrackHealth::abrupt_motion:
      return "abrupt motion";
  }
  return "unknown";
}

}  // namespace rastro
