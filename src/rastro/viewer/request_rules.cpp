// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/request_rules.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "rastro/base/text.h"
#include "rastro/viewer/block_writer.h"
#include "rastro/viewer/page.h"

namespace rastro::detail {
namespace {

constexpr std::size_t longest_target = 1024;

/// Takes as long for a wrong token as for the right one, so that time tells nothing of it.
bool is_same(std::string_view a, std::string_view b) {
  unsigned difference = a.size() == b.size() ? 0U : 1U;
  for (std::size_t k = 0; k < a.size(); ++k)
    difference |= static_cast<unsigned char>(a[k]) ^ static_cast<unsigned char>(b.empty() ? '\0' : b[k % b.size()]);
  return difference == 0;
}

/// The value of `name` in "a=1&b=2" or "a=1; b=2"; empty where there is none.
std::string_view value_of(std::string_view name, std::string_view text, char separator) {
  for (const std::string_view part : split(text, separator))
    if (part.size() > name.size() && part.starts_with(name) && part[name.size()] == '=')
      return part.substr(name.size() + 1);
  return {};
}

struct Target {
  std::string_view path, query;
};

Target parts_of(std::string_view target) {
  const std::size_t mark = target.find('?');
  if (mark == std::string_view::npos) return {target, {}};
  return {target.substr(0, mark), target.substr(mark + 1)};
}

/// "[::1]:8420" -> "::1", "localhost:8420" -> "localhost"; empty for what is no host.
std::string_view name_in(std::string_view host) {
  if (host.starts_with('[')) {
    const std::size_t end = host.find(']');
    return end == std::string_view::npos ? std::string_view() : host.substr(1, end - 1);
  }
  return host.substr(0, host.find(':'));
}

/// Browsers write hosts so.
std::string in_lower_case(std::string_view text) {
  std::string lower(text);
  for (char& each : lower) each = each >= 'A' && each <= 'Z' ? static_cast<char>(each - 'A' + 'a') : each;
  return lower;
}

bool is_numeric_address(std::string_view name) {
  std::array<unsigned char, sizeof(in6_addr)> ignored{};
  const std::string text(name);
  return inet_pton(AF_INET, text.c_str(), ignored.data()) == 1 ||
         inet_pton(AF_INET6, text.c_str(), ignored.data()) == 1;
}

/// What the page may do: run its own script, show images it made, and talk to this server.
constexpr const char* content_policy =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; media-src blob:; "
    "worker-src blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Digits alone; nullopt for anything else.
std::optional<std::uint64_t> number_in(std::string_view text) {
  const bool digits = std::all_of(text.begin(), text.end(), [](char each) { return each >= '0' && each <= '9'; });
  return digits ? parse_uint64(text) : std::nullopt;
}

/// "1/2" -> 1 and 2, where `count` is 2; nullopt for anything else.
template <std::size_t count>
std::optional<std::array<std::uint64_t, count>> numbers_in(std::string_view text) {
  const auto parts = split(text, '/');
  if (parts.size() != count) return std::nullopt;
  std::array<std::uint64_t, count> numbers{};
  for (std::size_t k = 0; k < count; ++k) {
    const auto number = number_in(parts[k]);
    if (!number) return std::nullopt;
    numbers[k] = *number;
  }
  return numbers;
}

ViewReply content(std::string_view type, std::string body) {
  const auto kept = std::make_shared<const std::string>(std::move(body));
  ViewReply reply;
  reply.type = type;
  reply.body = *kept;
  reply.kept = kept;
  return reply;
}

constexpr std::string_view binary = "application/octet-stream";

}  // namespace

std::string name_of_machine() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : std::string("localhost");
}

ViewReply refusal(int status, std::string_view line) {
  ViewReply reply;
  reply.status = status;
  reply.body = line;
  return reply;
}

RequestRules::RequestRules(std::vector<NamedScene> scenes, std::string token, bool loopback_only, std::uint16_t port)
    : token_(std::move(token)),
      cookie_name_(fmt::format("rastro_{}", port)),  // cookies of one host are shared by all its ports
      machine_(in_lower_case(name_of_machine())),
      loopback_only_(loopback_only) {
  for (NamedScene& scene : scenes) scenes_.push_back(std::make_shared<const NamedScene>(std::move(scene)));
  make_list();
}

void RequestRules::make_list() {
  auto list = nlohmann::ordered_json::array();
  for (std::size_t index = 0; index < scenes_.size(); ++index) {
    list.push_back({{"index", index}, {"name", scenes_[index]->name}, {"bytes", scenes_[index]->bytes.size()}});
    if (live_) list.back()["live"] = true;
    if (scenes_[index]->measure) list.back()["measures"] = true;
    if (scenes_[index]->frame_block) list.back()["frames"] = true;
  }
  list_ = std::make_shared<const std::string>(text_of(list));
}

void RequestRules::set_live(bool live) {
  live_ = live;
  make_list();
}

void RequestRules::set_scene(NamedScene scene) {
  scenes_.resize(std::max<std::size_t>(1, scenes_.size()));
  scenes_.front() = std::make_shared<const NamedScene>(std::move(scene));
  make_list();
}

bool RequestRules::asks_for_messages(const ViewRequest& request) { return parts_of(request.target).path == "/live"; }

/// A page elsewhere can have its name lead to this machine, but cannot make a browser call it localhost or a number.
bool RequestRules::is_host_allowed(std::string_view host) const {
  const std::string_view name = name_in(host);
  if (name == "localhost" || name == "127.0.0.1" || name == "::1") return true;
  return !loopback_only_ && !name.empty() && (in_lower_case(name) == machine_ || is_numeric_address(name));
}

bool RequestRules::has_token(const ViewRequest& request) const {
  if (token_.empty()) return true;
  return is_same(value_of("token", parts_of(request.target).query, '&'), token_) ||
         is_same(value_of(cookie_name_, request.cookie, ';'), token_);
}

ViewReply RequestRules::content_at(std::string_view path) const {
  constexpr std::string_view scene_path = "/api/scene/", frame_path = "/api/frame/", tile_path = "/api/tile/";
  ViewReply reply;
  if (path == "/") {
    reply.type = "text/html; charset=utf-8";
    reply.body = viewer_page();
    reply.fields = {{"Content-Security-Policy", content_policy}};
    return reply;
  }
  if (path == "/api/scenes") {
    reply.type = "application/json";
    reply.body = *list_;
    reply.kept = list_;
    return reply;
  }
  if (path.starts_with(frame_path)) return frame_at(path.substr(frame_path.size()));
  if (path.starts_with(tile_path)) return tile_at(path.substr(tile_path.size()));
  if (!path.starts_with(scene_path)) return refusal(404, "there is nothing here\n");
  return scene_at(path.substr(scene_path.size()));
}

/// "SCENE/FRAME"
ViewReply RequestRules::frame_at(std::string_view text) const {
  constexpr std::uint64_t most_frames = 1'000'000'000;
  const auto numbers = numbers_in<2>(text);
  if (!numbers || (*numbers)[0] >= scenes_.size() || (*numbers)[1] >= most_frames)
    return refusal(404, "there is no such frame\n");
  const auto& source = scenes_[static_cast<std::size_t>((*numbers)[0])];
  if (!source->frame_block) return refusal(404, "there are no frames here\n");
  ViewReply reply;
  reply.slow = ViewReply::Slow::reading;
  reply.make = [source, frame = static_cast<std::int64_t>((*numbers)[1])] {
    return content(binary, source->frame_block(frame));
  };
  return reply;
}

/// "SCENE/LAYER/TILE"
ViewReply RequestRules::tile_at(std::string_view text) const {
  const auto numbers = numbers_in<3>(text);
  if (!numbers || (*numbers)[0] >= scenes_.size()) return refusal(404, "there is no such tile\n");
  const auto& source = scenes_[static_cast<std::size_t>((*numbers)[0])];
  auto block = source->tile_block ? source->tile_block((*numbers)[1], (*numbers)[2]) : std::nullopt;
  return block ? content(binary, *std::move(block)) : refusal(404, "there is no such tile\n");
}

ViewReply RequestRules::scene_at(std::string_view number) const {
  ViewReply reply;
  const auto index = number_in(number);
  if (!index || *index >= scenes_.size()) return refusal(404, "there is no such scene\n");
  const auto& scene = scenes_[static_cast<std::size_t>(*index)];
  if (scene->bytes.empty()) return refusal(404, "there is no map yet\n");
  reply.type = binary;
  reply.body = scene->bytes;
  reply.kept = scene;
  return reply;
}

ViewReply RequestRules::measured_at(std::string_view number, std::string_view query) const {
  const auto index = parse_uint64(number);
  if (!index || *index >= scenes_.size()) return refusal(404, "there is no such scene\n");
  const auto& scene = scenes_[static_cast<std::size_t>(*index)];
  if (!scene->measure) return refusal(404, "there is no map to measure in\n");
  ViewReply reply;
  reply.slow = ViewReply::Slow::measuring;
  reply.make = [scene, asked = std::string(query)] { return content("application/json", scene->measure(asked)); };
  return reply;
}

ViewReply made(const ViewReply& reply) {
  if (!reply.make) return reply;
  try {
    return reply.make();
  } catch (const std::exception&) {  // the file may have gone in the meantime
    return refusal(404, "this cannot be read; 'rastro check' lists what is wrong\n");
  }
}

std::optional<ViewReply> RequestRules::refusal_of(const ViewRequest& request) const {
  if (request.hosts.size() != 1 || !is_host_allowed(request.hosts.front()))
    return refusal(403, "this host is not served: use the address that rastro view printed\n");
  if (!request.origin.empty() && request.origin != "http://" + request.hosts.front())
    return refusal(403, "other sites are not served\n");
  if (request.method != "GET" && request.method != "HEAD") {
    ViewReply reply = refusal(405, "only GET and HEAD are served\n");
    reply.fields = {{"Allow", "GET, HEAD"}};
    return reply;
  }
  if (request.target.size() > longest_target) return refusal(414, "the address is too long\n");
  if (!has_token(request))
    return refusal(401, "the token is missing or wrong: use the address that rastro view printed\n");
  return std::nullopt;
}

ViewReply RequestRules::reply_to(const ViewRequest& request) const {
  if (auto refused = refusal_of(request)) return *std::move(refused);
  constexpr std::string_view measure_path = "/api/measure/";
  const Target target = parts_of(request.target);
  if (target.path.starts_with(measure_path)) return measured_at(target.path.substr(measure_path.size()), target.query);
  ViewReply reply = content_at(target.path);
  // What the page asks for later carries the cookie; scripts cannot read it, other sites cannot send it.
  if (!token_.empty() && target.path == "/")
    reply.fields.emplace_back("Set-Cookie", cookie_name_ + "=" + token_ + "; Path=/; HttpOnly; SameSite=Strict");
  return reply;
}

}  // namespace rastro::detail
