// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/registered_depth.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "rastro/sensor/depth_registrar.h"

namespace rastro {
namespace {

/// Of one source; made at its first frame with depth, whose size is that of the color image.
class FrameRegistrar {
 public:
  void register_depth(const SourceInfo& info, Frame& frame) {
    if (frame.depth.empty()) return;
    const Camera& wanted = info.depth_registration->depth_camera;
    if (frame.depth.width() != wanted.width || frame.depth.height() != wanted.height)
      throw UnusableSource(fmt::format("depth is {}x{}, but depth_camera of the calibration {}x{}", frame.depth.width(),
                                       frame.depth.height(), wanted.width, wanted.height),
                           info.path, "give the calibration of this depth camera");
    if (!registrar_) {
      Camera color = *info.cameras.front().camera;
      color.width = frame.image.width();
      color.height = frame.image.height();
      registrar_.emplace(*info.depth_registration, color);
    }
    frame.depth = registrar_->registered(frame.depth);
  }

 private:
  std::optional<DepthRegistrar> registrar_;
};

class RegisteredSource final : public Source {
 public:
  explicit RegisteredSource(std::unique_ptr<Source> source) : source_(std::move(source)) {}
  const SourceInfo& info() const override { return source_->info(); }
  std::optional<Frame> next() override {
    auto frame = source_->next();
    if (frame) registrar_.register_depth(info(), *frame);
    return frame;
  }

 private:
  std::unique_ptr<Source> source_;
  FrameRegistrar registrar_;
};

class RegisteredLiveSource final : public LiveSource {
 public:
  explicit RegisteredLiveSource(std::unique_ptr<LiveSource> source) : source_(std::move(source)) {}
  const SourceInfo& info() const override { return source_->info(); }
  LiveCondition condition() const override { return source_->condition(); }
  std::optional<ArrivedFrame> next(TimeNs patience) override {
    auto arrived = source_->next(patience);
    if (arrived) registrar_.register_depth(info(), arrived->frame);
    return arrived;
  }

 private:
  std::unique_ptr<LiveSource> source_;
  FrameRegistrar registrar_;
};

bool is_to_be_registered(const SourceInfo& info, const OpenOptions& options) {
  return info.depth_registration && info.has_depth && options.want_depth && !options.raw_depth &&
         info.cameras.front().camera;
}

}  // namespace

std::unique_ptr<Source> registered_depth(std::unique_ptr<Source> source, const OpenOptions& options) {
  if (!is_to_be_registered(source->info(), options)) return source;
  return std::make_unique<RegisteredSource>(std::move(source));
}

std::unique_ptr<LiveSource> registered_depth(std::unique_ptr<LiveSource> source, const OpenOptions& options) {
  if (!is_to_be_registered(source->info(), options)) return source;
  return std::make_unique<RegisteredLiveSource>(std::move(source));
}

}  // namespace rastro
