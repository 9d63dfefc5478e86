#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "cli/process.h"
#include "support/scratch_folder.h"

/// Records of the real program, and `sinew record`, which reads them.
namespace sinew::test {
namespace {

const std::string kProgram =
    "joint base=0deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg\njoint base=30deg\n";

class RecordVerb : public testing::Test {
 protected:
  std::string record() {
    const std::string path = folder_.at("run.mcap");
    const Ended ran = sinew({"run", folder_.file("a.sinew", kProgram), "--robot", "learm",
                             "--profile", "bus", "--time-scale", "20", "--record", path});
    EXPECT_EQ(ran.exit, 0) << ran.err;
    EXPECT_NE(ran.out.find(path), std::string::npos) << ran.out;
    return path;
  }
  static std::size_t messages(const Json& json, const std::string& topic) {
    for (const Json& channel : json["channels"]) {
      if (channel["topic"] == topic) return channel["messages"];
    }
    return 0;
  }

  ScratchFolder folder_;
};

TEST_F(RecordVerb, run_leaves_a_record_that_becomes_a_table) {
  const std::string path = record();
  const std::string csv = folder_.at("run.csv");
  const Json json = answer({"record", path, "--csv", csv, "--json"});
  EXPECT_TRUE(json["whole"]);
  EXPECT_EQ(json["metadata"]["sinew.run"]["model"], "learm");
  EXPECT_EQ(json["metadata"]["sinew.end"]["lost"], "0");
  EXPECT_GT(json["duration_s"], 1.0);
  const std::size_t samples = messages(json, "/learm/joint_states");
  EXPECT_GT(samples, 20U);
  EXPECT_GT(messages(json, "/learm/wire"), 5U);
  EXPECT_GT(messages(json, "/learm/events"), 3U);
  std::istringstream lines(text_of(csv));
  std::string head;
  std::getline(lines, head);
  EXPECT_TRUE(
      head.starts_with("t_s,base_position_rad,base_lower_rad,base_upper_rad,"
                       "base_commanded_rad,base_quality,shoulder_position_rad"))
      << head;
  EXPECT_TRUE(head.ends_with(",state,to_device_bytes_s,to_host_bytes_s")) << head;
  std::size_t rows = 0;
  std::string last;
  for (std::string line; std::getline(lines, line); last = line) {
    ++rows;
    EXPECT_EQ(std::ranges::count(line, ','), std::ranges::count(head, ',')) << line;
  }
  EXPECT_EQ(rows, samples);
  // What it was told last: the base at 30 degrees.
  std::istringstream cells(last);
  std::string cell;
  for (int k = 0; k < 5; ++k) std::getline(cells, cell, ',');
  EXPECT_NEAR(std::strtod(cell.c_str(), nullptr), 0.5236, 1e-3) << last;
}

TEST_F(RecordVerb, every_run_leaves_one_unless_somebody_says_none) {
  setenv("XDG_STATE_HOME", folder_.at("state").c_str(), 1);
  const std::vector<std::string> words{"run",          folder_.file("wave.sinew", kProgram),
                                       "--robot",      "learm",
                                       "--profile",    "bus",
                                       "--time-scale", "20",
                                       "--json"};
  const Json ran = answer(words);
  std::vector<std::string> without = words;
  without.insert(without.end(), {"--record", "none"});
  const Json unrecorded = answer(without);
  // Nobody asked for it, so a folder that cannot be had keeps nobody from running.
  setenv("XDG_STATE_HOME", folder_.file("no_folder", "x").c_str(), 1);
  const Json homeless = answer(words);
  unsetenv("XDG_STATE_HOME");
  const std::string path = ran["record"]["file"];
  EXPECT_TRUE(path.starts_with(folder_.at("state/sinew/records/learm_run-wave_"))) << path;
  EXPECT_EQ(answer({"record", path, "--json"})["metadata"]["sinew.run"]["model"], "learm");
  EXPECT_FALSE(unrecorded.contains("record"));
  EXPECT_FALSE(homeless.contains("record"));
  const std::filesystem::directory_iterator all(folder_.at("state/sinew/records"));
  EXPECT_EQ(std::distance(begin(all), end(all)), 1);
}

TEST_F(RecordVerb, record_that_was_cut_gives_what_there_is) {
  const std::string whole = text_of(record());
  const std::string cut = folder_.file("cut.mcap", whole.substr(0, whole.size() / 2));
  const Ended ended = sinew({"record", cut, "--csv", folder_.at("cut.csv")});
  EXPECT_EQ(ended.exit, 0) << ended.err;
  EXPECT_NE(ended.out.find("it was cut off"), std::string::npos) << ended.out;
  EXPECT_NE(text_of(folder_.at("cut.csv")).find("\n0.0"), std::string::npos);
}

TEST_F(RecordVerb, what_is_no_record_is_refused_with_its_place) {
  const std::string path = record();
  std::string damaged = text_of(path);
  damaged[damaged.size() / 2] ^= 1;
  const struct {
    std::string file;
    std::string complaint;
  } cases[] = {
      {folder_.file("damaged.mcap", damaged), "damaged"},
      {folder_.file("text.mcap", "G0 B100\n"), "at byte 0: the begin of the file is not"},
      {folder_.file("empty.mcap", ""), "ends in its magic bytes"},
      {folder_.at("none.mcap"), "no such file"},
      {folder_.at(), "is a folder"},
  };
  for (const auto& [file, complaint] : cases) {
    const Ended ended = sinew({"record", file, "--csv", folder_.at("out.csv")});
    EXPECT_EQ(ended.exit, 2) << file;
    EXPECT_NE(ended.err.find(complaint), std::string::npos) << ended.err;
  }
  EXPECT_EQ(text_of(folder_.at("out.csv")), "");
  const Ended over = sinew({"record", path, "--csv", path});
  EXPECT_EQ(over.exit, 2);
  EXPECT_NE(over.err.find("choose another name"), std::string::npos) << over.err;
}

TEST_F(RecordVerb, sequence_is_recorded_as_any_program_is) {
  const std::string path = folder_.at("a.mcap");
  answer({"run", folder_.file("a.txt", "G0 B100\n"), "--robot", "bigrobotarm", "--record", path});
  EXPECT_EQ(answer({"record", path, "--json"})["metadata"]["sinew.run"]["model"], "bigrobotarm");
}

/// A machine that has a journal is a real one, and its faults are kept.
TEST_F(RecordVerb, run_leaves_the_seconds_before_its_fault) {
  setenv("XDG_STATE_HOME", folder_.at("state").c_str(), 1);
  const std::string link = folder_.at("arm");
  Process device({"sim", "bigrobotarm", "--link", link});
  device.wait_for_err("Ctrl-C ends it");
  Process run({"run", folder_.file("a.sinew", "joint base=60deg\njoint base=0deg\n"), "--robot",
               "bigrobotarm", "--port", link, "--journal", "arm", "--standing-at", "home",
               "--record", "none"});
  run.let_run(std::chrono::milliseconds(700));
  device.signal(9);
  device.end();
  const Ended ended = run.end();
  unsetenv("XDG_STATE_HOME");
  EXPECT_EQ(ended.exit, 1) << ended.err;
  EXPECT_NE(ended.out.find("the seconds before the fault: "), std::string::npos) << ended.out;
  const std::string folder = folder_.at("state/sinew/records");
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    files.push_back(entry.path());
  }
  ASSERT_EQ(files.size(), 1U);
  EXPECT_NE(files[0].find("bigrobotarm_fault-device_"), std::string::npos);
  EXPECT_EQ(sinew({"record", files[0]}).exit, 0);
}

/// Each job leaves a file, and a device that goes away leaves the seconds before it did.
TEST_F(RecordVerb, cell_records_its_jobs_and_its_faults) {
  setenv("XDG_STATE_HOME", folder_.at("state").c_str(), 1);
  const std::string link = folder_.at("arm");
  Process device({"sim", "bigrobotarm", "--link", link});
  device.wait_for_err("Ctrl-C ends it");
  const std::string cell =
      folder_.file("cell.toml",
                   "title = \"One\"\n[[robot]]\nname = \"arm\"\nrobot = \"bigrobotarm\"\n"
                   "port = \"" +
                       link + "\"\n");
  const std::string socket = folder_.at("cell.sock");
  const std::string jobs = folder_.at("jobs");
  {
    Process serve({"serve", cell, "--socket", socket, "--record-folder", jobs});
    serve.wait_for_err("answers on");
    const Ended ran = sinew({"run", folder_.file("a.sinew", "joint base=10deg\n"), "--robot", "arm",
                             "--socket", socket, "--standing-at", "home"});
    EXPECT_EQ(ran.exit, 0) << ran.err;
    const Ended own = sinew({"run", folder_.at("a.sinew"), "--robot", "arm", "--socket", socket,
                             "--record", folder_.at("own.mcap")});
    EXPECT_EQ(own.exit, 2);
    EXPECT_NE(own.err.find("--record-folder"), std::string::npos) << own.err;
    device.signal(9);
    device.end();
    serve.let_run(std::chrono::seconds(2));
    serve.signal(2);
    serve.end();
  }
  unsetenv("XDG_STATE_HOME");
  std::size_t count = 0;
  for (const std::string& folder : {jobs, folder_.at("state/sinew/records")}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const Json json = answer({"record", entry.path(), "--json"});
      EXPECT_TRUE(json["whole"]) << entry.path();
      EXPECT_GT(messages(json, "/arm/joint_states"), 20U) << entry.path();
      ++count;
    }
  }
  EXPECT_EQ(count, 2U);
}

}  // namespace
}  // namespace sinew::test
