// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <optional>
#include <string_view>

#include "rastro/viewer/request_rules.h"

namespace rastro::detail {

namespace http = boost::beast::http;

using RequestParser = http::request_parser<http::empty_body>;

/// For one request, within bounds.
void prepare(RequestParser& parser);

/// Of a parser that has read the header.
ViewRequest request_of(const RequestParser& parser);

/// Whether a body follows the header, which no request to this server has.
bool announces_body(const RequestParser& parser);

/// Why bytes are no request that is answered; nullopt where there is nobody to say it to.
std::optional<ViewReply> refusal_of(const boost::beast::error_code& error);

/// The reply to the bytes of one request, as the server gives it; nullopt where they are not a whole one.
std::optional<ViewReply> reply_to_bytes(const RequestRules& rules, std::string_view bytes);

}  // namespace rastro::detail
