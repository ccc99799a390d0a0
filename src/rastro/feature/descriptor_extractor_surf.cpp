// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/descriptor_extractor_surf.h"

#include "rastro/base/error.h"

#if RASTRO_WITH_SURF
// SURF is header-only in dlib: none of dlib's libraries is linked, so the check that headers and library match is
// disabled, and so is BLAS, with which descriptors could differ between machines.
#define DLIB_TEST_FOR_ODR_VIOLATIONS_H_
#include <dlib/assert.h>
#undef DLIB_USE_BLAS
#include <dlib/array2d.h>
#include <dlib/image_keypoint/surf.h>
#endif

namespace rastro {

#if RASTRO_WITH_SURF
namespace {

class SurfExtractor final : public DescriptorExtractor {
 public:
  explicit SurfExtractor(const DescriptorExtractorOptions& options) : options_(options) {}

 private:
  Features extract_unsorted(GrayView image) override {
    pixels_.set_size(image.height, image.width);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) pixels_[y][x] = image.at(x, y);
    }
    Features result;
    result.length = 64;
    for (const dlib::surf_point& point :
         dlib::get_surf_points(pixels_, options_.max_keypoints, options_.surf_threshold)) {
      result.keypoints.push_back({static_cast<float>(point.p.center.x()), static_cast<float>(point.p.center.y()),
                                  static_cast<float>(18.0 * point.p.scale), static_cast<float>(point.angle),
                                  static_cast<float>(point.p.score)});
      for (long i = 0; i < 64; ++i) result.floats.push_back(static_cast<float>(point.des(i)));
    }
    return result;
  }

  DescriptorExtractorOptions options_;
  dlib::array2d<unsigned char> pixels_;
};

}  // namespace

bool has_surf() { return true; }

std::unique_ptr<DescriptorExtractor> detail::make_surf_extractor(const DescriptorExtractorOptions& options) {
  return std::make_unique<SurfExtractor>(options);
}

#else

bool has_surf() { return false; }

std::unique_ptr<DescriptorExtractor> detail::make_surf_extractor(const DescriptorExtractorOptions&) {
  throw Error("this build has no SURF", "descriptor surf", "build with -DRASTRO_WITH_SURF=ON, or use sift or orb");
}

#endif

}  // namespace rastro
