#include "sinew/io/machine_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "support/scratch_folder.h"

namespace sinew::io {
namespace {

/// Folders as the kernel shows its devices.
struct Computer {
  Computer() {
    for (const char* name : {"dev", "tty", "hid"})
      std::filesystem::create_directory(folder.at(name));
  }
  void device(const std::string& name) const { folder.file("dev/" + name, ""); }
  /// @param type  as the driver says it: 0 no UART, 4 a 16550A, 32 a PL011
  void uart(const std::string& name, const char* type) const {
    device(name);
    std::filesystem::create_directory(folder.at("tty/" + name));
    folder.file("tty/" + name + "/type", type);
  }
  DeviceFolders folders() const { return {folder.at("dev"), folder.at("tty"), folder.at("hid")}; }
  std::vector<std::string> ports() const {
    std::vector<std::string> names;
    for (const FoundDevice& found : find_devices(folders())) {
      names.push_back(std::filesystem::path(found.path).filename());
    }
    return names;
  }
  bool misses(std::string_view words) const {
    const auto missing = missing_interfaces(folders());
    return std::ranges::any_of(
        missing, [&](const std::string& one) { return one.find(words) != std::string::npos; });
  }
  test::ScratchFolder folder;
};

TEST(MachineCheck, of_the_builtin_ports_those_are_listed_that_have_a_uart) {
  const Computer computer;
  computer.uart("ttyS0", "4\n");
  computer.uart("ttyS1", "0\n");
  computer.uart("ttyS10", "32\n");
  computer.uart("ttyS2", "");
  computer.device("ttyS3");
  computer.device("ttyUSB0");
  computer.device("tty1");
  computer.device("spidev0.0");
  EXPECT_EQ(computer.ports(),
            (std::vector<std::string>{"ttyS0", "ttyS10", "ttyUSB0", "spidev0.0"}));
  EXPECT_FALSE(computer.misses("serial ports: none"));
}

TEST(MachineCheck, empty_places_for_uarts_are_no_serial_ports) {
  const Computer computer;
  for (int i = 0; i < 32; ++i) computer.uart("ttyS" + std::to_string(i), "0\n");
  EXPECT_TRUE(computer.ports().empty());
  EXPECT_TRUE(computer.misses("serial ports: none is there"));
  EXPECT_TRUE(computer.misses("TTL pins need an adapter")) << "what a LeArm's owner looks for";
}

TEST(MachineCheck, a_learm_on_its_own_usb_is_told_that_this_is_no_serial_port) {
  const Computer computer;
  computer.device("ttyUSB0");
  computer.folder.file("hid/0003:046D:C31C.0001", "");
  EXPECT_FALSE(computer.misses("LeArm"));
  computer.folder.file("hid/0003:0483:5750.0002", "");
  EXPECT_TRUE(computer.misses("HID and no serial port. Connect its TTL pins"));
}

TEST(MachineCheck, an_adapter_is_shown_with_the_name_that_it_calls_itself) {
  const Computer computer;
  // A device file, which a plain file would not stand in for.
  std::filesystem::create_symlink("/dev/null", computer.folder.at("dev/ttyUSB0"));
  computer.device("ttyUSB1");
  std::filesystem::create_directories(computer.folder.at("dev/serial/by-id"));
  std::filesystem::create_symlink("../../ttyUSB0",
                                  computer.folder.at("dev/serial/by-id/usb-1a86_USB_Serial"));
  const auto found = find_devices(computer.folders());
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].name, "usb-1a86_USB_Serial");
  EXPECT_EQ(found[1].name, "");
}

TEST(MachineCheck, what_this_computer_lists_exists) {
  for (const FoundDevice& found : find_devices()) {
    EXPECT_TRUE(std::filesystem::exists(found.path)) << found.path;
  }
}

}  // namespace
}  // namespace sinew::io
