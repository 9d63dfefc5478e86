#include "sinew/devices/axis_registers/axis_registers_driver_link.h"

#include <algorithm>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew {

using namespace axis_registers;

static_assert(kMaxJoints <= 8, "a select is one byte");
static_assert(kResyncSize <= spi::kTransferMax && kDataMax + kCrcSize < kResyncSize);

AxisRegisterLink::AxisRegisterLink(const AxisRegistersDevice& device,
                                   const AxisRegisterTiming& timing)
    : slave_id_(device.slave_id),
      clock_hz_(device.clock_hz),
      timing_(timing),
      frame_id_(timing.first_frame_id) {
  SINEW_ASSERT(clock_hz_ > 0 && timing.tries > 0);
  SINEW_ASSERT(frame_id_ >= kFrameIdFirst && frame_id_ <= kFrameIdLast);
}

void AxisRegisterLink::reset() {
  step_ = Step::kIdle;
  in_transfer_ = false;
  abandoned_ = false;
  outcome_.reset();
  unsure_ = 0xFF;
}

void AxisRegisterLink::start(const AxisRegisterRequest& request, Instant now) {
  SINEW_ASSERT(!busy() && !outcome_);
  SINEW_ASSERT(request.operation == Operation::kRead || request.data.size() == request.size);
  SINEW_ASSERT(request.size <= kDataMax && request.tries > 0 && request.select != 0);
  request_ = request;
  abandoned_ = false;
  begun_ = now;
  tries_left_ = request.tries;
  tries_made_ = 0;
  free_at_ = std::max(free_at_, now);
  begin_try();
}

void AxisRegisterLink::begin_try() {
  ++health_.requests;
  if (tries_made_ > 0) ++health_.retries;
  --tries_left_;
  ++tries_made_;
  syn_repeated_ = false;
  const bool write = request_.operation == Operation::kWrite;
  header_ =
      encode_header({slave_id_, take_frame_id(), static_cast<std::uint8_t>(request_.operation),
                     request_.address, request_.size});
  sealed_ = SealedData{};
  if (write) sealed_ = seal({request_.data.data(), request_.data.size()});
  // A broadcast does not wait for boards that may be stuck.
  const bool resync = (unsure_ & request_.select) != 0 && !request_.blind;
  bursts_left_ = kResyncBursts;
  step_ = resync ? Step::kResync : Step::kSyn;
}

std::uint16_t AxisRegisterLink::take_frame_id() {
  const auto is_fresh = [this](std::uint16_t id) {
    for (std::size_t i = 0; i < last_ids_.size(); ++i) {
      if ((request_.select >> i & 1) != 0 && last_ids_[i] == id) return false;
    }
    return true;
  };
  // At most one id a board is taken, so this ends.
  while (!is_fresh(frame_id_)) frame_id_ = next_frame_id(frame_id_);
  const std::uint16_t id = frame_id_;
  for (std::size_t i = 0; i < last_ids_.size(); ++i) {
    if ((request_.select >> i & 1) != 0) last_ids_[i] = id;
  }
  frame_id_ = next_frame_id(id);
  return id;
}

bool AxisRegisterLink::droppable() const {
  return step_ < Step::kHeader || (step_ == Step::kHeader && !in_transfer_);
}

void AxisRegisterLink::abandon() {
  outcome_.reset();
  if (!busy()) return;
  abandoned_ = true;
  if (droppable() && !in_transfer_) step_ = Step::kIdle;
}

std::optional<Instant> AxisRegisterLink::next_deadline() const {
  if (!busy() || in_transfer_) return std::nullopt;
  return free_at_;
}

spi::Bytes AxisRegisterLink::bytes_of(Step step) const {
  const auto filled = [](std::size_t count, std::uint8_t byte) {
    spi::Bytes bytes;
    for (std::size_t i = 0; i < count; ++i) bytes.push_back(byte);
    return bytes;
  };
  const bool write = request_.operation == Operation::kWrite;
  switch (step) {
    case Step::kResync:
      return filled(kResyncSize, kResyncByte);
    case Step::kSyn:
      return {kSyn};
    case Step::kAck:
      return {kAck};
    case Step::kHeader:
      return spi::Bytes(header_);
    case Step::kData:
      if (!write) return filled(request_.size + kCrcSize, kFill);
      // Whoever gave it up does not want it done.
      if (abandoned_) return filled(request_.size + kCrcSize, kResyncByte);
      return spi::Bytes(std::span<const std::uint8_t>(sealed_.data(), sealed_.size()));
    case Step::kCommit:
      return write ? filled(kCommitSize, kFill) : spi::Bytes(encode_commit(Verdict::kOk));
    case Step::kIdle:
    case Step::kSynAck:
    case Step::kValidation:
      break;
  }
  return {kDummy};
}

Duration AxisRegisterLink::pause_behind(Step step) const {
  // Behind an error code the board gets its 50 ms, counted from what was sent last.
  if (step == Step::kResync && bursts_left_ > 1) return timing_.resync_pause;
  if (step == Step::kResync) return std::max(timing_.resync_pause, timing_.error_pause);
  return step == Step::kValidation ? timing_.validation_pause : timing_.step_pause;
}

std::optional<spi::Transfer> AxisRegisterLink::take_transfer(Instant now) {
  if (!busy() || in_transfer_ || now < free_at_) return std::nullopt;
  in_transfer_ = true;
  return spi::Transfer{request_.select, bytes_of(step_), timing_.setup, clock_hz_};
}

void AxisRegisterLink::exchanged(std::span<const std::uint8_t> miso, Instant now) {
  if (!in_transfer_) return;  // reset() came in between
  SINEW_ASSERT(!miso.empty());
  const bool drop = abandoned_ && droppable();
  in_transfer_ = false;
  free_at_ = now + pause_behind(step_);
  if (drop) {
    step_ = Step::kIdle;
    return;
  }
  check(miso, now);
}

void AxisRegisterLink::check(std::span<const std::uint8_t> miso, Instant now) {
  switch (step_) {
    case Step::kIdle:
      return;
    case Step::kResync:
      if (--bursts_left_ > 0) return;
      unsure_ = static_cast<std::uint8_t>(unsure_ & ~request_.select);
      step_ = Step::kSyn;
      return;
    case Step::kSyn:
      step_ = Step::kSynAck;
      return;
    case Step::kSynAck:
      if (miso[0] == kSynAck || request_.blind) {
        step_ = Step::kAck;
      } else if (!syn_repeated_) {
        syn_repeated_ = true;
        free_at_ += timing_.syn_retry_pause;
        step_ = Step::kSyn;
      } else {
        ++health_.timeouts;
        const double waited = to_seconds(now - begun_);
        fail({ErrorCode::kDeviceSilent, -1, waited, waited}, now);
      }
      return;
    case Step::kAck:
      step_ = Step::kHeader;
      return;
    case Step::kHeader:
      step_ = Step::kValidation;
      return;
    case Step::kValidation: {
      if (miso[0] == 0 || request_.blind) {
        step_ = Step::kData;
        return;
      }
      ++health_.unexpected;
      const auto verdict = verdict_of(miso[0]);
      const bool refused = verdict && *verdict != Verdict::kCrc && *verdict != Verdict::kStartByte;
      const Error error{ErrorCode::kUnexpectedReply, -1, 1.0 * miso[0], 0};
      return fail(refused ? Error{ErrorCode::kDeviceRefused} : error, now);
    }
    case Step::kData:
      return check_data(miso, now);
    case Step::kCommit:
      return check_commit(miso, now);
  }
}

void AxisRegisterLink::check_data(std::span<const std::uint8_t> miso, Instant now) {
  step_ = Step::kCommit;
  if (request_.operation == Operation::kWrite) return;
  const auto data = unseal(miso);
  if (data) {
    value_ = *data;
    return;
  }
  ++health_.unexpected;
  fail({ErrorCode::kChecksum, -1, 1.0 * tries_made_}, now);
}

void AxisRegisterLink::check_commit(std::span<const std::uint8_t> miso, Instant now) {
  if (request_.operation == Operation::kRead || request_.blind) {
    return finish({std::nullopt, value_});
  }
  const auto verdict = decode_commit(miso);
  if (verdict == Verdict::kOk) return finish({});
  if (abandoned_) return finish({});
  ++health_.unexpected;
  const Error damaged{ErrorCode::kChecksum, -1, 1.0 * tries_made_};
  const Error garbage{ErrorCode::kUnexpectedReply, -1, 1.0 * miso[0], 1.0 * kStart};
  fail(verdict ? damaged : garbage, now);
}

void AxisRegisterLink::fail(Error error, Instant now) {
  unsure_ = static_cast<std::uint8_t>(unsure_ | request_.select);
  free_at_ = now + timing_.error_pause;
  if (abandoned_ || tries_left_ == 0) return finish({error, {}});
  begin_try();
}

void AxisRegisterLink::finish(const AxisRegisterOutcome& outcome) {
  step_ = Step::kIdle;
  if (!abandoned_) outcome_ = outcome;
}

std::optional<AxisRegisterOutcome> AxisRegisterLink::take_outcome() {
  const auto outcome = outcome_;
  outcome_.reset();
  return outcome;
}

}  // namespace sinew
