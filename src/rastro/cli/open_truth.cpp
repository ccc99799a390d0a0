// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/open_truth.h"

#include "rastro/dataset/surface_truth/surface_truth_reader.h"

namespace rastro::cli {
namespace {

/// The truth on disk in the form in which scoring asks for it.
class RecordedTruth : public SurfaceTruth {
 public:
  explicit RecordedTruth(SurfaceTruthReader reader) : reader_(std::move(reader)) {}
  std::int64_t frame_count() const override { return reader_.frame_count(); }
  std::optional<SurfacePoint> surface_at(std::int64_t frame, const Eigen::Vector2d& pixel) const override {
    const std::optional<RecordedSurfacePoint> point = reader_.surface_at(frame, pixel);
    if (!point) return std::nullopt;
    return SurfacePoint{point->point_in_world, point->surface};
  }
  Sighting sighting_of(std::int64_t frame, const SurfacePoint& point) const override {
    const RecordedView view = reader_.view_of(frame, point.point_in_world);
    if (!view.inside) return {};
    return {view.visible ? Visibility::visible : Visibility::hidden_by_surface, view.pixel};
  }
  const Camera& camera() const { return reader_.camera(); }

 private:
  SurfaceTruthReader reader_;
};

}  // namespace

OpenedTruth open_truth(const std::string& data_folder) {
  auto truth = std::make_unique<RecordedTruth>(read_surface_truth(data_folder));
  const int width = truth->camera().width, height = truth->camera().height;
  return {std::move(truth), width, height};
}

}  // namespace rastro::cli
