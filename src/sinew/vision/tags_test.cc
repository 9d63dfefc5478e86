#include "sinew/vision/tags.h"

#include <gtest/gtest.h>

#include "sinew/core/units.h"
#include "sinew/vision/tag_board.h"
#include "support/property.h"

namespace sinew::vision {
namespace {

TEST(TagBoard, all_tags_of_a_printed_board_are_found_where_they_are) {
  for (const char* paper : {"a4", "letter"}) {
    const auto board = calibration_board(paper);
    ASSERT_TRUE(board);
    EXPECT_GE(board->columns * board->rows, 30) << paper;
    const double scale = 4000;  // px/m: 13 px a cell
    const Picture picture = picture_of(*board, scale);
    TagFinder finder({board->family});
    const auto tags = finder.find(picture);
    ASSERT_EQ(tags.size(), static_cast<std::size_t>(board->columns * board->rows)) << paper;
    const BoardCorners corners = corners_in(*board, tags);
    for (std::size_t i = 0; i < corners.pixels.size(); ++i) {
      const Pixel printed{scale * (corners.points_B[i].x + board->width / 2),
                          scale * (board->height / 2 - corners.points_B[i].y)};
      EXPECT_LT(length(corners.pixels[i] - printed), 0.8) << paper << ", corner " << i;
    }
  }
  EXPECT_FALSE(calibration_board("a0"));
}

TEST(TagBoard, sheet_for_the_table_has_tags_of_its_own_and_stays_on_the_paper) {
  for (const char* paper : {"a4", "a3", "letter"}) {
    const auto sheet = table_sheet(paper);
    const auto board = calibration_board(paper);
    ASSERT_TRUE(sheet && board);
    EXPECT_LT(board->first + board->columns * board->rows, sheet->first);
    EXPECT_LT(sheet->corner(sheet->first + 1, 1).x, sheet->width / 2 - 0.01);
    EXPECT_LT(sheet->corner(sheet->first, 0).y, sheet->height / 2 - 0.01);
    EXPECT_EQ(TagFinder({sheet->family}).find(picture_of(*sheet, 3100)).size(), 4U);
  }
}

TEST(TagBoard, crosses_to_touch_are_white_around_and_far_apart) {
  for (const char* paper : {"a4", "a3", "letter"}) {
    const auto sheet = table_sheet(paper);
    ASSERT_EQ(sheet->crosses.size(), 5U);
    constexpr double kScale = 4000;  // px/m
    const Picture print = picture_of(*sheet, kScale);
    const auto dark = [&](const Vec3& p_B) {
      return *print.at(static_cast<int>(kScale * (p_B.x + sheet->width / 2)),
                       static_cast<int>(kScale * (sheet->height / 2 - p_B.y))) == 0;
    };
    for (const BoardMark& cross : sheet->crosses) {
      EXPECT_TRUE(dark(cross.p_B)) << paper << ", " << cross.name;
      for (int step = 0; step < 60; ++step) {
        const Vec3 around = rotation_z(step * kPi / 30) * Vec3{0.007, 0, 0};
        EXPECT_FALSE(dark(cross.p_B + around)) << paper << ", " << cross.name;
      }
    }
    EXPECT_GT(norm(sheet->crosses[0].p_B - sheet->crosses[1].p_B), 0.75 * sheet->width);
    EXPECT_GT(norm(sheet->crosses[0].p_B - sheet->crosses[3].p_B), 0.7 * sheet->height);
    const auto marks = marks_of(*sheet);
    ASSERT_EQ(marks.size(), 9U);
    EXPECT_EQ(marks[0].name, "cross1");
    EXPECT_EQ(marks[5].name, "tag580");
    EXPECT_LT(norm(marks[5].p_B - Vec3{-sheet->pitch / 2, sheet->pitch / 2 + sheet->lift, 0}),
              1e-9);
    EXPECT_NE(svg_of(*sheet).find(">5</text>"), std::string::npos);
    EXPECT_NE(pdf_of(*sheet).find("(5) Tj"), std::string::npos);
  }
  EXPECT_TRUE(calibration_board("a4")->crosses.empty());
}

TEST(TagBoard, single_tag_has_its_middle_at_the_origin) {
  const TagBoard tag = single_tag(TagFamily::kStandard41h12, 7, 0.03);
  EXPECT_LT(norm(tag.corner(7, 0) - Vec3{-0.015, 0.015, 0}), 1e-12);
  EXPECT_LT(norm(tag.corner(7, 2) - Vec3{0.015, -0.015, 0}), 1e-12);
  EXPECT_FALSE(tag.has({TagFamily::k36h11, 7, {}, 0}));
  ASSERT_EQ(marks_of(tag).size(), 1U);
  EXPECT_EQ(marks_of(tag)[0].name, "tag7");
}

TEST(TagBoard, prints_are_true_to_scale) {
  const auto board = calibration_board("a4");
  const std::string svg = svg_of(*board);
  EXPECT_NE(svg.find("width=\"210mm\" height=\"297mm\" viewBox=\"0 0 210 297\""),
            std::string::npos);
  EXPECT_NE(svg.find("M55.0000"), std::string::npos) << "the ruler: 100 mm in the middle";
  EXPECT_NE(svg.find("h100.0000"), std::string::npos);
  const std::string pdf = pdf_of(*board);
  EXPECT_NE(pdf.find("/MediaBox [0 0 595.276 841.890]"), std::string::npos);
  EXPECT_NE(pdf.find(" 283.4646 "), std::string::npos) << "the ruler, in points";
  // Each object begins where the index says.
  const std::size_t index = pdf.find("xref\n");
  for (int i = 1; i <= 5; ++i) {
    const std::size_t row = index + 9 + 20 * static_cast<std::size_t>(i);
    const std::size_t at = std::stoul(pdf.substr(row, 10));
    EXPECT_EQ(pdf.substr(at, 7), std::to_string(i) + " 0 obj");
  }
  EXPECT_EQ(std::stoul(pdf.substr(pdf.find("startxref\n") + 10)), index);
}

TEST(Tags, corners_begin_at_the_upper_left_of_the_upright_tag_however_it_lies) {
  const auto cells = tag_cells(TagFamily::kStandard41h12, 7);
  ASSERT_TRUE(cells);
  constexpr int kCellPx = 12;
  const int side = cells->side * kCellPx + 40;
  Picture upright = black_picture(side, side);
  std::ranges::fill(upright.rgb, 200);
  for (int y = 0; y < cells->side * kCellPx; ++y) {
    for (int x = 0; x < cells->side * kCellPx; ++x) {
      std::fill_n(upright.at(x + 20, y + 20), 3, cells->at(x / kCellPx, y / kCellPx) ? 255 : 0);
    }
  }
  Picture turned = upright;  // a quarter to the right
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) std::copy_n(upright.at(x, y), 3, turned.at(side - 1 - y, x));
  }
  TagFinder finder({TagFamily::k36h11, TagFamily::kStandard41h12});
  const double near = 20 + cells->quiet * kCellPx;
  const double far = side - near;
  const auto one = finder.find(upright);
  const auto other = finder.find(turned);
  ASSERT_EQ(one.size(), 1U);
  ASSERT_EQ(other.size(), 1U);
  EXPECT_EQ(one[0].id, 7);
  EXPECT_EQ(one[0].family, TagFamily::kStandard41h12);
  EXPECT_LT(length(one[0].corners[0] - Pixel{near, near}), 1);
  EXPECT_LT(length(one[0].corners[1] - Pixel{far, near}), 1);
  EXPECT_LT(length(other[0].corners[0] - Pixel{far, near}), 1);
  EXPECT_LT(length(other[0].corners[1] - Pixel{far, far}), 1);
  EXPECT_FALSE(tag_cells(TagFamily::k36h11, 587));
  EXPECT_FALSE(tag_cells(TagFamily::k36h11, -1));
}

TEST(Tags, none_in_pictures_that_have_none_or_are_too_small) {
  TagFinder finder({TagFamily::k36h11});
  for (const auto& [width, height] : {std::pair(1, 1), {3, 200}, {64, 64}}) {
    EXPECT_TRUE(finder.find(black_picture(width, height)).empty());
  }
}

}  // namespace
}  // namespace sinew::vision
