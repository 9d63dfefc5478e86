#include "sinew/server/files/event_file.h"

#include <gtest/gtest.h>

#include "sinew/server/api/api_test_cell.h"
#include "sinew/server/files/event_log.h"
#include "support/scratch_folder.h"

namespace sinew::server {
namespace {

using sinew::test::ScratchFolder;
using test::ApiCell;
using test::ApiClient;
using test::place;

std::string line(int number) {
  return Json{{"number", number}, {"at_ms", 1'000 + number}, {"robot", "left"}, {"kind", "state"}}
      .dump();
}

std::vector<int> times_in(const std::string& path) {
  auto opened = EventFile::open(path);
  if (!opened) {
    ADD_FAILURE() << opened.error().sentence;
    return {};
  }
  std::vector<int> times;
  for (const Json& event : opened->events) times.push_back(event["at_ms"].get<int>());
  return times;
}

TEST(EventFile, holds_what_was_added_in_its_order) {
  const ScratchFolder folder;
  const std::string path = folder.at("made/for/it/cell.jsonl");
  {
    auto opened = EventFile::open(path);
    ASSERT_TRUE(opened) << opened.error().sentence;
    EXPECT_TRUE(opened->events.empty());
    opened->file.add({line(1), line(2)});
    opened->file.add({line(3)});
  }
  EXPECT_EQ(times_in(path), (std::vector{1001, 1002, 1003}));
  EXPECT_EQ(times_in(path), (std::vector{1001, 1002, 1003})) << "reading changes nothing";
}

TEST(EventFile, half_a_line_and_what_is_no_event_are_left_out) {
  const ScratchFolder folder;
  const std::string path = folder.at("cell.jsonl");
  const std::string deep(100'000, '[');
  ASSERT_TRUE(io::replace_file(path, "\n" + line(1) + "\n{}\n[1,2]\n\x00\xff\n" + deep + "\n" +
                                         R"({"at_ms":"x","robot":"left","kind":"state"})" + "\n" +
                                         line(2) + "\n" + line(3).substr(0, 20)));
  EXPECT_EQ(times_in(path), (std::vector{1001, 1002}));
  {
    auto opened = EventFile::open(path);
    ASSERT_TRUE(opened);
    opened->file.add({line(4)});
  }
  EXPECT_EQ(times_in(path), (std::vector{1001, 1002, 1004})) << "not glued to half a line";
}

TEST(EventFile, is_bounded) {
  const ScratchFolder folder;
  const std::string path = folder.at("cell.jsonl");
  const int count = static_cast<int>(2 * EventFile::kSizeMax / line(100'000).size());
  {
    auto opened = EventFile::open(path);
    ASSERT_TRUE(opened);
    for (int i = 0; i < count; i += 100) {
      std::vector<std::string> lines;
      for (int k = i; k < i + 100; ++k) lines.push_back(line(k));
      opened->file.add(lines);
    }
  }
  EXPECT_LT(*io::file_size(path), EventFile::kSizeMax + 100'000);
  const auto times = times_in(path);
  ASSERT_EQ(times.size(), EventLog::kMax);
  EXPECT_EQ(times.back(), 1000 + (count + 99) / 100 * 100 - 1);
  EXPECT_LT(*io::file_size(path), EventLog::kMax * 100);
}

/// However many there were before: numbers only grow, or who asks for those behind one misses some.
TEST(EventFile, numbers_go_on_behind_more_than_are_kept) {
  EventLog before;
  std::vector<Json> all;
  for (int i = 0; i < 2500; ++i) before.add(Json::parse(line(i + 1)));
  for (const auto& event : before.after(0)) all.push_back(Json::parse(event.text));
  ASSERT_EQ(all.size(), EventLog::kMax);
  EventLog now;
  now.begin(all);
  EXPECT_EQ(now.last(), 2500U);
  now.add(Json::parse(line(1)));
  EXPECT_EQ(now.after(2500).front().number, 2501U);
  EXPECT_EQ(now.after(0).front().number, 1502U);
  // What somebody has written there by hand counts nothing down, nor beyond what can be counted.
  EventLog odd;
  std::vector<Json> strange;
  for (const char* number : {"7", "3", "\"x\"", "1152921504606846976", "-4"}) {
    strange.push_back(Json::parse(std::string(R"({"number":)") + number + "}"));
  }
  odd.begin(strange);
  EXPECT_EQ(odd.last(), 11U);
}

TEST(EventFile, belongs_to_one_process) {
  const ScratchFolder folder;
  auto first = EventFile::open(folder.at("cell.jsonl"));
  ASSERT_TRUE(first);
  const auto second = EventFile::open(folder.at("cell.jsonl"));
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().sentence.find("in use by"), std::string::npos)
      << second.error().sentence;
  first->file.add({line(1)});
  EXPECT_NE(io::read_file(folder.at("cell.jsonl"))->find("1001"), std::string::npos);
}

TEST(EventFile, what_nobody_could_show_is_left_out) {
  const ScratchFolder folder;
  const std::string path = folder.at("cell.jsonl");
  const std::string head = R"({"at_ms":1001,"robot":"left","kind":"state")";
  const std::string deep = std::string(1'000'000, '[') + std::string(1'000'000, ']');
  ASSERT_TRUE(io::replace_file(
      path, head + R"(,"deep":)" + deep + "}\n" + head + R"(,"path":"/\xe4"})" + "\n" +
                R"({"at_ms":99999999999999999,"robot":"left","kind":"state"})" + "\n" +
                R"({"at_ms":-1,"robot":"left","kind":"state"})" + "\n" + line(2) + "\n"));
  EXPECT_EQ(times_in(path), (std::vector{1002}));
}

TEST(EventFile, a_folder_in_its_place_is_said) {
  const ScratchFolder folder;
  const auto opened = EventFile::open(folder.at("."));
  ASSERT_FALSE(opened);
  EXPECT_FALSE(opened.error().sentence.empty());
}

/// A fault of yesterday is still told today, and behind it that the controller began anew.
TEST(EventFile, a_cell_goes_on_with_the_numbers_of_its_lives_before) {
  const ScratchFolder folder;
  const std::string path = folder.at("events/cell.jsonl");
  Json before;
  {
    ApiCell cell({place("left", "learm", "bus")}, 20, {}, {}, nullptr, path);
    ApiClient client(cell);
    client.run("left", test::kStand);
    before = client.call("events.list")["result"]["events"];
    ASSERT_GT(before.size(), 5U);
    EXPECT_EQ(before[0]["kind"], "begun");
  }
  ApiCell cell({place("left", "learm", "bus")}, 20, {}, {}, nullptr, path);
  ApiClient client(cell);
  const Json now = client.call("events.list")["result"]["events"];
  ASSERT_GT(now.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_EQ(now[i], before[i]);
  const auto begun = std::ranges::find_if(now.begin() + 1, now.end(),
                                          [](const Json& one) { return one["kind"] == "begun"; });
  ASSERT_NE(begun, now.end());
  EXPECT_EQ((*begun)["version"], "test");
  std::uint64_t number = 0;
  for (const Json& event : now) EXPECT_EQ(event["number"], ++number);
}

TEST(EventFile, without_a_place_for_it_the_cell_says_so_and_goes_on) {
  const ScratchFolder folder;
  ASSERT_TRUE(io::replace_file(folder.at("events"), "no folder"));
  ApiCell cell({place("left", "learm", "bus")}, 20, {}, {}, nullptr,
               folder.at("events/cell.jsonl"));
  ApiClient client(cell);
  const Json events = client.call("events.list")["result"]["events"];
  ASSERT_GE(events.size(), 2U);
  EXPECT_EQ(events[1]["kind"], "begun");
  EXPECT_NE(events[1]["trouble"].get<std::string>().find("events"), std::string::npos);
}

}  // namespace
}  // namespace sinew::server
