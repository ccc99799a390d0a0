// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/dataset/open.h"

namespace rastro::cli {

/// One way to run a method of this program: a column of a comparison.
struct MethodOffer {
  std::string command;   ///< "slam" or "odometry".
  std::string method;    ///< "orb".
  std::string sensor;    ///< Option sensor; "scan": a laser log cut out of depth images; empty: no choice.
  std::string kind;      ///< What it sees with: "mono", "stereo", "depth" or "laser"; "auto": as it chooses.
  bool has_seed = true;  ///< Random numbers decide its result.

  bool as_scan() const { return sensor == "scan"; }
  /// "orb mono", "features", "rgbd odometry".
  std::string name() const;
  bool operator==(const MethodOffer&) const = default;
};

struct MethodOffers {
  std::vector<MethodOffer> possible;
  std::vector<std::string> refused;  ///< "hector: has no laser scans", one each.
};

/// Every method of the program with every sensor that it can be told to use. `wanted`: "all", or NAME, odometry/NAME,
/// slam/NAME, each with :SENSOR for one sensor only. Error for unknown ones.
std::vector<MethodOffer> methods_named(const std::vector<std::string>& wanted);

/// Which of them the recording allows, by what each says when it is made for it.
MethodOffers offers_for(const std::string& path, const OpenOptions& options, const std::vector<MethodOffer>& methods);

}  // namespace rastro::cli
