// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/view_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cctype>
#include <mutex>
#include <random>
#include <thread>

#include "rastro/base/error.h"
#include "rastro/viewer/view_connection.h"

namespace rastro {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::uint16_t usual_port = 8420;

asio::ip::address parsed_address(const std::string& text) {
  error_code error;
  const auto address = asio::ip::make_address(text, error);
  if (error) throw Error(fmt::format("'{}' is not an address", text), "--listen", "give a number such as 192.168.1.5");
  return address;
}

void require_sound(const ViewServerOptions& options, const asio::ip::address& address) {
  const bool sound = std::all_of(options.token.begin(), options.token.end(), [](unsigned char letter) {
    return std::isalnum(letter) != 0 || letter == '-' || letter == '_';
  });
  if (!sound) throw Error("has letters that an address cannot have", "--token", "use letters, digits, '-' and '_'");
  if (!address.is_loopback() && options.token.empty())
    throw Error("is reached by other machines", "--listen " + options.address, "give a --token as well");
}

/// Throws the system's error.
void listen(tcp::acceptor& acceptor, const tcp::endpoint& endpoint) {
  if (acceptor.is_open()) acceptor.close();
  acceptor.open(endpoint.protocol());
  acceptor.set_option(asio::socket_base::reuse_address(true));
  acceptor.bind(endpoint);
  acceptor.listen();
}

}  // namespace

/// Accepts connections in its own thread; everything but stop() happens there.
class ViewServer::Listener {
 public:
  Listener(ViewServerOptions options, std::vector<NamedScene> scenes)
      : options_(std::move(options)), scenes_(std::move(scenes)), acceptor_(context_), pause_(context_) {
    const auto address = parsed_address(options_.address);
    require_sound(options_, address);
    open(address);
    rules_ = std::make_unique<detail::RequestRules>(scenes_, options_.token, address.is_loopback(), port());
    accept();
    thread_ = std::thread([this] { run(); });
  }
  ~Listener() { stop(); }

  std::uint16_t port() const { return endpoint_.port(); }

  std::string url() const {
    const auto address = endpoint_.address();
    std::string host = address.is_v6() ? "[" + address.to_string() + "]" : address.to_string();
    if (address.is_unspecified()) host = detail::name_of_machine();
    return fmt::format("http://{}:{}/{}", host, port(), options_.token.empty() ? "" : "?token=" + options_.token);
  }

  void stop() {
    std::call_once(stopped_, [this] {
      context_.stop();
      thread_.join();
    });
  }

 private:
  void open(const asio::ip::address& address) {
    try {
      try {
        listen(acceptor_, {address, options_.port.value_or(usual_port)});
      } catch (const boost::system::system_error& error) {
        if (options_.port || error.code() != asio::error::address_in_use) throw;
        listen(acceptor_, {address, 0});
      }
    } catch (const boost::system::system_error& error) {
      throw Error("cannot be listened on (" + error.code().message() + ")",
                  fmt::format("{} port {}", options_.address, options_.port.value_or(usual_port)),
                  "give another --port, or 0 for any free one");
    }
    endpoint_ = acceptor_.local_endpoint();
  }

  /// A handler that throws (no memory) costs its own connection alone.
  void run() {
    for (;;) {
      try {
        context_.run();
        return;
      } catch (const std::exception&) {
      }
    }
  }

  void accept() {
    acceptor_.async_accept([this](const error_code& error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error) return accept_later();
      accept();
      connections_.add(std::move(socket), *rules_, options_);
    });
  }

  /// Without descriptors left, to accept at once would fail at once.
  void accept_later() {
    pause_.expires_after(std::chrono::milliseconds(100));
    pause_.async_wait([this](const error_code& error) {
      if (!error) accept();
    });
  }

  ViewServerOptions options_;
  std::vector<NamedScene> scenes_;
  std::unique_ptr<detail::RequestRules> rules_;
  asio::io_context context_{1};
  detail::ViewConnections connections_;
  tcp::acceptor acceptor_;
  tcp::endpoint endpoint_;
  asio::steady_timer pause_;
  std::once_flag stopped_;
  std::thread thread_;
};

ViewServer::ViewServer(ViewServerOptions options, std::vector<NamedScene> scenes)
    : listener_(std::make_unique<Listener>(std::move(options), std::move(scenes))) {}
ViewServer::~ViewServer() = default;
std::uint16_t ViewServer::port() const { return listener_->port(); }
std::string ViewServer::url() const { return listener_->url(); }
void ViewServer::stop() { listener_->stop(); }

std::string random_token() {
  std::random_device system;
  std::string token;
  for (int k = 0; k < 4; ++k) token += fmt::format("{:08x}", system());
  return token;
}

}  // namespace rastro
