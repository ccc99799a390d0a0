// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace rastro {

/// The method of a run, as its result.json names it.
struct MethodInUse {
  std::string name;
  std::string choice;  ///< Of `auto`: the method that it chose last, and why; else empty.
};

}  // namespace rastro
