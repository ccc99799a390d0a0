// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/campus_scene.h"

namespace rastro::campus {

std::unique_ptr<Scene> build_scene(std::uint64_t seed, int threads, double detail) {
  auto scene = std::make_unique<Scene>();
  Random building(seed_for(seed, 51)), grounds(seed_for(seed, 52)), walkers(seed_for(seed, 54));
  add_building(*scene, building);
  add_grounds(*scene, grounds);
  LapThings things(*scene, seed_for(seed, 53));
  add_things(things);
  things.add_moving();
  add_walkers(*scene, walkers);
  TaskPool pool(threads);
  scene->bake(seed_for(seed, 55), pool, detail, 0.9);
  return scene;
}

}  // namespace rastro::campus
