// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/request_rules.h"

#include <gtest/gtest.h>

#include "rastro/viewer/http_message.h"
#include "rastro/viewer/page.h"

namespace rastro::detail {
namespace {

const std::vector<NamedScene> scenes = {{"kitchen", "bytes of the kitchen"}, {"office \xff", "1234"}};

ViewRequest get(const std::string& target, const std::string& host = "localhost:8420") {
  return {"GET", target, {host}, "", ""};
}

TEST(RequestRules, ServesPageListAndScenes) {
  const RequestRules rules(scenes, "", true, 8420);
  const ViewReply page = rules.reply_to(get("/"));
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, viewer_page());
  ASSERT_EQ(page.fields.size(), 1U);
  EXPECT_EQ(page.fields[0].first, "Content-Security-Policy");
  EXPECT_NE(page.fields[0].second.find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(
      rules.reply_to(get("/api/scenes")).body,
      "[{\"index\":0,\"name\":\"kitchen\",\"bytes\":20},{\"index\":1,\"name\":\"office \xEF\xBF\xBD\",\"bytes\":4}]");
  EXPECT_EQ(rules.reply_to(get("/api/scene/0")).body, "bytes of the kitchen");
  EXPECT_EQ(rules.reply_to(get("/api/scene/1?x=y")).body, "1234");
}

TEST(RequestRules, MeasuresWhereThereIsAMap) {
  std::vector<NamedScene> both = {{"kitchen", "k"}, {"office", "o"}};
  both[1].measure = [](std::string_view query) { return "{\"asked\":\"" + std::string(query) + "\"}"; };
  const RequestRules rules(both, "", true, 8420);
  EXPECT_NE(rules.reply_to(get("/api/scenes")).body.find(R"("bytes":1,"measures":true)"), std::string::npos);
  EXPECT_EQ(made(rules.reply_to(get("/api/measure/1?kind=edges"))).body, R"({"asked":"kind=edges"})");
  for (const char* target :
       {"/api/measure/0", "/api/measure/2", "/api/measure/", "/api/measure/1/", "/api/measure/../1"})
    EXPECT_EQ(rules.reply_to(get(target)).status, 404) << target;
}

TEST(RequestRules, ServesNothingElse) {
  const RequestRules rules(scenes, "", true, 8420);
  for (const char* target :
       {"", "/..", "/../etc/passwd", "/api/scene/../../etc/passwd", "/api/scene/2", "/api/scene/-1", "/api/scene/",
        "/api/scene/0x0", "/api/scene/ 0", "/api/scene/0/", "/api/scene/99999999999999999999", "/api/scenes/", "//",
        "/%2e%2e/etc/passwd", "http://localhost/", "*", "/favicon.ico", "/etc/passwd"})
    EXPECT_EQ(rules.reply_to(get(target)).status, 404) << target;
  EXPECT_EQ(rules.reply_to(get("/" + std::string(5000, 'a'))).status, 414);
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "get", "TRACE"}) {
    ViewRequest request = get("/");
    request.method = method;
    EXPECT_EQ(rules.reply_to(request).status, 405) << method;
  }
}

TEST(RequestRules, RefusesOtherHosts) {
  const RequestRules here(scenes, "", true, 8420), everywhere(scenes, "secret", false, 8420);
  for (const char* host : {"localhost", "localhost:9000", "127.0.0.1:8420", "[::1]:8420", "[::1]"})
    EXPECT_EQ(here.reply_to(get("/", host)).status, 200) << host;
  for (const char* host :
       {"", "evil.example:8420", "localhost.evil.example", "192.168.1.5:8420", "[::1", "127.0.0.1.evil.example"})
    EXPECT_EQ(here.reply_to(get("/", host)).status, 403) << host;
  EXPECT_EQ(everywhere.reply_to(get("/?token=secret", "192.168.1.5:8420")).status, 200);
  EXPECT_EQ(everywhere.reply_to(get("/?token=secret", "[fe80::1]:8420")).status, 200);
  EXPECT_EQ(everywhere.reply_to(get("/?token=secret", "evil.example")).status, 403);
  ViewRequest none = get("/"), two = get("/");
  none.hosts.clear(), two.hosts.emplace_back("evil.example");
  EXPECT_EQ(here.reply_to(none).status, 403);
  EXPECT_EQ(here.reply_to(two).status, 403);
}

TEST(RequestRules, RefusesOtherOrigins) {
  const RequestRules rules(scenes, "", true, 8420);
  ViewRequest request = get("/api/scenes");
  request.origin = "http://localhost:8420";
  EXPECT_EQ(rules.reply_to(request).status, 200);
  for (const char* origin : {"http://evil.example", "null", "http://localhost:9999", "https://localhost:8420"}) {
    request.origin = origin;
    EXPECT_EQ(rules.reply_to(request).status, 403) << origin;
  }
}

TEST(RequestRules, AsksForTheToken) {
  const RequestRules rules(scenes, "s3cret", false, 8420);
  for (const char* target : {"/", "/?token=", "/?token=s3cre", "/?token=s3crets3cret", "/?token=S3CRET",
                             "/?nottoken=s3cret", "/api/scenes", "/api/scene/0", "/?token", "/nothing"})
    EXPECT_EQ(rules.reply_to(get(target)).status, 401) << target;
  const ViewReply page = rules.reply_to(get("/?a=b&token=s3cret"));
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.fields.back(), (std::pair<std::string, std::string>{
                                    "Set-Cookie", "rastro_8420=s3cret; Path=/; HttpOnly; SameSite=Strict"}));
  ViewRequest later = get("/api/scene/0");
  later.cookie = "other=1; rastro_8420=s3cret";
  EXPECT_EQ(rules.reply_to(later).status, 200);
  for (const char* cookie : {"rastro_8421=s3cret", "rastro_8420=wrong", "rastro_8420", "xrastro_8420=s3cret"}) {
    later.cookie = cookie;
    EXPECT_EQ(rules.reply_to(later).status, 401) << cookie;
  }
}

TEST(RequestRules, ReadsRequestsFromBytes) {
  const RequestRules rules(scenes, "", true, 8420);
  const auto status = [&](const std::string& bytes) {
    const auto reply = reply_to_bytes(rules, bytes);
    return reply ? reply->status : 0;
  };
  EXPECT_EQ(status("GET /api/scenes HTTP/1.1\r\nHost: localhost\r\n\r\n"), 200);
  EXPECT_EQ(status("HEAD / HTTP/1.0\r\nHost: localhost\r\n\r\n"), 200);
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: localhost\r\n"), 0) << "there may be more to come";
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: localhost\r\nHost: evil\r\n\r\n"), 403);
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: localhost\r\nOrigin: http://evil\r\n\r\n"), 403);
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\nhello"), 413);
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"), 413);
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: localhost\r\nX: " + std::string(20'000, 'x') + "\r\n\r\n"), 431);
  EXPECT_EQ(status("\x16\x03\x01 TLS hello\r\n\r\n"), 400);
  EXPECT_EQ(status("GET / FTP/1.1\r\n\r\n"), 400);
}

}  // namespace
}  // namespace rastro::detail
