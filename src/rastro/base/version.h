// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace rastro {

/// A part of rastro that can be left out of the build.
struct OptionalPart {
  std::string name;
  bool included = false;
};

/// The version of this build: for --version, and for the about.json of a run.
struct Version {
  std::string number;    ///< "0.1.0".
  std::string commit;    ///< Of the checkout when it was configured; "unknown" outside of git.
  std::string compiler;  ///< "GNU 12.2.0, Release".
  std::vector<OptionalPart> optional_parts;
};

const Version& version();

}  // namespace rastro
