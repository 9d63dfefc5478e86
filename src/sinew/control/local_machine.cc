#include "sinew/control/local_machine.h"

#include <algorithm>

#include "sinew/core/assert.h"

namespace sinew::control {

std::uint32_t LocalMachine::give(const CommandWhat& what) {
  SINEW_ASSERT(!waiting_.full());
  waiting_.push_back({++last_id_, lease_, what});
  return last_id_;
}

std::span<const Command> LocalMachine::commands(Instant now) {
  now_.clear();
  if (lease_.epoch != 0 && now - renewed_ >= kRenewal) {
    now_.push_back({0, lease_, RenewLease{}});
    renewed_ = now;
  }
  std::size_t count = 0;
  while (count < waiting_.size() && !now_.full()) {
    now_.push_back(waiting_[count++]);
    // What was given before the lease came is given under it.
    now_.back().lease = lease_;
    if (std::holds_alternative<TakeLease>(now_.back().what)) break;
  }
  waiting_.drop_front(count);
  return {now_.data(), now_.size()};
}

void LocalMachine::take(const Outputs& outputs) {
  for (const ControlEvent& event : outputs.events) {
    if (event.kind == ControlEvent::Kind::kLease) {
      const bool ours = event.lease.client == lease_.client;
      lease_.epoch = ours ? event.lease.epoch : 0;
    }
    if (!events_.full()) events_.push_back(event);
  }
}

}  // namespace sinew::control
