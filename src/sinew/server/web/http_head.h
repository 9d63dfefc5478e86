#pragma once

#include <cstddef>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// The heads of HTTP/1.1 requests, read strictly. Source: RFC 9110 and RFC 9112; where they leave a
/// choice, the stricter one is taken, so that no proxy in between can read a request differently.
namespace sinew::server {

inline constexpr std::size_t kHeadMax = std::size_t{16} * 1024;  ///< bytes, with the empty line
inline constexpr std::size_t kFieldsMax = 64;
inline constexpr std::size_t kTargetMax = 1024;  ///< bytes

/// Why a request is not served.
struct HttpRefusal {
  int status = 400;
  std::string sentence;
  std::string extra;  ///< fields that only this status has, each with its line end
};

struct HttpField {
  std::string name;   ///< in lower case
  std::string value;  ///< without the blanks around it
};

struct HttpHead {
  std::string method;
  std::string target;  ///< origin form: begins with '/'
  std::vector<HttpField> fields;

  /// How many fields have this name, given in lower case.
  std::size_t count(std::string_view name) const;
  /// The value of the first of them; null where there is none.
  const std::string* find(std::string_view name) const;
  /// Whether a field that lists words, in one line or in several, has this one; in any case of
  /// letters.
  bool lists(std::string_view name, std::string_view word) const;
};

/// Reads a whole head: request line, fields, and the empty line at its end.
/// @error  400 what is no HTTP/1.1 in its strict form: bare line feeds, folded lines, blanks before
///         a colon, control characters, an absolute target; 414, 431 too long; 501 a method of no
///         known form; 505 another version
std::expected<HttpHead, HttpRefusal> read_head(std::string_view text);

/// The words of a field's value between its commas, without blanks.
std::vector<std::string_view> words_between_commas(std::string_view value);

std::string lower_case(std::string_view text);

}  // namespace sinew::server
