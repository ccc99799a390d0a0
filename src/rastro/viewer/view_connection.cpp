// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/view_connection.h"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/span_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <cmath>
#include <optional>

#include "rastro/viewer/http_message.h"

namespace rastro::detail {
namespace {

namespace beast = boost::beast;
using Response = http::response<http::span_body<const char>>;

std::chrono::milliseconds in_ms(double seconds) { return std::chrono::milliseconds(std::llround(1e3 * seconds)); }

/// Enough for a slow connection, and an end for a client that does not read.
double seconds_for(std::size_t bytes) {
  constexpr double least_seconds = 20.0, least_bytes_per_second = 100'000.0;
  return least_seconds + static_cast<double>(bytes) / least_bytes_per_second;
}

Response response_of(const ViewReply& reply, unsigned version, bool keep_alive) {
  Response response{static_cast<http::status>(reply.status), version};
  response.set(http::field::content_type, beast::string_view(reply.type.data(), reply.type.size()));
  response.set(http::field::cache_control, "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  for (const auto& [name, value] : reply.fields) response.set(name, value);
  response.body() = {reply.body.data(), reply.body.size()};
  response.keep_alive(keep_alive);
  response.content_length(reply.body.size());
  return response;
}

}  // namespace

/// Reads requests and answers them, one after the other, until the client or a deadline ends it.
class ViewConnection : public std::enable_shared_from_this<ViewConnection> {
 public:
  ViewConnection(boost::asio::ip::tcp::socket socket, const ViewService& service)
      : stream_(std::move(socket)), service_(service) {}

  bool is_waiting() const { return waiting_; }
  void close() {
    beast::error_code ignored;
    stream_.socket().close(ignored);
  }

  void read() {
    parser_.emplace();
    prepare(*parser_);
    waiting_ = true;
    stream_.expires_after(in_ms(service_.options.request_seconds));
    http::async_read_header(stream_, buffer_, *parser_,
                            [self = shared_from_this()](const beast::error_code& error, std::size_t) {
                              self->waiting_ = false;
                              self->answer(error);
                            });
  }

 private:
  void answer(const beast::error_code& error) {
    if (error) {
      const auto reply = refusal_of(error);
      if (reply) write(*reply, false);
      return;
    }
    if (announces_body(*parser_)) return write(refusal(413, "requests have no body here\n"), false);
    const ViewRequest request = request_of(*parser_);
    if (RequestRules::asks_for_messages(request)) return hand_over(request);
    const ViewReply reply = service_.rules.reply_to(request);
    if (reply.make) return make(reply);
    write(reply, is_kept_after(reply));
  }

  /// The connection waits for it, the server goes on.
  void make(const ViewReply& reply) {
    stream_.expires_never();
    service_.workers.start(reply.slow, [self = shared_from_this(), reply] {
      boost::asio::post(self->stream_.get_executor(),
                        [self, done = made(reply)] { self->write(done, self->is_kept_after(done)); });
    });
  }

  bool is_kept_after(const ViewReply& reply) const { return reply.status < 400 && parser_->keep_alive(); }

  /// The rest is the client's.
  void hand_over(const ViewRequest& request) {
    if (const auto refused = service_.rules.refusal_of(request)) return write(*refused, false);
    if (service_.live == nullptr) return write(refusal(404, "no run goes on here\n"), false);
    if (!beast::websocket::is_upgrade(parser_->get())) return write(refusal(426, "this is a WebSocket\n"), false);
    stream_.expires_never();
    service_.live->accept(stream_.release_socket(), parser_->get());
  }

  void write(const ViewReply& reply, bool keep_alive) {
    constexpr unsigned http_1_1 = 11;
    const bool parsed = parser_->is_header_done();
    kept_ = reply.kept;
    response_ = response_of(reply, parsed ? parser_->get().version() : http_1_1, keep_alive);
    const bool header_only = parsed && parser_->get().method() == http::verb::head;
    stream_.expires_after(in_ms(seconds_for(reply.body.size())));
    const auto done = [self = shared_from_this(), keep_alive](const beast::error_code& error, std::size_t) {
      self->after_write(error, keep_alive);
    };
    serializer_.emplace(*response_);
    if (header_only) return http::async_write_header(stream_, *serializer_, done);
    http::async_write(stream_, *serializer_, done);
  }

  void after_write(const beast::error_code& error, bool keep_alive) {
    if (!error && keep_alive) return read();
    beast::error_code ignored;
    stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
  }

  static constexpr std::size_t most_buffered = 16 * 1024;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{most_buffered};
  std::optional<RequestParser> parser_;
  std::optional<Response> response_;
  std::optional<http::response_serializer<http::span_body<const char>>> serializer_;
  std::shared_ptr<const void> kept_;  ///< What the response shows.
  ViewService service_;
  bool waiting_ = false;
};

bool ViewConnections::make_room(std::size_t most) {
  std::erase_if(list_, [](const auto& each) { return each.expired(); });
  if (list_.size() < most) return true;
  const auto longest = std::find_if(list_.begin(), list_.end(), [](const auto& each) {
    const auto connection = each.lock();
    return connection && connection->is_waiting();
  });
  if (longest == list_.end()) return false;
  if (const auto connection = longest->lock()) connection->close();
  list_.erase(longest);
  return true;
}

void ViewConnections::add(boost::asio::ip::tcp::socket socket, const ViewService& service) {
  if (!make_room(static_cast<std::size_t>(std::max(1, service.options.max_connections)))) return;
  const auto connection = std::make_shared<ViewConnection>(std::move(socket), service);
  list_.push_back(connection);
  connection->read();
}

}  // namespace rastro::detail
