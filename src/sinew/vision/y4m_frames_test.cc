#include "sinew/vision/y4m_frames.h"

#include <gtest/gtest.h>

#include "support/property.h"
#include "support/video_files.h"

namespace sinew::vision {
namespace {

std::expected<Y4mHeader, std::string> header_of(const std::string& text) {
  return read_y4m_header(test::bytes_of(text));
}

std::string fault_of(const std::string& text) {
  const auto header = header_of(text);
  return header ? "fine" : header.error();
}

/// The first byte of each frame's picture, as many as there are.
std::vector<int> reds_of(const std::string& file) {
  auto frames = Y4mFrames::open(test::file_of(file));
  if (!frames) return {-1};
  std::vector<int> reds;
  while (const auto picture = frames->next()) reds.push_back(picture->rgb[0]);
  return reds;
}

std::string frame(char luma, std::size_t lumas, std::size_t chromas) {
  return "FRAME\n" + std::string(lumas, luma) + std::string(chromas, '\x80');
}

TEST(Y4mFrames, header_says_size_chroma_and_range) {
  const auto header = header_of("YUV4MPEG2 W640 H480 F30:1 Ip A1:1 C420jpeg XYSCSS=420JPEG\nFRAME");
  ASSERT_TRUE(header) << header.error();
  EXPECT_EQ(header->layout.width, 640);
  EXPECT_EQ(header->layout.height, 480);
  EXPECT_EQ(header->layout.chroma, Chroma::k420Centre);
  EXPECT_EQ(header->layout.range, LumaRange::kLimited);
  EXPECT_EQ(header->bytes, 58U);
  EXPECT_EQ(header_of("YUV4MPEG2 W2 H2 C444 XCOLORRANGE=FULL\n")->layout.range, LumaRange::kFull);
  EXPECT_EQ(header_of("YUV4MPEG2 W2 H2 C420mpeg2\n")->layout.chroma, Chroma::k420Left);
  EXPECT_EQ(header_of("YUV4MPEG2 W2 H2 C422\n")->layout.chroma, Chroma::k422);
  EXPECT_EQ(header_of("YUV4MPEG2 W2 H2 Cmono\n")->layout.chroma, Chroma::kNone);
  EXPECT_EQ(header_of("YUV4MPEG2 W2 H2\n")->layout.chroma, Chroma::k420Centre) << "the default";
}

TEST(Y4mFrames, of_every_chroma_come_in_their_order) {
  const std::string begin = "YUV4MPEG2 W4 H2 XCOLORRANGE=FULL C";
  const auto two = [](std::size_t chromas) {
    return frame(10, 8, chromas) + frame(20, 8, chromas);
  };
  EXPECT_EQ(reds_of(begin + "420\n" + two(4)), (std::vector{10, 20}));
  EXPECT_EQ(reds_of(begin + "422\n" + two(8)), (std::vector{10, 20}));
  EXPECT_EQ(reds_of(begin + "444\n" + two(16)), (std::vector{10, 20}));
  EXPECT_EQ(reds_of(begin + "mono\n" + two(0)), (std::vector{10, 20}));
}

TEST(Y4mFrames, may_have_parameters_of_their_own) {
  std::string file = "YUV4MPEG2 W4 H2 Cmono XCOLORRANGE=FULL\nFRAME Ip\n" + std::string(8, '\x1E');
  EXPECT_EQ(reds_of(file), std::vector{30});
}

TEST(Y4mFrames, of_a_file_that_was_cut_off_end_with_the_last_whole_one) {
  const std::string file =
      "YUV4MPEG2 W4 H2 XCOLORRANGE=FULL C420\n" + frame(10, 8, 4) + frame(20, 8, 4);
  for (std::size_t size = 0; size < file.size(); ++size) {
    EXPECT_LE(reds_of(file.substr(0, size)).size(), 1U) << size;
  }
}

TEST(Y4mFrames, what_is_not_read_is_said_in_a_sentence) {
  EXPECT_EQ(fault_of(""), "no Y4M file");
  EXPECT_EQ(fault_of("YUV4MPEG2 W4 H2"), "no Y4M file");
  EXPECT_EQ(fault_of("YUV4MPEG2 W4\n"),
            "a Y4M file without a size, or with frames over 64 million pixels");
  EXPECT_EQ(fault_of("YUV4MPEG2 W-4 H2\n"),
            "a Y4M file without a size, or with frames over 64 million pixels");
  EXPECT_EQ(fault_of("YUV4MPEG2 W99999 H99999\n"),
            "a Y4M file without a size, or with frames over 64 million pixels");
  EXPECT_EQ(fault_of("YUV4MPEG2 W4 H2 C420p10\n"),
            "a Y4M file with the chroma 'C420p10'; C420, C422, C444 and Cmono are read. Convert "
            "it: ffmpeg -i FILE -pix_fmt yuv420p OUT.y4m");
  EXPECT_EQ(fault_of("YUV4MPEG2 W4 H2 It\n"),
            "an interlaced Y4M file; take it out first: ffmpeg -i FILE -vf yadif OUT.y4m");
}

TEST(Y4mFrames, a_million_spoiled_bytes_in_files_crash_nothing) {
  const std::string file =
      "YUV4MPEG2 W4 H2 F1:1 C422 XCOLORRANGE=FULL\n" + frame(10, 8, 8) + frame(20, 8, 8);
  test::for_random_cases(100'000, [&](test::Random& random) {
    std::string spoiled = file;
    for (std::int64_t i = random.integer(1, 19); i > 0; --i) {
      spoiled[10 + random.bits() % (spoiled.size() - 10)] = static_cast<char>(random.bits());
    }
    ASSERT_LE(reds_of(spoiled).size(), spoiled.size() / 6);
  });
}

}  // namespace
}  // namespace sinew::vision
