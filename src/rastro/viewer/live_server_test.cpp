// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <thread>

#include "rastro/base/random.h"
#include "rastro/base/stopwatch.h"
#include "rastro/viewer/live_page_testing.h"
#include "rastro/viewer/live_view.h"
#include "rastro/viewer/view_server.h"

namespace rastro {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

constexpr milliseconds patience(20'000);

ViewServerOptions any_port(const std::string& token = "") {
  ViewServerOptions options;
  options.port = 0;
  options.token = token;
  return options;
}

LiveHello some_run() { return {"run", "orb", 240, {LiveCommand::pause, LiveCommand::end}}; }

LiveFrame frame_of(std::int64_t index) {
  LiveFrame frame;
  frame.index = index;
  return frame;
}

void wait_for_clients(const ViewServer& server, int count) {
  const Stopwatch watch;
  while (server.clients() < count && watch.elapsed_ms() < 20e3) std::this_thread::sleep_for(milliseconds(1));
  ASSERT_EQ(server.clients(), count);
}

TEST(LiveServer, GivesAPageWhatTheRunSends) {
  ViewServer server(some_run(), any_port());
  LivePage page(server.port());
  ASSERT_TRUE(page.is_open());
  EXPECT_EQ(page.next_of("hello")["title"], "run");
  wait_for_clients(server, 1);
  server.send(frame_of(0));
  server.send(LiveImage{1, 8, 8, {1, 2}, {}});
  server.send(frame_of(1));
  server.send(LiveStatus{true, true, false, "paused"});
  server.set_scene({"run", "12345678"}, 7);
  const json first = page.next_of("frame");
  EXPECT_EQ(first["index"], 0);
  EXPECT_EQ(first["dropped"], 0);
  EXPECT_EQ(page.next_of("frame")["index"], 1);
  EXPECT_EQ(page.next_of("status")["paused"], true);
  EXPECT_EQ(page.next_of("scene")["revision"], 7);
}

TEST(LiveServer, WhoComesLaterGetsStatusAndScene) {
  ViewServer server(some_run(), any_port());
  server.send(LiveStatus{false, true, false, "runs"});
  server.set_scene({"run", "12345678"}, 9);
  LivePage page(server.port());
  EXPECT_EQ(page.next_of("hello")["method"], "orb");
  EXPECT_EQ(page.next_of("status")["line"], "runs");
  EXPECT_EQ(page.next_of("scene")["revision"], 9);
}

TEST(LiveServer, TakesCommandsAndIgnoresTheRest) {
  ViewServer server(some_run(), any_port());
  LivePage page(server.port());
  page.next_of("hello");
  page.send("nonsense");
  page.send(R"({"command":"pause"})");
  EXPECT_EQ(server.next_command(patience), LiveCommand::pause);
  page.send(R"({"command":"end"})");
  EXPECT_EQ(server.next_command(patience), LiveCommand::end);
  EXPECT_EQ(server.next_command(milliseconds(0)), std::nullopt);
  page.send(std::string(1000, ' '));
  EXPECT_EQ(page.next(), "") << "longer than any command: closed";
  EXPECT_FALSE(page.is_open());
}

TEST(LiveServer, AppliesTheRulesOfTheServer) {
  ViewServer server(some_run(), any_port("s3cret"));
  EXPECT_FALSE(LivePage(server.port()).is_open()) << "without the token";
  EXPECT_FALSE(LivePage(server.port(), "/live?token=s3cret", "http://elsewhere.example").is_open());
  EXPECT_FALSE(LivePage(server.port(), "/api/scenes?token=s3cret").is_open()) << "no WebSocket";
  EXPECT_TRUE(LivePage(server.port(), "/live?token=s3cret").is_open());
  const ViewServer without_run(any_port(), std::vector<NamedScene>{});
  EXPECT_FALSE(LivePage(without_run.port()).is_open());
}

TEST(LiveServer, AStalledPageMissesFramesAndHoldsUpNobody) {
  ViewServer server(some_run(), any_port());
  LivePage stalled(server.port()), reading(server.port());
  reading.next_of("hello");
  wait_for_clients(server, 2);
  constexpr std::int64_t count = 3000;
  LiveFrame frame = frame_of(0);
  frame.detail = std::string(20'000, 'x');  // more than the system's buffers take
  double slowest_ms = 0.0;
  for (std::int64_t k = 0; k < count; ++k) {
    frame.index = k;
    const Stopwatch watch;
    server.send(frame);
    slowest_ms = std::max(slowest_ms, watch.elapsed_ms());
    if (k % 10 == 9) {
      EXPECT_FALSE(reading.next().empty());
    }
  }
  EXPECT_LT(slowest_ms, 1000.0) << "the run never waits for a page";
  server.send(LiveStatus{false, std::nullopt, true, "over"});
  EXPECT_EQ(reading.next_of("status")["ended"], true);
  stalled.next_of("hello");
  std::int64_t frames = 0, dropped = 0;
  for (std::string text = stalled.next(); text.find("\"status\"") == std::string::npos; text = stalled.next()) {
    ASSERT_FALSE(text.empty());
    ++frames;
    dropped = json::parse(text)["dropped"];
  }
  EXPECT_GT(dropped, 0);
  EXPECT_LE(frames + dropped, count);
}

TEST(LiveServer, RefusesMoreThanThirtyTwoPages) {
  ViewServer server(some_run(), any_port());
  std::vector<std::unique_ptr<LivePage>> pages;
  for (int k = 0; k < 32; ++k) pages.push_back(std::make_unique<LivePage>(server.port()));
  wait_for_clients(server, 32);
  EXPECT_FALSE(LivePage(server.port()).is_open());
  for (const auto& page : pages) EXPECT_EQ(page->next_of("hello")["title"], "run");
}

/// Bytes of WebSocket frames that are wrong in one way or another; none is a command.
std::string malformed_message(Random& random) {
  const auto any = [&random] { return static_cast<char>(random.below(256)); };
  const std::string mask(4, '\0');  // leaves the bytes as they are
  std::string command = R"({"command":"pause"})";
  command[random.below(static_cast<std::uint32_t>(command.size()))] = any();
  if (command == R"({"command":"pause"})") command.pop_back();
  const auto length = static_cast<char>(command.size());
  switch (random.below(7)) {
    case 0:  // whole, but no command
      return std::string{'\x81', static_cast<char>(length | '\x80')} + mask + command;
    case 1:  // not masked
      return std::string{'\x81', length} + command;
    case 2:  // of an absurd length
      return std::string{'\x82', '\xff'} + std::string(8, any()) + mask + command;
    case 3:  // goes on with what never began, or has a code that is none
      return std::string{static_cast<char>(random.below(16)), static_cast<char>(length | '\x80')} + mask + command;
    case 4:  // a ping that is too long
      return std::string{'\x89', '\xfe', '\x01', '\x00'} + mask + std::string(256, any());
    case 5:  // cut
      return std::string{'\x81', static_cast<char>(length | '\x80')} + mask + command.substr(0, random.below(19));
    default: {
      std::string bytes(1 + random.below(60), ' ');
      std::generate(bytes.begin(), bytes.end(), any);
      return bytes;
    }
  }
}

TEST(LiveServer, OutlivesMalformedMessages) {
  constexpr int messages = 10'000;
  ViewServer server(some_run(), any_port());
  LivePage good(server.port());
  wait_for_clients(server, 1);
  Random random(6);
  std::optional<LivePage> page;
  for (int k = 0; k < messages; ++k) {
    if (!page || !page->is_open() || random.below(4) == 0) page.emplace(server.port());
    page->send_raw(malformed_message(random));
    if (k % 100 == 0) server.send(frame_of(k));
  }
  good.send(R"({"command":"pause"})");
  EXPECT_EQ(server.next_command(patience), LiveCommand::pause) << "the only command of all";
  EXPECT_FALSE(server.next_command(milliseconds(0)));
  for (int k = 0; k < messages; k += 100) ASSERT_EQ(good.next_of("frame")["index"], k);
}

TEST(LiveView, WorksForPagesThatWatchAlone) {
  LiveView view(any_port(), some_run(), {});
  EXPECT_FALSE(view.is_watched());
  EXPECT_FALSE(view.wants_image());
  EXPECT_FALSE(view.wants_map(0.0));
  const std::string url = view.url();
  const auto port = static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
  LivePage page(port);
  page.next_of("hello");
  const Stopwatch watch;
  while (!view.wants_image() && watch.elapsed_ms() < 20e3) std::this_thread::sleep_for(milliseconds(1));
  EXPECT_TRUE(view.wants_image());
  EXPECT_TRUE(view.wants_map(0.0));
  EXPECT_FALSE(view.wants_map(1e9)) << "copies that take so long are rare";
  SeenImage seen;
  seen.frame.image = GrayImage(640, 480);
  view.show(std::move(seen));
  EXPECT_FALSE(view.wants_image()) << "not within 0.1 s";
  auto map = std::make_shared<Map>();
  map->revision = 5;
  view.show(std::shared_ptr<const Map>(map));
  EXPECT_EQ(page.next_of("scene")["revision"], 5);
  auto last = std::make_shared<Map>();
  last->revision = 6;
  view.finish(last);
  EXPECT_EQ(page.next_of("scene")["revision"], 6);
}

TEST(LiveView, AMapThatIsForgottenIsToldToNobodyAnyMore) {
  LiveView view(any_port(), some_run(), {});
  const std::string url = view.url();
  const auto port = static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
  LivePage page(port);
  page.next_of("hello");
  const auto map_of = [](std::int64_t revision) {
    auto map = std::make_shared<Map>();
    map->revision = revision;
    return std::shared_ptr<const Map>(map);
  };
  view.show(map_of(5));
  EXPECT_EQ(page.next_of("scene")["revision"], 5);
  view.forget_map();
  view.say(LiveStatus{false, true, false, "a new map begins", 1});
  EXPECT_EQ(page.next_of("status")["resets"], 1);
  LivePage later(port);
  EXPECT_EQ(later.next_of("status")["resets"], 1);
  view.show(map_of(1));
  EXPECT_EQ(later.next_of("scene")["revision"], 1) << "not 5";
}

}  // namespace
}  // namespace rastro
