// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
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
  int status = 200;
  std::string_view type = "text/plain; charset=utf-8";
  std::string_view body;  ///< Of the rules, valid as long as they are.
  std::vector<std::pair<std::string, std::string>> fields;
};

/// Which request is given what. Touches no file, no socket and no clock.
class RequestRules {
 public:
  /// `scenes` must outlive the rules.
  RequestRules(const std::vector<NamedScene>& scenes, std::string token, bool loopback_only, std::uint16_t port);
  ViewReply reply_to(const ViewRequest& request) const;

 private:
  bool is_host_allowed(std::string_view host) const;
  bool has_token(const ViewRequest& request) const;
  ViewReply content_at(std::string_view path) const;

  const std::vector<NamedScene>& scenes_;
  std::string list_;  ///< JSON of /api/scenes.
  std::string token_, cookie_name_, machine_;
  bool loopback_only_;
};

/// As other machines may call it.
std::string name_of_machine();

/// A reply that only says in one line what is wrong.
ViewReply refusal(int status, std::string_view line);

}  // namespace rastro::detail
