// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <list>
#include <memory>

#include "rastro/viewer/request_rules.h"
#include "rastro/viewer/view_server.h"

namespace rastro::detail {

class ViewConnection;

/// The open connections, oldest first. Of one thread.
class ViewConnections {
 public:
  using List = std::list<std::weak_ptr<ViewConnection>>;

  /// Starts to serve one more. At most options.max_connections stay: the oldest one that waits for a request makes
  /// room, else the new one is closed. `rules` and `options` must outlive the connections.
  void add(boost::asio::ip::tcp::socket socket, const RequestRules& rules, const ViewServerOptions& options);

 private:
  bool make_room(std::size_t most);
  List list_;
};

}  // namespace rastro::detail
