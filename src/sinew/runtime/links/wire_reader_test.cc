#include "sinew/driver/wire_reader.h"

#include <gtest/gtest.h>

#include "sinew/devices/axis_link/axis_link_wire.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/axis_registers/axis_registers_wire.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_facts.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_text.h"
#include "sinew/devices/icp/icp_wire.h"
#include "sinew/devices/ideal/ideal_wire.h"
#include "sinew/devices/kinds.h"
#include "sinew/devices/lsc/lsc_wire.h"
#include "sinew/devices/maxarm/maxarm_wire.h"
#include "sinew/mcu/arm_link.h"
#include "sinew/runtime/links/robot_variant.h"
#include "sinew/runtime/links/wire_monitor.h"
#include "sinew/wire/cobs.h"
#include "support/robots.h"

namespace sinew::runtime {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Kind = WireMessage::Kind;

template <class Encoded>
Bytes bytes_of(const Encoded& encoded) {
  return {encoded.begin(), encoded.end()};
}
Bytes both(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}
Bytes text_bytes(std::string_view text) {
  return {text.begin(), text.end()};
}

/// What passes between host and device, piece by piece, a millisecond each.
class Ear {
 public:
  explicit Ear(const Device& device, const DeviceFacts& facts = {})
      : reader_(listener_for(device, facts)) {}

  Ear& down(const Bytes& bytes, std::uint8_t select = 0) {
    return hear(WireWay::kToDevice, bytes, select);
  }
  Ear& up(const Bytes& bytes, std::uint8_t select = 0) {
    return hear(WireWay::kToHost, bytes, select);
  }
  void wait(Duration duration) { now_ += duration; }
  const std::vector<WireMessage>& all() const { return all_; }
  std::vector<std::string> texts() const {
    std::vector<std::string> texts;
    for (const WireMessage& one : all_) texts.push_back(text_of(one));
    return texts;
  }

 private:
  Ear& hear(WireWay way, const Bytes& bytes, std::uint8_t select) {
    now_ += std::chrono::milliseconds(1);
    reader_->read({now_, way, select, bytes}, all_);
    return *this;
  }
  Instant now_{};
  std::unique_ptr<WireReader> reader_;
  std::vector<WireMessage> all_;
};

using Texts = std::vector<std::string>;

RobotModel variant(const char* robot, std::optional<std::string> profile = {},
                   std::optional<std::string> wire = {}) {
  return *variant_of(test::robot(robot), profile, wire);
}

TEST(WireReader, hexapod_bytes_mean_what_their_place_says) {
  Ear ear(variant("hexapod").device);
  icp::Status status;
  status.one.parameters = icp::kMotorParameters;
  status.one.flags.step_loss = true;
  status.two.actual = 1;
  status.two.target = 1;
  const Bytes ack{icp::kAck};
  ear.down({icp::kInit}).up(ack).down({icp::encode_step({3, true})}).up(ack);
  ear.down({icp::kInit}).up(ack).down({icp::kRequest}).up(ack).down({0x03});
  // In pieces, as a serial port gives them.
  const Bytes block = bytes_of(icp::encode_reply(status));
  ear.up({block.begin(), block.begin() + 5}).up({block.begin() + 5, block.end()});
  EXPECT_EQ(ear.texts(),
            (Texts{"open", "ack", "step: motor 3, direction 1", "ack", "open", "ack", "ask status",
                   "ack", "select: motor 3",
                   "status: motor 3, motion at_target, actual 1, target 1, temperature normal, "
                   "flags step_loss"}));
  EXPECT_EQ(ear.all().back().bytes, block);
}

TEST(WireReader, hexapod_refusals_unasked_bytes_and_bytes_out_of_place_are_told) {
  Ear ear(variant("hexapod").device);
  ear.down({0x55}).down({icp::kInit}).up({icp::kAck}).down({0x91}).up({icp::kErrorOnes});
  ear.up({0x42});
  EXPECT_EQ(ear.texts(), (Texts{"ignored", "open", "ack", "refused: why parity",
                                "refused: why ones", "unasked"}));
  EXPECT_EQ(ear.all()[0].kind, Kind::kBad);
  EXPECT_EQ(ear.all()[5].kind, Kind::kBad);
}

TEST(WireReader, learm_frames_both_ways_with_noise_between) {
  Ear ear(variant("learm", "bus").device);
  lsc::Move move{.time_ms = 100, .servos = {{1, 1500}, {6, 480}}};
  ear.down(bytes_of(lsc::encode(lsc::Request{move})));
  ear.up(both({0x12, 0x34}, bytes_of(lsc::encode(lsc::Reply{lsc::Battery{7412}}))));
  ear.up(bytes_of(lsc::encode(lsc::Reply{lsc::GroupStarted{3, 2}})));
  EXPECT_EQ(ear.texts(), (Texts{"move: time_ms 100, servos 1:1500 6:480", "noise",
                                "battery: volts 7.412", "group started: group 3, times 2"}));
  EXPECT_EQ(ear.all()[1].bytes, (Bytes{0x12, 0x34}));
  EXPECT_EQ(ear.all()[2].bytes, bytes_of(lsc::encode(lsc::Reply{lsc::Battery{7412}})));
}

TEST(WireReader, what_never_becomes_whole_is_told_as_unfinished) {
  Ear ear(variant("learm", "bus").device);
  const Bytes frame = bytes_of(lsc::encode(lsc::Request{lsc::ReadBattery{}}));
  ear.down({frame.begin(), frame.end() - 1});
  EXPECT_TRUE(ear.all().empty());
  ear.wait(std::chrono::seconds(1));
  ear.down(frame);
  EXPECT_EQ(ear.texts(), (Texts{"unfinished", "read battery"}));
  EXPECT_EQ(ear.all()[0].bytes, (Bytes{frame.begin(), frame.end() - 1}));
}

TEST(WireReader, maxarm_frames_with_the_sum_that_they_have) {
  Ear ear(variant("maxarm").device);
  ear.down(bytes_of(maxarm::encode_request(maxarm::SetAngle{{500, 600, 700}, 1200})));
  ear.down(bytes_of(maxarm::encode_request(maxarm::ReadAngle{})));
  Bytes damaged =
      bytes_of(maxarm::encode_reply(maxarm::Angles{{500, 600, -1}}, maxarm::Checksum::kSpec));
  ear.up(damaged);
  ear.up(
      bytes_of(maxarm::encode_reply(maxarm::Position{{1, -2, 3}}, maxarm::Checksum::kWithHeader)));
  damaged.back() ^= 1;
  ear.up(damaged);
  ASSERT_GE(ear.all().size(), 5U);
  EXPECT_EQ(ear.texts()[0], "set angle: pulses 500 600 700, time_ms 1200");
  EXPECT_EQ(ear.texts()[1], "read angle");
  EXPECT_EQ(ear.texts()[2], "angles: pulses 500 600 -1, checksum spec");
  EXPECT_EQ(ear.texts()[3], "xyz: xyz_mm 1 -2 3, checksum with_header");
  for (std::size_t i = 4; i < ear.all().size(); ++i) EXPECT_EQ(ear.all()[i].kind, Kind::kBad);
}

TEST(WireReader, bigrobotarm_byte_and_text_wires) {
  using namespace bigrobotarm;
  Device device = variant("bigrobotarm").device;
  const Bytes end{byte::kTerminator};
  Ear bytes(device, DeviceFacts(BigRobotArmFacts{.wire = BigRobotArmWire::kByte}));
  bytes.down(both(bytes_of(byte::encode_request(ReadStatus{})), end));
  Status status{.positions = {1, 2, 3, 4, 5}, .gripper = Gripper{true, 90}};
  bytes.up(bytes_of(byte::encode_reply(status)));
  EXPECT_EQ(bytes.texts(), (Texts{"ask status",
                                  "status: steps 1 2 3 4 5, speeds 0 0 0 0 0, accelerations 0 0 0 "
                                  "0 0, gripper yes, gripper_deg 90, sync no"}));
  EXPECT_EQ(bytes.all()[0].bytes, both(bytes_of(byte::encode_request(ReadStatus{})), end));

  Ear lines(device, DeviceFacts(BigRobotArmFacts{.wire = BigRobotArmWire::kText}));
  const auto line = text::encode_line({Request{Goto{{10, 20, 30, 40, 50}}}});
  lines.down(both(text_bytes(text::view(line)), {'\r'}));
  lines.up(text_bytes("BigRobotArm::READY\r\nwhatever\r\n"));
  lines.up(text_bytes("Process command: \xe2\x80\xae<b>\x1b[2J\r\n"));
  EXPECT_EQ(lines.texts(), (Texts{"goto: steps 10 20 30 40 50", "ready", "damaged",
                                  "echo: line \\xe2\\x80\\xae<b>\\x1b[2J"}));
}

TEST(WireReader, a_register_transaction_transfer_by_transfer) {
  using namespace axis_registers;
  const RobotModel robot = variant("robot-arm-2", {}, "registers");
  const auto& device = robot.device.settings.get<AxisRegistersDevice>();
  Ear ear(robot.device);
  const auto transfer = [&](const Bytes& mosi, const Bytes& miso) {
    ear.down(mosi, 0x04).up(miso, 0x04);
  };
  const Data status = encode_status({.motor_ok = true, .homed = true, .fault = 3});
  const HeaderBytes header = encode_header({.slave_id = device.slave_id,
                                            .frame_id = 7,
                                            .operation = 1,
                                            .address = device.registers.diag_status,
                                            .size = 4});
  transfer({kSyn}, {0});
  transfer({kDummy}, {kSynAck});
  transfer({kAck}, {0});
  transfer(bytes_of(header), Bytes(kHeaderSize, 0));
  transfer({kDummy}, {0});
  transfer(Bytes(8, kFill), bytes_of(seal(status)));
  transfer(bytes_of(encode_commit(Verdict::kOk)), Bytes(4, 0));
  Texts told;
  for (const WireMessage& one : ear.all()) {
    EXPECT_EQ(one.select, 0x04);
    if (one.kind != Kind::kFill) told.push_back(text_of(one));
  }
  EXPECT_EQ(
      told,
      (Texts{"syn", "syn ack", "ack", "read register: register diag_status, frame_id 7, size 4",
             "validation: verdict ok", "data: register diag_status, flags motor_ok homed, fault 3",
             "commit: verdict ok"}));
}

TEST(WireReader, axis_link_frames_and_silence) {
  using namespace axis_link;
  Ear ear(variant("robot-arm-2", {}, "link").device);
  ear.down(bytes_of(encode(Request{.axis = 2, .mode = Mode::kReadHealth, .sequence = 9})), 0x04);
  Reply reply{.axis = 2, .session = 1, .sequence = 8, .body = State{.homed = true}};
  Bytes frame = bytes_of(encode(reply));
  ear.up(frame, 0x04).up(Bytes(kFrameSize, 0), 0x04);
  frame[3] ^= 4;
  ear.up(frame, 0x04);
  EXPECT_EQ(ear.texts(), (Texts{"read health: sequence 9",
                                "state: sequence 8, position_deg 0, velocity_deg_s 0, flags homed, "
                                "fault 0, verdict accepted",
                                "no answer", "damaged: why checksum"}));
}

TEST(WireReader, arm_link_frames_both_ways) {
  using namespace mcu::arm_link;
  Ear ear(variant("bigrobotarm", {}, "framed").device);
  const auto framed = [](const auto& message) {
    std::array<std::uint8_t, kReplyMax> frame{};
    const std::size_t size = encode(message, frame.data());
    const auto stream = cobs::encode(std::span(frame.data(), size));
    return Bytes(stream.begin(), stream.end());
  };
  Request segment{};
  segment.kind = mcu::arm_link::Kind::kSegment;
  segment.session = 3;
  segment.sequence = 70;
  segment.segment = {20, false, mcu::kGripperStays, {256, -512, 0, 0, 1}, {1024, 0, 0, 0, 0}};
  Reply state{};
  state.kind = mcu::arm_link::Kind::kSegment;
  state.session = 3;
  state.sequence = 70;
  state.moving = true;
  state.queued_ms = 40;
  state.queue_room = 14;
  state.positions[1] = -512;
  const Bytes good = framed(state);
  Bytes damaged = good;
  damaged[9] ^= 4;
  ear.down(framed(segment)).up(good).up(damaged).up(both({0x41}, good));
  EXPECT_EQ(ear.texts(),
            (Texts{"segment: session 3, number 70, time_ms 20, units 256 -512 0 0 1, speeds 1024 0 "
                   "0 0 0",
                   "segment: session 3, number 70, units 0 -512 0 0 0, moving yes, queued_ms 40, "
                   "queue_room 14, fault none",
                   "damaged", "damaged",
                   "segment: session 3, number 70, units 0 -512 0 0 0, moving yes, queued_ms 40, "
                   "queue_room 14, fault none"}));
}

/// However a port cuts the stream, the same messages come of it, and every byte is in one.
TEST(WireReader, lines_of_the_ideal_device) {
  using namespace ideal;
  Ear ear(test::robot("puma560").device);
  Move move;
  move.number = 3;
  move.duration_us = 20000;
  move.q = {-5, 6};
  move.qd = {0, 7};
  State state;
  state.phase = Phase::kMoving;
  state.taken = 3;
  state.q = state.qd = {0, 1};
  ear.down(bytes_of(encode(Numbered<Request>{1, move})))
      .up(bytes_of(encode(Numbered<Reply>{1, state})))
      .down(text_bytes("2 stop*00000000\n"))
      .up(bytes_of(encode(Numbered<Reply>{2, Refusal{Why::kBusy}})));
  EXPECT_EQ(ear.texts(),
            (std::vector<std::string>{"move: number 3, time_us 20000, urad -5 6, urad_s 0 7",
                                      "state: phase moving, taken 3, done 0, urad 0 1, urad_s 0 1",
                                      "damaged", "refused: why busy"}));
}

TEST(WireReader, pieces_of_any_size_make_the_same_messages) {
  Bytes stream;
  for (int i = 0; i < 5; ++i) {
    stream = both(stream, bytes_of(lsc::encode(lsc::Reply{lsc::Battery{7000}})));
    stream = both(stream, {0x55, 0x01, 0x02});
    stream = both(stream, bytes_of(lsc::encode(lsc::Reply{lsc::GroupFinished{1, 1}})));
  }
  const Device device = variant("learm", "bus").device;
  for (std::size_t size = 1; size <= stream.size(); ++size) {
    Ear ear(device);
    for (std::size_t i = 0; i < stream.size(); i += size) {
      ear.up({stream.begin() + static_cast<std::ptrdiff_t>(i),
              stream.begin() + static_cast<std::ptrdiff_t>(std::min(i + size, stream.size()))});
    }
    Bytes heard;
    std::size_t good = 0;
    for (const WireMessage& one : ear.all()) {
      heard = both(heard, one.bytes);
      good += one.kind == Kind::kGood ? 1 : 0;
    }
    EXPECT_EQ(heard, stream) << size;
    EXPECT_EQ(good, 10U) << size;
  }
}

TEST(WireMonitor, tells_each_client_what_it_has_not_and_how_much_it_has_missed) {
  const Device device = variant("hexapod").device;
  WireRing ring;
  WireMonitor monitor(ring, device);
  const auto pass = [&](int count) {
    for (int i = 0; i < count; ++i) ring.add(WireWay::kToDevice, Bytes{icp::kInit}, Instant{});
  };
  pass(3);
  auto read = monitor.read({}, 0, 100);
  EXPECT_EQ(read.frames.size(), 3U);
  EXPECT_EQ(read.frames.front()->sequence, 1U);
  EXPECT_EQ(read.last, 3U);
  EXPECT_EQ(read.lost, 0U);
  pass(5);
  read = monitor.read({}, 3, 2);
  ASSERT_EQ(read.frames.size(), 2U) << "the latest";
  EXPECT_EQ(read.frames.front()->sequence, 7U);
  EXPECT_EQ(read.lost, 3U);
  EXPECT_TRUE(monitor.read({}, 8, 100).frames.empty());
  pass(static_cast<int>(WireRing::kSlots) + 50);
  read = monitor.read({}, 8, 5000);
  EXPECT_EQ(read.last, 8 + WireRing::kSlots + 50);
  EXPECT_EQ(read.frames.size() + read.lost, WireRing::kSlots + 50);
  EXPECT_EQ(read.frames.back()->sequence, read.last);
  // A number of an earlier run.
  EXPECT_EQ(monitor.read({}, 1'000'000'000, 10).frames.size(), 10U);
}

}  // namespace
}  // namespace sinew::runtime
