#include "sinew/runtime/cameras/stored_pictures.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sinew/core/error_code.h"
#include "sinew/vision/picture_file.h"
#include "support/scratch_folder.h"
#include "support/video_files.h"

namespace sinew::runtime {
namespace {

std::string png(std::uint8_t red) {
  return test::text_of(vision::encode_png(test::plain_picture(4, 2, red, 0, 0)));
}

std::string jpeg(std::uint8_t red) {
  return test::text_of(vision::encode_jpeg(test::plain_picture(16, 16, red, red, red)));
}

/// The red of each picture in turn; at the end the call fails, and goes on to.
std::vector<int> reds_of(std::expected<CameraSource, std::string>& source) {
  EXPECT_TRUE(source) << source.error();
  std::vector<int> reds;
  while (const auto picture = (*source)({})) reds.push_back(picture->rgb[0]);
  EXPECT_EQ((*source)({}).error().code, ErrorCode::kCameraLost);
  return reds;
}

TEST(StoredPictures, names_are_ordered_by_the_numbers_in_them) {
  std::vector<std::string> names{"b1",   "a10", "a2", "a1",   "a010",
                                 "a02b", "a2a", "a",  "a1.9", "a1.10"};
  std::ranges::sort(names, comes_before);
  EXPECT_EQ(names, (std::vector<std::string>{"a", "a1", "a1.9", "a1.10", "a2", "a2a", "a02b",
                                             "a010", "a10", "b1"}));
  EXPECT_FALSE(comes_before("a", "a"));
}

TEST(StoredPictures, of_a_folder_come_in_their_order_once_each) {
  const test::ScratchFolder folder;
  folder.file("table10.png", png(10));
  folder.file("table9.PNG", png(9));
  folder.file("table2.jpg", jpeg(100));
  folder.file("table3.jpg", "no picture");
  folder.file("notes.txt", "no image");
  auto source = folder_pictures(folder.at());
  EXPECT_EQ(reds_of(source), (std::vector{100, 9, 10}));
}

TEST(StoredPictures, folder_without_any_is_refused) {
  const test::ScratchFolder folder;
  EXPECT_EQ(folder_pictures(folder.at()).error(), folder.at() + ": has no JPEG or PNG files in it");
  EXPECT_EQ(folder_pictures(folder.at("none")).error(),
            folder.at("none") + ": no such file or directory");
}

TEST(StoredPictures, of_an_avi_file_are_its_frames) {
  const test::ScratchFolder folder;
  const auto bare = test::without_huffman_tables(test::bytes_of(jpeg(200)));
  const std::string path = folder.file(
      "a.avi", test::avi_file(test::avi_stream("vids", "MJPG"),
                              test::avi_chunk("00dc", jpeg(100)) + test::avi_chunk("00dc", "bad") +
                                  test::avi_chunk("00dc", test::text_of(bare))));
  auto source = avi_pictures(path);
  EXPECT_EQ(reds_of(source), (std::vector{100, 200}));
  EXPECT_EQ(avi_pictures(folder.file("b.avi", "text")).error(),
            folder.at("b.avi") + ": no AVI file");
  EXPECT_EQ(avi_pictures(folder.at("c.avi")).error(),
            folder.at("c.avi") + ": no such file or directory");
}

TEST(StoredPictures, of_a_y4m_file_are_its_frames) {
  const test::ScratchFolder folder;
  const std::string path = folder.file("a.y4m", "YUV4MPEG2 W4 H2 Cmono XCOLORRANGE=FULL\nFRAME\n" +
                                                    std::string(8, '\x0A') + "FRAME\n" +
                                                    std::string(8, '\x14') + "FRAME\n123");
  auto source = y4m_pictures(path);
  EXPECT_EQ(reds_of(source), (std::vector{10, 20}));
  EXPECT_EQ(y4m_pictures(folder.file("b.y4m", "text")).error(),
            folder.at("b.y4m") + ": no Y4M file");
}

TEST(StoredPictures, sources_of_one_file_do_not_share_their_place) {
  const test::ScratchFolder folder;
  folder.file("1.png", png(1));
  folder.file("2.png", png(2));
  auto first = folder_pictures(folder.at());
  auto second = folder_pictures(folder.at());
  EXPECT_EQ((*first)({})->rgb[0], 1);
  EXPECT_EQ(reds_of(second), (std::vector{1, 2}));
  EXPECT_EQ(reds_of(first), std::vector{2});
}

}  // namespace
}  // namespace sinew::runtime
