// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace rastro {

/// Strict parsers of one number: nullopt unless the whole text is a number, without locale. Surrounding spaces are
/// allowed. parse_double also accepts nan and inf; parse_finite does not.
std::optional<double> parse_double(std::string_view text);
std::optional<double> parse_finite(std::string_view text);
std::optional<std::int64_t> parse_int64(std::string_view text);
std::optional<std::uint64_t> parse_uint64(std::string_view text);

std::string_view trim(std::string_view text);
/// Pieces between separators, trimmed; "a,,b" has an empty middle piece.
std::vector<std::string_view> split(std::string_view text, char separator);
/// Pieces between runs of spaces and tabs.
std::vector<std::string_view> split_words(std::string_view text);

/// Length in bytes of the UTF-8 character at the front of `text`; 0 if there is no complete and valid one.
std::size_t utf8_length(std::string_view text);

/// Makes text from outside safe for a message: one line of valid UTF-8, other bytes as \xNN, truncated after about
/// `longest` bytes. Messages of other libraries need this too, because they quote bad input.
std::string one_line(std::string_view text, std::size_t longest = 200);
/// The same in single quotes, truncated after about 60 bytes.
std::string in_quotes(std::string_view text);
/// The text as one word of a POSIX shell: as it is, or in single quotes where that would read it otherwise.
std::string as_shell_word(std::string_view text);

/// The name nearest to `wanted` by edit distance; empty if none is near: at most half of the letters differ.
std::string nearest_name(std::string_view wanted, std::span<const std::string> names);

/// For the remedy of an unknown name: "did you mean 'window'?"; where no name is near, `otherwise` or, if that is
/// empty, a list of the names.
std::string did_you_mean(std::string_view wanted, std::span<const std::string> names, std::string_view otherwise = {});

}  // namespace rastro
