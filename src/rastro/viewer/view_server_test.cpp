// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/view_server.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <thread>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/base/stopwatch.h"
#include "rastro/viewer/page.h"

namespace rastro {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr int patience_ms = 20'000;

/// A client that sends what it is told.
class Client {
 public:
  explicit Client(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  ~Client() { ::close(socket_); }

  bool connected() const { return connected_; }
  void send(std::string_view bytes) const { ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  void end() const { ::shutdown(socket_, SHUT_WR); }
  /// Until the server closes; nullopt where it does not within `ms`.
  std::optional<std::string> all(int ms = patience_ms) const {
    std::string text;
    char piece[65536];
    for (;;) {
      pollfd wait{socket_, POLLIN, 0};
      if (::poll(&wait, 1, ms) <= 0) return std::nullopt;
      const ssize_t count = ::recv(socket_, piece, sizeof piece, 0);
      if (count <= 0) return text;
      text.append(piece, static_cast<std::size_t>(count));
    }
  }

 private:
  int socket_;
  bool connected_ = false;
};

ViewServerOptions any_port() {
  ViewServerOptions options;
  options.port = 0;
  return options;
}

std::vector<NamedScene> two_scenes() { return {{"kitchen", std::string(3'000'000, 'k')}, {"office", "1234"}}; }

std::vector<NamedScene> no_scenes() { return {}; }

std::string reply_of(const ViewServer& server, const std::string& first_line, const std::string& fields = "") {
  const Client client(server.port());
  client.send(first_line + " HTTP/1.1\r\nHost: localhost:" + std::to_string(server.port()) +
              "\r\nConnection: close\r\n" + fields + "\r\n");
  return client.all().value_or("no end");
}

std::string body_in(const std::string& reply) {
  return reply.substr(std::min(reply.size(), reply.find("\r\n\r\n") + 4));
}

TEST(ViewServer, AnswersOverLoopback) {
  const ViewServer server(any_port(), two_scenes());
  const std::string page = reply_of(server, "GET /");
  EXPECT_THAT(page, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(page.substr(0, 2000), HasSubstr("Content-Security-Policy: default-src 'none'"));
  EXPECT_THAT(page.substr(0, 2000), HasSubstr("X-Content-Type-Options: nosniff"));
  EXPECT_EQ(body_in(page), viewer_page());
  EXPECT_EQ(body_in(reply_of(server, "GET /api/scene/0")), two_scenes()[0].bytes);
  EXPECT_THAT(reply_of(server, "GET /api/scenes"), HasSubstr("\"name\":\"office\",\"bytes\":4"));
  const std::string head = reply_of(server, "HEAD /api/scene/0");
  EXPECT_THAT(head, HasSubstr("Content-Length: 3000000\r\n"));
  EXPECT_EQ(body_in(head), "");
  EXPECT_THAT(reply_of(server, "GET /etc/passwd"), StartsWith("HTTP/1.1 404 "));
  EXPECT_THAT(reply_of(server, "POST /", "Content-Length: 1\r\n"), StartsWith("HTTP/1.1 413 "));
  EXPECT_THAT(reply_of(server, "DELETE /"), StartsWith("HTTP/1.1 405 "));
  EXPECT_EQ(server.url(), "http://127.0.0.1:" + std::to_string(server.port()) + "/");
}

TEST(ViewServer, KeepsAConnectionForSeveralRequests) {
  const ViewServer server(any_port(), two_scenes());
  const Client client(server.port());
  const std::string request = "GET /api/scene/1 HTTP/1.1\r\nHost: localhost\r\n\r\n";
  client.send(request + request);
  client.end();
  const std::string replies = client.all().value_or("no end");
  EXPECT_THAT(replies, HasSubstr("1234HTTP/1.1 200 OK"));
  EXPECT_THAT(replies, ::testing::EndsWith("1234"));
}

TEST(ViewServer, MeasuresAndReadsBesideOtherRequests) {
  std::promise<void> go;
  const std::shared_future<void> gone = go.get_future().share();
  std::vector<NamedScene> scenes = two_scenes();
  scenes[1].measure = [gone](std::string_view) { return gone.wait(), std::string("measured"); };
  scenes[1].frame_block = [](std::int64_t frame) { return "frame " + std::to_string(frame); };
  scenes[1].tile_block = [](std::uint64_t layer, std::uint64_t tile) -> std::optional<std::string> {
    return layer == 0 && tile < 9 ? std::optional("tile " + std::to_string(tile)) : std::nullopt;
  };
  const ViewServer server(any_port(), scenes);
  const Client measuring(server.port());
  measuring.send("GET /api/measure/1 HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  // All of these are answered before the measurement is, which waits for them.
  EXPECT_EQ(body_in(reply_of(server, "GET /api/scene/1")), "1234");
  EXPECT_EQ(body_in(reply_of(server, "GET /api/tile/1/0/8")), "tile 8");
  EXPECT_EQ(body_in(reply_of(server, "GET /api/frame/1/3")), "frame 3");
  for (const char* none : {"/api/tile/1/0/9", "/api/tile/1/1/0", "/api/tile/0/0/0", "/api/tile/1/0", "/api/tile/1/0/-1",
                           "/api/tile/1/0/../x"})
    EXPECT_THAT(reply_of(server, std::string("GET ") + none), StartsWith("HTTP/1.1 404 ")) << none;
  go.set_value();
  EXPECT_EQ(body_in(measuring.all().value_or("no end")), "measured");
}

TEST(ViewServer, StopsWhileMeasurementsWait) {
  std::vector<NamedScene> scenes = two_scenes();
  std::promise<void> begun;
  std::atomic<int> measured = 0;
  scenes[0].measure = [&](std::string_view) {
    if (measured++ == 0) begun.set_value();
    return std::string(100, 'm');
  };
  ViewServer server(any_port(), scenes);
  std::vector<std::unique_ptr<Client>> clients;
  for (int k = 0; k < 20; ++k) {
    clients.push_back(std::make_unique<Client>(server.port()));
    clients.back()->send("GET /api/measure/0 HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  begun.get_future().wait();
  server.stop();
  const int done = measured;
  EXPECT_LE(done, 20);
  for (const auto& each : clients) EXPECT_TRUE(each->connected());
}

TEST(ViewServer, AsksForHostAndToken) {
  ViewServerOptions options = any_port();
  options.token = "s3cret";
  const ViewServer server(options, two_scenes());
  EXPECT_THAT(reply_of(server, "GET /api/scene/1"), StartsWith("HTTP/1.1 401 "));
  EXPECT_THAT(reply_of(server, "GET /api/scene/1?token=wrong"), StartsWith("HTTP/1.1 401 "));
  EXPECT_EQ(body_in(reply_of(server, "GET /api/scene/1?token=s3cret")), "1234");
  EXPECT_THAT(server.url(), ::testing::EndsWith("/?token=s3cret"));
  const std::string cookie = "Cookie: rastro_" + std::to_string(server.port()) + "=s3cret\r\n";
  EXPECT_EQ(body_in(reply_of(server, "GET /api/scene/1", cookie)), "1234");
  const Client elsewhere(server.port());
  elsewhere.send("GET /?token=s3cret HTTP/1.1\r\nHost: evil.example\r\n\r\n");
  EXPECT_THAT(elsewhere.all().value_or("no end"), StartsWith("HTTP/1.1 403 "));
}

TEST(ViewServer, RefusesOptionsThatAreUnsafe) {
  const auto refused = [](const char* address, const char* token) {
    ViewServerOptions options = any_port();
    options.address = address, options.token = token;
    try {
      const ViewServer server(options, no_scenes());
      return std::string("accepted");
    } catch (const Error& error) {
      return std::string(error.what());
    }
  };
  EXPECT_THAT(refused("0.0.0.0", ""), HasSubstr("--token"));
  EXPECT_THAT(refused("::", ""), HasSubstr("--token"));
  EXPECT_THAT(refused("here", ""), HasSubstr("is not an address"));
  EXPECT_THAT(refused("203.0.113.7", "t"), HasSubstr("cannot be listened on"));
  EXPECT_THAT(refused("127.0.0.1", "a b"), HasSubstr("letters"));
  const ViewServer first(any_port(), no_scenes());
  ViewServerOptions taken;
  taken.port = first.port();
  EXPECT_THROW(ViewServer(taken, no_scenes()), Error);
}

TEST(ViewServer, TakesAnotherPortWhereTheUsualOneIsTaken) {
  const ViewServer first({}, no_scenes()), second({}, no_scenes());
  EXPECT_NE(first.port(), second.port());
  EXPECT_THAT(reply_of(second, "GET /api/scenes"), StartsWith("HTTP/1.1 200 "));
}

/// Requests cut, doubled, mixed and with random bytes in them.
std::string malformed_request(Random& random) {
  static const std::string right =
      "GET /api/scene/0 HTTP/1.1\r\nHost: localhost\r\nConnection: keep-alive\r\nCookie: a=b; c\r\n\r\n";
  std::string bytes =
      random.uniform() < 0.2 ? std::string(static_cast<std::size_t>(random.uniform(0.0, 300.0)), 'x') : right;
  const int changes = 1 + static_cast<int>(random.uniform(0.0, 12.0));
  for (int k = 0; k < changes && !bytes.empty(); ++k) {
    const auto at = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(bytes.size())));
    const double what = random.uniform();
    if (what < 0.5)
      bytes[at] = static_cast<char>(random.next());
    else if (what < 0.7)
      bytes.erase(at);
    else if (what < 0.9)
      bytes.insert(at, bytes.substr(0, at));
    else
      bytes.insert(at, 9000, 'y');
  }
  return bytes.substr(0, 30'000);
}

TEST(ViewServer, OutlivesMalformedRequests) {
  constexpr int requests = 10'000;
  ViewServerOptions options = any_port();
  options.request_seconds = 1.0;
  const ViewServer server(options, {{"small", "1234"}});
  Random random(3);
  const Stopwatch watch;
  for (int k = 0; k < requests; ++k) {
    const Client client(server.port());
    ASSERT_TRUE(client.connected()) << k;
    client.send(malformed_request(random));
    if (k % 16 != 0) continue;  // most go away at once, some wait for an end
    client.end();
    ASSERT_TRUE(client.all()) << k;
  }
  EXPECT_THAT(reply_of(server, "GET /api/scene/0"), StartsWith("HTTP/1.1 200 "));
}

TEST(ViewServer, ServesOthersWhileClientsStall) {
  ViewServerOptions options = any_port();
  options.max_connections = 8;
  const ViewServer server(options, two_scenes());
  std::vector<std::unique_ptr<Client>> stalled;
  for (int k = 0; k < 40; ++k) {
    stalled.push_back(std::make_unique<Client>(server.port()));
    stalled.back()->send(k % 2 == 0 ? "GET /api/scene/0 HTTP/1.1\r\nHost: loc" : "");
  }
  EXPECT_EQ(body_in(reply_of(server, "GET /api/scene/1")), "1234");
}

TEST(ViewServer, ClosesConnectionsThatDoNotEndTheirRequest) {
  ViewServerOptions options = any_port();
  options.request_seconds = 0.2;
  const ViewServer server(options, two_scenes());
  const Client stalled(server.port());
  stalled.send("GET /api/scene/0 HTTP/1.1\r\nHost: loc");
  EXPECT_EQ(stalled.all(5'000), "") << "closed, without an answer";
}

TEST(ViewServer, StopsWithOpenConnectionsFromSeveralThreads) {
  ViewServer server(any_port(), two_scenes());
  const std::uint16_t port = server.port();
  const Client stalled(port), reading(port);
  reading.send("GET /api/scene/0 HTTP/1.1\r\nHost: localhost\r\n\r\n");
  Stopwatch watch;
  {
    std::vector<std::jthread> threads;
    for (int k = 0; k < 4; ++k) threads.emplace_back([&server] { server.stop(); });
  }
  EXPECT_LT(watch.lap_ms(), 2'000.0);
  server.stop();
}

TEST(ViewServer, FreesThePortAtItsEnd) {
  auto server = std::make_unique<ViewServer>(any_port(), two_scenes());
  ViewServerOptions again;
  again.port = server->port();
  server.reset();
  EXPECT_FALSE(Client(*again.port).connected());
  EXPECT_EQ(ViewServer(again, no_scenes()).port(), *again.port);
}

TEST(RandomToken, IsLongAndNew) {
  const std::string token = random_token();
  EXPECT_EQ(token.size(), 32U);
  EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(token, random_token());
}

}  // namespace
}  // namespace rastro
