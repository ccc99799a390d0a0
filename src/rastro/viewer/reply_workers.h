// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <boost/asio/thread_pool.hpp>
#include <functional>

#include "rastro/viewer/request_rules.h"

namespace rastro::detail {

/// Threads for replies that take long, one for each kind of them, so that neither the messages of a run nor other
/// requests wait. They have less priority than the run.
class ReplyWorkers {
 public:
  ReplyWorkers();
  ~ReplyWorkers();
  ReplyWorkers(const ReplyWorkers&) = delete;
  ReplyWorkers& operator=(const ReplyWorkers&) = delete;

  /// Does the work after what is already waiting of this kind. Returns at once.
  void start(ViewReply::Slow kind, std::function<void()> work);
  /// Waits for the work that was begun; what waits is left out.
  void stop();

 private:
  boost::asio::thread_pool reading_{1}, measuring_{1};
};

}  // namespace rastro::detail
