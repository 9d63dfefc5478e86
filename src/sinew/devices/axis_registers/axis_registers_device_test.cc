#include "sinew/devices/axis_registers/axis_registers_device.h"

#include <gtest/gtest.h>

#include <vector>

#include "sinew/core/units.h"
#include "sinew/devices/axis/axis_device_test_fake.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace axis_registers;
using Bytes = std::vector<std::uint8_t>;
using State = AxisRegisterSlave::State;
using enum AxisRegisterProfile;

AxisRegistersDevice one_board(AngleEncoding encoding = AngleEncoding::kDegU32) {
  AxisRegistersDevice device;
  device.encoding = encoding;
  device.boards.push_back({.select_gpio = 5, .ready_gpio = 22, .zero = from_deg(-170)});
  return device;
}

struct Answer {
  Verdict verdict = Verdict::kOk;
  Bytes last;  ///< COMMIT, or data with its CRC
};

/// A board and the simplest host that can be: it sends the script and looks at nothing.
struct Board {
  explicit Board(AxisRegisterProfile profile, const AxisRegistersDevice& device = one_board())
      : slave(axis_register_slave_settings(device, 0), profile, axis) {
    axis.place(0);
  }

  Bytes send(const Bytes& mosi) {
    Bytes miso(mosi.size());
    slave.exchange(mosi, miso);
    return miso;
  }
  Verdict header(Operation operation, std::uint16_t address, std::uint16_t size,
                 std::uint16_t frame_id) {
    send({kSyn});
    EXPECT_EQ(send({kDummy}), Bytes{kSynAck});
    send({kAck});
    const HeaderBytes bytes =
        encode_header({1, frame_id, static_cast<std::uint8_t>(operation), address, size});
    send(Bytes(bytes.begin(), bytes.end()));
    return static_cast<Verdict>(send({kDummy})[0]);
  }
  Verdict header(Operation operation, std::uint16_t address, std::uint16_t size) {
    return header(operation, address, size, ++id);
  }
  Answer write(std::uint16_t address, const Bytes& data) {
    const Verdict verdict =
        header(Operation::kWrite, address, static_cast<std::uint16_t>(data.size()));
    if (verdict != Verdict::kOk) return {verdict, {}};
    const SealedData sealed = seal(data);
    send(Bytes(sealed.begin(), sealed.end()));
    return {verdict, send(Bytes(kCommitSize, kFill))};
  }
  Answer read(std::uint16_t address, std::uint16_t size) {
    const Verdict verdict = header(Operation::kRead, address, size);
    if (verdict != Verdict::kOk) return {verdict, {}};
    const Bytes sealed = send(Bytes(size + kCrcSize, kFill));
    send({kStart, kCommit, 0, kEnd});
    const auto data = unseal(sealed);
    EXPECT_TRUE(data);
    return {verdict, data ? Bytes(data->begin(), data->end()) : Bytes{}};
  }

  test::FakeAxis axis;
  AxisRegisterSlave slave;
  std::uint16_t id = 0;
};

const Bytes kCommitOk{kStart, kCommit, 0, kEnd};
const Bytes kCommitCrc{kStart, kCommit, 7, kEnd};

TEST(AxisRegisterSlave, documented_transactions_are_byte_exact) {
  Board board(kDocument);
  EXPECT_EQ(board.write(0, {1}).last, kCommitOk);
  EXPECT_TRUE(board.axis.status().homing);
  EXPECT_EQ(board.read(0, 1).last, Bytes{1}) << "HOMING reads 1 while it runs";
  board.axis.advance(Instant{} + std::chrono::seconds(60));
  EXPECT_EQ(board.read(0, 1).last, Bytes{0});
  EXPECT_EQ(board.read(3, 4).last, (Bytes{0, 0, 0, 0x1F}));
  EXPECT_EQ(board.write(1, {0, 0, 0, 140}).last, kCommitOk);
  EXPECT_NEAR(board.axis.status().q_target, from_deg(-30), 1e-12) << "140 counts from -170";
  EXPECT_EQ(board.read(1, 4).last, (Bytes{0, 0, 0, 140}));
  EXPECT_EQ(board.read(3, 4).last, (Bytes{0, 0, 0, 0x3F})) << "moving";
}

TEST(AxisRegisterSlave, emergency_stop_latches_and_its_release_resumes_nothing) {
  Board board(kDocument);
  board.write(1, {0, 0, 0, 200});
  EXPECT_TRUE(board.axis.status().moving);
  board.write(4, {1});
  EXPECT_FALSE(board.axis.status().moving);
  EXPECT_EQ(board.read(4, 1).last, Bytes{1});
  EXPECT_EQ(board.read(3, 4).last, (Bytes{0, 0, 0, 0x9F}));
  board.write(4, {0});
  EXPECT_EQ(board.read(4, 1).last, Bytes{0});
  EXPECT_FALSE(board.axis.status().moving);
  board.write(4, {0x42});
  EXPECT_TRUE(board.axis.status().emergency_stopped) << "whatever is not a clear no stops";
}

TEST(AxisRegisterSlave, faults_and_self_test_go_through_the_diag_registers) {
  Board board(kDocument);
  board.axis.told().fault = AxisFault::kStalled;
  EXPECT_EQ(board.read(3, 4).last[2], 2);
  board.write(2, {1});
  EXPECT_EQ(board.read(3, 4).last[2], 0);
  board.write(2, {2});
  EXPECT_EQ(board.axis.self_tests, 1);
  EXPECT_EQ(board.axis.clears, 1);
  board.write(0, {1});
  board.write(0, {0});
  EXPECT_EQ(board.axis.cancels, 1);
  EXPECT_FALSE(board.axis.status().homing);
}

TEST(AxisRegisterSlave, all_four_encodings_of_ninety_degrees_move_to_ninety_degrees) {
  const std::vector<std::pair<AngleEncoding, Bytes>> kNinety{
      {AngleEncoding::kDegU32, {0, 0, 1, 4}},  // 260 from -170
      {AngleEncoding::kMdegI32, {0x00, 0x01, 0x5F, 0x90}},
      {AngleEncoding::kF32Be, {0x42, 0xB4, 0x00, 0x00}},
      {AngleEncoding::kF32Le, {0x00, 0x00, 0xB4, 0x42}}};
  for (const auto& [encoding, bytes] : kNinety) {
    Board board(kDocument, one_board(encoding));
    EXPECT_EQ(board.write(1, bytes).last, kCommitOk);
    EXPECT_NEAR(to_deg(board.axis.status().q_target), 90, 1e-9);
    EXPECT_EQ(board.read(1, 4).last, bytes);
  }
  Board board(kDocument, one_board(AngleEncoding::kF32Be));
  board.write(1, {0x7F, 0xC0, 0, 0});
  EXPECT_EQ(board.axis.moves, 0) << "not a number";
}

TEST(AxisRegisterSlave, a_refused_target_is_not_read_back) {
  Board board(kDocument);
  board.write(1, {0, 0, 0, 200});
  board.write(1, {0, 0, 0x10, 0});
  EXPECT_EQ(board.read(1, 4).last, (Bytes{0, 0, 0, 200}));
}

TEST(AxisRegisterSlave, register_access_is_checked) {
  for (const auto profile : {kDocument, kAsBuilt}) {
    Board board(profile);
    EXPECT_EQ(board.read(2, 1).verdict, Verdict::kOperation);
    EXPECT_EQ(board.write(3, {0, 0, 0, 0}).verdict, Verdict::kOperation);
    EXPECT_EQ(board.read(5, 1).verdict, Verdict::kRegister);
    EXPECT_EQ(board.read(1, 5).verdict, Verdict::kSize);
    EXPECT_EQ(board.slave.state(), State::kWaitSyn) << "an error ends the transaction";
  }
}

TEST(AxisRegisterSlave, row_1_as_built_reads_the_lowest_byte_four_times) {
  Board board(kAsBuilt);
  board.write(1, {0x12, 0x34, 0x56, 0x78});
  EXPECT_EQ(board.read(1, 4).last, (Bytes{0x78, 0x78, 0x78, 0x78}));
  board.write(1, {0, 0, 0x03, 0xE8});
  EXPECT_EQ(board.read(1, 4).last, (Bytes{0xE8, 0xE8, 0xE8, 0xE8}));
  board.write(4, {1});
  EXPECT_EQ(board.read(4, 1).last, Bytes{1}) << "one byte is read right";
}

TEST(AxisRegisterSlave, row_2_as_built_checks_the_end_before_the_id) {
  for (const auto& [profile, expected] :
       {std::pair(kDocument, Verdict::kSlaveId), std::pair(kAsBuilt, Verdict::kEndByte)}) {
    Board board(profile);
    HeaderBytes bytes = encode_header({2, 9, 2, 4, 1});
    bytes.back() = 0;
    board.send({kSyn});
    board.send({kDummy});
    board.send({kAck});
    board.send(Bytes(bytes.begin(), bytes.end()));
    EXPECT_EQ(board.send({kDummy})[0], static_cast<std::uint8_t>(expected));
  }
}

TEST(AxisRegisterSlave, row_3_a_short_write_sets_the_high_bytes_and_nobody_looks) {
  Board board(kAsBuilt);
  board.write(1, {1, 2, 3, 4});
  const std::uint32_t looked = board.slave.changes();
  EXPECT_EQ(board.write(1, {0xAA, 0xBB}).last, kCommitOk);
  EXPECT_EQ(board.slave.register_value(Register::kMoveAngle), (Data{0xAA, 0xBB, 3, 4}));
  EXPECT_EQ(board.slave.changes(), looked);
  Board strict(kDocument);
  EXPECT_EQ(strict.write(1, {0xAA, 0xBB}).verdict, Verdict::kSize);
}

TEST(AxisRegisterSlave, row_4_an_id_counts_as_used_once_its_header_is_accepted) {
  for (const auto profile : {kDocument, kAsBuilt}) {
    Board board(profile);
    const Verdict first = profile == kDocument ? Verdict::kOk : Verdict::kFrameId;
    EXPECT_EQ(board.header(Operation::kWrite, 4, 1, 0xFFFF), first) << "after power-on";
    board.slave.power_up();
    EXPECT_EQ(board.header(Operation::kWrite, 4, 1, 50), Verdict::kOk);
    board.send({1, 0, 0, 0, 0});  // wrong CRC
    EXPECT_EQ(board.send(Bytes(4, kFill)), kCommitCrc);
    EXPECT_EQ(board.header(Operation::kWrite, 4, 1, 50), Verdict::kFrameId);
    EXPECT_EQ(board.header(Operation::kWrite, 4, 1, 3), Verdict::kOk) << "lower ones pass";
    board.slave.power_up();
    EXPECT_EQ(board.header(Operation::kWrite, 4, 1, 3), Verdict::kOk) << "forgotten";
  }
}

TEST(AxisRegisterSlave, row_5_ready_tells_nothing_as_built) {
  Board built(kAsBuilt);
  EXPECT_FALSE(built.slave.ready_pin()) << "low at boot";
  built.send({kSyn});
  EXPECT_FALSE(built.slave.ready_pin());
  Board board(kDocument);
  EXPECT_TRUE(board.slave.ready_pin());
  board.write(4, {1});
  EXPECT_FALSE(board.slave.ready_pin()) << "carried out";
  board.send({kSyn});
  EXPECT_TRUE(board.slave.ready_pin());
}

TEST(AxisRegisterSlave, row_8_miso_repeats_its_last_byte_while_it_receives) {
  for (const auto profile : {kDocument, kAsBuilt}) {
    Board board(profile);
    EXPECT_EQ(board.send({kSyn}), Bytes{0}) << "nothing was sent yet";
    EXPECT_EQ(board.send({kDummy}), Bytes{0x98});
    EXPECT_EQ(board.send({kAck}), Bytes{0x98});
    const HeaderBytes header = encode_header({1, 1, 1, 4, 1});
    EXPECT_EQ(board.send(Bytes(header.begin(), header.end())), Bytes(14, 0x98));
    EXPECT_EQ(board.send({kDummy}), Bytes{0x00});
    EXPECT_EQ(board.send(Bytes(5, 0)), (Bytes{0x00, 0xC7, 0x04, 0xDD, 0x7B}));
    EXPECT_EQ(board.send(kCommitOk), Bytes(4, 0x7B));
    EXPECT_EQ(board.send({kSyn}), Bytes{0x7B}) << "seen in the hardware log";
  }
}

TEST(AxisRegisterSlave, row_9_wrong_bytes_before_the_header_change_nothing) {
  Board board(kAsBuilt);
  for (int byte = 0; byte < 256; ++byte) {
    if (byte != kSyn) board.send({static_cast<std::uint8_t>(byte)});
    ASSERT_EQ(board.slave.state(), State::kWaitSyn);
  }
  board.send({kSyn});
  board.send({kDummy});
  for (int byte = 0; byte < 256; ++byte) {
    if (byte != kAck) board.send({static_cast<std::uint8_t>(byte)});
    ASSERT_EQ(board.slave.state(), State::kWaitAck);
  }
}

TEST(AxisRegisterSlave, row_10_half_a_transfer_begins_again_and_extra_bytes_are_ignored) {
  for (const auto profile : {kDocument, kAsBuilt}) {
    Board board(profile);
    board.send({kSyn, 1, 2, 3});
    EXPECT_EQ(board.slave.state(), State::kSendSynAck);
    EXPECT_EQ(board.send({kDummy, kDummy, kDummy}), Bytes(3, kSynAck));
    board.send({kAck, kSyn});
    EXPECT_EQ(board.slave.state(), State::kWaitHeader);
    const HeaderBytes header = encode_header({1, 1, 2, 4, 1});
    board.send(Bytes(header.begin(), header.begin() + 13));
    EXPECT_EQ(board.slave.state(), State::kWaitHeader);
    board.send(Bytes(header.begin(), header.end()));
    EXPECT_EQ(board.send({kDummy})[0], 0);
    board.send({1, 0xC3});
    board.send({1, 0xC3, 0xC5, 0xC0, 0xCC});
    EXPECT_EQ(board.send({0, 0}), (Bytes{kStart, kCommit})) << "broken off";
    EXPECT_EQ(board.send(Bytes(4, 0)), kCommitOk) << "from its first byte";
    EXPECT_EQ(board.slave.register_value(Register::kEmergencyStop), Data{1});
  }
}

TEST(AxisRegisterSlave, clocks_without_a_select_fill_an_armed_transfer_as_with_a_software_select) {
  Board board(kAsBuilt);
  board.header(Operation::kWrite, 4, 1);
  ASSERT_EQ(board.slave.state(), State::kWaitData);
  board.slave.select(true);
  for (int i = 0; i < 48; ++i) board.slave.shift(0);
  EXPECT_EQ(board.slave.state(), State::kSendCommit) << "row 16: moved on, and still stuck";
}

TEST(AxisRegisterSlave, row_11_bad_data_is_answered_07_and_touches_nothing) {
  for (const auto profile : {kDocument, kAsBuilt}) {
    Board board(profile);
    board.write(4, {0});
    board.header(Operation::kWrite, 4, 1);
    board.send({1, 0xC3, 0xC5, 0xC0, 0xCD});
    EXPECT_EQ(board.send(Bytes(4, 0)), kCommitCrc);
    EXPECT_EQ(board.slave.state(), State::kWaitSyn);
    EXPECT_EQ(board.slave.register_value(Register::kEmergencyStop), Data{0});
    EXPECT_EQ(board.axis.stops, 0);
  }
}

TEST(AxisRegisterSlave, row_12_what_the_host_commits_on_a_read_is_ignored) {
  for (const Bytes& commit : {kCommitOk, kCommitCrc, Bytes{1, 2, 3, 4}}) {
    Board board(kAsBuilt);
    board.header(Operation::kRead, 4, 1);
    board.send(Bytes(5, 0));
    board.send(commit);
    EXPECT_EQ(board.slave.state(), State::kWaitSyn);
  }
}

TEST(AxisRegisterSlave, row_22_later_boards_have_their_own_map) {
  AxisRegistersDevice device = one_board(AngleEncoding::kF32Be);
  device.registers = {0, 1, 3, 4, 5};
  Board board(kDocument, device);
  EXPECT_EQ(board.write(2, {1}).last, kCommitOk);
  EXPECT_EQ(board.read(2, 1).last, Bytes{1}) << "ENABLE_MOTOR, where older boards clear faults";
  EXPECT_EQ(board.axis.clears, 0);
  EXPECT_EQ(board.write(3, {1}).last, kCommitOk);
  EXPECT_EQ(board.axis.clears, 1);
  EXPECT_EQ(board.write(4, {1}).verdict, Verdict::kSize) << "DIAG_STATUS, where E-STOP was";
  EXPECT_EQ(board.write(4, {0, 0, 0, 1}).verdict, Verdict::kOperation);
  EXPECT_EQ(board.read(4, 4).last, (Bytes{0, 0, 0, 0x1F}));
  board.write(5, {1});
  EXPECT_TRUE(board.axis.status().emergency_stopped);
  board.write(6, {1});
  EXPECT_TRUE(board.slave.in_boot_loader());
  board.send({kSyn});
  EXPECT_EQ(board.slave.state(), State::kSendCommit) << "nobody is there";
  board.slave.power_up();
  EXPECT_EQ(board.read(4, 4).verdict, Verdict::kOk);
}

TEST(AxisRegisterSlave, rows_23_to_26_as_built_stores_and_does_nothing) {
  Board board(kAsBuilt);
  board.write(1, {0, 0, 0, 90});
  board.write(4, {1});
  board.write(2, {1});
  EXPECT_EQ(board.write(0, {1}).last, kCommitOk);
  EXPECT_EQ(board.read(0, 1).last, Bytes{0}) << "HOMING reads back 0 at once";
  EXPECT_EQ(board.read(4, 1).last, Bytes{1});
  EXPECT_EQ(board.read(3, 4).last, (Bytes{0, 0, 0, 0})) << "DIAG_STATUS is never written";
  EXPECT_EQ(board.axis.moves + board.axis.stops + board.axis.homings + board.axis.clears, 0);
}

/// Brings the board into one of its states; `deaths` of a host are the first six and their twins.
void leave_after(Board& board, Operation operation, int transfers) {
  const bool write = operation == Operation::kWrite;
  const HeaderBytes header =
      encode_header({1, ++board.id, static_cast<std::uint8_t>(operation), 1, 4});
  const SealedData sealed = seal(Bytes{0, 0, 0, 90});
  const std::vector<Bytes> script{
      {kSyn},   {kDummy},
      {kAck},   Bytes(header.begin(), header.end()),
      {kDummy}, write ? Bytes(sealed.begin(), sealed.end()) : Bytes(8, kFill)};
  for (int i = 0; i < transfers; ++i) board.send(script[static_cast<std::size_t>(i)]);
}

TEST(AxisRegisterSlave, four_bursts_bring_every_state_to_where_it_waits_for_syn) {
  for (const auto profile : {kDocument, kAsBuilt}) {
    for (const auto operation : {Operation::kRead, Operation::kWrite}) {
      for (int transfers = 0; transfers <= 6; ++transfers) {
        Board board(profile);
        leave_after(board, operation, transfers);
        const int moves = board.axis.moves;
        for (int burst = 0; burst < kResyncBursts; ++burst) {
          board.send(Bytes(kResyncSize, kResyncByte));
        }
        EXPECT_EQ(board.slave.state(), State::kWaitSyn) << transfers;
        EXPECT_EQ(board.axis.moves, moves) << "a burst moves nothing";
        EXPECT_EQ(board.write(4, {1}).last, kCommitOk);
      }
    }
  }
}

TEST(AxisRegisterSlave, any_noise_is_survived_and_four_bursts_end_it) {
  test::for_random_cases(3'000, [](test::Random& random) {
    Board board(random.chance(0.5) ? kDocument : kAsBuilt);
    for (int frame = 0; frame < 60; ++frame) {
      if (random.chance(0.5)) {
        leave_after(board, random.chance(0.5) ? Operation::kRead : Operation::kWrite,
                    static_cast<int>(random.integer(1, 6)));
      }
      Bytes noise(static_cast<std::size_t>(random.integer(1, 40)));
      for (auto& byte : noise) {
        byte = static_cast<std::uint8_t>(random.chance(0.3) ? random.integer(0x97, 0x99)
                                                            : random.integer(0, 255));
      }
      board.send(noise);
    }
    for (int burst = 0; burst < kResyncBursts; ++burst) {
      board.send(Bytes(kResyncSize, kResyncByte));
    }
    ASSERT_EQ(board.slave.state(), State::kWaitSyn);
    board.id = static_cast<std::uint16_t>(board.id + 1);
    EXPECT_EQ(board.write(4, {1}).last, kCommitOk);
  });
}

TEST(AxisRegisterSlave, exchanging_does_not_allocate) {
  for (const auto profile : {kDocument, kAsBuilt}) {
    Board board(profile);
    const HeaderBytes header = encode_header({1, 9, 2, 1, 4});
    const SealedData sealed = seal(std::array<std::uint8_t, 4>{0, 0, 0, 90});
    std::array<std::uint8_t, 32> miso{};
    const test::AllocationCounter allocations;
    for (const std::uint8_t byte : {kSyn, kDummy, kAck}) board.slave.exchange({&byte, 1}, miso);
    board.slave.exchange(header, miso);
    board.slave.exchange({&kDummy, 1}, miso);
    board.slave.exchange({sealed.data(), sealed.size()}, miso);
    EXPECT_EQ(allocations.count(), 0U);
    EXPECT_EQ(board.slave.state(), State::kSendCommit);
  }
}

}  // namespace
}  // namespace sinew
