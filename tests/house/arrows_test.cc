#include "house/arrows.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sinew::house {
namespace {

using Complaints = std::vector<std::string>;
using Tree = std::vector<SourceFile>;

constexpr std::array<std::string_view, 2> kCheckedFolders{"src", "tests"};

std::string text_of(const Complaints& complaints) {
  std::string text;
  for (const std::string& complaint : complaints) text += complaint + "\n";
  return text;
}

const Tree& the_house() {
  static const Tree tree = read_tree(SINEW_SOURCE_DIR, kCheckedFolders);
  return tree;
}

TEST(House, is_read_from_disk_with_every_file) {
  EXPECT_GT(the_house().size(), 20U);
  const auto has = [](std::string_view path) {
    return std::ranges::find(the_house(), path, &SourceFile::path) != the_house().end();
  };
  EXPECT_TRUE(has("src/sinew/core/pose.h"));
  EXPECT_TRUE(has("tests/house/arrows_test.cc"));
}

TEST(House, every_include_follows_an_arrow) {
  EXPECT_EQ(text_of(check_arrows(the_house())), "");
}

TEST(House, only_io_touches_the_system) {
  EXPECT_EQ(text_of(check_guarded_headers(the_house())), "");
}

TEST(House, nothing_that_moves_reads_a_clock_and_no_test_sleeps) {
  EXPECT_EQ(text_of(check_clocks_and_sleeps(the_house())), "");
}

TEST(Arrows, are_followed_to_their_end_and_core_is_always_reached) {
  EXPECT_EQ(reachable_from("core"), Complaints{});
  EXPECT_EQ(reachable_from("driver"), (Complaints{"core", "mcu", "model", "wire"}));
  EXPECT_EQ(reachable_from("device"),
            (Complaints{"core", "kinematics", "mcu", "model", "motion", "wire"}));
  EXPECT_EQ(reachable_from("cli").size(), kArrows.size() - 1);
  EXPECT_EQ(reachable_from("cellar"), Complaints{});
}

TEST(Arrows, of_a_devices_files_go_by_their_names) {
  const Tree tree{
      {"src/sinew/devices/arm/arm_driver.cc",
       "#include \"sinew/devices/arm/arm_wire.h\"\n#include \"sinew/sim/machine.h\"\n"},
      {"src/sinew/devices/arm/arm_wire_words.h", "#include \"sinew/devices/arm/arm_driver.h\"\n"},
      {"src/sinew/devices/arm/arm.cc",
       "#include \"sinew/devices/arm/arm_driver.h\"\n#include \"sinew/config/robot_file.h\"\n"},
      {"src/sinew/devices/arm/arm_driver_test.cc", "#include \"sinew/sim/machine.h\"\n"}};
  EXPECT_EQ(check_arrows(tree),
            (Complaints{"src/sinew/devices/arm/arm_driver.cc:2: includes sinew/sim/machine.h; "
                        "driver may include core, mcu, model, wire",
                        "src/sinew/devices/arm/arm_wire_words.h:1: includes "
                        "sinew/devices/arm/arm_driver.h; wire may include core, mcu",
                        "src/sinew/devices/arm/arm.cc:2: includes sinew/config/robot_file.h; "
                        "devices may include core, device, driver, file, kinematics, mcu, model, "
                        "motion, sim, toml, wire"}));
}

TEST(Arrows, lead_only_to_folders_that_have_a_row_and_never_in_a_circle) {
  for (const FolderArrows& row : kArrows) {
    for (const std::string& target : reachable_from(row.folder)) {
      const auto back = reachable_from(target);
      EXPECT_EQ(std::ranges::find(back, row.folder), back.end()) << row.folder << " <> " << target;
      EXPECT_NE(std::ranges::find(kArrows, target, &FolderArrows::folder), kArrows.end()) << target;
    }
  }
}

TEST(Arrows, name_file_line_include_and_what_would_be_allowed) {
  const Tree tree{{"src/sinew/driver/arm.cc",
                   "#include \"sinew/driver/arm.h\"\n\n#include <array>\n"
                   "#include \"sinew/wire/frame.h\"\n  #  include \"sinew/kinematics/dh.h\"\n"}};
  EXPECT_EQ(check_arrows(tree), (Complaints{"src/sinew/driver/arm.cc:5: includes "
                                            "sinew/kinematics/dh.h; driver may include core, mcu, "
                                            "model, wire"}));
}

TEST(Arrows, forbid_io_to_every_folder_that_moves) {
  for (const char* folder : {"wire", "motion", "kinematics", "device", "driver", "control"}) {
    const Tree tree{{std::string("src/sinew/") + folder + "/x.h", "#include \"sinew/io/port.h\""}};
    EXPECT_EQ(check_arrows(tree).size(), 1U) << folder;
  }
  EXPECT_EQ(check_arrows(Tree{{"src/sinew/cli/x.cc", "#include \"sinew/io/port.h\""}}),
            Complaints{});
}

TEST(Arrows, need_a_folder_that_the_table_knows) {
  const Tree tree{{"src/sinew/cellar/x.h", ""},
                  {"src/sinew/core/x.h", "#include \"sinew/cellar/x.h\"\n"}};
  EXPECT_EQ(check_arrows(tree),
            (Complaints{"src/sinew/cellar/x.h:1: folder cellar has no arrows",
                        "src/sinew/core/x.h:1: includes sinew/cellar/x.h: no folder of that name "
                        "has arrows"}));
}

TEST(Arrows, allow_no_way_around_by_relative_paths_or_test_headers) {
  const Tree tree{{"src/sinew/core/x.h", "#include \"../io/port.h\"\n"},
                  {"src/sinew/core/y.h", "#include \"support/property.h\"\n"},
                  {"src/sinew/core/z.h", "#include <sinew/io/port.h>\n"}};
  EXPECT_EQ(check_arrows(tree).size(), 3U);
}

TEST(Arrows, leave_unit_tests_and_comments_alone) {
  const Tree tree{{"src/sinew/core/x_test.cc", "#include \"sinew/io/port.h\"\n"},
                  {"src/sinew/core/x.h",
                   "// #include \"sinew/io/port.h\"\n/*\n"
                   "#include \"sinew/io/port.h\"\n*/\n"},
                  {"tests/whole/x.cc", "#include \"sinew/io/port.h\"\n"}};
  EXPECT_EQ(check_arrows(tree), Complaints{});
}

TEST(Arrows, allow_helpers_of_tests_everything_but_to_be_shipped) {
  const Tree tree{
      {"src/sinew/devices/bigrobotarm/bigrobotarm_golden_test_support.h", "#include <fstream>\n"},
      {"src/sinew/wire/arm_test_robot.h", "#include \"support/property.h\"\n"},
      {"src/sinew/wire/x.cc", "#include \"sinew/wire/arm_test_robot.h\"\n"},
      {"src/sinew/wire/x_test_helper.cc", "#include \"support/property.h\"\n"}};
  EXPECT_EQ(check_arrows(tree),
            (Complaints{"src/sinew/wire/x.cc:1: includes sinew/wire/arm_test_robot.h: that header "
                        "is for tests only",
                        "src/sinew/wire/x_test_helper.cc:1: includes support/property.h: in quotes "
                        "only \"sinew/...\" may stand here"}));
  EXPECT_EQ(check_guarded_headers(tree), Complaints{});
}

TEST(GuardedHeaders, name_who_may_include_them) {
  const Tree tree{{"src/sinew/core/x.cc", "#include <unistd.h>\n"},
                  {"src/sinew/runtime/x.cc", "\n#include <sys/epoll.h>\n"},
                  {"src/sinew/cli/x.cc", "#include <boost/asio/serial_port.hpp>\n"},
                  {"src/sinew/io/x.cc", "#include <boost/beast.hpp>\n"},
                  {"src/sinew/io/y.cc", "#include <unistd.h>\n#include <boost/asio.hpp>\n"},
                  {"src/sinew/io/y_test.cc", "#include <boost/beast.hpp>\n"}};
  EXPECT_EQ(check_guarded_headers(tree),
            (Complaints{"src/sinew/core/x.cc:1: includes unistd.h; only io may",
                        "src/sinew/runtime/x.cc:2: includes sys/epoll.h; only io may",
                        "src/sinew/cli/x.cc:1: includes boost/asio/serial_port.hpp; only io "
                        "server/web may",
                        "src/sinew/io/x.cc:1: includes boost/beast.hpp; only server/web may"}));
}

TEST(GuardedHeaders, keep_threads_files_and_streams_out_of_what_moves) {
  for (const char* header : {"thread", "mutex", "fstream", "iostream", "cstdio"}) {
    const std::string text = std::string("#include <") + header + ">\n";
    for (const char* folder :
         {"control", "driver", "device", "wire", "motion", "planning", "kinematics"}) {
      const std::string path = std::string("src/sinew/") + folder + "/x.cc";
      EXPECT_EQ(check_guarded_headers(Tree{{path, text}}),
                (Complaints{path + ":1: includes " + header + "; " + folder +
                            " sees no clock, file, stream or thread"}));
    }
    EXPECT_EQ(check_guarded_headers(Tree{{"src/sinew/config/x.cc", text}}), Complaints{});
  }
}

TEST(Clocks, are_refused_to_what_moves_and_left_to_io) {
  const std::string now = "const auto t =\n    std::chrono::steady_clock::now();\n";
  EXPECT_EQ(check_clocks_and_sleeps(Tree{{"src/sinew/motion/x.cc", now}}),
            (Complaints{"src/sinew/motion/x.cc:2: uses steady_clock::now: time is handed in as an "
                        "Instant"}));
  EXPECT_EQ(check_clocks_and_sleeps(Tree{{"src/sinew/io/x.cc", now}}), Complaints{});
  const Tree prose{
      {"src/sinew/motion/x.h", "// no system_clock::now() here\nauto s = \"sleep(\";"}};
  EXPECT_EQ(check_clocks_and_sleeps(prose), Complaints{});
}

TEST(Clocks, no_sleep_in_what_moves_nor_in_any_test) {
  const std::string nap = "std::this_thread::sleep_for(1ms);\n";
  for (const char* path : {"src/sinew/driver/x.cc", "src/sinew/io/x_test.cc", "tests/whole/x.cc"}) {
    EXPECT_EQ(check_clocks_and_sleeps(Tree{{path, nap}}),
              (Complaints{std::string(path) +
                          ":1: uses sleep_for(: nothing waits here, time is virtual"}));
  }
  EXPECT_EQ(check_clocks_and_sleeps(Tree{{"src/sinew/io/x.cc", nap}}), Complaints{});
}

TEST(Clocks, randomness_without_a_seed_is_refused_everywhere) {
  EXPECT_EQ(
      check_clocks_and_sleeps(Tree{{"src/sinew/cli/x.cc", "std::random_device d;"}}),
      (Complaints{"src/sinew/cli/x.cc:1: uses random_device: randomness has a printed seed"}));
}

}  // namespace
}  // namespace sinew::house
