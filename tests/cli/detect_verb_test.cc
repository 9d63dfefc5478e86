#include <gtest/gtest.h>

#include "cli/process.h"
#include "sinew/io/scratch_folder_test_support.h"
#include "sinew/vision/picture_file.h"

namespace sinew::test {
namespace {

/// A white table with a red square of 60 px in the middle.
vision::Picture table() {
  vision::Picture picture = vision::black_picture(320, 240);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const bool red = x >= 130 && x < 190 && y >= 90 && y < 150;
      picture.at(x, y)[0] = red ? 190 : 215;
      picture.at(x, y)[1] = picture.at(x, y)[2] = red ? 30 : 212;
    }
  }
  return picture;
}

std::string png_file(const ScratchFolder& folder, const std::string& name,
                     const vision::Picture& picture) {
  const auto png = vision::encode_png(picture);
  return folder.file(name, std::string(png.begin(), png.end()));
}

TEST(DetectVerb, tells_where_the_cubes_are_and_shows_them) {
  const ScratchFolder folder;
  const std::string image = png_file(folder, "table.png", table());
  const Json json = answer({"detect", image, "--json"});
  EXPECT_EQ(json["image"], image);
  EXPECT_EQ(json["width"], 320);
  EXPECT_EQ(json["height"], 240);
  ASSERT_EQ(json["cubes"].size(), 1U) << json.dump();
  const Json& cube = json["cubes"][0];
  EXPECT_EQ(cube["color"], "red");
  EXPECT_NEAR(cube["center_px"][0].get<double>(), 160, 1);
  EXPECT_NEAR(cube["center_px"][1].get<double>(), 120, 1);
  EXPECT_NEAR(cube["size_px"].get<double>(), 60, 2);
  EXPECT_EQ(cube["top_px"].size(), 4U);

  const std::string seen = folder.at("seen.png");
  const Ended shown = sinew({"detect", image, "--debug", seen});
  EXPECT_EQ(shown.exit, 0) << shown.err;
  EXPECT_NE(shown.out.find("red"), std::string::npos) << shown.out;
  const std::string bytes = text_of(seen);
  const auto picture =
      vision::decode_picture({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  ASSERT_TRUE(picture) << picture.error();
  EXPECT_EQ(picture->width, 320);
  EXPECT_EQ(picture->at(160, 120)[1], 255) << "a cross in its middle";
}

TEST(DetectVerb, several_images_are_answered_one_by_one) {
  const ScratchFolder folder;
  const std::string image = png_file(folder, "table.png", table());
  const std::string text = folder.file("note.txt", "no picture");
  const Ended ended = sinew({"detect", image, text, folder.at("nowhere.jpg"), "--json"});
  EXPECT_EQ(ended.exit, 1);
  const Json images = ended.json()["images"];
  ASSERT_EQ(images.size(), 3U);
  EXPECT_EQ(images[0]["cubes"].size(), 1U);
  EXPECT_EQ(images[1]["error"]["sentence"], text + ": no picture; JPEG and PNG files are read");
  EXPECT_NE(ended.err.find("nowhere.jpg"), std::string::npos) << ended.err;
}

TEST(DetectVerb, wishes_that_make_no_sense_are_refused) {
  const ScratchFolder folder;
  const std::string image = png_file(folder, "table.png", table());
  const Ended color = sinew({"detect", image, "--colors", "red,octarine"});
  EXPECT_EQ(color.exit, 2);
  EXPECT_NE(color.err.find("'octarine' is none of red, orange"), std::string::npos) << color.err;
  EXPECT_EQ(sinew({"detect", image, image, "--debug", folder.at("a.png")}).exit, 2);
  EXPECT_EQ(sinew({"detect", image, "--debug", image}).exit, 2);
  EXPECT_EQ(sinew({"detect"}).exit, 2);
  const Json blue = answer({"detect", image, "--colors", "blue", "--json"});
  EXPECT_TRUE(blue["cubes"].empty());
  EXPECT_EQ(blue["refused"][0]["why"], "it is red, which was not asked for");
}

}  // namespace
}  // namespace sinew::test
