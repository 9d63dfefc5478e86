#include "sinew/runtime/station_client.h"

#include <utility>

#include "sinew/core/error_code.h"

namespace sinew::runtime {

using control::Command;
using control::ControlEvent;

namespace {
constexpr Duration kRenewal = std::chrono::milliseconds(100);  // of a lease that lasts 1 s
}

StationClient::StationClient(Station& station, control::ClientId client, std::uint8_t slot)
    : station_(station), slot_(slot), lease_{.client = client} {
  refresh();
}

Expected<std::unique_ptr<StationClient>> StationClient::make(Station& station,
                                                             control::ClientId client) {
  const auto slot = station.take_slot();
  if (!slot) return std::unexpected(Error{ErrorCode::kBusy});
  return std::unique_ptr<StationClient>(new StationClient(station, client, *slot));
}

StationClient::~StationClient() {
  station_.leave_slot(slot_);
}

void StationClient::refresh() {
  view_ = station_.view();
  if (taking_ != 0) return;
  for (Command& command : std::exchange(waiting_, {})) {
    command.lease = lease_;
    send(command);
  }
}

void StationClient::keep_lease(Instant now) {
  if (lease_.epoch == 0 || (renewed_ && now - *renewed_ < kRenewal)) return;
  renewed_ = now;
  give(control::RenewLease{});
}

void StationClient::act_for(control::ClientId client) {
  const auto& holder = view_.holder;
  lease_ = {.client = client, .epoch = 0};
  if (holder && holder->client == client) lease_ = *holder;
}

std::uint32_t StationClient::give(const control::CommandWhat& what) {
  Command command{station_.next_id(slot_), lease_, what};
  if (std::holds_alternative<control::TakeLease>(what)) taking_ = command.id;
  if (std::holds_alternative<control::Begin>(what)) motion_ = command.id;
  const bool waits = taking_ != 0 && taking_ != command.id && control::needs_lease(what);
  if (waits && waiting_.size() < kWaitingMax) {
    waiting_.push_back(command);
  } else if (waits) {
    refused_.push_back({.kind = ControlEvent::Kind::kRefused,
                        .command = command.id,
                        .error = {ErrorCode::kBusy},
                        .lease = {}});
  } else {
    send(command);
  }
  return command.id;
}

void StationClient::send(const Command& command) {
  auto given = station_.claim(command);
  if (given) given = station_.post(command, view_.stops);
  if (given) return;
  refused_.push_back({.kind = ControlEvent::Kind::kRefused,
                      .command = command.id,
                      .error = given.error(),
                      .lease = {}});
}

std::optional<ControlEvent> StationClient::take_event() {
  std::optional<ControlEvent> event;
  if (!refused_.empty()) {
    event = refused_.front();
    refused_.erase(refused_.begin());
  } else {
    event = station_.take_event(slot_);
    // It may be newer than the view, and what follows from it must not be planned from an old one.
    if (event) view_ = station_.view();
  }
  if (event) look_at(*event);
  return event;
}

void StationClient::look_at(const ControlEvent& event) {
  if (event.kind == ControlEvent::Kind::kLease) {
    const bool ours = event.lease.client == lease_.client;
    lease_.epoch = ours ? event.lease.epoch : 0;
  }
  if (event.command == 0 || !control::is_end(event.kind)) return;
  if (event.command == taking_) taking_ = 0;
  if (event.command == motion_) motion_ = 0;
}

}  // namespace sinew::runtime
