// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/inverse_depth_pyramid.h"

#include <algorithm>
#include <cstddef>

#include "rastro/slam/lsd/depth/depth_kernels.h"

namespace rastro {
namespace {

constexpr std::size_t before = 16, behind = 32;  // zeros beside a row, for what vectors read there

/// One row of the finer map at a time, and the sums of one row of the coarser one.
class HalvingBuffers {
 public:
  explicit HalvingBuffers(int width)
      : width_(static_cast<std::size_t>(width)),
        mean_(before + width_ + behind),
        variance_(mean_.size()),
        sums_(4 * mean_.size()) {}

  HalvingRow row(const InverseDepthMap& fine, int y) {
    std::copy_n(fine.mean.row(y), width_, &mean_[before]);
    std::copy_n(fine.variance.row(y), width_, &variance_[before]);
    return {&mean_[before], &variance_[before]};
  }
  HalvingSums sums() {
    const std::size_t size = mean_.size();
    return {sums_.data(), sums_.data() + size, sums_.data() + 2 * size, sums_.data() + 3 * size};
  }
  void clear() { std::fill(sums_.begin(), sums_.end(), 0.0F); }

 private:
  std::size_t width_;
  std::vector<float> mean_, variance_, sums_;
};

}  // namespace

void halve(const InverseDepthMap& fine, InverseDepthMap& coarse) {
  const int width = (fine.width() + 1) / 2, height = (fine.height() + 1) / 2;
  if (coarse.width() != width || coarse.height() != height) coarse = InverseDepthMap(width, height);
  HalvingBuffers buffers(fine.width());
  HalvingSums sums = buffers.sums();
  for (int y = 0; y < height; ++y) {
    for (int row = std::max(0, 2 * y - 1); row <= std::min(fine.height() - 1, 2 * y + 1); ++row)
      depth_kernels().add_row(buffers.row(fine, row), row == 2 * y ? 2.0F : 1.0F, width, sums);
    depth_kernels().divide(sums, width, coarse.mean.row(y), coarse.variance.row(y));
    buffers.clear();
  }
}

InverseDepthMap halve(const InverseDepthMap& fine) {
  InverseDepthMap coarse;
  halve(fine, coarse);
  return coarse;
}

std::vector<InverseDepthMap> inverse_depth_pyramid(const InverseDepthMap& map, int levels) {
  RASTRO_CHECK(levels >= 1, "a pyramid has a level");
  std::vector<InverseDepthMap> pyramid{map};
  while (static_cast<int>(pyramid.size()) < levels) pyramid.push_back(halve(pyramid.back()));
  return pyramid;
}

}  // namespace rastro
