// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/landmark_log/landmark_log.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/dataset/laser_log/log_words.h"

namespace rastro {
namespace {

constexpr double most_velocity = 1e4;
constexpr std::int64_t most_robots = 5;  // Subjects of MRCLAM; landmarks follow.

/// Calls `read` with the words of each line, going on after broken ones.
template <typename Read>
void read_lines(std::string_view text, std::string_view where, std::vector<std::string>& warnings, Read read) {
  std::int64_t used = 0, broken = 0;
  std::string first_problem;
  for (const auto& line : content_lines(text)) {
    try {
      read(LogWords(line.text, {where, line.number}));
      ++used;
    } catch (const Error& error) {
      if (broken++ == 0) first_problem = error.what();
    }
  }
  if (used == 0 && broken > 0) throw Error(first_problem);
  if (used == 0) throw Error("has only comments", where, "");
  if (broken > 0) warnings.push_back(fmt::format("{} lines skipped; the first: {}", broken, first_problem));
}

void require_end(LogWords& words) {
  if (const auto more = words.next()) words.refuse(fmt::format("{} is too much", in_quotes(*more)));
}

WheelVelocity read_velocity(LogWords& words) {
  WheelVelocity velocity;
  velocity.stamp = words.stamp("the time", StampUnit::seconds);
  velocity.forward = words.bounded("the forward velocity", most_velocity);
  velocity.yaw_rate = words.bounded("the yaw rate", most_velocity);
  require_end(words);
  return velocity;
}

std::int64_t read_id(LogWords& words) {
  const auto text = words.next();
  if (text == "-") return -1;
  const auto id = text ? parse_int64(*text) : std::nullopt;
  if (!id || *id < -1) words.refuse("the landmark is neither a number nor -");
  return *id;
}

StampedObservation read_observation(LogWords& words) {
  StampedObservation seen;
  seen.stamp = words.stamp("the time", StampUnit::seconds);
  seen.measurement.id = read_id(words);
  seen.measurement.range = words.finite("the range");
  seen.measurement.bearing = words.finite("the bearing");
  if (seen.measurement.range < 0.0) words.refuse("the range is below 0");
  require_end(words);
  return seen;
}

template <typename Item>
void sort_by_stamp(std::vector<Item>& items) {
  std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.stamp < b.stamp; });
}

/// Sums up wheel velocities as time goes on.
class DeadReckoning {
 public:
  explicit DeadReckoning(const std::vector<WheelVelocity>& velocities) : velocities_(velocities) {}

  const SE2& pose_at(TimeNs stamp) {
    while (next_ < velocities_.size() && velocities_[next_].stamp <= stamp) {
      go_to(velocities_[next_].stamp);
      current_ = velocities_[next_++];
    }
    go_to(stamp);
    return pose_;
  }

 private:
  void go_to(TimeNs stamp) {
    const double seconds = to_seconds(stamp - current_.stamp);
    if (next_ > 0) pose_ = pose_ * SE2::exp({current_.forward * seconds, 0.0, current_.yaw_rate * seconds});
    current_.stamp = stamp;
  }

  const std::vector<WheelVelocity>& velocities_;
  std::size_t next_ = 0;
  WheelVelocity current_;
  SE2 pose_;
};

}  // namespace

LandmarkLog parse_landmark_log(std::string_view text, std::string_view where) {
  LandmarkLog log;
  read_lines(text, where, log.warnings, [&](LogWords words) {
    const auto kind = words.next();
    if (kind == "odometry") {
      log.velocities.push_back(read_velocity(words));
    } else if (kind == "landmark") {
      log.observations.push_back(read_observation(words));
    } else {
      words.refuse(fmt::format("{} is neither odometry nor landmark", in_quotes(kind.value_or(""))));
    }
  });
  sort_by_stamp(log.velocities);
  sort_by_stamp(log.observations);
  return log;
}

void parse_mrclam_odometry(LandmarkLog& log, std::string_view text, std::string_view where) {
  read_lines(text, where, log.warnings, [&](LogWords words) { log.velocities.push_back(read_velocity(words)); });
  sort_by_stamp(log.velocities);
}

void parse_mrclam_measurements(LandmarkLog& log, const std::map<std::int64_t, std::int64_t>& subject_of_barcode,
                               std::string_view text, std::string_view where) {
  std::int64_t robots = 0, strangers = 0;
  read_lines(text, where, log.warnings, [&](LogWords words) {
    auto seen = read_observation(words);
    const auto found = subject_of_barcode.find(seen.measurement.id);
    if (found == subject_of_barcode.end()) {
      ++strangers;
    } else if (found->second <= most_robots) {
      ++robots;
    } else {
      seen.measurement.id = found->second;
      log.observations.push_back(seen);
    }
  });
  if (robots > 0) log.warnings.push_back(fmt::format("{} observations of other robots ignored: {}", robots, where));
  if (strangers > 0)
    log.warnings.push_back(fmt::format("{} observations of unknown barcodes ignored: {}", strangers, where));
  sort_by_stamp(log.observations);
}

std::map<std::int64_t, std::int64_t> parse_mrclam_barcodes(std::string_view text, std::string_view where) {
  std::map<std::int64_t, std::int64_t> subjects;
  std::vector<std::string> warnings;
  read_lines(text, where, warnings, [&](LogWords words) {
    const auto subject = static_cast<std::int64_t>(words.count("the subject", 1'000'000));
    subjects[static_cast<std::int64_t>(words.count("the barcode", 1'000'000))] = subject;
  });
  if (!warnings.empty()) throw Error(warnings.front(), where, "");
  return subjects;
}

Trajectory parse_mrclam_ground_truth(std::string_view text, std::string_view where) {
  Trajectory ground_truth;
  std::vector<std::string> warnings;
  read_lines(text, where, warnings, [&](LogWords words) {
    StampedPose& pose = ground_truth.emplace_back();
    pose.stamp = words.stamp("the time", StampUnit::seconds);
    const double x = words.finite("x"), y = words.finite("y");
    pose.world_from_body = SE3(SO3::exp({0.0, 0.0, words.finite("the heading")}), {x, y, 0.0});
  });
  if (!warnings.empty()) throw Error(warnings.front(), where, "");
  sort_by_stamp(ground_truth);
  return ground_truth;
}

std::vector<Frame> landmark_frames(const LandmarkLog& log) {
  std::vector<Frame> frames;
  DeadReckoning wheels(log.velocities);
  for (const auto& seen : log.observations) {
    if (frames.empty() || frames.back().stamp != seen.stamp) {
      Frame& frame = frames.emplace_back();
      frame.index = static_cast<std::int64_t>(frames.size()) - 1;
      frame.stamp = seen.stamp;
      frame.name = fmt::format("frame {}", frame.index);
      if (!log.velocities.empty()) frame.odometry_from_body = wheels.pose_at(seen.stamp);
    }
    frames.back().landmarks.push_back(seen.measurement);
  }
  return frames;
}

bool looks_like_landmark_log(std::string_view front) {
  for (const auto line : split(front, '\n')) {
    const auto words = split_words(line);
    if (!words.empty() && !line.starts_with('#')) return words.front() == "odometry" || words.front() == "landmark";
  }
  return false;
}

}  // namespace rastro
