// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/live_clients.h"

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket.hpp>

namespace rastro::detail {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
using Kind = LiveMessage::Kind;

}  // namespace

void LiveInbox::put(LiveCommand command) {
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() >= most_waiting) return;
    waiting_.push_back(command);
  }
  arrived_.notify_one();
}

std::optional<LiveCommand> LiveInbox::take(std::chrono::milliseconds at_most) {
  std::unique_lock lock(mutex_);
  if (!arrived_.wait_for(lock, at_most, [this] { return !waiting_.empty(); })) return std::nullopt;
  const LiveCommand command = waiting_.front();
  waiting_.pop_front();
  return command;
}

/// One page. Writes one message at a time; what waits is bounded.
class LiveClient : public std::enable_shared_from_this<LiveClient> {
 public:
  LiveClient(boost::asio::ip::tcp::socket socket, LiveInbox& inbox, std::atomic<int>& open)
      : stream_(std::move(socket)), inbox_(inbox), open_(open) {
    ++open_;
    constexpr std::size_t longest_command = 256;
    stream_.read_message_max(longest_command);
    // A client that answers no ping for half a minute is gone.
    websocket::stream_base::timeout timeout{std::chrono::seconds(10), std::chrono::seconds(30), true};
    stream_.set_option(timeout);
  }

  void accept(const LiveClients::Request& request) {
    stream_.async_accept(request, [self = shared_from_this()](const beast::error_code& error) {
      if (error) return self->close();
      self->accepted_ = true;
      self->read();
      self->write_next();
    });
  }

  void push(const LiveMessage& message) {
    if (closed_) return;
    if (message.kind == Kind::image || message.kind == Kind::place || message.kind == Kind::scene ||
        message.kind == Kind::calibration)
      drop(message.kind);  // the latest one counts
    if (message.kind == Kind::frame && waiting(Kind::frame) >= most_frames) {
      drop_first(Kind::frame);
      ++dropped_;
    }
    if (waiting_.size() >= most_waiting) return close();
    waiting_.push_back(message);
    write_next();
  }

  /// Of what waits.
  void forget(Kind kind) { drop(kind); }
  bool is_closed() const { return closed_; }

  void close() {
    if (closed_) return;
    closed_ = true;
    --open_;
    waiting_.clear();
    beast::error_code ignored;
    beast::get_lowest_layer(stream_).socket().close(ignored);
  }

 private:
  static constexpr std::ptrdiff_t most_frames = 200;
  static constexpr std::size_t most_waiting = 300;

  std::ptrdiff_t waiting(Kind kind) const {
    return std::count_if(waiting_.begin(), waiting_.end(), [kind](const auto& each) { return each.kind == kind; });
  }
  void drop(Kind kind) {
    std::erase_if(waiting_, [kind](const auto& each) { return each.kind == kind; });
  }
  void drop_first(Kind kind) {
    const auto first =
        std::find_if(waiting_.begin(), waiting_.end(), [kind](const auto& each) { return each.kind == kind; });
    if (first != waiting_.end()) waiting_.erase(first);
  }

  void read() {
    stream_.async_read(buffer_, [self = shared_from_this()](const beast::error_code& error, std::size_t) {
      if (error) return self->close();
      if (const auto command = live_command_in(beast::buffers_to_string(self->buffer_.data())))
        self->inbox_.put(*command);
      self->buffer_.clear();
      self->read();
    });
  }

  void write_next() {
    if (!accepted_ || writing_ || closed_ || waiting_.empty()) return;
    writing_ = true;
    current_ = std::move(waiting_.front());
    waiting_.pop_front();
    tail_ = current_.kind == Kind::frame ? ",\"dropped\":" + std::to_string(dropped_) + "}" : std::string();
    stream_.binary(current_.kind == Kind::image || current_.kind == Kind::place);
    const std::array<boost::asio::const_buffer, 2> buffers = {boost::asio::buffer(*current_.bytes),
                                                              boost::asio::buffer(tail_)};
    stream_.async_write(buffers, [self = shared_from_this()](const beast::error_code& error, std::size_t) {
      self->writing_ = false;
      if (error) return self->close();
      self->write_next();
    });
  }

  websocket::stream<beast::tcp_stream> stream_;
  LiveInbox& inbox_;
  std::atomic<int>& open_;  ///< Number of clients.
  beast::flat_buffer buffer_;
  std::deque<LiveMessage> waiting_;
  LiveMessage current_;
  std::string tail_;
  std::int64_t dropped_ = 0;  ///< Frames that this client was too slow for.
  bool accepted_ = false, writing_ = false, closed_ = false;
};

void LiveClients::forget_closed() {
  std::erase_if(clients_, [](const auto& each) { return each->is_closed(); });
}

void LiveClients::accept(boost::asio::ip::tcp::socket socket, const Request& request) {
  forget_closed();
  if (clients_.size() >= most_clients) return;
  auto client = std::make_shared<LiveClient>(std::move(socket), inbox_, count_);
  client->push(hello_);
  if (status_) client->push(*status_);
  if (scene_) client->push(*scene_);
  if (calibration_) client->push(*calibration_);
  client->accept(request);
  clients_.push_back(std::move(client));
}

void LiveClients::forget_scene() {
  scene_.reset();
  for (const auto& client : clients_) client->forget(Kind::scene);
}

void LiveClients::send(const LiveMessage& message) {
  if (message.kind == Kind::status) status_ = message;
  if (message.kind == Kind::scene) scene_ = message;
  if (message.kind == Kind::calibration) calibration_ = message;
  for (const auto& client : clients_) client->push(message);
  forget_closed();
}

}  // namespace rastro::detail
