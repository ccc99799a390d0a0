// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/laser_log/log_lines.h"

#include <zlib.h>

#include <algorithm>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr std::size_t longest_line = std::size_t{4} << 20;
constexpr unsigned piece_size = 1U << 18;
constexpr std::size_t front_size = std::size_t{64} << 10;
constexpr std::size_t text_bytes_per_other = 100;  // A damaged log is a log still; what has more is no text.
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

bool is_text(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte >= 0x20 || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v';
}

std::size_t others_in(std::string_view text) {
  return text.size() - static_cast<std::size_t>(std::count_if(text.begin(), text.end(), is_text));
}

std::string_view without_mark(std::string_view text) {
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  return text;
}

}  // namespace

struct LogLines::State {
  std::string path;
  gzFile file = nullptr;
  std::string buffer;
  std::size_t begin = 0;  ///< Of what was not given out yet.
  std::int64_t number = 0;
  std::int64_t skipped = 0, first_skipped = 0;
  bool ended = false;
  bool damaged = false;

  ~State() {
    if (file != nullptr) gzclose_r(file);
  }

  void fill() {
    buffer.erase(0, begin);
    begin = 0;
    const std::size_t kept = buffer.size();
    if (kept > longest_line) throw Error("has a line of more than 4 MiB", path, "it is not a text log");
    buffer.resize(kept + piece_size);
    const int got = gzread(file, buffer.data() + kept, piece_size);
    buffer.resize(kept + static_cast<std::size_t>(std::max(got, 0)));
    if (got >= static_cast<int>(piece_size)) return;
    // A short read is the end, or a packed file that breaks off: zlib says which only when asked.
    int code = Z_OK;
    gzerror(file, &code);
    ended = true;
    damaged = got < 0 || (code != Z_OK && code != Z_STREAM_END);
  }
};

LogLines::LogLines(const std::string& path) : state_(std::make_unique<State>()) {
  state_->path = path;
  state_->file = gzopen(path.c_str(), "rb");
  if (state_->file == nullptr) throw Error("cannot be read", path, "is it there, and may you read it?");
  gzbuffer(state_->file, piece_size);
}

LogLines::~LogLines() = default;
LogLines::LogLines(LogLines&&) noexcept = default;
LogLines& LogLines::operator=(LogLines&&) noexcept = default;

std::optional<std::string_view> LogLines::next() {
  while (const auto line = any_line()) {
    if (others_in(*line) == 0) return number() == 1 ? without_mark(*line) : *line;
    if (state_->skipped++ == 0) state_->first_skipped = number();
  }
  return std::nullopt;
}

std::optional<std::string_view> LogLines::any_line() {
  State& state = *state_;
  std::size_t searched = state.begin;
  for (;;) {
    const auto end = state.buffer.find('\n', searched);
    if (end != std::string::npos) {
      const auto line = std::string_view(state.buffer).substr(state.begin, end - state.begin);
      state.begin = end + 1;
      ++state.number;
      return line;
    }
    if (state.ended) break;
    const std::size_t unread = state.buffer.size() - state.begin;
    state.fill();
    searched = unread;
  }
  if (state.damaged || state.begin >= state.buffer.size()) return std::nullopt;
  const auto line = std::string_view(state.buffer).substr(state.begin);
  state.begin = state.buffer.size();
  ++state.number;
  return line;
}

std::int64_t LogLines::number() const { return state_->number; }
bool LogLines::damaged() const { return state_->damaged; }
std::int64_t LogLines::skipped() const { return state_->skipped; }
std::int64_t LogLines::first_skipped() const { return state_->first_skipped; }

std::string text_at_front(const std::string& path) {
  const gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) return {};
  std::string text(front_size, '\0');
  const int got = gzread(file, text.data(), static_cast<unsigned>(text.size()));
  gzclose_r(file);
  text.resize(static_cast<std::size_t>(std::max(got, 0)));
  if (others_in(text) * text_bytes_per_other > text.size()) return {};
  return std::string(without_mark(text));
}

}  // namespace rastro
