// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/view_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
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
  using LiveMessage = detail::LiveMessage;

  Listener(ViewServerOptions options, std::vector<NamedScene> scenes, const LiveHello* run)
      : options_(std::move(options)), acceptor_(context_), pause_(context_) {
    const auto address = parsed_address(options_.address);
    require_sound(options_, address);
    open(address);
    rules_.emplace(std::move(scenes), options_.token, address.is_loopback(), port());
    if (run != nullptr) {
      live_.emplace(message(LiveMessage::Kind::hello, message_of(*run)), inbox_);
      rules_->set_live(true);
    }
    accept();
    thread_ = std::thread([this] { this->run(); });
  }
  ~Listener() { stop(); }

  std::uint16_t port() const { return endpoint_.port(); }

  std::string url() const {
    const auto address = endpoint_.address();
    std::string host = address.is_v6() ? "[" + address.to_string() + "]" : address.to_string();
    if (address.is_unspecified()) host = detail::name_of_machine();
    return fmt::format("http://{}:{}/{}", host, port(), options_.token.empty() ? "" : "?token=" + options_.token);
  }

  void send(LiveMessage::Kind kind, std::string text) {
    // A thread that gets no time must not be given more and more to do.
    constexpr int most_posted = 1000;
    const bool can_be_missed = kind == LiveMessage::Kind::frame || kind == LiveMessage::Kind::image;
    if (posted_ >= most_posted && can_be_missed) return;
    post([this, sent = message(kind, std::move(text))] { live_->send(sent); });
  }

  void end_live() {
    post([this] { rules_->set_live(false); });
  }

  void set_scene(NamedScene scene, std::int64_t revision) {
    post([this, scene = std::move(scene), sent = message(LiveMessage::Kind::scene, scene_message(revision))]() mutable {
      rules_->set_scene(std::move(scene));
      live_->send(sent);
    });
  }

  void forget_scene(std::string name) {
    post([this, name = std::move(name)]() mutable {
      rules_->set_scene({std::move(name), ""});
      live_->forget_scene();
    });
  }

  int clients() const { return live_ ? live_->count() : 0; }
  detail::LiveInbox& inbox() { return inbox_; }

  void stop() {
    std::call_once(stopped_, [this] {
      context_.stop();
      thread_.join();
      workers_.stop();
    });
  }

 private:
  static LiveMessage message(LiveMessage::Kind kind, std::string text) {
    return {kind, std::make_shared<const std::string>(std::move(text))};
  }

  template <typename Work>
  void post(Work work) {
    ++posted_;
    asio::post(context_, [this, work = std::move(work)]() mutable {
      --posted_;
      work();
    });
  }

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
      connections_.add(std::move(socket), {options_, *rules_, workers_, live_ ? &*live_ : nullptr});
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
  std::optional<detail::RequestRules> rules_;
  detail::LiveInbox inbox_;
  std::atomic<int> posted_ = 0;
  asio::io_context context_{1};
  std::optional<detail::LiveClients> live_;
  detail::ViewConnections connections_;
  tcp::acceptor acceptor_;
  tcp::endpoint endpoint_;
  asio::steady_timer pause_;
  detail::ReplyWorkers workers_;  // Goes before the context: what waits there holds connections.
  std::once_flag stopped_;
  std::thread thread_;
};

ViewServer::ViewServer(ViewServerOptions options, std::vector<NamedScene> scenes)
    : listener_(std::make_unique<Listener>(std::move(options), std::move(scenes), nullptr)) {}
ViewServer::ViewServer(const LiveHello& run, ViewServerOptions options)
    : listener_(std::make_unique<Listener>(std::move(options), std::vector<NamedScene>{{run.title, ""}}, &run)) {}
ViewServer::~ViewServer() = default;
std::uint16_t ViewServer::port() const { return listener_->port(); }
std::string ViewServer::url() const { return listener_->url(); }
void ViewServer::stop() { listener_->stop(); }

void ViewServer::send(const LiveFrame& frame) {
  if (clients() > 0) listener_->send(detail::LiveMessage::Kind::frame, message_of(frame));
}
void ViewServer::send(const LiveImage& image) {
  if (clients() > 0) listener_->send(detail::LiveMessage::Kind::image, block_of(image));
}
void ViewServer::send(const LivePlace& place) {
  if (clients() > 0) listener_->send(detail::LiveMessage::Kind::place, block_of(place));
}
void ViewServer::send(const LiveStatus& status) {
  if (status.ended) listener_->end_live();
  listener_->send(detail::LiveMessage::Kind::status, message_of(status));
}
void ViewServer::send(const LiveCalibration& calibration) {
  listener_->send(detail::LiveMessage::Kind::calibration, message_of(calibration));
}
void ViewServer::set_scene(NamedScene scene, std::int64_t revision) {
  listener_->set_scene(std::move(scene), revision);
}
void ViewServer::forget_scene(std::string name) { listener_->forget_scene(std::move(name)); }
int ViewServer::clients() const { return listener_->clients(); }
std::optional<LiveCommand> ViewServer::next_command(std::chrono::milliseconds at_most) {
  return listener_->inbox().take(at_most);
}

std::string random_token() {
  std::random_device system;
  std::string token;
  for (int k = 0; k < 4; ++k) token += fmt::format("{:08x}", system());
  return token;
}

}  // namespace rastro
