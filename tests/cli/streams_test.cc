#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <sstream>

#include "cli/process.h"
#include "support/scratch_folder.h"

/// What happens where stdout and stderr are closed, full, or lead to somebody who went away.
namespace sinew::test {
namespace {

TEST(Streams, answer_that_does_not_arrive_is_no_success) {
  for (const std::string where : {"closed", "/dev/full"}) {
    SCOPED_TRACE(where);
    for (const Arguments& arguments :
         {Arguments{"robots"}, Arguments{"fk", "learm", "--joints-deg", "0,0,0,0,0", "--json"},
          Arguments{"--help"}, Arguments{"sim", "bigrobotarm"}}) {
      const Ended ended = sinew(arguments, {.out = where, .err = ""});
      EXPECT_EQ(ended.exit, 1) << arguments[0];
      EXPECT_NE(ended.err.find("standard output: "), std::string::npos) << ended.err;
    }
  }
}

/// With stdout and stderr closed the port used to get their numbers: the report went to the arm.
TEST(Streams, nothing_for_people_goes_to_the_arm) {
  const ScratchFolder folder;
  const std::string link = folder.at("arm");
  Process sim(
      {"sim", "bigrobotarm", "--link", link, "--time-scale", "100", "--log", folder.at("log")});
  sim.wait_for_out("\n");
  const std::string program = folder.file("p.txt", "G0 B100\nG1 E1 P40\n");
  const Ended ended =
      sinew({"run", program, "--robot", "bigrobotarm", "--port", link, "--standing-at", "home"},
            {.out = "closed", .err = "closed"});
  EXPECT_EQ(ended.exit, 1);
  sim.signal(SIGINT);
  sim.end();
  std::size_t to_device = 0;
  std::stringstream log(text_of(folder.at("log")));
  for (std::string line; std::getline(log, line);) {
    const std::string key = "host -> device  ";
    const std::size_t at = line.find(key);
    if (at == std::string::npos) continue;
    to_device += line.find("  ", at + key.size()) + 1 - at - key.size();
  }
  // Status four times, speeds, accelerations, goto and gripper, three characters a byte.
  EXPECT_EQ(to_device, 3U * (4 * 2 + 3 * 22 + 4));
}

TEST(Streams, reader_that_goes_away_does_not_end_a_run) {
  const ScratchFolder folder;
  const std::string program = folder.file("p.txt", "BEGIN I20\nG0 B100\nG0 B0\nEND\n");
  const std::string call = std::string(SINEW_PROGRAM) + " run " + program +
                           " --robot bigrobotarm --time-scale 100 --record " + folder.at("r.csv") +
                           " 2>&1 | true";
  ASSERT_EQ(std::system(call.c_str()), 0);
  const std::string csv = text_of(folder.at("r.csv"));
  // The last sample is at rest where the last of 40 orders ended.
  const std::string home = ",0.000000,0.000000,0.000000,0.000000,0.000000,commanded,";
  EXPECT_NE(csv.rfind(home), std::string::npos)
      << csv.substr(csv.size() - std::min<std::size_t>(csv.size(), 200));
}

TEST(Streams, commas_and_points_do_not_depend_on_the_locale) {
  ASSERT_EQ(setenv("LC_ALL", "de_DE.UTF-8", 1), 0);
  const Json json = answer({"fk", "learm", "--joints-deg", "0.5,1.5,2,3,4"});
  unsetenv("LC_ALL");
  EXPECT_NEAR(json["joints_deg"][1].get<double>(), 1.5, 1e-9);
}

TEST(Streams, names_with_odd_bytes_stay_valid_json_and_harmless_text) {
  const ScratchFolder folder;
  const std::string name = folder.file("b\x1b[31m\xc3\xbc\xff\xc2\x9b.txt", "FOO\n");
  const Ended ended = sinew({"--json", "run", name, "--robot", "bigrobotarm"});
  EXPECT_EQ(ended.exit, 2);
  EXPECT_EQ(ended.json()["error"]["complaints"][0]["line"], 1);
  EXPECT_NE(ended.err.find("b\\x1b[31m\xc3\xbc\\xff\\xc2"), std::string::npos) << ended.err;
  EXPECT_EQ(ended.err.find('\x1b'), std::string::npos);
  const std::string good = folder.file("\xff<&.txt", "G0 B10\n");
  const std::string svg_path = folder.at("p.svg");
  const Ended run = sinew(
      {"run", good, "--robot", "bigrobotarm", "--time-scale", "100", "--plot", svg_path, "--json"});
  EXPECT_EQ(run.exit, 0) << run.err;
  const std::string svg = text_of(svg_path);
  EXPECT_EQ(svg.find('\xff'), std::string::npos);
  EXPECT_NE(svg.find("&lt;&amp;.txt"), std::string::npos);
}

TEST(Streams, no_file_descriptor_is_taken_for_granted) {
  const Ended ended = sinew({"robots", "learm", "--json"}, {.out = "", .err = "closed"});
  EXPECT_EQ(ended.exit, 0);
  EXPECT_EQ(ended.json()["id"], "learm");
}

}  // namespace
}  // namespace sinew::test
