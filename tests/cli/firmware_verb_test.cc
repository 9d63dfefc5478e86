#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "cli/boot_loader.h"
#include "cli/process.h"
#include "support/board_image_bytes.h"
#include "support/scratch_folder.h"

/// `sinew firmware` with the real stm32flash, and a simulated boot loader at the other end.
namespace sinew::test {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

const std::string kF103 = "axis-stm32f103";
const std::string kF401 = "axis-stm32f401";

Bytes image(const std::string& board, const std::string& version) {
  return board_image_bytes(board, version, 336, 40'000);
}

std::string text_of(const Bytes& bytes) {
  return {bytes.begin(), bytes.end()};
}

BootLoader::Chip f103() {
  return {.id = 0x410, .sizes = std::vector<std::uint32_t>(64, 1024)};
}
BootLoader::Chip f401() {
  return {.id = 0x423,
          .extended_erase = true,
          .sizes = {0x4000, 0x4000, 0x4000, 0x4000, 0x10000, 0x20000}};
}

class Firmware : public ::testing::Test {
 protected:
  void SetUp() override {
    real_ = find("stm32flash");
    if (real_.empty()) GTEST_SKIP() << "stm32flash is not here";
    path_ = std::getenv("PATH");
    setenv("XDG_STATE_HOME", folder_.at("state").c_str(), 1);
    setenv("XDG_RUNTIME_DIR", folder_.at("").c_str(), 1);
    // A pseudo-terminal has no parity.
    tool("exec " + real_ + " -m 8n1 \"$@\"\n");
    setenv("PATH", (folder_.at("bin") + ":" + path_).c_str(), 1);
  }
  void TearDown() override {
    if (!path_.empty()) setenv("PATH", path_.c_str(), 1);
  }
  static std::string find(const std::string& name) {
    for (const char* folder : {"/usr/bin/", "/usr/local/bin/"}) {
      if (fs::exists(folder + name)) return folder + name;
    }
    return {};
  }
  /// In place of the tool of that name.
  void tool(const std::string& script, const std::string& name = "stm32flash") {
    fs::create_directories(folder_.at("bin"));
    const std::string file = folder_.file("bin/" + name, "#!/bin/sh\n" + script);
    fs::permissions(file, fs::perms::owner_all);
  }
  /// A folder of images for both boards.
  std::string images(const std::string& version) {
    fs::create_directories(folder_.at("images"));
    for (const std::string& board : {kF103, kF401}) {
      folder_.file("images/" + board + ".bin", text_of(image(board, version)));
    }
    return folder_.at("images");
  }
  Ended flash(const std::string& board, const BootLoader& at, Arguments more = {}) {
    Arguments all{"firmware", "flash",    board,           "--port",
                  at.port(),  "--images", images("0.2.0"), "--json"};
    all.insert(all.end(), more.begin(), more.end());
    return sinew(all);
  }
  std::vector<std::string> kept() const {
    std::vector<std::string> files;
    const std::string folder = folder_.at("state/sinew/firmware");
    if (!fs::exists(folder)) return files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    return files;
  }

  ScratchFolder folder_;
  std::string real_, path_;
};

Bytes bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

bool begins_with(const Bytes& all, const Bytes& begin) {
  return all.size() >= begin.size() && std::equal(begin.begin(), begin.end(), all.begin());
}

TEST_F(Firmware, an_empty_board_is_written_verified_and_started) {
  for (const bool older : {true, false}) {
    const std::string board = older ? kF103 : kF401;
    const BootLoader loader(older ? f103() : f401());
    const Ended done = flash(board, loader);
    ASSERT_EQ(done.exit, 0) << done.err << done.out;
    EXPECT_TRUE(begins_with(loader.flash(), image(board, "0.2.0")));
    EXPECT_EQ(loader.started(), 0x08000000U);
    EXPECT_FALSE(loader.spoiled());
    EXPECT_TRUE(kept().empty()) << "nothing was on it";
    EXPECT_EQ(done.json()["version"], "0.2.0");
  }
}

TEST_F(Firmware, what_was_on_it_is_kept_and_can_be_put_back_and_the_setup_stays) {
  BootLoader loader(f103());
  const Bytes old = image(kF103, "0.1.0");
  const Bytes setup(1024, 0x5A);
  loader.put(0, old);
  loader.put(62 * 1024, setup);
  const Ended done = flash(kF103, loader);
  ASSERT_EQ(done.exit, 0) << done.err << done.out;
  ASSERT_EQ(kept().size(), 1U);
  const std::string before = done.json()["before"];
  EXPECT_EQ(before, kept()[0]);
  EXPECT_TRUE(begins_with(bytes_of(before), old));
  EXPECT_EQ(sinew({"firmware", "info", before, "--json"}).json()["version"], "0.1.0");
  const auto of_setup = [&] {
    const Bytes all = loader.flash();
    return Bytes(all.begin() + 62 * 1024, all.begin() + 63 * 1024);
  };
  EXPECT_EQ(of_setup(), setup);
  const Ended back = flash(kF103, loader, {"--image", before});
  ASSERT_EQ(back.exit, 0) << back.err << back.out;
  EXPECT_TRUE(begins_with(loader.flash(), old));
  EXPECT_EQ(of_setup(), setup);
}

TEST_F(Firmware, the_same_image_is_not_written_again) {
  const BootLoader loader(f103());
  ASSERT_EQ(flash(kF103, loader).exit, 0);
  const Ended again = flash(kF103, loader);
  EXPECT_EQ(again.exit, 0) << again.err;
  EXPECT_EQ(again.json()["written"], false);
}

TEST_F(Firmware, another_chip_is_not_written) {
  const BootLoader loader(f401());
  const Ended refused = flash(kF103, loader);
  EXPECT_EQ(refused.exit, 1);
  EXPECT_TRUE(refused.err.contains("says that it is 423; a Blue Pill (STM32F103C8) says 410"))
      << refused.err;
  EXPECT_EQ(loader.flash(), Bytes(0x40000, 0xFF));
}

TEST_F(Firmware, what_cannot_be_read_is_not_lost_without_a_word) {
  BootLoader::Chip chip = f103();
  chip.read_protected = true;
  const BootLoader loader(chip);
  const Ended refused = flash(kF103, loader);
  EXPECT_EQ(refused.exit, 1);
  EXPECT_TRUE(refused.err.contains("--no-backup")) << refused.err;
}

TEST_F(Firmware, a_cable_that_comes_out_is_told_and_the_next_try_ends_it) {
  BootLoader::Chip chip = f103();
  chip.dies_at = 10'000;
  {
    BootLoader dying(chip);
    dying.put(0, image(kF103, "0.1.0"));
    const Ended lost = flash(kF103, dying);
    EXPECT_EQ(lost.exit, 1);
    EXPECT_TRUE(lost.err.contains("half written")) << lost.err;
    EXPECT_TRUE(lost.err.contains("is kept in")) << lost.err;
    EXPECT_EQ(kept().size(), 1U);
  }
  const BootLoader loader(f103());
  EXPECT_EQ(flash(kF103, loader).exit, 0);
}

TEST_F(Firmware, bad_input_is_told_before_anything_is_asked) {
  const BootLoader loader(f103());
  const auto says = [&](const Arguments& arguments, int exit, const std::string& text) {
    const Ended refused = sinew(arguments);
    EXPECT_EQ(refused.exit, exit) << refused.out;
    EXPECT_TRUE(refused.err.contains(text)) << refused.err;
  };
  const std::string folder = images("0.2.0");
  const std::string port = loader.port();
  says({"firmware", "burn"}, 2, "list, info or flash");
  says({"firmware", "flash", "--port", port}, 2, "which board? There are axis-stm32f103");
  says({"firmware", "flash", "axis-stm32f104", "--port", port}, 2, "axis-stm32f104?");
  says({"firmware", "flash", kF103}, 2, "--port /dev/ttyUSB0");
  says({"firmware", "flash", kF103, "--port", port, "--probe"}, 2, "one of them");
  says({"firmware", "flash", kF103, "--usb"}, 2, "has no USB");
  says({"firmware", "flash", kF103, "--port", "/dev/nothing"}, 1, "no such device");
  says({"firmware", "flash", kF103, "--port", port, "--images", "/nowhere"}, 1, "no such folder");
  says({"firmware", "flash", kF103, "--port", port, "--image", folder + "/" + kF401 + ".bin"}, 1,
       "an image of axis-stm32f401");
  says({"firmware", "flash", kF103, "--port", port, "--image",
        folder_.file("large", std::string(70'000, 'x'))},
       1, "70000 bytes");
  says({"firmware", "info"}, 2, "which file");
  says({"firmware", "info", "/dev/null"}, 2, "whose boards are there?");
  says({"firmware", "info", "/dev/null", "--robot", "learm"}, 1, "sinew doctor --robot learm");
  says({"firmware", "info", "/dev/null", "--robot", "nobody"}, 2, "nobody");
  says({"firmware", "info", folder_.file("text", "no image")}, 1, "nothing in it says");
  folder_.file("images/" + kF103 + ".bin", text_of(image(kF103, "0.2.0")).substr(0, 30'000));
  says({"firmware", "list", "--images", folder}, 1, "nothing in it says");
  EXPECT_EQ(loader.flash(), Bytes(0x10000, 0xFF));
}

TEST_F(Firmware, ctrl_c_does_not_end_what_is_being_written) {
  const BootLoader loader(f103());
  Process process(
      {"firmware", "flash", kF103, "--port", loader.port(), "--images", images("0.2.0")});
  process.wait_for_err("writes the image");
  process.signal(SIGINT);
  const Ended done = process.end();
  EXPECT_EQ(done.exit, 0) << done.err;
  EXPECT_TRUE(begins_with(loader.flash(), image(kF103, "0.2.0")));
}

/// Tools of which no board can be simulated: what they are run with, and what is made of their
/// words (dfu-util 0.11, openocd 0.12).
TEST_F(Firmware, usb_and_probe_run_their_tools_and_hold_against_the_image_what_was_written) {
  const std::string log = folder_.at("log"), flash = folder_.at("flash");
  tool("echo \"$@\" >>" + log +
           "\nwhile [ $# -gt 0 ]; do case $1 in -l) echo 'Found DFU: "
           "[0483:df11] ver=2200, devnum=5, cfg=1, intf=0, path=\"1-1\", alt=0, name=\"@Internal "
           "Flash  "
           "/0x08000000/04*016Kg,01*064Kg,01*128Kg\"';; -U) if [ -f " +
           flash + " ]; then head -c ${size} " + flash +
           " >$2; else head -c 65536 /dev/zero | tr '\\\\0' '\\\\377' >$2; fi;; -D) cp $2 " +
           flash + ";; -s) size=${2#*:};; esac; shift; done\n",
       "dfu-util");
  const Arguments usb{"firmware", "flash", kF401, "--usb", "--images", images("0.2.0")};
  const Ended done = sinew(usb);
  EXPECT_EQ(done.exit, 0) << done.err;
  EXPECT_EQ(bytes_of(flash), image(kF401, "0.2.0"));
  const std::string text = text_of(bytes_of(log));
  EXPECT_TRUE(text.contains("-d 0483:df11 -a 0 -s 0x08000000 -D ")) << text;
  EXPECT_TRUE(text.contains("-s 0x08000000:40000 -U ")) << text;

  tool("echo \"$@\" >>" + log +
           "\necho '0xe0042000: 20036410'\ncase \"$*\" in *dump_image*) f=\"$*\"; "
           "f=${f#*\\{}; head -c 63488 /dev/zero >\"${f%%\\}*}\";; esac\n",
       "openocd");
  const Ended probed = sinew({"firmware", "flash", kF103, "--probe", "--images", images("0.2.0")});
  EXPECT_EQ(probed.exit, 0) << probed.err;
  EXPECT_TRUE(text_of(bytes_of(log)).contains("-f target/stm32f1x.cfg -c program {"))
      << text_of(bytes_of(log));
  EXPECT_TRUE(text_of(bytes_of(log)).contains("} verify reset exit 0x08000000"));
}

TEST_F(Firmware, an_arduino_is_written_over_its_own_port_and_what_was_on_it_is_kept) {
  const std::string log = folder_.at("log"), flash = folder_.at("flash");
  const std::string board = "bigrobotarm-atmega2560";
  const auto avrdude = [&](const std::string& signature) {
    tool("echo \"$@\" >>" + log + "\necho 'avrdude: Device signature = " + signature +
             " (probably m2560)' >&2\nfor last; do :; done\ncase $last in flash:r:*) "
             "f=${last#*:r:}; "
             "cp " +
             flash + " \"${f%:r}\";; flash:w:*) f=${last#*:w:}; cp \"${f%:r}\" " + flash +
             ";; esac\n",
         "avrdude");
  };
  folder_.file("flash", "the maker's program");
  const std::string port = folder_.file("port", "");
  fs::create_directories(folder_.at("arduino"));
  const Bytes wanted = board_image_bytes(board, "0.2.0", 336, 29'000);
  folder_.file("arduino/" + board + ".bin", text_of(wanted));
  const Arguments all{"firmware",           "flash", board, "--port", port, "--images",
                      folder_.at("arduino")};
  avrdude("0x1e950f");
  const Ended other = sinew(all);
  EXPECT_EQ(other.exit, 1);
  EXPECT_TRUE(other.err.contains("says that it is 950f")) << other.err;
  EXPECT_EQ(text_of(bytes_of(flash)), "the maker's program");
  avrdude("0x1e9801");
  const Ended done = sinew(all);
  EXPECT_EQ(done.exit, 0) << done.err;
  EXPECT_TRUE(done.out.contains("is kept in ")) << done.out;
  EXPECT_EQ(bytes_of(flash), wanted);
  const std::string text = text_of(bytes_of(log));
  EXPECT_TRUE(text.contains("-p m2560 -c wiring -P " + port + " -b 115200 -D -U flash:w:")) << text;
  const Ended usb = sinew({"firmware", "flash", board, "--usb", "--images", folder_.at("arduino")});
  EXPECT_EQ(usb.exit, 2);
  EXPECT_TRUE(usb.err.contains("--port /dev/ttyUSB0")) << usb.err;
}

}  // namespace
}  // namespace sinew::test
