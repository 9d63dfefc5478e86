#include "sinew/runtime/cameras/open_camera.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>

#include "sinew/vision/picture_file.h"
#include "support/scratch_folder.h"
#include "support/tcp_server.h"
#include "support/video_files.h"

namespace sinew::runtime {
namespace {

std::string fault_of(const std::string& device) {
  const auto source = open_camera(device, {});
  return source ? "fine" : source.error();
}

TEST(OpenCamera, every_kind_of_device_is_known_by_its_text) {
  const test::ScratchFolder folder;
  const auto picture = test::plain_picture(16, 16, 50, 50, 50);
  const std::string png = test::text_of(vision::encode_png(picture));
  std::filesystem::create_directory(folder.at("stored"));
  folder.file("stored/1.png", png);
  const std::string jpeg = test::text_of(vision::encode_jpeg(picture));
  test::TcpTestServer server([&](test::TcpTestServer::Client& client, int) {
    client.request();
    client.send("HTTP/1.1 200 OK\r\n\r\n" + png);
  });
  const std::array devices{
      folder.at("stored"),
      folder.file("a.avi",
                  test::avi_file(test::avi_stream("vids", "MJPG"), test::avi_chunk("00dc", jpeg))),
      folder.file("a.y4m", "YUV4MPEG2 W4 H2 Cmono XCOLORRANGE=FULL\nFRAME\n" + std::string(8, 50)),
      server.address(),
  };
  for (const std::string& device : devices) {
    auto source = open_camera(device, {});
    ASSERT_TRUE(source) << source.error();
    const auto seen = (*source)({});
    ASSERT_TRUE(seen) << device;
    EXPECT_NEAR(seen->rgb[0], 50, 1) << device;
  }
  EXPECT_EQ(fault_of(folder.at("table.jpg")), "fine") << "another program will write it";
}

TEST(OpenCamera, what_is_none_is_refused_in_a_sentence) {
  const test::ScratchFolder folder;
  EXPECT_EQ(fault_of("/dev/null").find("/dev/null: is no camera"), 0U);
  EXPECT_EQ(fault_of("/dev/video99").find("/dev/video99: no such file or directory; plug the "),
            0U);
  EXPECT_EQ(fault_of("https://cam/").find("https://cam/: https is not read"), 0U);
  EXPECT_EQ(fault_of(folder.file("a.mp4", "x")).find(folder.at("a.mp4") + ": no camera. Give "),
            0U);
  EXPECT_EQ(
      fault_of(folder.at("none")),
      folder.at("none") + ": no such file or directory; compare its name, or create the folder");
}

}  // namespace
}  // namespace sinew::runtime
