#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "sinew/core/instant.h"
#include "sinew/server/api/api.h"

namespace sinew::server {

/// What a token is made of: 128 bits, in hexadecimal.
inline constexpr std::size_t kTokenBytes = 16;

/// As text, two digits a byte.
std::string token_text(std::span<const std::uint8_t, kTokenBytes> random);
bool is_token_text(std::string_view text);

/// Who a token makes its bearer, and who has shown too many wrong ones.
///
/// A right token always counts, also from an address that has shown wrong ones: a page with an old
/// token that keeps on trying must not keep its owner from the stop. What guards against guessing
/// is the length; the limit bounds what guessing costs the server, whose connections then end.
class WebTokens {
 public:
  /// Wrong ones from an address within kWindow; those behind are told to wait.
  static constexpr std::size_t kWrongMax = 10;
  static constexpr Duration kWindow = std::chrono::minutes(1);
  /// Addresses that are remembered; the one that was wrong longest ago is forgotten first.
  static constexpr std::size_t kAddressesMax = 1024;

  enum class Verdict : std::uint8_t { kViewer, kOperator, kWrong, kTooManyWrong };

  WebTokens(std::string operator_token, std::string viewer_token);

  /// Takes as long for any token of the right length.
  Verdict judge(std::string_view token, const std::string& address, Instant now);
  /// How long until this address may be wrong again; zero where it may.
  Duration wait(const std::string& address, Instant now) const;

 private:
  struct Wrong {
    std::deque<Instant> at;  ///< the last kWrongMax
  };
  void remember(const std::string& address, Instant now);

  std::string operator_;
  std::string viewer_;
  std::map<std::string, Wrong> wrong_;
};

}  // namespace sinew::server
