#include "sinew/server/web/web_tokens.h"

#include <algorithm>

#include "sinew/core/assert.h"

namespace sinew::server {
namespace {

/// Looks at every letter, whatever the first ones say.
bool same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    difference |= static_cast<unsigned char>(a[k]) ^ static_cast<unsigned char>(b[k]);
    // Otherwise a compiler may see that nothing changes any more.
    asm volatile("" : "+r"(difference));
  }
  return difference == 0;
}

}  // namespace

std::string token_text(std::span<const std::uint8_t, kTokenBytes> random) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : random) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  return text;
}

bool is_token_text(std::string_view text) {
  return text.size() == 2 * kTokenBytes && std::ranges::all_of(text, [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

WebTokens::WebTokens(std::string operator_token, std::string viewer_token)
    : operator_(std::move(operator_token)), viewer_(std::move(viewer_token)) {
  SINEW_ASSERT(is_token_text(operator_) && is_token_text(viewer_) && operator_ != viewer_);
}

WebTokens::Verdict WebTokens::judge(std::string_view token, const std::string& address,
                                    Instant now) {
  const bool is_operator = same(token, operator_);
  const bool is_viewer = same(token, viewer_);
  if (is_operator) return Verdict::kOperator;
  if (is_viewer) return Verdict::kViewer;
  if (wait(address, now) > Duration{}) return Verdict::kTooManyWrong;
  remember(address, now);
  return Verdict::kWrong;
}

Duration WebTokens::wait(const std::string& address, Instant now) const {
  const auto found = wrong_.find(address);
  if (found == wrong_.end() || found->second.at.size() < kWrongMax) return {};
  return std::max(Duration{}, found->second.at.front() + kWindow - now);
}

void WebTokens::remember(const std::string& address, Instant now) {
  if (!wrong_.contains(address) && wrong_.size() >= kAddressesMax) {
    wrong_.erase(
        std::ranges::min_element(wrong_, {}, [](const auto& one) { return one.second.at.back(); }));
  }
  std::deque<Instant>& at = wrong_[address].at;
  at.push_back(now);
  if (at.size() > kWrongMax) at.pop_front();
}

}  // namespace sinew::server
