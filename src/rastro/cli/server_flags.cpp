// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/server_flags.h"

#include <fmt/format.h>

#include "rastro/base/error.h"

namespace rastro::cli {

void add_server_flags(CLI::App& command, ServerFlags& flags, const std::string& group) {
  const auto named = [&group](CLI::Option* option, const char* type) {
    option->type_name(type);
    if (!group.empty()) option->group(group);
  };
  named(command.add_option("--port", flags.port, "Port (default: 8420, or any free one; 0: any free one)"), "N");
  named(command.add_option("--listen", flags.listen,
                           "Address to serve other machines on, such as 0.0.0.0 (default: none)"),
        "ADDRESS");
  named(command.add_option("--token", flags.token, "Token that clients must give (default with --listen: generated)"),
        "T");
}

ViewServerOptions server_options(const ServerFlags& flags) {
  ViewServerOptions options;
  options.token = flags.token;
  if (!flags.listen.empty()) {
    options.address = flags.listen;
    if (flags.token.empty()) options.token = random_token();
  }
  if (!flags.port) return options;
  if (*flags.port < 0 || *flags.port > 65535)
    throw Error(fmt::format("{} is not a port", *flags.port), "--port", "give 1 to 65535, or 0 for any free one");
  options.port = static_cast<std::uint16_t>(*flags.port);
  return options;
}

}  // namespace rastro::cli
