// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

namespace rastro::cli {

/// Two lines for each method of a list: name and summary, and what it needs.
template <typename Method>
std::string methods_text(const std::vector<std::unique_ptr<Method>>& methods) {
  std::string text;
  for (const auto& method : methods)
    text += fmt::format("  {:<10} {}\n  {:<10}   input: {}\n", method->name(), method->summary(), "", method->needs());
  return text;
}

/// "features, hybrid or profiles"
template <typename Method>
std::string names_text(const std::vector<std::unique_ptr<Method>>& methods) {
  std::string text;
  for (std::size_t i = 0; i < methods.size(); ++i)
    text += (i == 0 ? "" : i + 1 == methods.size() ? " or " : ", ") + methods[i]->name();
  return text;
}

}  // namespace rastro::cli
