#pragma once

#include <cstdint>
#include <optional>

#include "sinew/core/error.h"
#include "sinew/core/instant.h"

namespace sinew::control {

using ClientId = std::uint32_t;

/// Proof that its bearer is the one who may move. Every new holder has a higher epoch, so a
/// command that was sent under an old one is known as such, however late it comes.
struct LeaseToken {
  ClientId client = 0;
  std::uint64_t epoch = 0;  ///< 0: never given
  friend bool operator==(const LeaseToken&, const LeaseToken&) = default;
};

/// One client moves, many watch. A lease lives for kLife and ends by itself where its holder does
/// not renew it. All members are @rt.
class Lease {
 public:
  static constexpr Duration kLife = std::chrono::seconds(1);

  /// @param life  of another length where time runs quicker than the clients' (a scaled simulation)
  explicit Lease(Duration life = kLife) : life_(life) {}

  /// @error kLeaseHeld (measured: its holder) while somebody else has it
  Expected<LeaseToken> take(ClientId client, Instant now);
  /// Whoever had it has it no more. What moves has to be stopped first; that is the caller's.
  LeaseToken take_over(ClientId client, Instant now);
  /// @error kLeaseLost: it has ended, or somebody else has it
  Expected<void> renew(const LeaseToken& token, Instant now);
  /// Without effect where it is not the present one.
  void give_back(const LeaseToken& token);

  /// @error kLeaseLost, as renew(); a token that is none: the same
  Expected<void> check(const LeaseToken& token, Instant now) const;
  /// Who has it now.
  std::optional<LeaseToken> holder(Instant now) const;
  /// When it ends where nobody renews it.
  std::optional<Instant> ends() const { return held_ ? std::optional(end_) : std::nullopt; }

 private:
  LeaseToken give(ClientId client, Instant now);

  LeaseToken token_;
  bool held_ = false;
  Instant end_{};
  Duration life_;
};

}  // namespace sinew::control
