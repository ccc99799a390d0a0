// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/reply_workers.h"

#include <boost/asio/post.hpp>
#include <utility>

#include "rastro/viewer/thread_priority.h"

namespace rastro::detail {

ReplyWorkers::ReplyWorkers() {
  boost::asio::post(reading_, lower_priority_of_this_thread);
  boost::asio::post(measuring_, lower_priority_of_this_thread);
}

ReplyWorkers::~ReplyWorkers() { stop(); }

void ReplyWorkers::start(ViewReply::Slow kind, std::function<void()> work) {
  boost::asio::post(kind == ViewReply::Slow::measuring ? measuring_ : reading_, std::move(work));
}

void ReplyWorkers::stop() {
  reading_.stop();
  measuring_.stop();
  reading_.join();
  measuring_.join();
}

}  // namespace rastro::detail
