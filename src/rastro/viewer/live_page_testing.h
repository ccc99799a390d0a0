// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

namespace rastro {

/// A page for tests: a WebSocket of /live, read message by message.
class LivePage {
 public:
  explicit LivePage(std::uint16_t port, const std::string& target = "/live", const std::string& origin = "") {
    const std::string host = "127.0.0.1:" + std::to_string(port);
    boost::beast::get_lowest_layer(socket_).connect({boost::asio::ip::address_v4::loopback(), port});
    if (!origin.empty()) {
      socket_.set_option(
          boost::beast::websocket::stream_base::decorator([origin](boost::beast::websocket::request_type& request) {
            request.set(boost::beast::http::field::origin, origin);
          }));
    }
    socket_.handshake(host, target, error_);
  }
  bool is_open() const { return !error_; }
  /// The next one; the socket waits without end, as the tests' time limit does not.
  std::string next() {
    boost::beast::flat_buffer buffer;
    socket_.read(buffer, error_);
    return error_ ? "" : boost::beast::buffers_to_string(buffer.data());
  }
  nlohmann::json next_of(const std::string& type) {
    for (;;) {
      const std::string text = next();
      if (error_) return {};
      if (!socket_.got_text()) continue;
      nlohmann::json message = nlohmann::json::parse(text);
      if (message["type"] == type) return message;
    }
  }
  nlohmann::json next_text() {
    for (;;) {
      const std::string text = next();
      if (error_) return {};
      if (socket_.got_text()) return nlohmann::json::parse(text);
    }
  }
  /// Header of the next block.
  nlohmann::json next_block() {
    for (;;) {
      const std::string bytes = next();
      if (error_) return {};
      if (socket_.got_text()) continue;
      std::uint32_t length = 0;
      std::memcpy(&length, bytes.data(), sizeof length);
      return nlohmann::json::parse(bytes.substr(4, length));
    }
  }
  void send(const std::string& text) { socket_.write(boost::asio::buffer(text), error_); }
  /// Bytes beside the protocol.
  void send_raw(const std::string& bytes) {
    boost::asio::write(socket_.next_layer(), boost::asio::buffer(bytes), error_);
  }

 private:
  boost::asio::io_context context_;
  boost::beast::websocket::stream<boost::asio::ip::tcp::socket> socket_{context_};
  boost::beast::error_code error_;
};

}  // namespace rastro
