#include "sinew/vision/http_reply.h"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "sinew/vision/byte_text.h"

namespace sinew::vision {
namespace {

constexpr std::size_t kFieldsMax = 64;

std::string_view without_blanks(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::optional<std::uint64_t> number_in(std::string_view digits, int base) {
  std::uint64_t value = 0;
  const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), value, base);
  const bool is_whole = end.ec == std::errc{} && end.ptr == digits.data() + digits.size();
  return is_whole ? std::optional(value) : std::nullopt;
}

/// A value in quotes without them and without their backslashes; up to ';' where there are none.
std::string unquoted(std::string_view text) {
  std::string value;
  const bool is_quoted = text.starts_with('"');
  for (std::size_t i = is_quoted ? 1 : 0; i < text.size(); ++i) {
    if (is_quoted && text[i] == '\\' && i + 1 < text.size()) {
      ++i;
    } else if (text[i] == (is_quoted ? '"' : ';')) {
      break;
    }
    value += text[i];
  }
  return is_quoted ? value : std::string(without_blanks(value));
}

}  // namespace

std::string lower_letters(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

HttpFields HttpFields::of(std::string_view lines) {
  HttpFields all;
  while (!lines.empty() && all.fields_.size() < kFieldsMax) {
    const std::size_t end = std::min(lines.find('\n'), lines.size());
    const std::string_view line = lines.substr(0, end);
    lines.remove_prefix(std::min(end + 1, lines.size()));
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) continue;
    all.fields_.emplace_back(lower_letters(without_blanks(line.substr(0, colon))),
                             without_blanks(line.substr(colon + 1)));
  }
  return all;
}

std::string_view HttpFields::value(std::string_view name) const {
  const auto found = std::ranges::find(fields_, name, &std::pair<std::string, std::string>::first);
  return found != fields_.end() ? std::string_view(found->second) : std::string_view();
}

std::expected<std::optional<std::uint64_t>, std::string> HttpFields::length(
    std::string_view name) const {
  const std::string_view text = value(name);
  if (text.empty()) return std::optional<std::uint64_t>();
  const auto number = number_in(text, 10);
  if (!number) return std::unexpected("a length that is no number");
  return number;
}

std::size_t head_bytes(Bytes bytes) {
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (bytes[i] != '\n') continue;
    if (has_at(bytes, i + 1, "\n")) return i + 2;
    if (has_at(bytes, i + 1, "\r\n")) return i + 3;
  }
  return 0;
}

std::expected<HttpReplyHead, std::string> read_reply_head(std::string_view head) {
  const std::size_t end = std::min(head.find('\n'), head.size());
  std::string_view line = without_blanks(head.substr(0, end));
  const std::size_t blank = line.find(' ');
  if (!line.starts_with("HTTP/1.") || blank == std::string_view::npos) {
    return std::unexpected("replies with something other than HTTP");
  }
  line = without_blanks(line.substr(blank));
  const auto status = number_in(line.substr(0, 3), 10);
  if (!status || line.size() < 3 || *status < 100 || *status > 599) {
    return std::unexpected("replies with something other than HTTP");
  }
  return HttpReplyHead{static_cast<int>(*status), std::string(without_blanks(line.substr(3))),
                       HttpFields::of(head.substr(std::min(end + 1, head.size())))};
}

std::string field_parameter(std::string_view value, std::string_view name) {
  bool is_quoted = false;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (is_quoted && value[i] == '\\') {
      ++i;
      continue;
    }
    if (value[i] == '"') is_quoted = !is_quoted;
    if (value[i] != ';' || is_quoted) continue;
    const std::string_view rest = value.substr(i + 1);
    const std::size_t equals = rest.find('=');
    if (equals == std::string_view::npos) break;
    if (lower_letters(without_blanks(rest.substr(0, equals))) != name) continue;
    const std::string_view given = rest.substr(equals + 1);
    return unquoted(given.substr(std::min(given.find_first_not_of(" \t"), given.size())));
  }
  return {};
}

std::expected<HttpBody, std::string> HttpBody::of(const HttpFields& fields) {
  HttpBody body;
  const std::string coding = lower_letters(fields.value("transfer-encoding"));
  if (coding == "chunked") {
    body.is_chunked_ = true;
    body.state_ = State::kChunkSize;
    return body;
  }
  if (!coding.empty() && coding != "identity") {
    return std::unexpected("sends its pictures with the transfer encoding '" + coding +
                           "'; only chunked is read");
  }
  const auto length = fields.length("content-length");
  if (!length) return std::unexpected("replies with " + length.error());
  body.is_open_ = !length->has_value();
  body.left_ = length->value_or(0);
  if (!body.is_open_ && body.left_ == 0) body.state_ = State::kWhole;
  return body;
}

/// What a whole line between chunks means.
std::expected<void, std::string> HttpBody::take_line() {
  const std::string line(without_blanks(line_));
  line_.clear();
  if (state_ == State::kChunkEnd) {
    if (!line.empty()) return std::unexpected("sends chunks that are longer than they say");
    state_ = State::kChunkSize;
  } else if (state_ == State::kTrailer) {
    if (line.empty()) state_ = State::kWhole;
  } else {
    const std::size_t end = std::min(line.find(';'), line.size());
    const auto size = number_in(without_blanks(std::string_view(line).substr(0, end)), 16);
    if (!size) return std::unexpected("sends chunks without a size");
    left_ = *size;
    state_ = left_ == 0 ? State::kTrailer : State::kBytes;
  }
  return {};
}

std::expected<void, std::string> HttpBody::feed(Bytes bytes, std::vector<std::uint8_t>& body) {
  constexpr std::size_t kLineMax = 1024;
  while (!bytes.empty() && state_ != State::kWhole) {
    if (state_ == State::kBytes) {
      const std::size_t count =
          is_open_ ? bytes.size()
                   : static_cast<std::size_t>(std::min<std::uint64_t>(left_, bytes.size()));
      body.insert(body.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
      bytes = bytes.subspan(count);
      if (is_open_) continue;
      left_ -= count;
      if (left_ == 0) state_ = is_chunked_ ? State::kChunkEnd : State::kWhole;
      continue;
    }
    const char letter = static_cast<char>(bytes.front());
    bytes = bytes.subspan(1);
    if (letter != '\n') {
      line_ += letter;
      if (line_.size() > kLineMax) return std::unexpected("sends chunks without a size");
    } else if (auto taken = take_line(); !taken) {
      return taken;
    }
  }
  return {};
}

}  // namespace sinew::vision
