#include "sinew/vision/avi_frames.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/property.h"
#include "support/video_files.h"

namespace sinew::vision {
namespace {

using test::avi_chunk;
using test::avi_file;
using test::avi_list;
using test::avi_stream;

const std::string kVideo = avi_stream("vids", "MJPG");
const std::string kSound = avi_stream("auds", std::string(4, '\0'));

/// Frames as text; what is wrong with the file, in brackets.
std::vector<std::string> frames_of(const std::string& file) {
  auto frames = AviFrames::open(test::file_of(file));
  if (!frames) return {"(" + frames.error() + ")"};
  std::vector<std::string> all;
  while (const auto frame = frames->next()) all.push_back(test::text_of(*frame));
  return all;
}

using Texts = std::vector<std::string>;

TEST(AviFrames, come_in_their_order_and_odd_ones_are_padded) {
  EXPECT_EQ(frames_of(avi_file(kVideo, avi_chunk("00dc", "one") + avi_chunk("00dc", "three!") +
                                           avi_chunk("00db", "x"))),
            (Texts{"one", "three!", "x"}));
}

TEST(AviFrames, of_the_video_stream_alone_are_read) {
  const std::string movi = avi_chunk("00wb", "sound") + avi_chunk("01dc", "one") +
                           avi_chunk("JUNK", "0000") + avi_chunk("02dc", "other camera") +
                           avi_chunk("01dc", "two");
  EXPECT_EQ(frames_of(avi_file(kSound + kVideo + kVideo, movi)), (Texts{"one", "two"}));
}

TEST(AviFrames, in_groups_and_in_further_parts_of_a_large_file_are_found) {
  const std::string first = avi_file(kVideo, avi_list("rec ", avi_chunk("00dc", "one")));
  const std::string second = avi_list("AVIX", avi_list("movi", avi_chunk("00dc", "two")), "RIFF");
  EXPECT_EQ(frames_of(first + second), (Texts{"one", "two"}));
}

TEST(AviFrames, that_were_dropped_while_recording_are_passed_over) {
  EXPECT_EQ(frames_of(avi_file(kVideo, avi_chunk("00dc", "") + avi_chunk("00dc", "one"))),
            Texts{"one"});
}

TEST(AviFrames, of_a_recorder_that_was_switched_off_are_read_to_the_last_whole_one) {
  std::string file = avi_file(kVideo, avi_chunk("00dc", "one") + avi_chunk("00dc", "two!"));
  file.resize(file.size() - 24 - 2);  // the index, and half of the last frame
  EXPECT_EQ(frames_of(file), Texts{"one"});
  // The lengths of RIFF and movi are written at the end; here they are still zero.
  for (const std::string& list : {std::string("RIFF"), std::string("LIST")}) {
    const std::size_t at = list == "RIFF" ? 0 : file.find("movi") - 8;
    file.replace(at + 4, 4, std::string(4, '\0'));
  }
  EXPECT_EQ(frames_of(file), Texts{"one"});
  for (std::size_t size = 0; size < file.size(); ++size) {
    EXPECT_LE(frames_of(file.substr(0, size)).size(), 1U);
  }
}

TEST(AviFrames, other_files_and_codings_are_refused_in_a_sentence) {
  EXPECT_EQ(frames_of(""), Texts{"(no AVI file)"});
  EXPECT_EQ(frames_of("RIFF\x10\0\0\0WAVEfmt "), Texts{"(no AVI file)"});
  EXPECT_EQ(frames_of(avi_file(kSound, avi_chunk("00wb", "sound"))),
            Texts{"(an AVI file without video in it)"});
  EXPECT_EQ(frames_of(avi_file(avi_stream("vids", "H264"), avi_chunk("00dc", "one"))),
            Texts{"(an AVI file with video coded as 'H264'; Motion JPEG is read. Convert it: "
                  "ffmpeg -i FILE -c:v mjpeg -q:v 2 OUT.avi)"});
  EXPECT_EQ(frames_of(avi_file(avi_stream("vids", "mjpg"), avi_chunk("00dc", "one"))),
            Texts{"one"});
}

TEST(AviFrames, lengths_that_lie_end_the_file_and_cost_no_memory) {
  std::string file = avi_file(kVideo, avi_chunk("00dc", "one") + avi_chunk("00dc", "two!"));
  const std::size_t second = file.rfind("00dc");
  file.replace(second + 4, 4, "\xFF\xFF\xFF\xFF");
  EXPECT_EQ(frames_of(file), Texts{"one"});
  // Nothing but empty chunks: an end is found in them too.
  std::string empty = avi_file(kVideo, "");
  for (int i = 0; i < 120'000; ++i) empty += avi_chunk("00dc", "");
  EXPECT_EQ(frames_of(empty), Texts{});
}

TEST(AviFrames, a_million_spoiled_bytes_in_files_crash_nothing) {
  const std::string file =
      avi_file(kSound + kVideo, avi_chunk("00wb", "s") + avi_chunk("01dc", "one") +
                                    avi_list("rec ", avi_chunk("01dc", "three")));
  test::for_random_cases(100'000, [&](test::Random& random) {
    std::string spoiled = file;
    for (std::int64_t i = random.integer(1, 19); i > 0; --i) {
      spoiled[random.bits() % spoiled.size()] = static_cast<char>(random.bits());
    }
    // The marks without which nothing would be read, mostly.
    if (random.chance(0.8)) spoiled.replace(0, 12, file, 0, 12);
    std::size_t bytes = 0;
    for (const std::string& frame : frames_of(spoiled)) bytes += frame.size();
    ASSERT_LE(bytes, 2 * spoiled.size());
  });
}

}  // namespace
}  // namespace sinew::vision
