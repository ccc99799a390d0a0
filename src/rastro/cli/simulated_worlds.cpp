// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/simulated_worlds.h"

#include <fmt/format.h>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/synthetic/worlds/campus.h"
#include "rastro/synthetic/worlds/corridor.h"
#include "rastro/synthetic/worlds/hall.h"
#include "rastro/synthetic/worlds/loop.h"
#include "rastro/synthetic/worlds/rooms.h"
#include "rastro/synthetic/worlds/street.h"

namespace rastro::cli {
namespace {

constexpr const char* hall_text =
    R"(machine hall seen from a drone, 752x480 at 20 Hz: it rises behind a press and descends again (frames 0-29),
         rotates abruptly (42-56), passes behind a pillar (76-112), then tours the hall without end)";
constexpr const char* street_text =
    R"(drive around a block of houses as in KITTI, 1242x375 at 10 Hz: a curve (frames 6-43), a straight, a second curve
         (about 210-250) and so on without end; other cars move, the exposure changes)";
constexpr const char* corridor_text =
    R"(robot with a 2D laser (270 degrees, 10 m, 10 Hz) and wheel odometry with errors on an office floor: a loop of
         76 m and 10 m more, glass doors, 26 m of corridor without structure, a walking person; --format tum: what its
         depth camera sees)";
constexpr const char* bedroom_text =
    R"(small room with few objects in artificial light, in color and depth from a hand-held Kinect, 640x480 at 30 Hz:
         a blue box on a shelf (0.32 x 0.25 m), a bed of 2 m; a round of 38.5 s back to the start, an abrupt rotation at
         15 s, and on without end; with objects.yaml for `rastro measure` and truth.ply)";
constexpr const char* study_text =
    R"(the same for a cluttered room in less light: shelves (0.16 m high, 0.75 m wide), a wall calendar (0.42 m), a
         glass table (0.85 m) with missing or wrong depth; the abrupt rotation is at 20.5 s)";
constexpr const char* loop_text =
    R"(walk of 120 m through streets, a hall and a square, 640x480 at 20 Hz, with --stereo or --format tum: back at the
         start in the same direction (frames 860-), across the square in the opposite one (1420-), a crowd (210-420), and
         two seconds at another place (550-589); closures.yaml lists the frames that see the same place)";
constexpr const char* campus_text =
    R"(walk of 30 minutes, 640x480 at 20 Hz, with --stereo or --format tum: three laps of 600 m over two floors whose
         corridors look alike, a courtyard and a parking lot; light, furniture, cars and people change from lap to lap;
         --every 10 for 2 Hz; with closures.yaml)";

std::int64_t frames_of_round(double round_s) { return static_cast<std::int64_t>(round_s * 30.0) + 1; }

std::vector<SimulatedWorld> make_worlds() {
  return {
      {"hall", hall_text, "euroc", 150, false, false,
       [](const WorldFlags& f) {
         return make_hall({.seed = f.seed, .distortion = f.distortion, .threads = f.threads});
       }},
      {"street", street_text, "kitti", 400, false, false,
       [](const WorldFlags& f) { return make_street({.seed = f.seed, .threads = f.threads}); }},
      {"corridor", corridor_text, "carmen", 150, false, false,
       [](const WorldFlags& f) { return make_corridor({.seed = f.seed, .threads = f.threads}); }},
      {"bedroom", bedroom_text, "tum", frames_of_round(bedroom_round_s), false, false,
       [](const WorldFlags& f) { return make_bedroom({.seed = f.seed, .threads = f.threads}); }},
      {"study", study_text, "tum", frames_of_round(study_round_s), false, false,
       [](const WorldFlags& f) { return make_study({.seed = f.seed, .threads = f.threads}); }},
      {"loop", loop_text, "euroc", loop_frames, true, true,
       [](const WorldFlags& f) { return make_loop({.seed = f.seed, .threads = f.threads}); }},
      {"campus", campus_text, "euroc", campus_frames, true, true,
       [](const WorldFlags& f) { return make_campus({.seed = f.seed, .threads = f.threads}); }},
  };
}

}  // namespace

const std::vector<SimulatedWorld>& simulated_worlds() {
  static const std::vector<SimulatedWorld> worlds = make_worlds();
  return worlds;
}

const SimulatedWorld& simulated_world(const std::string& name) {
  std::vector<std::string> names;
  for (const SimulatedWorld& world : simulated_worlds()) {
    if (world.name == name) return world;
    names.emplace_back(world.name);
  }
  throw Error("there is no such world", name, did_you_mean(name, names));
}

std::string simulated_worlds_text() {
  std::string text;
  for (const SimulatedWorld& world : simulated_worlds()) text += fmt::format("{:8} {}\n", world.name, world.text);
  return text;
}

}  // namespace rastro::cli
