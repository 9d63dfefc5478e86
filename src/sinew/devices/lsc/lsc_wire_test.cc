#include "sinew/devices/lsc/lsc_wire.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "support/allocation_guard.h"
#include "support/golden.h"
#include "support/property.h"

namespace sinew::lsc {
namespace {

using ByteList = std::vector<std::uint8_t>;
using Words = std::vector<std::string>;

template <class Integer>
Integer number(const std::string& word) {
  return static_cast<Integer>(std::stol(word));
}

ServoValues values_of(const Words& words, std::size_t first) {
  ServoValues servos;
  for (std::size_t i = first; i < words.size(); ++i) {
    const auto parts = test::split(words[i], ':');
    servos.push_back({number<std::uint8_t>(parts.at(0)), number<std::uint16_t>(parts.at(1))});
  }
  return servos;
}

ServoOffsets offsets_of(const Words& words) {
  ServoOffsets servos;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto parts = test::split(words[i], ':');
    servos.push_back({number<std::uint8_t>(parts.at(0)), number<std::int8_t>(parts.at(1))});
  }
  return servos;
}

ServoIds ids_of(const Words& words) {
  ServoIds ids;
  for (std::size_t i = 1; i < words.size(); ++i) ids.push_back(number<std::uint8_t>(words[i]));
  return ids;
}

Request request_of(const std::string& meaning) {
  const Words words = test::words_in(meaning);
  const std::string& name = words.at(0);
  const auto u8 = [&](std::size_t i) { return number<std::uint8_t>(words.at(i)); };
  const auto i8 = [&](std::size_t i) { return number<std::int8_t>(words.at(i)); };
  const auto u16 = [&](std::size_t i) { return number<std::uint16_t>(words.at(i)); };
  const auto i16 = [&](std::size_t i) { return number<std::int16_t>(words.at(i)); };
  using Step = GroupStep::Kind;
  if (name == "move") return Move{u16(1), values_of(words, 2)};
  if (name == "run") return RunGroup{u8(1), u16(2)};
  if (name == "stop-group") return StopGroup{};
  if (name == "erase") return EraseGroup{u8(1)};
  if (name == "speed") return SetGroupSpeed{u8(1), u16(2)};
  if (name == "save-offsets") return SaveOffsets{};
  if (name == "battery") return ReadBattery{};
  if (name == "unload") return Unload{ids_of(words)};
  if (name == "positions") return ReadPositions{ids_of(words)};
  if (name == "store-offsets") return StoreBusOffsets{ids_of(words)};
  if (name == "bus-offsets") return ReadBusOffsets{ids_of(words)};
  if (name == "adjust-offset") return AdjustBusOffset{u8(1), i16(2), words.at(3) == "wide"};
  if (name == "mode") return SetMode{u8(1), u8(2), i16(3)};
  if (name == "write-info") return WriteBusInfo{};
  if (name == "read-info") return ReadBusInfo{};
  if (name == "begin") return GroupStep{Step::kBegin, u8(1), 0, 0, {}};
  if (name == "actions") return GroupStep{Step::kCount, u8(1), 0, 0, {}};
  if (name == "blocks") return GroupStep{Step::kBlocks, u8(1), 0, 0, {}};
  if (name == "action") {
    return GroupStep{Step::kAction, 0, u8(1), u8(2), {u16(3), values_of(words, 4)}};
  }
  if (name == "end") return GroupStep{Step::kEnd, 0, 0, 0, {}};
  if (name == "version") return ReadVersion{};
  if (name == "offsets") return ReadOffsets{};
  if (name == "jog") return Jog{i8(1), i8(2), i8(3)};
  if (name == "chassis") return Chassis{};
  if (name == "set-offset") return SetOffset{{u8(1), i8(2)}};
  if (name == "home") return GoHome{};
  if (name == "commanded") return ReadCommanded{};
  if (name == "store-action") {
    return StoreAction{u8(1), u8(2), u8(3), {u16(4), values_of(words, 5)}};
  }
  throw std::runtime_error("no such request: " + meaning);
}

Reply reply_of(const std::string& meaning) {
  const Words words = test::words_in(meaning);
  const std::string& name = words.at(0);
  const auto u8 = [&](std::size_t i) { return number<std::uint8_t>(words.at(i)); };
  const auto u16 = [&](std::size_t i) { return number<std::uint16_t>(words.at(i)); };
  if (name == "battery") return Battery{u16(1)};
  if (name == "started") return GroupStarted{u8(1), u16(2)};
  if (name == "stopped") return GroupStopped{};
  if (name == "finished") return GroupFinished{u8(1), u16(2)};
  if (name == "erased") return GroupErased{};
  if (name == "version") return Version{u8(1), u8(2)};
  if (name == "step") return GroupStepTaken{u8(1)};
  if (name == "saved") return OffsetsSaved{};
  if (name == "positions") return Positions{values_of(words, 1)};
  if (name == "bus-offsets") return BusOffsets{offsets_of(words)};
  if (name == "stored") return ActionStored{};
  if (name == "info") return BusInfo{Parameters{u8(1)}};
  if (name == "commanded") {
    Commanded commanded;
    std::ranges::copy(values_of(words, 1), commanded.servos.begin());
    return commanded;
  }
  if (name == "offsets") {
    Offsets offsets;
    std::ranges::copy(offsets_of(words), offsets.servos.begin());
    return offsets;
  }
  throw std::runtime_error("no such reply: " + meaning);
}

std::vector<Dialect> dialects_of(const std::string& name) {
  if (name == "lsc6") return {Dialect::kLsc6};
  if (name == "bus") return {Dialect::kBus};
  if (name == "esp32") return {Dialect::kEsp32};
  return {Dialect::kLsc6, Dialect::kBus, Dialect::kEsp32};
}

std::vector<Frame> decode(FrameDecoder& decoder, std::span<const std::uint8_t> bytes) {
  std::vector<Frame> frames;
  for (const std::uint8_t byte : bytes) {
    if (const auto frame = decoder.push(byte)) frames.push_back(*frame);
  }
  return frames;
}

std::vector<Frame> decode(std::span<const std::uint8_t> bytes) {
  FrameDecoder decoder;
  return decode(decoder, bytes);
}

ByteList list(const Bytes& bytes) {
  return {bytes.begin(), bytes.end()};
}

TEST(Lsc, every_golden_request_is_read_and_written) {
  int count = 0;
  for (const auto& golden : test::read_goldens("lsc.txt")) {
    if (golden.who == "board") continue;
    ++count;
    const ByteList bytes = test::from_hex(golden.bytes);
    const Request meaning = request_of(golden.meaning);
    EXPECT_EQ(list(encode(meaning)), bytes) << golden.where;
    const auto frames = decode(bytes);
    ASSERT_EQ(frames.size(), 1U) << golden.where;
    for (const Dialect dialect : dialects_of(test::words_in(golden.who).at(1))) {
      EXPECT_EQ(decode_request(frames[0], dialect), meaning) << golden.where;
    }
  }
  EXPECT_EQ(count, 37);
}

TEST(Lsc, every_golden_reply_is_read_and_written) {
  int count = 0;
  for (const auto& golden : test::read_goldens("lsc.txt")) {
    if (golden.who != "board") continue;
    ++count;
    const ByteList bytes = test::from_hex(golden.bytes);
    const Reply meaning = reply_of(golden.meaning);
    EXPECT_EQ(list(encode(meaning)), bytes) << golden.where;
    const auto frames = decode(bytes);
    ASSERT_EQ(frames.size(), 1U) << golden.where;
    EXPECT_EQ(decode_reply(frames[0]), meaning) << golden.where;
  }
  EXPECT_EQ(count, 15);
}

TEST(Lsc, a_board_understands_only_the_commands_that_it_has) {
  // One row a command: what each board makes of it without or with the parameters it needs.
  const auto known = [](const Request& request, Dialect dialect) {
    return decode_request(decode(encode(request)).at(0), dialect).has_value();
  };
  for (const auto& [request, lsc6, bus, esp32] :
       std::vector<std::tuple<Request, bool, bool, bool>>{{ReadVersion{}, false, false, true},
                                                          {Move{20, {{1, 500}}}, true, true, true},
                                                          {Jog{}, false, false, true},
                                                          {GroupStep{}, true, true, false},
                                                          {RunGroup{}, true, true, true},
                                                          {EraseGroup{}, true, true, true},
                                                          {SetOffset{}, false, false, true},
                                                          {SetGroupSpeed{}, true, true, false},
                                                          {SaveOffsets{}, false, false, true},
                                                          {GoHome{}, false, false, true},
                                                          {ReadCommanded{}, false, false, true},
                                                          {ReadBattery{}, true, true, false},
                                                          {Unload{{1}}, false, true, false},
                                                          {ReadPositions{{1}}, false, true, false},
                                                          {AdjustBusOffset{}, false, true, false},
                                                          {SetMode{}, false, true, false},
                                                          {ReadBusInfo{}, false, true, false}}) {
    const int command = encode(request)[3];
    EXPECT_EQ(known(request, Dialect::kLsc6), lsc6) << command;
    EXPECT_EQ(known(request, Dialect::kBus), bus) << command;
    EXPECT_EQ(known(request, Dialect::kEsp32), esp32) << command;
  }
}

TEST(Lsc, wrong_counts_and_lengths_are_no_request) {
  for (const char* hex : {"55 55 08 03 02 E8 03 01 D0 07",     // one servo where two are announced
                          "55 55 09 03 01 E8 03 01 D0 07 00",  // a byte too many
                          "55 55 05 03 00 E8 03", "55 55 02 03",  // no servo
                          "55 55 03 06 08", "55 55 03 07 00", "55 55 03 0F 01"}) {
    const auto frames = decode(test::from_hex(hex));
    ASSERT_EQ(frames.size(), 1U) << hex;
    EXPECT_FALSE(decode_request(frames[0], Dialect::kLsc6)) << hex;
  }
  const auto nine =
      decode(test::from_hex("55 55 20 03 09 64 00 01 0000 02 0000 03 0000 04 0000 05 0000 06 0000 "
                            "07 0000 08 0000 09 0000"));
  ASSERT_EQ(nine.size(), 1U);
  EXPECT_FALSE(decode_request(nine[0], Dialect::kBus));
}

TEST(Lsc, third_55_moves_the_header_and_an_impossible_length_ends_it) {
  FrameDecoder decoder;
  EXPECT_EQ(decode(decoder, test::from_hex("55 55 55 55 02 07")).size(), 1U);
  EXPECT_EQ(decoder.skipped(), 2U);
  for (const char* hex : {"55 55 00", "55 55 01", "55 55 23", "55 55 FF"}) {
    FrameDecoder fresh;
    EXPECT_TRUE(decode(fresh, test::from_hex(hex)).empty());
    EXPECT_TRUE(fresh.at_boundary()) << hex;
    EXPECT_EQ(decode(fresh, test::from_hex("55 55 02 07")).size(), 1U) << hex;
  }
}

TEST(Lsc, esp32_takes_a_third_55_for_a_length_and_swallows_as_much) {
  FrameDecoder decoder(LengthRule::kAnything);
  ByteList bytes = test::from_hex("55 55 55");
  for (int i = 0; i < 21; ++i) bytes.insert(bytes.end(), {0x55, 0x55, 2, 7});
  EXPECT_TRUE(decode(decoder, bytes).empty());
  EXPECT_TRUE(decoder.at_boundary());
  EXPECT_EQ(decoder.skipped(), bytes.size());
  EXPECT_EQ(decode(decoder, test::from_hex("55 55 02 07")).size(), 1U);
}

TEST(Lsc, frames_are_found_between_boot_text_and_garbage) {
  ByteList stream;
  const auto text = [&](const std::string& words) {
    stream.insert(stream.end(), words.begin(), words.end());
  };
  const auto frame = [&](const Reply& reply) {
    const Bytes bytes = encode(reply);
    stream.insert(stream.end(), bytes.begin(), bytes.end());
  };
  text("pwm servo\r\nbegin\r\n");
  frame(Version{1, 5});
  text("U");  // one 55 alone
  frame(Battery{7500});
  text("\r\n");
  frame(GroupFinished{8, 1});
  FrameDecoder decoder;
  std::vector<Reply> replies;
  for (const Frame& found : decode(decoder, stream)) replies.push_back(*decode_reply(found));
  EXPECT_EQ(replies, (std::vector<Reply>{Version{1, 5}, Battery{7500}, GroupFinished{8, 1}}));
  EXPECT_EQ(decoder.skipped(), 21U);
}

TEST(Lsc, six_servos_take_25_bytes) {
  Move move{100, {}};
  for (std::uint8_t id = 1; id <= 6; ++id) move.servos.push_back({id, 1500});
  EXPECT_EQ(encode(Request{move}).size(), 25U);
}

Request random_move(test::Random& random) {
  Move move{static_cast<std::uint16_t>(random.integer(0, 65535)), {}};
  for (std::int64_t n = random.integer(1, kServosMax); n > 0; --n) {
    const bool header = random.chance(0.2);  // 55 55 inside data, often
    move.servos.push_back({static_cast<std::uint8_t>(header ? 0x55 : random.integer(0, 255)),
                           static_cast<std::uint16_t>(header ? 0x5555 : random.integer(0, 65535))});
  }
  return move;
}

TEST(Lsc, random_moves_survive_every_cut_between_other_frames) {
  test::for_random_cases(20'000, [](test::Random& random) {
    ByteList stream;
    std::vector<Request> sent;
    for (int i = 0; i < 3; ++i) {
      sent.push_back(random_move(random));
      const Bytes bytes = encode(sent.back());
      stream.insert(stream.end(), bytes.begin(), bytes.end());
    }
    const auto cut =
        static_cast<std::size_t>(random.integer(0, static_cast<std::int64_t>(stream.size())));
    FrameDecoder decoder;
    const std::span<const std::uint8_t> bytes(stream);
    auto frames = decode(decoder, bytes.first(cut));
    FrameDecoder copy = decoder;
    for (const Frame& frame : decode(copy, bytes.subspan(cut))) frames.push_back(frame);
    ASSERT_EQ(frames.size(), sent.size());
    for (std::size_t i = 0; i < sent.size(); ++i) {
      EXPECT_EQ(decode_request(frames[i], Dialect::kBus), sent[i]);
    }
    EXPECT_EQ(copy.skipped(), 0U);
  });
}

TEST(Lsc, after_any_noise_a_frame_and_a_pause_the_next_frame_is_read) {
  test::for_random_cases(50'000, [](test::Random& random) {
    FrameDecoder decoder;
    for (std::int64_t n = random.integer(0, 60); n > 0; --n) {
      const bool header = random.chance(0.4);
      (void)decoder.push(header ? kHeader : static_cast<std::uint8_t>(random.integer(0, 255)));
    }
    // Without a pause the noise may have begun a frame; its longest swallows this many bytes.
    for (std::size_t i = 0; i <= kFrameMax; ++i) (void)decoder.push(0);
    EXPECT_TRUE(decoder.at_boundary());
    EXPECT_EQ(decode(decoder, encode(Request{StopGroup{}})).size(), 1U);
    (void)decoder.push(kHeader);
    decoder.reset();
    EXPECT_EQ(decode(decoder, encode(Reply{Battery{5000}})).size(), 1U);
  });
}

TEST(Lsc, a_flipped_bit_is_another_valid_move_in_two_places_of_five) {
  // What docs/wires/lsc.md says of the wire's weakness, counted.
  const Bytes move = encode(Request{Move{100, {{6, 1500}, {5, 1255}, {4, 511}, {3, 644}}}});
  int passed = 0;
  for (std::size_t bit = 0; bit < 8 * move.size(); ++bit) {
    Bytes damaged = move;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    const auto frames = decode(damaged);
    if (frames.size() != 1) continue;
    const auto request = decode_request(frames[0], Dialect::kLsc6);
    const auto* other = request ? std::get_if<Move>(&*request) : nullptr;
    if (other == nullptr) continue;
    const bool sane = std::ranges::all_of(other->servos, [](const ServoValue& servo) {
      return servo.id >= 1 && servo.id <= 6 && servo.value >= 500 && servo.value <= 2500;
    });
    passed += sane ? 1 : 0;
  }
  EXPECT_EQ(passed, 60) << "of " << 8 * move.size();
}

TEST(Lsc, coding_does_not_allocate) {
  const test::AllocationCounter allocations;
  FrameDecoder decoder;
  for (const std::uint8_t byte : encode(Request{Move{100, {{6, 1500}}}})) {
    if (const auto frame = decoder.push(byte)) (void)decode_request(*frame, Dialect::kLsc6);
  }
  for (const std::uint8_t byte : encode(Reply{Battery{7500}})) {
    if (const auto frame = decoder.push(byte)) (void)decode_reply(*frame);
  }
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::lsc
