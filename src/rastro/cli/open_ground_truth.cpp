// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/open_ground_truth.h"

#include "rastro/dataset/surface_truth/surface_ground_truth_reader.h"

namespace rastro::cli {
namespace {

/// The ground truth of a recording on disk, as the scores need it.
class RecordedGroundTruth : public SurfaceGroundTruth {
 public:
  explicit RecordedGroundTruth(SurfaceGroundTruthReader reader) : reader_(std::move(reader)) {}

  std::int64_t frame_count() const override { return reader_.frame_count(); }
  std::optional<SurfacePoint> surface_at(std::int64_t frame, const Eigen::Vector2d& pixel) const override {
    const auto found = reader_.corner_surface_at(frame, pixel);
    if (!found) return std::nullopt;
    return SurfacePoint{found->point_in_world, found->surface};
  }
  ProjectedPoint project(std::int64_t frame, const SurfacePoint& point) const override {
    const RecordedView view = reader_.view_of(frame, point.point_in_world);
    if (!view.inside) return {};
    return {view.visible ? Visibility::visible : Visibility::occluded_by_surface, view.pixel};
  }

 private:
  SurfaceGroundTruthReader reader_;
};

}  // namespace

OpenedGroundTruth open_ground_truth(const std::string& data_folder) {
  SurfaceGroundTruthReader reader = read_surface_ground_truth(data_folder);
  OpenedGroundTruth opened;
  opened.image_width = reader.camera().width;
  opened.image_height = reader.camera().height;
  for (const StampedPose& pose : reader.poses()) opened.stamps.push_back(pose.stamp);
  opened.ground_truth = std::make_unique<RecordedGroundTruth>(std::move(reader));
  return opened;
}

}  // namespace rastro::cli
