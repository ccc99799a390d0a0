// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "rastro/viewer/view_server.h"

namespace rastro::cli {

/// Where the viewer listens.
struct ServerFlags {
  std::string listen, token;  ///< Empty: not given.
  std::optional<int> port;
};

void add_server_flags(CLI::App& command, ServerFlags& flags, const std::string& group);

/// With a token of its own where others are served and none is given. Error for what is no port.
ViewServerOptions server_options(const ServerFlags& flags);

}  // namespace rastro::cli
