#include <gtest/gtest.h>

#include "cli/process.h"
#include "cli/rendered_table.h"
#include "sinew/config/camera_file.h"
#include "sinew/core/units.h"
#include "sinew/vision/picture_file.h"
#include "sinew/vision/tag_board.h"
#include "support/scratch_folder.h"

namespace sinew::test {
namespace {

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
  const auto center =
      vision::pinhole(320, 240, from_deg(50)).project(kX_WC.inverse() * Vec3{0, 0, kEdge});
  EXPECT_NEAR(cube["center_px"][0].get<double>(), center->x, 2);
  EXPECT_NEAR(cube["center_px"][1].get<double>(), center->y, 2);
  EXPECT_NEAR(cube["size_px"].get<double>(), 31, 2);
  EXPECT_EQ(cube["top_px"].size(), 4U);
  EXPECT_FALSE(cube.contains("center_mm"));

  const std::string seen = folder.at("seen.png");
  const Ended shown = sinew({"detect", image, "--debug", seen});
  EXPECT_EQ(shown.exit, 0) << shown.err;
  EXPECT_NE(shown.out.find("red"), std::string::npos) << shown.out;
  const std::string bytes = text_of(seen);
  const auto picture =
      vision::decode_picture({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  ASSERT_TRUE(picture) << picture.error();
  EXPECT_EQ(picture->width, 320);
  const auto* cross = picture->at(static_cast<int>(cube["center_px"][0].get<double>()),
                                  static_cast<int>(cube["center_px"][1].get<double>()));
  EXPECT_EQ(cross[1], 255) << "a cross in its middle";
}

TEST(DetectVerb, with_a_camera_it_says_millimetres_and_the_level_in_a_tower) {
  const ScratchFolder folder;
  const std::string camera = folder.file(
      "camera.toml",
      camera_text({"test", vision::pinhole(320, 240, from_deg(50)), kX_WC, 0.2, 1e-3, "", "",
                   vision::TouchedTable{"left", {rotation_z(kPi / 2), {0.2, 0.05, 0}}, 1e-3}}));
  for (const int levels : {0, 2}) {
    const std::string image = png_file(folder, "table.png", table(levels));
    const Json json = answer(
        {"detect", image, "--camera", camera, "--cube-mm", "25", "--colors", "red", "--json"});
    ASSERT_EQ(json["cubes"].size(), 1U) << json.dump();
    const Json& cube = json["cubes"][0];
    EXPECT_NEAR(cube["center_mm"][0].get<double>(), 0, 2);
    EXPECT_NEAR(cube["center_mm"][1].get<double>(), 0, 2);
    EXPECT_EQ(cube["center_mm"][2].get<double>(), 25 * (levels + 1));
    EXPECT_EQ(json["robot"], "left");
    EXPECT_NEAR(cube["center_base_mm"][0].get<double>(), 200 - cube["center_mm"][1].get<double>(),
                0.02);
    EXPECT_NEAR(cube["center_base_mm"][1].get<double>(), 50 + cube["center_mm"][0].get<double>(),
                0.02);
    EXPECT_NEAR(cube["yaw_table_deg"].get<double>(), to_deg(0.3), 5);
    EXPECT_EQ(cube["level"], levels + 1);
  }
  const std::string image = png_file(folder, "table.png", table());
  const Json other = answer({"detect", image, "--camera", camera, "--cube-mm", "40", "--json"});
  EXPECT_TRUE(other["cubes"].empty());
  EXPECT_NE(other["refused"].dump().find("that of a cube 40 mm"), std::string::npos);

  EXPECT_EQ(sinew({"detect", image, "--camera", camera}).exit, 2);
  const Ended alone = sinew({"detect", image, "--cube-mm", "25"});
  EXPECT_EQ(alone.exit, 0) << alone.err;
  EXPECT_NE(alone.out.find("need a calibrated camera, too: --camera FILE"), std::string::npos);
  EXPECT_EQ(sinew({"detect", image, "--cube-mm", "0"}).exit, 2);
  EXPECT_EQ(sinew({"detect", image, "--camera", camera, "--cube-mm", "nan"}).exit, 2);
  EXPECT_EQ(sinew({"detect", image, "--camera", image, "--cube-mm", "25"}).exit, 2);
  const std::string small = png_file(folder, "small.png", vision::shrunk(table(), 160));
  const Ended refused = sinew({"detect", small, "--camera", camera, "--cube-mm", "25"});
  EXPECT_EQ(refused.exit, 1);
  EXPECT_NE(refused.err.find("is 160 x 120 px"), std::string::npos) << refused.err;
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

TEST(CameraVerb, boards_are_printed_and_tags_found) {
  const ScratchFolder folder;
  const Ended svg = sinew({"camera", "board"});
  EXPECT_EQ(svg.exit, 0) << svg.err;
  EXPECT_EQ(svg.out.substr(0, 4), "<svg");
  EXPECT_EQ(sinew({"camera", "board", "--form", "pdf"}).out.substr(0, 5), "%PDF-");
  EXPECT_NE(sinew({"camera", "sheet", "--paper", "a3"}).out, svg.out);
  const std::string board =
      png_file(folder, "board.png", picture_of(*vision::calibration_board("a4"), 3000));
  const Json tags = answer({"camera", "tags", board, "--json"});
  EXPECT_GE(tags["tags"].size(), 30U);
  EXPECT_EQ(tags["tags"][3]["id"], 3);

  const std::string camera = folder.at("camera.toml");
  const std::vector<std::vector<std::string>> wrong{
      {"camera", "board", "--paper", "a0"},
      {"camera", "board", "--form", "docx"},
      {"camera", "board", board},
      {"camera", "tags"},
      {"camera", "dance"},
      {"camera", "calibrate", board},
      {"camera", "calibrate", board, "--table", board, "--out", camera, "--name", "a\"b"}};
  for (const auto& arguments : wrong) EXPECT_EQ(sinew(arguments).exit, 2) << arguments.back();
  const Ended alone = sinew({"camera", "calibrate", board, "--table", board, "--out", camera});
  EXPECT_EQ(alone.exit, 1);
  EXPECT_NE(alone.err.find("No tag of the sheet is seen"), std::string::npos) << alone.err;
  const std::string sheet =
      png_file(folder, "sheet.png", picture_of(*vision::table_sheet("a4"), 3000));
  const Ended few = sinew({"camera", "calibrate", board, "--table", sheet, "--out", camera});
  EXPECT_EQ(few.exit, 1);
  EXPECT_NE(few.err.find("Too few views: 1, at least 5 needed"), std::string::npos) << few.err;
  EXPECT_TRUE(text_of(camera).empty()) << "nothing is written";
}

}  // namespace
}  // namespace sinew::test
