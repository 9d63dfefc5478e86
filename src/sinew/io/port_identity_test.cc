#include "sinew/io/port_identity.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "sinew/io/port.h"
#include "support/scratch_folder.h"

namespace sinew::io {
namespace {

using Names = std::vector<std::string>;

TEST(PortIdentity, adapter_has_its_links_whatever_it_is_called_today) {
  const test::ScratchFolder folder;
  const DeviceFolders folders{.files = folder.at("dev")};
  std::filesystem::create_directories(folder.at("dev/serial/by-id"));
  std::filesystem::create_directories(folder.at("dev/serial/by-path"));
  const std::string device = folder.file("dev/ttyUSB0", "");
  const std::string by_id = folder.at("dev/serial/by-id/usb-FTDI_A1");
  const std::string by_path = folder.at("dev/serial/by-path/pci-usb-0:2");
  EXPECT_EQ(port_identities(device, folders), Names{std::filesystem::canonical(device)});
  std::filesystem::create_symlink("../../ttyUSB0", by_id);
  std::filesystem::create_symlink("../../ttyUSB0", by_path);
  EXPECT_EQ(port_identities(device, folders), (Names{by_id, by_path}));
  EXPECT_EQ(port_identities(by_id, folders), (Names{by_id, by_path}));
  std::filesystem::remove(device);
  EXPECT_EQ(port_identities(by_id, folders), Names{by_id});
}

TEST(PortIdentity, pseudo_terminal_of_the_same_number_is_another_one) {
  const test::ScratchFolder folder;
  const std::string link = folder.at("arm");
  Names first;
  std::string path;
  {
    auto port = Port::open_pseudo_terminal();
    ASSERT_TRUE(port);
    path = port->path();
    std::filesystem::create_symlink(path, link);
    first = port_identities(link);
    ASSERT_EQ(first.size(), 2U);
    EXPECT_EQ(first[0], link);
    EXPECT_EQ(port_identities(path), Names{first[1]});
  }
  // The kernel's clock ticks every few ms.
  bool other = false;
  for (int tries = 0; tries < 100'000 && !other; ++tries) {
    auto again = Port::open_pseudo_terminal();
    ASSERT_TRUE(again);
    other = port_identities(again->path()).front() != first[1];
  }
  EXPECT_TRUE(other);
}

TEST(PortIdentity, other_names_stand_as_they_are_given) {
  EXPECT_EQ(port_identities("spidev"), Names{"spidev"});
  EXPECT_EQ(port_identities("simwire:unix:/tmp/a"), Names{"simwire:unix:/tmp/a"});
}

}  // namespace
}  // namespace sinew::io
