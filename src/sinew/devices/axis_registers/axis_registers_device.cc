#include "sinew/devices/axis_registers/axis_registers_device.h"

#include <algorithm>

#include "sinew/core/assert.h"
#include "sinew/core/units.h"

namespace sinew {

using namespace axis_registers;

namespace {

constexpr AxisRegisterMap kLaterMap{0, 1, 3, 4, 5};

std::uint16_t address_in(const AxisRegisterMap& map, const RegisterRow& row) {
  switch (row.name) {
    case Register::kHoming:
      return map.homing;
    case Register::kMoveAngle:
      return map.move_angle;
    case Register::kDiagControl:
      return map.diag_control;
    case Register::kDiagStatus:
      return map.diag_status;
    case Register::kEmergencyStop:
      return map.emergency_stop;
    case Register::kEnableMotor:
    case Register::kFirmwareUpdate:
      break;
  }
  return row.address;
}

Status wire_status(const AxisStatus& axis) {
  Status status;
  status.motor_ok = axis.motor_ok;
  status.sensor_ok = axis.sensor_ok;
  status.communication_ok = axis.communication_ok;
  status.position_ok = axis.position_ok;
  status.homed = axis.homed;
  status.moving = axis.moving || axis.homing;
  status.end_stop = axis.end_stop;
  status.emergency_stop = axis.emergency_stopped;
  status.fault = static_cast<std::uint8_t>(axis.fault);
  return status;
}

}  // namespace

AxisRegisterSlaveSettings axis_register_slave_settings(const AxisRegistersDevice& device,
                                                       std::size_t joint) {
  return {device.registers, device.encoding, device.slave_id, device.boards[joint].zero};
}

AxisRegisterSlave::AxisRegisterSlave(const AxisRegisterSlaveSettings& settings,
                                     AxisRegisterProfile profile, Axis& axis)
    : profile_(profile),
      encoding_(settings.encoding),
      zero_(settings.zero),
      slave_id_(settings.slave_id),
      axis_(axis) {
  const bool later = settings.registers == kLaterMap;
  for (RegisterRow row : kLaterRegisters) {
    const bool extra = row.name == Register::kEnableMotor || row.name == Register::kFirmwareUpdate;
    if (extra && !later) continue;
    row.address = address_in(settings.registers, row);
    rows_.push_back(row);
  }
  power_up();
}

void AxisRegisterSlave::power_up() {
  violations_ = {};
  armed_ = false;
  place_ = 0;
  miso_ = 0;
  // The first firmware begins with FFFF, so that id is refused; the document refuses an id that was
  // accepted, and none was.
  last_frame_id_ = profile_ == AxisRegisterProfile::kAsBuilt ? 0xFFFF : 0;
  values_ = {};
  changes_ = 0;
  in_boot_loader_ = false;
  ready_pin_ = profile_ == AxisRegisterProfile::kDocument;
  to_send_.clear();
  state_ = State::kWaitSyn;
}

std::string_view AxisRegisterSlave::name_of(State state) {
  constexpr std::string_view kNames[] = {"WAIT_SYN",    "SEND_SYN_ACK",    "WAIT_ACK",
                                         "WAIT_HEADER", "SEND_VALIDATION", "WAIT_DATA",
                                         "SEND_COMMIT", "SEND_DATA",       "WAIT_COMMIT"};
  return kNames[static_cast<std::size_t>(state)];
}

void AxisRegisterSlave::select(bool selected) {
  selected_ = selected;
  // The rising edge means nothing: only the next falling one starts the transfer over.
  if (!selected || in_boot_loader_) return;
  if (armed_ && place_ > 0) ++violations_.broken_transfers;
  armed_ = true;
  place_ = 0;
}

std::uint8_t AxisRegisterSlave::shift(std::uint8_t mosi) {
  if (!armed_) {
    // A board with a software chip select hears what is meant for others, too.
    if (selected_) ++violations_.surplus_bytes;
    return miso_;
  }
  if (sends()) miso_ = to_send_[place_];
  const std::uint8_t sent = miso_;
  received_[place_++] = mosi;
  if (place_ == length()) complete();
  return sent;
}

void AxisRegisterSlave::exchange(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso) {
  SINEW_ASSERT(miso.size() >= mosi.size());
  select(true);
  for (std::size_t i = 0; i < mosi.size(); ++i) miso[i] = shift(mosi[i]);
  select(false);
}

void AxisRegisterSlave::next_answer(std::span<std::uint8_t> miso) const {
  std::uint8_t last = miso_;
  for (std::size_t i = 0; i < miso.size(); ++i) {
    if (sends() && !in_boot_loader_ && i < length()) last = to_send_[i];
    miso[i] = last;
  }
}

bool AxisRegisterSlave::sends() const {
  return state_ == State::kSendSynAck || state_ == State::kSendValidation ||
         state_ == State::kSendCommit || state_ == State::kSendData;
}

std::size_t AxisRegisterSlave::length() const {
  switch (state_) {
    case State::kWaitHeader:
      return kHeaderSize;
    case State::kWaitData:
    case State::kSendData:
      return header_.size + kCrcSize;
    case State::kSendCommit:
    case State::kWaitCommit:
      return kCommitSize;
    case State::kWaitSyn:
    case State::kSendSynAck:
    case State::kWaitAck:
    case State::kSendValidation:
      break;
  }
  return 1;
}

void AxisRegisterSlave::enter(State state) {
  state_ = state;
  armed_ = false;
}

void AxisRegisterSlave::send(std::span<const std::uint8_t> bytes) {
  to_send_.clear();
  for (const std::uint8_t byte : bytes) to_send_.push_back(byte);
}

void AxisRegisterSlave::complete() {
  // The same state again, too, waits for the next falling edge.
  armed_ = false;
  switch (state_) {
    case State::kWaitSyn:
      if (received_[0] != kSyn) {
        ++violations_.stray_bytes;
        return;
      }
      if (profile_ == AxisRegisterProfile::kDocument) ready_pin_ = true;
      send(std::array{kSynAck});
      return enter(State::kSendSynAck);
    case State::kSendSynAck:
      return enter(State::kWaitAck);
    case State::kWaitAck:
      if (received_[0] == kAck) return enter(State::kWaitHeader);
      ++violations_.stray_bytes;
      return;
    case State::kWaitHeader:
      return take_header();
    case State::kSendValidation: {
      if (verdict_ != Verdict::kOk) return enter(State::kWaitSyn);
      if (header_.operation == static_cast<std::uint8_t>(Operation::kWrite)) {
        return enter(State::kWaitData);
      }
      send(seal(read(*row_of(header_.address), header_.size)));
      return enter(State::kSendData);
    }
    case State::kWaitData:
      return take_data();
    case State::kSendCommit:
      ready_pin_ = false;
      return enter(State::kWaitSyn);
    case State::kSendData:
      return enter(State::kWaitCommit);
    case State::kWaitCommit:
      ready_pin_ = false;
      return enter(State::kWaitSyn);
  }
}

void AxisRegisterSlave::take_header() {
  HeaderBytes bytes{};
  std::copy_n(received_.begin(), bytes.size(), bytes.begin());
  const bool document = profile_ == AxisRegisterProfile::kDocument;
  verdict_ =
      check_header(bytes, {.checks = document ? Checks::kDocument : Checks::kAsBuilt,
                           .slave_id = slave_id_,
                           .last_frame_id = last_frame_id_,
                           .registers = std::span<const RegisterRow>(rows_.data(), rows_.size())});
  if (verdict_ == Verdict::kOk) {
    header_ = read_header(bytes);
    // Accepted is the header, whatever becomes of the data behind it.
    last_frame_id_ = header_.frame_id;
  } else {
    ++violations_.refused_headers;
  }
  send(std::array{static_cast<std::uint8_t>(verdict_)});
  enter(State::kSendValidation);
}

void AxisRegisterSlave::take_data() {
  const auto data = unseal(std::span<const std::uint8_t>(received_).first(length()));
  const RegisterRow& row = *row_of(header_.address);
  if (data) {
    store(row, *data);
    if (data->size() == row.size) {
      ++changes_;
      act(row.name);
    }
  }
  if (!data) ++violations_.bad_data;
  send(encode_commit(data ? Verdict::kOk : Verdict::kCrc));
  enter(State::kSendCommit);
}

const RegisterRow* AxisRegisterSlave::row_of(std::uint16_t address) const {
  const auto* const row = std::ranges::find(rows_, address, &RegisterRow::address);
  SINEW_ASSERT(row != rows_.end());  // the header was checked
  return row;
}

void AxisRegisterSlave::store(const RegisterRow& row, std::span<const std::uint8_t> data) {
  std::uint32_t& value = values_[static_cast<std::size_t>(row.name)];
  for (std::size_t i = 0; i < data.size(); ++i) {
    const auto shift = 8 * (row.size - 1 - i);
    value = (value & ~(0xFFU << shift)) | std::uint32_t{data[i]} << shift;
  }
}

Data AxisRegisterSlave::stored(const RegisterRow& row) const {
  const std::uint32_t value = values_[static_cast<std::size_t>(row.name)];
  Data data;
  for (std::size_t i = row.size; i-- > 0;) {
    data.push_back(static_cast<std::uint8_t>(value >> 8 * i & 0xFF));
  }
  return data;
}

Data AxisRegisterSlave::register_value(Register name) const {
  const auto* const row = std::ranges::find(rows_, name, &RegisterRow::name);
  SINEW_ASSERT(row != rows_.end());
  return profile_ == AxisRegisterProfile::kAsBuilt ? stored(*row) : live_value(name);
}

Data AxisRegisterSlave::read(const RegisterRow& row, std::size_t size) const {
  Data data;
  if (profile_ == AxisRegisterProfile::kAsBuilt) {
    // It hands out the register's address for every byte, so each is the lowest one.
    const Data value = stored(row);
    for (std::size_t i = 0; i < size; ++i) data.push_back(value.back());
    return data;
  }
  const Data value = live_value(row.name);
  SINEW_ASSERT(size == value.size());
  return value;
}

Data AxisRegisterSlave::live_value(Register name) const {
  const AxisStatus status = axis_.status();
  switch (name) {
    case Register::kHoming:
      return {status.homing ? kOn : kOff};
    case Register::kEmergencyStop:
      return {status.emergency_stopped ? kOn : kOff};
    case Register::kDiagStatus:
      return encode_status(wire_status(status));
    case Register::kMoveAngle: {
      const bool from_zero = encoding_ == AngleEncoding::kDegU32;
      const double angle = to_deg(status.q_target - (from_zero ? zero_ : 0));
      // An axis may stand a little before its zero; 0 is the nearest that can be said.
      const auto bytes = encode_angle(encoding_, from_zero ? std::max(angle, 0.0) : angle);
      return bytes ? Data(*bytes) : Data{0, 0, 0, 0};
    }
    case Register::kDiagControl:
    case Register::kEnableMotor:
    case Register::kFirmwareUpdate:
      break;
  }
  return stored(*std::ranges::find(rows_, name, &RegisterRow::name));
}

void AxisRegisterSlave::act(Register name) {
  const std::uint32_t value = values_[static_cast<std::size_t>(name)];
  if (name == Register::kFirmwareUpdate) {
    in_boot_loader_ = value == kOn;
    return;
  }
  if (profile_ == AxisRegisterProfile::kAsBuilt) {
    // Its callbacks are empty; the one of HOMING takes the request back.
    if (name == Register::kHoming) values_[static_cast<std::size_t>(name)] = kOff;
    return;
  }
  switch (name) {
    case Register::kHoming:
      if (value == kOn) static_cast<void>(axis_.home());
      if (value == kOff) axis_.cancel_homing();
      break;
    case Register::kMoveAngle:
      move();
      break;
    case Register::kDiagControl:
      if (value == kClearFaults) axis_.clear_faults();
      if (value == kRunSelfTest) axis_.self_test();
      break;
    case Register::kEmergencyStop:
      // Whatever is not a clear "no" stops.
      if (value == kOff) {
        axis_.release_emergency_stop();
      } else {
        axis_.emergency_stop();
      }
      break;
    case Register::kDiagStatus:
    case Register::kEnableMotor:
    case Register::kFirmwareUpdate:
      break;
  }
}

void AxisRegisterSlave::move() {
  AngleBytes bytes{};
  const Data data = stored(*std::ranges::find(rows_, Register::kMoveAngle, &RegisterRow::name));
  std::copy_n(data.begin(), bytes.size(), bytes.begin());
  const auto angle_deg = decode_angle(encoding_, bytes);
  if (!angle_deg) return;
  const double offset = encoding_ == AngleEncoding::kDegU32 ? zero_ : 0;
  // The wire has no word for a refusal: it shows in DIAG_STATUS, and MOVE_ANGLE reads the old
  // target.
  static_cast<void>(axis_.move_to(offset + from_deg(*angle_deg)));
}

}  // namespace sinew
