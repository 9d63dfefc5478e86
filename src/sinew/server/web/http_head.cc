#include "sinew/server/web/http_head.h"

#include <algorithm>

namespace sinew::server {
namespace {

constexpr std::string_view kLineEnd = "\r\n";
constexpr std::size_t kVerbMax = 16;

std::unexpected<HttpRefusal> refuse(int status, std::string sentence) {
  return std::unexpected(HttpRefusal{status, std::move(sentence), {}});
}

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

/// RFC 9110, 5.6.2.
bool is_token(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) {
    return is_letter_or_digit(c) || std::string_view("!#$%&'*+-.^_`|~").contains(c);
  });
}

bool is_printable_ascii(char c) {
  return c > ' ' && c < '\x7f';
}

/// Visible letters of any kind, blanks and tabs.
bool is_value(std::string_view text) {
  return std::ranges::all_of(text, [](char c) {
    return c == '\t' || (static_cast<unsigned char>(c) >= ' ' && c != '\x7f');
  });
}

std::string_view without_blanks(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
}

/// The next line, without its end; nothing where none ends.
std::optional<std::string_view> take_line(std::string_view& text) {
  const std::size_t end = text.find(kLineEnd);
  if (end == std::string_view::npos) return std::nullopt;
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end + kLineEnd.size());
  return line;
}

std::optional<HttpRefusal> read_request_line(std::string_view line, HttpHead& head) {
  const std::size_t first = line.find(' ');
  const std::size_t last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) {
    return HttpRefusal{400, "a request begins with METHOD /PATH HTTP/1.1", {}};
  }
  const std::string_view method = line.substr(0, first);
  const std::string_view target = line.substr(first + 1, last - first - 1);
  const std::string_view version = line.substr(last + 1);
  if (!version.starts_with("HTTP/")) {
    return HttpRefusal{400, "a request begins with METHOD /PATH HTTP/1.1", {}};
  }
  if (version != "HTTP/1.1") return HttpRefusal{505, "only HTTP/1.1 is spoken here", {}};
  if (!is_token(method) || method.size() > kVerbMax) {
    return HttpRefusal{501, "no method has such a name", {}};
  }
  if (target.size() > kTargetMax) {
    return HttpRefusal{414, "no address here is longer than 1024 bytes", {}};
  }
  if (!target.starts_with('/') || !std::ranges::all_of(target, is_printable_ascii)) {
    return HttpRefusal{400, "an address is a path that begins with /, in printable ASCII", {}};
  }
  head.method = method;
  head.target = target;
  return std::nullopt;
}

std::optional<HttpRefusal> read_field(std::string_view line, HttpHead& head) {
  if (line.starts_with(' ') || line.starts_with('\t')) {
    return HttpRefusal{400, "folded header lines are not taken", {}};
  }
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || !is_token(line.substr(0, colon))) {
    return HttpRefusal{400, "a header line is NAME: VALUE, without a blank before the colon", {}};
  }
  const std::string_view value = without_blanks(line.substr(colon + 1));
  if (!is_value(value)) {
    return HttpRefusal{400, "control characters are not taken in headers", {}};
  }
  if (head.fields.size() == kFieldsMax) {
    return HttpRefusal{431, "a request has at most 64 header lines", {}};
  }
  head.fields.push_back({lower_case(line.substr(0, colon)), std::string(value)});
  return std::nullopt;
}

}  // namespace

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::vector<std::string_view> words_between_commas(std::string_view value) {
  std::vector<std::string_view> words;
  while (!value.empty()) {
    const std::size_t comma = std::min(value.find(','), value.size());
    if (const auto word = without_blanks(value.substr(0, comma)); !word.empty()) {
      words.push_back(word);
    }
    value.remove_prefix(std::min(comma + 1, value.size()));
  }
  return words;
}

std::size_t HttpHead::count(std::string_view name) const {
  return static_cast<std::size_t>(std::ranges::count(fields, name, &HttpField::name));
}

const std::string* HttpHead::find(std::string_view name) const {
  const auto found = std::ranges::find(fields, name, &HttpField::name);
  return found != fields.end() ? &found->value : nullptr;
}

bool HttpHead::lists(std::string_view name, std::string_view word) const {
  const std::string wanted = lower_case(word);
  return std::ranges::any_of(fields, [&](const HttpField& field) {
    return field.name == name &&
           std::ranges::any_of(words_between_commas(field.value),
                               [&](std::string_view one) { return lower_case(one) == wanted; });
  });
}

std::expected<HttpHead, HttpRefusal> read_head(std::string_view text) {
  if (text.size() > kHeadMax) return refuse(431, "the head of a request has at most 16 KiB");
  HttpHead head;
  const auto first = take_line(text);
  if (!first) return refuse(400, "a request begins with METHOD /PATH HTTP/1.1");
  if (auto refusal = read_request_line(*first, head)) return std::unexpected(std::move(*refusal));
  while (const auto line = take_line(text)) {
    if (line->empty()) {
      if (text.empty()) return head;
      return refuse(400, "bytes stand behind the end of the head");
    }
    if (auto refusal = read_field(*line, head)) return std::unexpected(std::move(*refusal));
  }
  return refuse(400, "the head has no end");
}

}  // namespace sinew::server
