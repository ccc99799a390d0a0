// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/http_message.h"

#include <boost/beast/http/error.hpp>
#include <boost/beast/http/field.hpp>

namespace rastro::detail {
namespace {

std::string string_of(boost::beast::string_view view) { return {view.data(), view.size()}; }

}  // namespace

void prepare(RequestParser& parser) {
  constexpr std::uint32_t longest_header = 8 * 1024;
  parser.header_limit(longest_header);
  parser.body_limit(0);
}

ViewRequest request_of(const RequestParser& parser) {
  const auto& message = parser.get();
  ViewRequest request;
  request.method = string_of(message.method_string());
  request.target = string_of(message.target());
  const auto hosts = message.equal_range(http::field::host);
  for (auto host = hosts.first; host != hosts.second; ++host) request.hosts.push_back(string_of(host->value()));
  request.origin = string_of(message[http::field::origin]);
  request.cookie = string_of(message[http::field::cookie]);
  return request;
}

bool announces_body(const RequestParser& parser) {
  const auto length = parser.content_length();
  return parser.chunked() || (length && *length > 0);
}

std::optional<ViewReply> refusal_of(const boost::beast::error_code& error) {
  if (error == http::error::end_of_stream || error == http::error::partial_message) return std::nullopt;
  if (error == http::error::header_limit || error == http::error::buffer_overflow)
    return refusal(431, "the header is too long\n");
  if (error == http::error::body_limit || error == http::error::unexpected_body)
    return refusal(413, "requests have no body here\n");
  if (error.category() == make_error_code(http::error::bad_method).category())
    return refusal(400, "this is not HTTP\n");
  return std::nullopt;
}

std::optional<ViewReply> reply_to_bytes(const RequestRules& rules, std::string_view bytes) {
  RequestParser parser;
  prepare(parser);
  boost::beast::error_code error;
  parser.put(boost::asio::buffer(bytes.data(), bytes.size()), error);
  if (error == http::error::need_more) return std::nullopt;
  if (error) return refusal_of(error);
  if (!parser.is_header_done()) return std::nullopt;
  if (announces_body(parser)) return refusal(413, "requests have no body here\n");
  return made(rules.reply_to(request_of(parser)));
}

}  // namespace rastro::detail
