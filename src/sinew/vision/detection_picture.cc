#include "sinew/vision/detection_picture.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::vision {
namespace {

using Ink = std::array<std::uint8_t, 3>;
constexpr Ink kSeen{0, 255, 70};
constexpr Ink kRefused{255, 0, 255};
constexpr Ink kPaper{0, 0, 0};

/// Capitals of 3 x 5 dots: a row in three bits, an octal digit each.
struct Glyph {
  char letter;
  const char* rows;
};
constexpr Glyph kGlyphs[] = {
    {'0', "75557"}, {'1', "26227"}, {'2', "71747"}, {'3', "71717"}, {'4', "55711"}, {'5', "74717"},
    {'6', "74757"}, {'7', "71122"}, {'8', "75757"}, {'9', "75717"}, {'A', "25755"}, {'B', "65656"},
    {'C', "34443"}, {'D', "65556"}, {'E', "74647"}, {'F', "74644"}, {'G', "34553"}, {'H', "55755"},
    {'I', "72227"}, {'J', "11152"}, {'K', "55655"}, {'L', "44447"}, {'M', "57755"}, {'N', "65555"},
    {'O', "25552"}, {'P', "65644"}, {'Q', "25563"}, {'R', "65655"}, {'S', "34216"}, {'T', "72222"},
    {'U', "55557"}, {'V', "55552"}, {'W', "55775"}, {'X', "55255"}, {'Y', "55222"}, {'Z', "71247"},
    {',', "00024"}, {'.', "00002"}, {':', "02020"}, {';', "02024"}, {'-', "00700"}};
constexpr int kGlyphRows = 5;

/// Null where there is none: a gap.
const char* rows_of(char letter) {
  const char capital =
      letter >= 'a' && letter <= 'z' ? static_cast<char>(letter - 'a' + 'A') : letter;
  const auto* glyph = std::ranges::find(kGlyphs, capital, &Glyph::letter);
  return glyph != std::end(kGlyphs) ? glyph->rows : nullptr;
}

/// px
int line_width(const Picture& picture) {
  return std::max(1, std::max(picture.width, picture.height) / 500);
}

class Pen {
 public:
  /// @param width  px, of a line
  Pen(Picture& picture, int width) : picture_(picture), width_(width) {}

  void box(Pixel corner, double width, double height, const Ink& ink) {
    const auto cut = [](double value, int size) {
      return static_cast<int>(std::lround(std::clamp(value, 0.0, static_cast<double>(size))));
    };
    const int right = cut(corner.x + width, picture_.width);
    const int bottom = cut(corner.y + height, picture_.height);
    for (int y = cut(corner.y, picture_.height); y < bottom; ++y) {
      for (int x = cut(corner.x, picture_.width); x < right; ++x) {
        std::ranges::copy(ink, picture_.at(x, y));
      }
    }
  }

  void line(Pixel from, Pixel to, const Ink& ink) {
    const double steps = std::max(1.0, std::ceil(length(to - from)));
    const double half = width_ / 2.0;
    for (int i = 0; i <= static_cast<int>(steps); ++i) {
      const Pixel p = from + (i / steps) * (to - from);
      box({p.x - half, p.y - half}, width_, width_, ink);
    }
  }

  void outline(const Quad& quad, const Ink& ink) {
    for (std::size_t i = 0; i < 4; ++i) line(quad[i], quad[(i + 1) % 4], ink);
  }

  void cross_at(Pixel p, const Ink& ink) {
    const double arm = 4.0 * width_;
    line({p.x - arm, p.y}, {p.x + arm, p.y}, ink);
    line({p.x, p.y - arm}, {p.x, p.y + arm}, ink);
  }

  /// @param at  its upper left corner
  void text(std::string_view letters, Pixel at, const Ink& ink) {
    const double dot = 2.0 * width_;
    for (const char letter : letters) {
      box({at.x - dot, at.y - dot}, 5 * dot, 7 * dot, kPaper);
      const char* rows = rows_of(letter);
      for (int row = 0; rows != nullptr && row < kGlyphRows; ++row) {
        const int bits = rows[row] - '0';
        for (int column = 0; column < 3; ++column) {
          if ((bits >> (2 - column) & 1) == 0) continue;
          box({at.x + column * dot, at.y + row * dot}, dot, dot, ink);
        }
      }
      at.x += 4 * dot;
    }
  }

 private:
  Picture& picture_;
  int width_;
};

/// A line of the legend, and the ink of what it is about.
struct Line {
  std::string text;
  Ink ink;
};

/// What each number is: those of one kind on one line, or on some where they are many.
class Legend {
 public:
  /// @param letters  on a line
  explicit Legend(std::size_t letters) : letters_(letters) {}

  void add(std::size_t number, const std::string& what, const Ink& ink) {
    auto line = std::ranges::find_if(lines_, [&](const Line& one) {
      return one.text.starts_with(what + ":") && one.text.size() + 5 <= letters_;
    });
    if (line == lines_.end()) line = lines_.insert(lines_.end(), {what + ":", ink});
    line->text += " " + std::to_string(number);
  }
  const std::vector<Line>& lines() const { return lines_; }

 private:
  std::size_t letters_;
  std::vector<Line> lines_;
};

}  // namespace

Picture detection_picture(Picture picture, const Detection& detection) {
  const int width = line_width(picture);
  Legend legend(static_cast<std::size_t>(std::max(1, picture.width / (8 * width) - 2)));
  std::size_t number = 0;
  Pen pen(picture, width);
  const auto draw = [&](const Quad& outline, const Ink& ink, const std::string& what) {
    pen.outline(outline, ink);
    pen.text(std::to_string(++number), outline[0], ink);
    legend.add(number, what, ink);
  };
  for (const SeenCube& cube : detection.cubes) {
    draw(cube.top, kSeen, std::string(name(cube.color)));
    pen.cross_at(cube.center, kSeen);
  }
  for (const RefusedShape& shape : detection.refused) {
    draw(shape.outline, kRefused, "no cube, " + shape.why);
  }
  const int line_height = 16 * width;
  int y = picture.height + 8 * width;
  picture.height += (static_cast<int>(legend.lines().size()) + 1) * line_height;
  picture.rgb.resize(3 * static_cast<std::size_t>(picture.width) *
                     static_cast<std::size_t>(picture.height));
  for (const Line& line : legend.lines()) {
    pen.text(line.text, {6.0 * width, 1.0 * y}, line.ink);
    y += line_height;
  }
  return picture;
}

}  // namespace sinew::vision
