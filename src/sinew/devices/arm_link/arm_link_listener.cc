#include "sinew/devices/arm_link/arm_link_listener.h"

#include <algorithm>
#include <array>

#include "sinew/devices/arm_link/arm_link_wire_words.h"
#include "sinew/driver/stream_reader.h"
#include "sinew/wire/board_image.h"
#include "sinew/wire/cobs.h"

namespace sinew::wires {
namespace {

using mcu::arm_link::Kind;
using mcu::arm_link::Reply;
using mcu::arm_link::Request;

constexpr double kServoUnits = mcu::kServoUnitsPerDegree;

Told read(const Request& request) {
  Told told{arm_link::name(request.kind), {whole("session", request.session)}};
  if (mcu::arm_link::is_numbered(request.kind)) {
    told.fields.push_back(whole("number", request.sequence));
  }
  switch (request.kind) {
    case Kind::kHello:
      told.fields.push_back(whole("deadline_ms", request.deadline_ms));
      told.fields.push_back(list("brakings", request.brakings));
      break;
    case Kind::kSegment:
      told.fields.push_back(whole("time_ms", request.segment.ms));
      told.fields.push_back(list("units", request.segment.targets));
      told.fields.push_back(list("speeds", request.segment.velocities));
      break;
    case Kind::kGripper:
      told.fields.push_back(flag("gripper", request.gripper_on));
      told.fields.push_back(real("gripper_deg", request.gripper / kServoUnits));
      break;
    case Kind::kPositions:
      told.fields.push_back(list("units", request.positions));
      break;
    default:
      break;
  }
  return told;
}

Told read(const Reply& reply) {
  Told told{arm_link::name(reply.kind),
            {whole("session", reply.session), whole("number", reply.sequence)}};
  if (reply.kind == Kind::kIdentity) {
    ImageIdentity bytes{};
    std::copy_n(reply.identity, bytes.size(), bytes.begin());
    const auto image = decode_identity(bytes);
    told.fields.push_back(word("image", image ? image->board_name() : "unknown"));
    if (image) told.fields.push_back(word("version", image->version_text()));
    return told;
  }
  if (reply.kind == Kind::kStatistics) {
    told.fields.push_back(whole("starts", reply.starts));
    told.fields.push_back(whole("stack_free", reply.stack_free));
    told.fields.push_back(whole("late_slices", reply.late_slices));
    told.fields.push_back(whole("bytes_lost", reply.bytes_lost));
    told.fields.push_back(whole("frames_bad", reply.frames_bad));
    return told;
  }
  told.fields.push_back(list("units", reply.positions));
  told.fields.push_back(flag("moving", reply.moving));
  told.fields.push_back(whole("queued_ms", reply.queued_ms));
  told.fields.push_back(whole("queue_room", reply.queue_room));
  told.fields.push_back(word("fault", arm_link::name(reply.fault)));
  return told;
}

class ArmLinkReader : public StreamReader {
 protected:
  std::optional<Told> push(WireWay way, std::uint8_t byte) override {
    Way& one = ways_[static_cast<std::size_t>(way)];
    one.begun = true;  // the 00 before a frame is part of it
    const auto dropped = one.decoder.dropped();
    const auto frame = one.decoder.push(byte);
    if (!frame && one.decoder.dropped() == dropped) return std::nullopt;
    one.begun = false;
    if (!frame) return bad("damaged");
    const auto size = static_cast<std::uint8_t>(frame->size());
    if (way == WireWay::kToDevice) {
      Request request{};
      const bool good = mcu::arm_link::decode(frame->data(), size, request);
      return good ? wires::read(request) : bad("damaged");
    }
    Reply reply{};
    const bool good = mcu::arm_link::decode(frame->data(), size, reply);
    return good ? wires::read(reply) : bad("damaged");
  }
  bool between(WireWay way) const override { return !ways_[static_cast<std::size_t>(way)].begun; }
  void reset(WireWay way) override { ways_[static_cast<std::size_t>(way)] = {}; }

 private:
  struct Way {
    cobs::Decoder decoder;
    bool begun = false;  ///< a frame
  };
  std::array<Way, 2> ways_;
};

}  // namespace

std::unique_ptr<WireReader> arm_link_reader() {
  return std::make_unique<ArmLinkReader>();
}

}  // namespace sinew::wires
