// SPDX-License-Identifier: Apache-2.0
// Trajectory and map by any SLAM method; the map is saved for 04_read_a_map and for `rastro info`, export, localize.
//   example_03_slam                             one camera in the generated world `hall`; writes map.rastro
//   example_03_slam DATA METHOD [MAP_FILE]      a recording: hector or ekf (laser), rgbd (depth camera), orb (cameras)
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <string>

#include "rastro/base/error.h"
#include "rastro/dataset/open.h"
#include "rastro/map/file/map_file.h"
#include "rastro/methods/methods.h"
#include "rastro/synthetic/worlds/hall.h"

namespace {

constexpr int frames_of_hall = 40;

void print_event(const rastro::SlamUpdate& update, const rastro::SlamEvent& event) {
  fmt::print("frame {:5}: {} {}\n", update.index, event.kind, event.detail);
}

void run(rastro::Source& source, const rastro::SlamMethod& method, const std::string& map_file) {
  rastro::TaskPool pool(0);
  rastro::SlamContext context;
  context.pool = &pool;
  context.pipelined = true;  // mapping runs beside tracking; the results are the same
  const auto slam = method.make(source.info(), context);
  std::size_t tracked = 0, frames = 0;
  while (const auto frame = source.next()) {
    const rastro::SlamUpdate update = slam->process(*frame);
    for (const rastro::SlamEvent& event : update.events) print_event(update, event);
    tracked += update.state == rastro::SlamState::tracking ? 1 : 0;
    ++frames;
  }
  slam->finish();  // settles what mapping still has to do
  const auto map = slam->snapshot();
  rastro::save_map(*map, map_file);
  fmt::print("{} frames, {} with a pose, {} plainly tracking\n", frames, slam->trajectory().size(), tracked);
  fmt::print("{} keyframes and {} constraints written to {}\n", map->keyframes.size(), map->constraints.size(),
             map_file);
}

void run_recording(const std::string& data, const std::string& method_name, const std::string& map_file) {
  const auto method = rastro::slam_method(method_name);
  rastro::OpenOptions open;
  open.want_color = method->wants_color();
  open.want_depth = method->wants_depth();
  open.want_right = method->wants_right();
  run(*rastro::open(data, open), *method, map_file);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc > 2) {
    run_recording(argv[1], argv[2], argc > 3 ? argv[3] : "map.rastro");
  } else {
    const rastro::World hall = rastro::make_hall({.scale = 0.5});
    const auto method = rastro::slam_method("orb");
    method->options().set("features", "500", "example");  // any option by name, as --set does
    run(*rastro::synthetic_source(hall, frames_of_hall), *method, "map.rastro");
  }
  return 0;
} catch (const rastro::Error& error) {  // bad input: one plain line
  fmt::print(stderr, "{}\n", error.what());
  return 2;
}
