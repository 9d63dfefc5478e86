#include "sinew/devices/feetech/feetech_wire.h"

#include <algorithm>
#include <cstdlib>

#include "sinew/core/assert.h"

namespace sinew::feetech {
namespace {

constexpr std::uint8_t kPing = 1;
constexpr std::uint8_t kRead = 2;
constexpr std::uint8_t kWrite = 3;
constexpr std::uint8_t kWriteWaits = 4;
constexpr std::uint8_t kAction = 5;
constexpr std::uint8_t kSetMiddle = 0x0B;
constexpr std::uint8_t kSyncRead = 0x82;
constexpr std::uint8_t kSyncWrite = 0x83;

constexpr std::size_t kFront = 4;   // header, id, length
constexpr std::uint8_t kLeast = 2;  // of a length: what, and the sum

template <class Each>
void append(Packet& packet, const Each& bytes) {
  for (const std::uint8_t byte : bytes) packet.parameters.push_back(byte);
}

struct Maker {
  Packet operator()(const Ping& m) const { return {m.id, kPing, {}}; }
  Packet operator()(const Read& m) const { return {m.id, kRead, {m.address, m.count}}; }
  Packet operator()(const Write& m) const {
    Packet packet{m.id, m.waits ? kWriteWaits : kWrite, {m.address}};
    append(packet, m.data);
    return packet;
  }
  Packet operator()(const Action& m) const { return {m.id, kAction, {}}; }
  Packet operator()(const SetMiddle& m) const { return {m.id, kSetMiddle, {}}; }
  Packet operator()(const SyncRead& m) const {
    Packet packet{kBroadcast, kSyncRead, {m.address, m.count}};
    append(packet, m.ids);
    return packet;
  }
  Packet operator()(const SyncWrite& m) const {
    SINEW_ASSERT(!m.parts.empty());
    const auto count = static_cast<std::uint8_t>(m.parts[0].data.size());
    Packet packet{kBroadcast, kSyncWrite, {m.address, count}};
    for (const SyncWrite::Part& part : m.parts) {
      SINEW_ASSERT(part.data.size() == count);
      packet.parameters.push_back(part.id);
      append(packet, part.data);
    }
    return packet;
  }
};

/// Of all between the header and the sum.
template <class Bytes>
std::uint8_t sum_of(const Bytes& bytes, std::size_t end) {
  unsigned sum = 0;
  for (std::size_t i = 2; i < end; ++i) sum += bytes[i];
  return static_cast<std::uint8_t>(~sum);
}

Bytes framed(const Packet& packet) {
  Bytes bytes{kHeader, kHeader, packet.id,
              static_cast<std::uint8_t>(packet.parameters.size() + kLeast), packet.what};
  for (const std::uint8_t byte : packet.parameters) bytes.push_back(byte);
  bytes.push_back(sum_of(bytes, bytes.size()));
  return bytes;
}

template <class Parameters>
std::optional<Data> data_of(const Parameters& parameters, std::size_t from) {
  if (parameters.size() - from > kDataMax) return std::nullopt;
  Data data;
  for (std::size_t i = from; i < parameters.size(); ++i) data.push_back(parameters[i]);
  return data;
}

std::optional<Request> sync_read(const Packet& packet) {
  const auto& given = packet.parameters;
  if (given.size() < 3 || given.size() - 2 > kServosMax) return std::nullopt;
  SyncRead read{given[0], given[1], {}};
  for (std::size_t i = 2; i < given.size(); ++i) read.ids.push_back(given[i]);
  return read;
}

std::optional<Request> sync_write(const Packet& packet) {
  const auto& given = packet.parameters;
  if (given.size() < 4 || given[1] == 0 || given[1] > kDataMax) return std::nullopt;
  const std::size_t each = 1U + given[1];
  const std::size_t parts = (given.size() - 2) / each;
  if (parts * each != given.size() - 2 || parts > kServosMax) return std::nullopt;
  SyncWrite write{given[0], {}};
  for (std::size_t i = 0; i < parts; ++i) {
    SyncWrite::Part part{given[2 + i * each], {}};
    for (std::size_t k = 1; k < each; ++k) part.data.push_back(given[2 + i * each + k]);
    write.parts.push_back(part);
  }
  return write;
}

}  // namespace

Bytes encode(const Request& request) {
  return framed(std::visit(Maker{}, request));
}

Bytes encode(const Reply& reply) {
  Packet packet{reply.id, reply.trouble, {}};
  append(packet, reply.data);
  return framed(packet);
}

std::optional<Request> decode_request(const Packet& packet) {
  const auto& given = packet.parameters;
  switch (packet.what) {
    case kPing:
      if (given.empty()) return Ping{packet.id};
      break;
    case kRead:
      if (given.size() == 2) return Read{packet.id, given[0], given[1]};
      break;
    case kWrite:
    case kWriteWaits:
      if (given.size() < 2) break;
      if (auto data = data_of(given, 1)) {
        return Write{packet.id, given[0], *data, packet.what == kWriteWaits};
      }
      break;
    case kAction:
      if (given.empty()) return Action{packet.id};
      break;
    case kSetMiddle:
      if (given.empty()) return SetMiddle{packet.id};
      break;
    case kSyncRead:
      if (packet.id == kBroadcast) return sync_read(packet);
      break;
    case kSyncWrite:
      if (packet.id == kBroadcast) return sync_write(packet);
      break;
    default:
      break;
  }
  return std::nullopt;
}

std::optional<Reply> decode_reply(const Packet& packet) {
  if (packet.id > kIdMax) return std::nullopt;
  auto data = data_of(packet.parameters, 0);
  if (!data) return std::nullopt;
  return Reply{packet.id, packet.what, *data};
}

PacketDecoder::Result PacketDecoder::push(std::uint8_t byte) {
  buffer_.push_back(byte);
  Result result = Result::kMore;
  while (!buffer_.empty()) {
    const std::size_t size = buffer_.size();
    const bool header = buffer_[0] == kHeader && (size < 2 || buffer_[1] == kHeader);
    const bool id = size < 3 || buffer_[2] != kHeader;
    const std::size_t length = size < kFront ? kLeast : buffer_[3];
    const bool fits = length >= kLeast && length <= kParametersMax + kLeast;
    if (header && id && fits) {
      if (size < kFront || size < kFront + length) return result;
      const std::size_t sum = kFront + length - 1;
      if (buffer_[sum] == sum_of(buffer_, sum)) {
        packet_ = {buffer_[2], buffer_[4], {}};
        for (std::size_t i = 5; i < sum; ++i) packet_.parameters.push_back(buffer_[i]);
        buffer_.drop_front(sum + 1);
        return Result::kPacket;
      }
    }
    // Noise, or a packet that was damaged: the next one may have begun inside.
    buffer_.drop_front(1);
    result = Result::kDamaged;
  }
  return result;
}

std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t index, std::endian order) {
  SINEW_ASSERT(index + 1 < bytes.size());
  const unsigned first = bytes[index];
  const unsigned second = bytes[index + 1];
  return static_cast<std::uint16_t>(order == std::endian::little ? second << 8 | first
                                                                 : first << 8 | second);
}

void put_word(Data& data, std::uint16_t word, std::endian order) {
  const auto low = static_cast<std::uint8_t>(word & 0xFF);
  const auto high = static_cast<std::uint8_t>(word >> 8);
  data.push_back(order == std::endian::little ? low : high);
  data.push_back(order == std::endian::little ? high : low);
}

int signed_word(std::uint16_t word, int sign) {
  const unsigned bit = 1U << sign;
  const int magnitude = static_cast<int>(word & (bit - 1));
  return (word & bit) != 0 ? -magnitude : magnitude;
}

std::uint16_t sign_and_magnitude(int value, int sign) {
  const int most = (1 << sign) - 1;
  const unsigned magnitude = static_cast<unsigned>(std::min(std::abs(value), most));
  return static_cast<std::uint16_t>(magnitude | (value < 0 ? 1U << sign : 0U));
}

}  // namespace sinew::feetech
