#include "sinew/control/lease.h"

#include "sinew/core/error_code.h"

namespace sinew::control {

LeaseToken Lease::give(ClientId client, Instant now) {
  token_ = {client, token_.epoch + 1};
  held_ = true;
  end_ = now + life_;
  return token_;
}

Expected<LeaseToken> Lease::take(ClientId client, Instant now) {
  const auto has = holder(now);
  if (!has) return give(client, now);
  if (has->client != client) {
    return std::unexpected(Error{ErrorCode::kLeaseHeld, -1, 1.0 * has->client});
  }
  end_ = now + life_;
  return *has;
}

LeaseToken Lease::take_over(ClientId client, Instant now) {
  return give(client, now);
}

Expected<void> Lease::renew(const LeaseToken& token, Instant now) {
  const auto fine = check(token, now);
  if (fine) end_ = now + life_;
  return fine;
}

void Lease::give_back(const LeaseToken& token) {
  if (token == token_) held_ = false;
}

Expected<void> Lease::check(const LeaseToken& token, Instant now) const {
  const auto has = holder(now);
  if (has && *has == token) return {};
  return std::unexpected(Error{ErrorCode::kLeaseLost});
}

std::optional<LeaseToken> Lease::holder(Instant now) const {
  if (!held_ || now >= end_) return std::nullopt;
  return token_;
}

}  // namespace sinew::control
