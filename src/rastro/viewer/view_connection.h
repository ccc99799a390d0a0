// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <list>
#include <memory>

#include "rastro/viewer/live_clients.h"
#include "rastro/viewer/reply_workers.h"
#include "rastro/viewer/request_rules.h"
#include "rastro/viewer/view_server.h"

namespace rastro::detail {

class ViewConnection;

/// What connections are served with; all of it outlives them.
struct ViewService {
  const ViewServerOptions& options;
  const RequestRules& rules;
  ReplyWorkers& workers;
  LiveClients* live = nullptr;  ///< Null where no run goes on.
};

/// The open connections, oldest first. Of one thread.
class ViewConnections {
 public:
  using List = std::list<std::weak_ptr<ViewConnection>>;

  /// Starts to serve one more. At most options.max_connections stay: the oldest one that waits for a request makes
  /// room, else the new one is closed. Those that ask for the messages of a run become its clients.
  void add(boost::asio::ip::tcp::socket socket, const ViewService& service);

 private:
  bool make_room(std::size_t most);
  List list_;
};

}  // namespace rastro::detail
