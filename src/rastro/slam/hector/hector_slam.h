// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>

#include "rastro/base/task_pool.h"
#include "rastro/slam/hector/options.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// Scan matching against a map that grows with the scans (Kohlbrecher et al. 2011), with loops closed by a graph of
/// submaps. Planar: z, roll and pitch stay 0. The world is the body frame at the first scan.
class HectorSlam : public Slam {
 public:
  /// `pool` may be null and must outlive this. `map_budget_bytes`: memory limit of the map, see MapBudget; 0:
  /// unlimited. `stop` (may be null): once set, finish() leaves the map as it is.
  HectorSlam(const HectorOptions& options, TaskPool* pool, std::size_t map_budget_bytes = 0,
             const std::atomic<bool>* stop = nullptr);
  ~HectorSlam() override;
  SlamUpdate process(const Frame& frame) override;
  std::vector<SlamEvent> finish() override;
  Trajectory trajectory() const override;
  std::shared_ptr<const Map> snapshot() const override;
  void reset() override;
  bool set_mapping(bool on) override;
  MapMemory map_memory() const override;

 private:
  class State;
  HectorOptions options_;
  TaskPool* pool_;
  std::size_t map_budget_bytes_;
  const std::atomic<bool>* stop_;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
