// SPDX-License-Identifier: Apache-2.0
#include "rastro/methods/auto_slam.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "rastro/methods/method_choice.h"

namespace rastro {
namespace {

std::unique_ptr<SlamMethod> seeded(std::unique_ptr<SlamMethod> method, std::uint64_t seed) {
  OptionTable table = method->options();
  const auto is_seed = [](const Option& option) { return option.name == "seed"; };
  if (std::any_of(table.options().begin(), table.options().end(), is_seed))
    table.set("seed", fmt::format("{}", seed), "the seed");
  return method;
}

class AutoSlam : public Slam {
 public:
  AutoSlam(const AutoSlamOptions& options, SourceInfo source, const SlamContext& context, SlamMethodByName by_name)
      : options_(options), source_(std::move(source)), context_(context), by_name_(std::move(by_name)) {}

  SlamUpdate process(const Frame& frame) override {
    std::vector<SlamEvent> events;
    if (!slam_) {
      choices_ = slam_choices(source_, texture_of(frame.image.view(), options_.corner_threshold),
                              options_.least_texture, context_.live);
      use(0, choices_.front().reason, events);
    } else if (has_failed(frame.stamp)) {
      use(in_use_ + 1, fmt::format("{} gave no pose for {:.1f} s", choices_[in_use_].method, options_.patience_s),
          events);
    }
    SlamUpdate update = slam_->process(frame);
    if (!waiting_since_) waiting_since_ = frame.stamp;
    has_pose_ = has_pose_ || (update.state != SlamState::initializing && update.state != SlamState::lost);
    update.events.insert(update.events.begin(), events.begin(), events.end());
    return update;
  }

  std::vector<SlamEvent> finish() override { return slam_ ? slam_->finish() : std::vector<SlamEvent>(); }
  Trajectory trajectory() const override { return slam_ ? slam_->trajectory() : Trajectory(); }
  std::shared_ptr<const Map> snapshot() const override { return slam_ ? slam_->snapshot() : nullptr; }
  std::vector<PlaceBelief> places() const override { return slam_ ? slam_->places() : std::vector<PlaceBelief>(); }
  /// The next frame is the first: the choice is made again.
  void reset() override {
    slam_.reset();
    waiting_since_.reset();
    has_pose_ = false;
  }
  bool set_mapping(bool on) override { return slam_ && slam_->set_mapping(on); }
  std::vector<FeatureObservation> observations() const override {
    return slam_ ? slam_->observations() : std::vector<FeatureObservation>();
  }
  std::int64_t dropped_frames() const override { return slam_ ? slam_->dropped_frames() : 0; }
  MapMemory map_memory() const override { return slam_ ? slam_->map_memory() : MapMemory(); }

 private:
  bool has_failed(TimeNs stamp) const {
    return !has_pose_ && in_use_ + 1 < choices_.size() && waiting_since_ &&
           to_seconds(stamp - *waiting_since_) > options_.patience_s;
  }

  void use(std::size_t choice, const std::string& reason, std::vector<SlamEvent>& events) {
    in_use_ = choice;
    waiting_since_.reset();
    slam_.reset();
    slam_ = seeded(by_name_(choices_[choice].method), options_.seed)->make(source_, context_);
    events.push_back({"method", choices_[choice].method + ": " + reason});
  }

  AutoSlamOptions options_;
  SourceInfo source_;
  SlamContext context_;
  SlamMethodByName by_name_;
  std::vector<MethodChoice> choices_;
  std::size_t in_use_ = 0;
  std::unique_ptr<Slam> slam_;           ///< Null before the first frame.
  std::optional<TimeNs> waiting_since_;  ///< Stamp of the first frame of the method in use.
  bool has_pose_ = false;                ///< Some frame had one.
};

class AutoSlamMethod : public SlamMethod {
 public:
  explicit AutoSlamMethod(SlamMethodByName by_name) : by_name_(std::move(by_name)) {}
  std::string name() const override { return "auto"; }
  std::string summary() const override { return "the method that suits sensors and texture, and why"; }
  std::string needs() const override { return "calibrated images, laser scans, or landmarks with wheel odometry"; }
  OptionTable options() override {
    OptionTable table;
    table.add({"least_texture",
               &options_.least_texture,
               "",
               "share of the first image with corners, below which rgbd is chosen before fusion for a depth camera",
               0,
               1,
               {}});
    table.add(
        {"corner_threshold", &options_.corner_threshold, "", "contrast of these corners, gray levels", 1, 255, {}});
    table.add({"seed", &options_.seed, "", "seed of the random numbers of the method in use", 0, 0, {}});
    table.add({"patience_s",
               &options_.patience_s,
               "s",
               "so long a method may give no pose at the start before another one takes over",
               0,
               3600,
               {}});
    return table;
  }
  bool wants_color() const override { return true; }  // rgbd may be the choice, and its map is in color
  bool wants_depth() const override { return true; }
  bool wants_right() const override { return true; }
  std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const override {
    // Whatever is wrong with the source is said before the run begins.
    for (const MethodChoice& choice : slam_choices(source, 1.0, 0.0, context.live))
      by_name_(choice.method)->make(source, {});
    return std::make_unique<AutoSlam>(options_, source, context, by_name_);
  }

 private:
  SlamMethodByName by_name_;
  AutoSlamOptions options_;
};

}  // namespace

std::unique_ptr<SlamMethod> auto_slam_method(SlamMethodByName method_by_name) {
  return std::make_unique<AutoSlamMethod>(std::move(method_by_name));
}

}  // namespace rastro
