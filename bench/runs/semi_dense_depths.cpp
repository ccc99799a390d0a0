// SPDX-License-Identifier: Apache-2.0
// The semi-dense depths of a run on a generated world, against its exact depths:
//   rastro simulate hall --out hall
//   rastro slam hall --method lsd --out run
//   rastro_bench_semi_dense hall run/map.rastro
// A third argument is the world's seed (1).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/synthetic/worlds/corridor.h"
#include "rastro/synthetic/worlds/hall.h"
#include "rastro/synthetic/worlds/loop.h"
#include "rastro/synthetic/worlds/rooms.h"
#include "rastro/synthetic/worlds/street.h"

namespace {

using namespace rastro;

World world_named(const std::string& name, std::uint64_t seed) {
  const std::map<std::string, std::function<World()>> worlds = {{"hall", [=] { return make_hall({.seed = seed}); }},
                                                                {"street", [=] { return make_street({.seed = seed}); }},
                                                                {"loop", [=] { return make_loop({.seed = seed}); }},
                                                                {"corridor", [=] { return make_corridor({.seed = seed}); }},
                                                                {"bedroom", [=] { return make_bedroom({.seed = seed}); }},
                                                                {"study", [=] { return make_study({.seed = seed}); }}};
  const auto found = worlds.find(name);
  if (found == worlds.end()) throw Error("is no world of this program", name, "give hall, street, loop or bedroom");
  return found->second();
}

/// Inverse depths: of the map, and exact.
struct Compared {
  double estimate, sigma, exact;
};

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What the map's inverse depths are multiplied by to become metric.
double scale_of_depths(const std::vector<Compared>& pixels) {
  std::vector<double> ratios;
  for (const Compared& pixel : pixels) ratios.push_back(pixel.exact / pixel.estimate);
  return median(std::move(ratios));
}

void print_errors(const std::string& name, const std::vector<Compared>& pixels, double scale, std::size_t keyframes) {
  std::vector<double> relative, signed_errors, sigmas;
  double near = 0.0, inside = 0.0;
  for (const Compared& pixel : pixels) {
    const double error = scale * pixel.estimate - pixel.exact;
    relative.push_back(std::abs(error) / pixel.exact);
    signed_errors.push_back(error / pixel.exact);
    near += relative.back() < 0.05 ? 1.0 : 0.0;
    sigmas.push_back(std::abs(error) / (scale * pixel.sigma));
    inside += sigmas.back() < 2.0 ? 1.0 : 0.0;
  }
  const auto count = static_cast<double>(pixels.size());
  fmt::print("{:20} {:7.0f} {:8.2f} % {:9.3f} {:9.3f} {:10.2f} {:8.3f} %\n", name,
             count / static_cast<double>(keyframes), 100.0 * median(relative), near / count, inside / count,
             median(sigmas) / 0.6745, 100.0 * median(signed_errors));
}

double median_error(const std::vector<Compared>& pixels) {
  std::vector<double> relative;
  for (const Compared& pixel : pixels) relative.push_back(std::abs(pixel.estimate - pixel.exact) / pixel.exact);
  return median(std::move(relative));
}

std::vector<Compared> compared(const SemiDenseDepth& depths, const DepthImage& exact) {
  std::vector<Compared> pixels;
  for (const SemiDenseDepth::Pixel& pixel : depths.pixels) {
    const float depth = exact.at(pixel.x, pixel.y);
    if (!(depth > 0.0F)) continue;
    pixels.push_back({static_cast<double>(pixel.inverse_depth), std::sqrt(static_cast<double>(pixel.variance)),
                      1.0 / static_cast<double>(depth)});
  }
  return pixels;
}

void run(int argc, char** argv) {
  if (argc != 3 && argc != 4)
    throw Error("takes a world, a map of a run on it, and the seed of the world (default: 1)",
                "rastro_bench_semi_dense", "give WORLD MAP [SEED]");
  const auto seed = argc == 4 ? parse_int64(argv[3]) : std::optional<std::int64_t>(1);
  if (!seed || *seed < 0) throw Error("is not a seed", argv[3], "give a whole number, such as 1");
  const World world = world_named(argv[1], static_cast<std::uint64_t>(*seed));
  const auto map = load_map(argv[2]);
  const auto layer = map->layer<SemiDenseLayer>();
  if (!layer) throw Error("has no semi-dense depths", argv[2], "give a map made by --method lsd");
  TaskPool pool(1);
  std::vector<Compared> all, by_keyframe;
  constexpr double converged = 0.1;
  std::size_t keyframes = 0, unconverged = 0;
  for (const Keyframe& keyframe : map->keyframes) {
    const auto depths = layer->of.find(keyframe.id);
    if (depths == layer->of.end() || keyframe.submap != 0) continue;
    std::vector<Compared> pixels = compared(*depths->second, world.depth_at(world.time_of(keyframe.frame), pool).depth);
    if (pixels.empty()) continue;
    ++keyframes;
    all.insert(all.end(), pixels.begin(), pixels.end());
    const double own = scale_of_depths(pixels);
    for (Compared& pixel : pixels) pixel.estimate *= own, pixel.sigma *= own;
    if (median_error(pixels) > converged) unconverged = keyframes;
    by_keyframe.insert(by_keyframe.end(), pixels.begin(), pixels.end());
  }
  const double scale = scale_of(*map).metric ? 1.0 : scale_of_depths(all);
  fmt::print("{:20} {:>7} {:>10} {:>9} {:>9} {:>10} {:>10}\n", "", "pixels", "median", "within 5%", "2 sigma", "sigmas",
             "bias");
  print_errors("scale of the map", all, scale, keyframes);
  print_errors("scale per keyframe", by_keyframe, 1.0, keyframes);
  fmt::print("{} of {} keyframes until the median error, each with a scale of its own, stays below 10 %\n", unconverged,
             keyframes);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(argc, argv);
  } catch (const rastro::Error& error) {
    std::fprintf(stderr, "rastro_bench_semi_dense: %s\n", error.what());
    return 2;
  }
  return 0;
}
