// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

namespace rastro {

/// A limit such as "recall>=0.7" or "ate_rmse<=0.3".
struct ScoreLimit {
  std::string name;
  bool at_least = true;
  double value = 0.0;
};

/// Parses a limit; throws Error showing `examples` if the text is none. The caller checks that the score exists.
ScoreLimit read_limit(const std::string& text, const std::string& examples);

/// False without a value.
bool keeps_limit(const std::optional<double>& score, const ScoreLimit& limit);

}  // namespace rastro
