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

/// Error when the text is no limit, showing `examples`. Whether there is such a score, the caller knows.
ScoreLimit read_limit(const std::string& text, const std::string& examples);

/// A score with nothing to count keeps no limit.
bool keeps_limit(const std::optional<double>& score, const ScoreLimit& limit);

}  // namespace rastro
