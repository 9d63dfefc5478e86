#include "sinew/runtime/records/kept_records.h"

#include <gtest/gtest.h>

#include "sinew/runtime/records/mcap_writer.h"
#include "support/scratch_folder.h"

namespace sinew::runtime {
namespace {

std::string mcap(double length) {
  std::string bytes;
  McapWriter writer(
      [&](std::span<const std::uint8_t> more) {
        bytes.append(reinterpret_cast<const char*>(more.data()), more.size());
      },
      "test");
  const auto channel = writer.add_channel(0, "/a", "json");
  constexpr std::uint64_t kBegin = 1'795'305'600'000'000'000;
  writer.add_message(channel, kBegin, "{}");
  writer.add_message(channel, kBegin + static_cast<std::uint64_t>(length * 1e9), "{}");
  writer.finish();
  return bytes;
}

TEST(KeptRecordName, never_leads_out_of_its_folder) {
  for (const char* good : {"a.mcap", "left_move_20261122T004512.345Z.mcap", "A-b_c.1.mcap"}) {
    EXPECT_TRUE(is_record_name(good)) << good;
  }
  const std::string hostile[] = {"",
                                 ".mcap",
                                 "..mcap",
                                 "../a.mcap",
                                 "a/b.mcap",
                                 "/etc/passwd",
                                 "a.mcap/..",
                                 "a.toml",
                                 "a\\b.mcap",
                                 "a b.mcap",
                                 std::string("a\0b.mcap", 8),
                                 "\xC3\xA4.mcap",
                                 std::string(200, 'a') + ".mcap"};
  for (const std::string& bad : hostile) EXPECT_FALSE(is_record_name(bad)) << bad;
}

TEST(KeptRecords, are_listed_with_what_their_names_and_ends_say) {
  const test::ScratchFolder folder;
  folder.file("left_wave_2_20261122T004512.345Z.mcap", mcap(12.5));
  folder.file("six_fault-lost_20261123T000000.000Z.mcap", mcap(11));
  const std::string whole = mcap(3);
  folder.file("left_cut_20261121T000000.000Z.mcap", whole.substr(0, whole.size() / 2));
  folder.file("mine.mcap", mcap(1));
  folder.file("left_x_20261399T000000.000Z.mcap", "no record");
  folder.file("notes.txt", "mine");
  KeptRecords records(folder.at());
  for (int turn = 0; turn < 2; ++turn) {  // the second one from what is known
    const auto list = records.list();
    ASSERT_TRUE(list);
    ASSERT_EQ(list->size(), 5u);
    const KeptRecord& fault = (*list)[0];
    EXPECT_TRUE(fault.fault);
    EXPECT_EQ(fault.robot, "six");
    const KeptRecord& wave = (*list)[1];
    EXPECT_EQ(wave.robot, "left");
    EXPECT_EQ(wave.title, "wave_2");
    EXPECT_FALSE(wave.fault);
    EXPECT_EQ(wave.began_ms, 1'795'308'312'345);
    ASSERT_TRUE(wave.length);
    EXPECT_NEAR(*wave.length, 12.5, 1e-9);
    EXPECT_EQ(wave.size, mcap(12.5).size());
    EXPECT_FALSE((*list)[2].length);
    EXPECT_TRUE((*list)[3].robot.empty());
  }
  EXPECT_TRUE(records.check_room());
  EXPECT_TRUE(records.remove("mine.mcap"));
  EXPECT_FALSE(records.remove("mine.mcap"));
  EXPECT_EQ(records.list()->size(), 4u);
}

TEST(KeptRecords, have_a_bound) {
  const test::ScratchFolder folder;
  for (std::size_t i = 0; i < KeptRecords::kFilesMax; ++i) {
    folder.file("r" + std::to_string(i) + ".mcap", "");
  }
  const auto room = KeptRecords(folder.at()).check_room();
  ASSERT_FALSE(room);
  EXPECT_NE(room.error().sentence.find("holds 200 records"), std::string::npos);
}

}  // namespace
}  // namespace sinew::runtime
