// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rastro/viewer/scene.h"

namespace rastro::detail {

/// What counts of a request, as it was sent.
struct ViewRequest {
  std::string method, target;
  std::vector<std::string> hosts;  ///< Values of all Host fields.
  std::string origin, cookie;      ///< Empty: no such field.
};

struct ViewReply {
  /// What makes it take long.
  enum class Slow : std::uint8_t { reading, measuring };

  int status = 200;
  std::string_view type = "text/plain; charset=utf-8";
  std::string_view body;             ///< Of the program, or of `kept`.
  std::shared_ptr<const void> kept;  ///< Stays while the reply is sent: scenes are replaced as a run goes on.
  std::vector<std::pair<std::string, std::string>> fields;
  /// Set where the reply takes long: makes it, in any thread, but one at a time of each kind.
  std::function<ViewReply()> make = nullptr;
  Slow slow = Slow::reading;
};

/// Which request is given what. Touches no file, no socket and no clock. Of one thread.
class RequestRules {
 public:
  RequestRules(std::vector<NamedScene> scenes, std::string token, bool loopback_only, std::uint16_t port);
  ViewReply reply_to(const ViewRequest& request) const;
  /// Whether the request asks for the messages of a run, which only a connection can give; its reply where it may not.
  static bool asks_for_messages(const ViewRequest& request);
  std::optional<ViewReply> refusal_of(const ViewRequest& request) const;

  /// Whether the scenes are of a run that goes on.
  void set_live(bool live);
  /// Takes the place of the first one.
  void set_scene(NamedScene scene);

 private:
  bool is_host_allowed(std::string_view host) const;
  bool has_token(const ViewRequest& request) const;
  ViewReply content_at(std::string_view path) const;
  ViewReply scene_at(std::string_view number) const;
  ViewReply frame_at(std::string_view numbers) const;
  ViewReply tile_at(std::string_view numbers) const;
  ViewReply measured_at(std::string_view number, std::string_view query) const;
  void make_list();

  std::vector<std::shared_ptr<const NamedScene>> scenes_;
  bool live_ = false;
  std::shared_ptr<const std::string> list_;  ///< JSON of /api/scenes.
  std::string token_, cookie_name_, machine_;
  bool loopback_only_;
};

/// As other machines may call it.
std::string name_of_machine();

/// The reply itself, where it is one that takes long as well. Never throws but for lack of memory.
ViewReply made(const ViewReply& reply);

/// A reply that only says in one line what is wrong.
ViewReply refusal(int status, std::string_view line);

}  // namespace rastro::detail
