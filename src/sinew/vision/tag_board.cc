#include "sinew/vision/tag_board.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace sinew::vision {
namespace {

struct Paper {
  std::string_view name;
  double width;   ///< m
  double height;  ///< m
};
constexpr std::array<Paper, 3> kPapers{
    {{"a4", 0.210, 0.297}, {"a3", 0.297, 0.420}, {"letter", 0.2159, 0.2794}}};
constexpr double kMargin = 0.012;    ///< m, that printers leave white
constexpr double kFoot = 0.020;      ///< m, for the ruler
constexpr double kRuler = 0.100;     ///< m
constexpr double kRulerTop = 0.010;  ///< m, of the ruler above the margin
constexpr double kCross = 0.005;     ///< m, half of a cross
constexpr double kThin = 0.0003;     ///< m, of a line

const Paper* paper_named(std::string_view name) {
  const auto found = std::ranges::find(kPapers, name, &Paper::name);
  return found == kPapers.end() ? nullptr : &*found;
}

/// A black rectangle: its lower left corner, from that of the sheet. m
struct Bar {
  double x;
  double y;
  double width;
  double height;
};

std::vector<Bar> ruler_of(const TagBoard& board) {
  const double x = (board.width - kRuler) / 2;
  const double y = kMargin + 0.004;
  std::vector<Bar> bars{{x, y, kRuler, kThin}};
  for (int mm = 0; mm <= 100; mm += 5) {
    const double tick = mm % 50 == 0 ? 0.006 : mm % 10 == 0 ? 0.004 : 0.0025;
    bars.push_back({x + mm * 1e-3 - kThin / 2, y, kThin, tick});
  }
  return bars;
}

/// Where the number of a cross stands: beside it, towards the middle. m, from the middle of the
/// sheet
Vec3 number_place(const BoardMark& cross) {
  constexpr double kAside = 0.0095;
  return cross.p_B + Vec3{cross.p_B.x > 0 ? -kAside : kAside, -0.0015, 0};
}
std::string_view number_of(const BoardMark& cross) {
  return std::string_view(cross.name).substr(cross.name.find_first_of("0123456789"));
}

/// All that is black, cells of a row that touch as one.
std::vector<Bar> bars_of(const TagBoard& board) {
  std::vector<Bar> bars = ruler_of(board);
  for (const BoardMark& cross : board.crosses) {
    const double x = cross.p_B.x + board.width / 2;
    const double y = cross.p_B.y + board.height / 2;
    bars.push_back({x - kCross, y - kThin / 2, 2 * kCross, kThin});
    bars.push_back({x - kThin / 2, y - kCross, kThin, 2 * kCross});
  }
  for (int i = 0; i < board.columns * board.rows; ++i) {
    const auto cells = tag_cells(board.family, board.first + i);
    const double cell = board.tag / (cells->side - 2 * cells->quiet);
    const Vec3 corner = board.corner(board.first + i, 0);
    const double left = corner.x + board.width / 2 - cells->quiet * cell;
    const double top = corner.y + board.height / 2 + cells->quiet * cell;
    for (int y = 0; y < cells->side; ++y) {
      for (int x = 0; x < cells->side;) {
        const int begin = x;
        while (x < cells->side && !cells->at(x, y)) ++x;
        if (x > begin) {
          bars.push_back({left + begin * cell, top - (y + 1) * cell, (x - begin) * cell, cell});
        }
        ++x;
      }
    }
  }
  return bars;
}

std::string title_of(const TagBoard& board) {
  return fmt::format(
      "AprilTag {} {}-{}, {:.2f} mm every {:.2f} mm. Print at 100 %. The ruler must be 100 mm "
      "long.",
      name(board.family), board.first, board.first + board.columns * board.rows - 1,
      1e3 * board.tag, 1e3 * board.pitch);
}

}  // namespace

Vec3 TagBoard::corner(int id, std::size_t which) const {
  const int i = id - first;
  const double x = (i % columns - (columns - 1) / 2.0) * pitch;
  const double y = ((rows - 1) / 2.0 - static_cast<double>(i / columns)) * pitch + lift;
  const double right = which == 1 || which == 2 ? 0.5 : -0.5;
  const double up = which < 2 ? 0.5 : -0.5;
  return {x + right * tag, y + up * tag, 0};
}

std::optional<TagBoard> calibration_board(std::string_view paper) {
  const Paper* sheet = paper_named(paper);
  if (!sheet) return std::nullopt;
  TagBoard board{.paper = std::string(sheet->name), .width = sheet->width, .height = sheet->height};
  // A fifth of the pitch stays white: a tag needs a cell of it all around.
  constexpr double kTag = 0.027;
  board.tag = kTag;
  board.pitch = 1.25 * kTag;
  const auto fit = [&](double room) { return 1 + static_cast<int>((room - kTag) / board.pitch); };
  board.columns = fit(sheet->width - 2 * kMargin);
  board.rows = fit(sheet->height - 2 * kMargin - kFoot);
  board.lift = kFoot / 2;
  return board;
}

std::optional<TagBoard> table_sheet(std::string_view paper) {
  const Paper* sheet = paper_named(paper);
  if (!sheet) return std::nullopt;
  TagBoard board{.paper = std::string(sheet->name), .width = sheet->width, .height = sheet->height};
  // Numbers that no calibration board has.
  board.first = 580;
  board.columns = board.rows = 2;
  board.tag = 0.04;
  board.pitch = sheet->width - 2 * kMargin - 1.2 * board.tag;
  board.lift = kFoot / 2;
  // In the white strips above and below the tags, as far apart as the paper allows.
  const double x = sheet->width / 2 - kMargin - kCross;
  const double tags_end = board.pitch / 2 + 0.6 * board.tag;
  const double above = (board.lift + tags_end + sheet->height / 2 - kMargin) / 2;
  const double below = (board.lift - tags_end - sheet->height / 2 + kMargin + kRulerTop) / 2;
  board.crosses = {{"cross1", {-x, above, 0}},
                   {"cross2", {x, above, 0}},
                   {"cross3", {x, below, 0}},
                   {"cross4", {-x, below, 0}},
                   {"cross5", {0, board.lift, 0}}};
  return board;
}

TagBoard single_tag(TagFamily family, int id, double side) {
  TagBoard board{.paper = {}, .width = side, .height = side};
  board.family = family;
  board.first = id;
  board.columns = board.rows = 1;
  board.tag = board.pitch = side;
  return board;
}

std::vector<BoardMark> marks_of(const TagBoard& board) {
  std::vector<BoardMark> marks = board.crosses;
  for (int id = board.first; id < board.first + board.columns * board.rows; ++id) {
    marks.push_back({fmt::format("tag{}", id), 0.5 * (board.corner(id, 0) + board.corner(id, 2))});
  }
  return marks;
}

std::string svg_of(const TagBoard& board) {
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.4g}mm\" height=\"{1:.4g}mm\" "
      "viewBox=\"0 0 {0:.4g} {1:.4g}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
      "<path d=\"",
      1e3 * board.width, 1e3 * board.height);
  for (const Bar& bar : bars_of(board)) {
    svg += fmt::format("M{:.4f} {:.4f}h{:.4f}v{:.4f}h{:.4f}z\n", 1e3 * bar.x,
                       1e3 * (board.height - bar.y - bar.height), 1e3 * bar.width, 1e3 * bar.height,
                       -1e3 * bar.width);
  }
  svg += "\"/>\n";
  for (const BoardMark& cross : board.crosses) {
    const Vec3 place = number_place(cross);
    svg += fmt::format(
        "<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"4.5\" text-anchor=\"middle\" "
        "font-family=\"Helvetica, Arial, sans-serif\">{}</text>\n",
        1e3 * (place.x + board.width / 2), 1e3 * (board.height / 2 - place.y), number_of(cross));
  }
  svg += fmt::format(
      "<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"3\" text-anchor=\"middle\" "
      "font-family=\"Helvetica, Arial, sans-serif\">{}</text>\n</svg>\n",
      500 * board.width, 1e3 * (board.height - kMargin), title_of(board));
  return svg;
}

std::string pdf_of(const TagBoard& board) {
  constexpr double kPoint = 72 / 0.0254;  // a metre, of PDF's points
  std::string content = "0 g\n";
  for (const Bar& bar : bars_of(board)) {
    content += fmt::format("{:.4f} {:.4f} {:.4f} {:.4f} re\n", kPoint * bar.x, kPoint * bar.y,
                           kPoint * bar.width, kPoint * bar.height);
  }
  content += "f\n";
  for (const BoardMark& cross : board.crosses) {
    const Vec3 place = number_place(cross) + Vec3{board.width / 2 - 0.00125, board.height / 2, 0};
    content += fmt::format("BT /F 12.8 Tf {:.2f} {:.2f} Td ({}) Tj ET\n", kPoint * place.x,
                           kPoint * place.y, number_of(cross));
  }
  content += fmt::format("BT /F 8 Tf {:.2f} {:.2f} Td ({}) Tj ET\n", kPoint * kMargin,
                         kPoint * kMargin, title_of(board));
  const std::array<std::string, 5> objects{
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      fmt::format("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.3f} {:.3f}] /Contents 5 0 R "
                  "/Resources << /Font << /F 4 0 R >> >> >>",
                  kPoint * board.width, kPoint * board.height),
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>",
      fmt::format("<< /Length {} >>\nstream\n{}endstream", content.size(), content)};
  std::string pdf = "%PDF-1.4\n";
  std::string index = fmt::format("xref\n0 {}\n0000000000 65535 f \n", objects.size() + 1);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    index += fmt::format("{:010} 00000 n \n", pdf.size());
    pdf += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects[i]);
  }
  return pdf + index +
         fmt::format("trailer\n<< /Size {} /Root 1 0 R >>\nstartxref\n{}\n%%EOF\n",
                     objects.size() + 1, pdf.size());
}

Picture picture_of(const TagBoard& board, double scale) {
  Picture picture = black_picture(static_cast<int>(std::ceil(board.width * scale)),
                                  static_cast<int>(std::ceil(board.height * scale)));
  std::ranges::fill(picture.rgb, 255);
  // Bars that share an edge have to round it alike: a hair below keeps sums of floating point from
  // falling on both sides of a half. A line thinner than a pixel still has one.
  const auto at = [&](double metres) {
    return static_cast<int>(std::lround(metres * scale - 1e-6));
  };
  const auto behind = [&](double begin, double length) {
    return std::max(at(begin) + 1, at(begin + length));
  };
  for (const Bar& bar : bars_of(board)) {
    const double top = board.height - bar.y - bar.height;
    for (int y = at(top); y < std::min(picture.height, behind(top, bar.height)); ++y) {
      for (int x = at(bar.x); x < std::min(picture.width, behind(bar.x, bar.width)); ++x) {
        std::fill_n(picture.at(x, y), 3, 0);
      }
    }
  }
  return picture;
}

BoardCorners corners_in(const TagBoard& board, const std::vector<SeenTag>& tags) {
  BoardCorners found;
  for (const SeenTag& tag : tags) {
    if (!board.has(tag)) continue;
    for (std::size_t k = 0; k < 4; ++k) {
      found.points_B.push_back(board.corner(tag.id, k));
      found.pixels.push_back(tag.corners[k]);
    }
  }
  return found;
}

}  // namespace sinew::vision
