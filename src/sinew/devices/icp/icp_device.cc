#include "sinew/devices/icp/icp_device.h"

#include <algorithm>

namespace sinew {

using namespace icp;

namespace {

/// Those that need the modules, and so take the firmware's time.
bool needs_modules(const Request& request) {
  return std::holds_alternative<Step>(request) || std::holds_alternative<Select>(request) ||
         std::holds_alternative<Wake>(request);
}

}  // namespace

IcpController::IcpController(const IcpQuirks& quirks, std::span<Tmc222, kMotors> modules,
                             Instant boot)
    : quirks_(quirks), modules_(modules), decoder_(quirks.dialect) {
  power_cycle(boot);
}

void IcpController::power_cycle(Instant now) {
  state_ = State::kBooting;
  decoder_ = RequestDecoder(quirks_.dialect);
  job_.reset();
  waiting_.reset();
  output_.clear();
  due_ = now + quirks_.boot;
  last_byte_ = due_;
}

void IcpController::power_off() {
  state_ = State::kDead;
  job_.reset();
  waiting_.reset();
}

std::optional<Instant> IcpController::next_event() const {
  if (state_ == State::kBooting || state_ == State::kWorking) return due_;
  return std::nullopt;
}

void IcpController::advance(Instant now) {
  if (state_ == State::kBooting && now >= due_) finish_boot(due_);
  // A byte that waited may begin the next work, which may be over by now as well.
  for (int i = 0; i < 2 && state_ == State::kWorking && now >= due_; ++i) {
    state_ = State::kReady;
    const Instant done = due_;
    if (job_) work(*job_, done);
    job_.reset();
    if (!waiting_) continue;
    const std::uint8_t byte = *waiting_;
    waiting_.reset();
    take(byte, done);
  }
  const bool idle =
      state_ == State::kReady && quirks_.idle_shutdown && now - last_byte_ > *quirks_.idle_shutdown;
  if (idle) state_ = State::kDead;
}

void IcpController::receive(std::uint8_t byte, Instant now) {
  advance(now);
  last_byte_ = now;
  if (state_ == State::kDead) return;
  if (state_ == State::kReady) return take(byte, now);
  if (state_ == State::kWorking && !waiting_) {
    waiting_ = byte;
    return;
  }
  ++bytes_lost_;
}

void IcpController::take(std::uint8_t byte, Instant now) {
  const auto request = decoder_.push(byte);
  if (!request) return;
  if (!*request) return refuse(request->error());
  if (!needs_modules(**request) || quirks_.processing == Duration::zero()) {
    return work(**request, now);
  }
  job_ = **request;
  state_ = State::kWorking;
  due_ = now + quirks_.processing;
}

void IcpController::work(const Request& request, Instant now) {
  if (std::holds_alternative<Init>(request) || std::holds_alternative<StatusRequest>(request)) {
    reply(Ack{});
  } else if (std::holds_alternative<Kill>(request)) {
    state_ = State::kDead;
  } else if (std::holds_alternative<Wake>(request)) {
    wake_all(now);
    reply(Ack{});
  } else if (const auto* wanted = std::get_if<Step>(&request)) {
    step(*wanted, now);
  } else if (const auto* select = std::get_if<Select>(&request)) {
    read_module(select->motor, now);
  }
}

void IcpController::step(const Step& step, Instant now) {
  const bool plus = step.direction == quirks_.bit_one_is_plus;
  const auto unit = plus ? std::int16_t{1} : quirks_.minus_one;
  const bool reset = send(step.motor, tmc222::ResetPosition{}, now);
  const bool set = send(step.motor, tmc222::SetPosition{unit}, now);
  if ((reset && set) || quirks_.ack_without_module) reply(Ack{});
}

void IcpController::read_module(std::uint8_t motor, Instant now) {
  Tmc222& module = modules_[motor - 1U];
  tmc222::Answer one{};
  tmc222::Answer two{};
  const bool read = send(motor, tmc222::GetFullStatus1{}, now) && module.read(one, now) &&
                    send(motor, tmc222::GetFullStatus2{}, now) && module.read(two, now);
  if (!read) {
    if (quirks_.ack_without_module) reply(Ack{});
    return;
  }
  const auto first = tmc222::decode_status1(one);
  const auto second = tmc222::decode_status2(two);
  if (first && second) reply(Status{*first, *second});
}

bool IcpController::send(std::uint8_t motor, const tmc222::Command& command, Instant now) {
  return modules_[motor - 1U].write(tmc222::encode_command(command), now);
}

void IcpController::wake_all(Instant now) {
  for (std::uint8_t motor = 1; motor <= kMotors; ++motor) {
    send(motor, tmc222::GetFullStatus1{}, now);
  }
}

void IcpController::finish_boot(Instant now) {
  wake_all(now);
  for (std::uint8_t motor = 1; motor <= kMotors; ++motor) {
    send(motor, tmc222::SetMotorParam{kMotorParameters}, now);
  }
  state_ = State::kReady;
}

void IcpController::refuse(Refusal why) {
  if (why == Refusal::kNoMotor && quirks_.silent_without_motor) return;
  reply(Refused{why});
}

void IcpController::reply(const Reply& reply) {
  const ReplyBytes bytes = encode_reply(reply);
  // A host that does not read loses replies, as with any port.
  if (output_.size() + bytes.size() > output_.capacity()) {
    bytes_lost_ += bytes.size();
    return;
  }
  for (const std::uint8_t byte : bytes) output_.push_back(byte);
}

std::size_t IcpController::take_output(std::span<std::uint8_t> out) {
  return output_.take_front(out);
}

}  // namespace sinew
