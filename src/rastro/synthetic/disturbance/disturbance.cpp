// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/disturbance/disturbance.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/synthetic/disturbance/disturbance_parts.h"

namespace rastro {
namespace {

using disturbance::Change;
using disturbance::Value;

constexpr const char* flag = "--disturb";

struct KnownDisturbance {
  DisturbanceKind kind;
  Change (*make)(const Value&);
};

const std::vector<KnownDisturbance>& known_disturbances() {
  namespace d = disturbance;
  static const std::vector<KnownDisturbance> known = {
      {{"none", "", "", "nothing: the recording as it is", WarningDue::no}, d::none},
      {{"black", "A:B", "", "black images without depth in frames A to B-1", WarningDue::either}, d::black},
      {{"freeze", "A:B", "", "images, depth and scans of the frame before A are repeated in frames A to B-1",
        WarningDue::either},
       d::freeze},
      {{"drop", "A:B", "", "frames A to B-1 are missing", WarningDue::either}, d::drop},
      {{"noise", "SIGMA", "10", "normal noise of the intensities, standard deviation of 0 to 255", WarningDue::no},
       d::noise},
      {{"blur", "PIXELS", "8", "motion blur: the mean over so many pixels of a row", WarningDue::either}, d::blur},
      {{"dark", "FACTOR", "8", "so many times less light, with the noise of the camera", WarningDue::either}, d::dark},
      {{"crowd", "SHARE", "0.3", "figures walk by 1 m in front and cover this share of the image on average",
        WarningDue::either},
       d::crowd},
      {{"color-cast", "FACTOR", "0.6", "red is scaled; intensities stay", WarningDue::no}, d::color_cast},
      {{"swap-stereo", "", "", "left and right images are swapped"}, d::swap_stereo},
      {{"late-right", "N", "1", "the right image is that of N frames before"}, d::late_right},
      {{"baseline", "FACTOR", "10", "the calibrated baseline is scaled"}, d::baseline},
      {{"focal-length", "FACTOR", "0.5", "the calibrated focal lengths are scaled"}, d::focal_length},
      {{"mirror-depth", "", "", "depth images are mirrored, left to right"}, d::mirror_depth},
      {{"constant-depth", "METERS", "2", "every measured depth is the same"}, d::constant_depth},
      {{"late-depth", "SECONDS", "0.2", "the depth image is an earlier one, with the stamp of the right one"},
       d::late_depth},
      {{"depth-scale", "FACTOR", "2", "depth is scaled"}, d::depth_scale},
      {{"stuck-scan", "FRAME", "0", "the scan of this frame is repeated from then on"}, d::stuck_scan},
      {{"reverse-beams", "", "", "the beams of a scan are in the wrong order"}, d::reverse_beams},
      {{"range-scale", "FACTOR", "2", "ranges of scans are scaled, their limits too"}, d::range_scale},
      {{"reverse-odometry", "", "", "every motion of the wheel odometry has the wrong sign"}, d::reverse_odometry}};
  return known;
}

/// The kind, and its value: the one given or the default.
std::pair<const KnownDisturbance*, Value> parsed(const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  const std::string name = assignment.substr(0, equals);
  const auto& known = known_disturbances();
  const auto found = std::find_if(known.begin(), known.end(), [&](const auto& each) { return each.kind.name == name; });
  if (found == known.end()) {
    std::vector<std::string> names;
    for (const KnownDisturbance& each : known) names.push_back(each.kind.name);
    throw Error(in_quotes(name) + " is not a disturbance", flag, did_you_mean(name, names));
  }
  const DisturbanceKind& kind = found->kind;
  if (equals != std::string::npos && kind.value.empty())
    throw Error(fmt::format("'{}' has no value", name), flag, "give the name alone");
  Value value{name, equals == std::string::npos ? kind.default_value : assignment.substr(equals + 1)};
  if (!kind.value.empty() && trim(value.text).empty())
    throw Error(fmt::format("'{}' needs a value", name), flag, fmt::format("give {}={}", name, kind.value));
  return {&*found, std::move(value)};
}

class DisturbedSource : public Source {
 public:
  DisturbedSource(std::unique_ptr<Source> source, Change change)
      : source_(std::move(source)), change_(std::move(change)), info_(source_->info()) {
    if (change_.info) change_.info(info_);
  }

  const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    for (;;) {
      std::optional<Frame> frame = source_->next();
      if (!frame || !change_.frame || change_.frame(*frame)) return frame;
    }
  }

 private:
  std::unique_ptr<Source> source_;
  Change change_;
  SourceInfo info_;
};

}  // namespace

namespace disturbance {

double Value::factor() const {
  const auto number = parse_finite(text);
  if (!number || !(*number > 0.0 && *number < 1e6))
    throw Error(in_quotes(text) + " is not a factor", std::string(flag) + " " + name, "give a number above 0");
  return *number;
}

double Value::amount(const char* unit) const {
  const auto number = parse_finite(text);
  if (!number || !(*number >= 0.0 && *number < 1e6))
    throw Error(in_quotes(text) + " is not an amount", std::string(flag) + " " + name,
                fmt::format("give {} from 0", unit));
  return *number;
}

std::int64_t Value::count() const {
  const auto number = parse_int64(text);
  if (!number || *number < 0 || *number > 1'000'000)
    throw Error(in_quotes(text) + " is not a number of frames", std::string(flag) + " " + name,
                "give a whole number from 0");
  return *number;
}

FrameRange frames_of(const Value& value) {
  const auto ends = split(value.text, ':');
  const auto first = parse_int64(ends.front()), end = parse_int64(ends.back());
  if (ends.size() != 2 || !first || !end || *first < 0 || *end <= *first)
    throw Error(in_quotes(value.text) + " is not a range of frames", std::string(flag) + " " + value.name,
                "give A:B with A below B, such as 30:40");
  return {*first, *end};
}

}  // namespace disturbance

const std::vector<DisturbanceKind>& disturbance_kinds() {
  static const std::vector<DisturbanceKind> kinds = [] {
    std::vector<DisturbanceKind> all;
    for (const KnownDisturbance& each : known_disturbances()) all.push_back(each.kind);
    return all;
  }();
  return kinds;
}

WarningDue warning_due(const std::string& assignment) { return parsed(assignment).first->kind.warning_due; }

void check_disturbance(const std::string& assignment) {
  const auto [known, value] = parsed(assignment);
  known->make(value);
}

std::unique_ptr<Source> disturbed(std::unique_ptr<Source> source, const std::string& assignment) {
  const auto [known, value] = parsed(assignment);
  return std::make_unique<DisturbedSource>(std::move(source), known->make(value));
}

}  // namespace rastro
