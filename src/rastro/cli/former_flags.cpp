// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/former_flags.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/log.h"

namespace rastro::cli {
namespace {

/// A flag that was renamed; it is accepted for one release.
struct FormerFlag {
  const char* command;
  const char* former;
  const char* current;
};
constexpr FormerFlag former_flags[] = {{"track", "--pictures", "--images"},
                                       {"track", "--match-picture", "--match-image"},
                                       {"evaluate", "--truth", "--ground-truth"},
                                       {"simulate", "--no-truth", "--no-ground-truth"}};

const FormerFlag* former_flag(const std::string& command, const std::string& name) {
  const auto* found = std::find_if(std::begin(former_flags), std::end(former_flags), [&](const FormerFlag& each) {
    return command == each.command && name == each.former;
  });
  return found == std::end(former_flags) ? nullptr : found;
}

}  // namespace

std::vector<std::string> with_current_flags(int argc, const char* const* argv) {
  std::vector<std::string> words(argv, argv + argc);
  if (argc < 2) return words;
  const bool quiet = std::find(words.begin(), words.end(), "--quiet") != words.end();
  for (auto word = words.begin() + 2; word != words.end() && *word != "--"; ++word) {
    const std::string name = word->substr(0, word->find('='));
    const FormerFlag* flag = former_flag(words[1], name);
    if (!flag) continue;
    if (!quiet)
      log_warning(fmt::format("{}: {} is now {}; the next release will not accept the old name", flag->command,
                              flag->former, flag->current));
    word->replace(0, name.size(), flag->current);
  }
  return words;
}

}  // namespace rastro::cli
