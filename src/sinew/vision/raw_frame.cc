#include "sinew/vision/raw_frame.h"

#include <algorithm>
#include <array>

#include "sinew/vision/byte_text.h"
#include "sinew/vision/picture_file.h"

namespace sinew::vision {
namespace {

using Made = std::expected<Picture, std::string>;

/// Coefficients of BT.601 in 1/65536.
struct Matrix {
  int luma_zero = 0;
  int luma = 0;
  int red_v = 0;
  int green_u = 0;
  int green_v = 0;
  int blue_u = 0;
};

const Matrix& matrix_of(LumaRange range) {
  // 255/219 and 255/224 times 1.402, 0.344136, 0.714136, 1.772.
  static constexpr Matrix kLimited{16, 76309, 104597, 25675, 53279, 132201};
  static constexpr Matrix kFull{0, 65536, 91881, 22553, 46802, 116130};
  return range == LumaRange::kFull ? kFull : kLimited;
}

std::uint8_t clipped(int value) {
  return static_cast<std::uint8_t>(std::clamp((value + 32768) >> 16, 0, 255));
}

void write_pixel(std::uint8_t* out, const Matrix& matrix, int luma, int u, int v) {
  const int y = matrix.luma * (luma - matrix.luma_zero);
  out[0] = clipped(y + matrix.red_v * (v - 128));
  out[1] = clipped(y - matrix.green_u * (u - 128) - matrix.green_v * (v - 128));
  out[2] = clipped(y + matrix.blue_u * (u - 128));
}

std::optional<std::string> size_fault(int width, int height) {
  if (width < 1 || height < 1) return "a frame without pixels";
  if (width <= kPixelsMax / height) return std::nullopt;
  return "a frame of " + std::to_string(width) + " x " + std::to_string(height) +
         " pixels; at most " + std::to_string(kPixelsMax / 1'000'000) + " million are read";
}

std::string cut_short(std::size_t have, std::size_t want) {
  return "a frame cut short: " + std::to_string(have) + " of " + std::to_string(want) + " bytes";
}

/// What keeps rows of `row` bytes from being read.
std::optional<std::string> layout_fault(Bytes bytes, const FrameLayout& layout, std::size_t row) {
  if (auto fault = size_fault(layout.width, layout.height)) return fault;
  // No driver pads a row to this length; a lying one would overflow the product below.
  constexpr std::size_t kStrideMax = std::size_t{1} << 30U;
  if (layout.stride < row || layout.stride > kStrideMax) {
    return "rows of " + std::to_string(row) + " bytes in a stride of " +
           std::to_string(layout.stride);
  }
  const std::size_t want = layout.stride * (static_cast<std::size_t>(layout.height) - 1) + row;
  if (bytes.size() < want) return cut_short(bytes.size(), want);
  return std::nullopt;
}

int columns_of_chroma(const PlaneLayout& layout) {
  return layout.chroma == Chroma::k444 ? layout.width : (layout.width + 1) / 2;
}

bool is_420(Chroma chroma) {
  return chroma == Chroma::k420Centre || chroma == Chroma::k420Left;
}

int rows_of_chroma(const PlaneLayout& layout) {
  return is_420(layout.chroma) ? (layout.height + 1) / 2 : layout.height;
}

/// A chroma plane's samples for one row of luma, each 0 to 255. Between samples it is linear.
class ChromaRow {
 public:
  ChromaRow(Bytes plane, const PlaneLayout& layout)
      : plane_(plane),
        layout_(layout),
        columns_(static_cast<std::size_t>(columns_of_chroma(layout))),
        rows_(static_cast<std::size_t>(rows_of_chroma(layout))),
        sum_(columns_),
        row_(static_cast<std::size_t>(layout.width)) {}

  const std::vector<int>& at(int y) {
    blend_rows(static_cast<std::size_t>(y));
    spread();
    return row_;
  }

 private:
  /// Four times the chroma at the height of this row.
  void blend_rows(std::size_t y) {
    std::size_t near = y;
    std::size_t far = y;
    if (is_420(layout_.chroma)) {
      near = y / 2;
      far = y % 2 == 0 ? near - (near > 0 ? 1 : 0) : std::min(near + 1, rows_ - 1);
    }
    for (std::size_t i = 0; i < columns_; ++i) {
      sum_[i] = 3 * plane_[near * columns_ + i] + plane_[far * columns_ + i];
    }
  }

  void spread() {
    for (std::size_t x = 0; x < row_.size(); ++x) {
      if (layout_.chroma == Chroma::k444) {
        row_[x] = (sum_[x] + 2) / 4;
        continue;
      }
      const std::size_t near = x / 2;
      const std::size_t after = std::min(near + 1, columns_ - 1);
      if (layout_.chroma == Chroma::k420Centre) {
        const std::size_t far = x % 2 == 0 ? near - (near > 0 ? 1 : 0) : after;
        row_[x] = (3 * sum_[near] + sum_[far] + 8) / 16;
      } else {
        row_[x] = (sum_[near] + sum_[x % 2 == 0 ? near : after] + 4) / 8;
      }
    }
  }

  Bytes plane_;
  PlaneLayout layout_;
  std::size_t columns_;
  std::size_t rows_;
  std::vector<int> sum_;
  std::vector<int> row_;
};

}  // namespace

Made picture_from_yuyv(Bytes bytes, const FrameLayout& layout) {
  const auto pairs = static_cast<std::size_t>(std::max(layout.width, 0) / 2 + layout.width % 2);
  if (auto fault = layout_fault(bytes, layout, 4 * pairs)) {
    return std::unexpected(std::move(*fault));
  }
  const Matrix& matrix = matrix_of(layout.range);
  Picture picture = black_picture(layout.width, layout.height);
  for (int y = 0; y < layout.height; ++y) {
    const std::uint8_t* row = bytes.data() + static_cast<std::size_t>(y) * layout.stride;
    std::uint8_t* out = picture.at(0, y);
    for (std::size_t x = 0; x < static_cast<std::size_t>(layout.width); ++x) {
      const std::size_t pair = x / 2;
      const std::uint8_t* here = row + 4 * pair;
      const std::uint8_t* next = row + 4 * std::min(pair + 1, pairs - 1);
      const bool odd = x % 2 == 1;
      const int u = odd ? (here[1] + next[1] + 1) / 2 : here[1];
      const int v = odd ? (here[3] + next[3] + 1) / 2 : here[3];
      write_pixel(out + 3 * x, matrix, here[odd ? 2 : 0], u, v);
    }
  }
  return picture;
}

Made picture_from_grey(Bytes bytes, const FrameLayout& layout) {
  if (auto fault = layout_fault(bytes, layout, static_cast<std::size_t>(std::max(layout.width, 0))))
    return std::unexpected(std::move(*fault));
  const Matrix& matrix = matrix_of(layout.range);
  Picture picture = black_picture(layout.width, layout.height);
  for (int y = 0; y < layout.height; ++y) {
    const std::uint8_t* row = bytes.data() + static_cast<std::size_t>(y) * layout.stride;
    for (int x = 0; x < layout.width; ++x) {
      write_pixel(picture.at(x, y), matrix, row[x], 128, 128);
    }
  }
  return picture;
}

std::optional<std::size_t> frame_bytes(const PlaneLayout& layout) {
  if (size_fault(layout.width, layout.height)) return std::nullopt;
  const std::size_t luma =
      static_cast<std::size_t>(layout.width) * static_cast<std::size_t>(layout.height);
  if (layout.chroma == Chroma::kNone) return luma;
  return luma + 2 * static_cast<std::size_t>(columns_of_chroma(layout)) *
                    static_cast<std::size_t>(rows_of_chroma(layout));
}

Made picture_from_planes(Bytes bytes, const PlaneLayout& layout) {
  if (auto fault = size_fault(layout.width, layout.height)) {
    return std::unexpected(std::move(*fault));
  }
  const std::size_t want = frame_bytes(layout).value_or(0);
  if (bytes.size() < want) return std::unexpected(cut_short(bytes.size(), want));
  const std::size_t luma =
      static_cast<std::size_t>(layout.width) * static_cast<std::size_t>(layout.height);
  if (layout.chroma == Chroma::kNone) {
    return picture_from_grey(
        bytes, {layout.width, layout.height, static_cast<std::size_t>(layout.width), layout.range});
  }
  const std::size_t chroma = (want - luma) / 2;
  ChromaRow u_rows(bytes.subspan(luma, chroma), layout);
  ChromaRow v_rows(bytes.subspan(luma + chroma, chroma), layout);
  const Matrix& matrix = matrix_of(layout.range);
  Picture picture = black_picture(layout.width, layout.height);
  const std::uint8_t* sample = bytes.data();
  for (int y = 0; y < layout.height; ++y) {
    const auto& u = u_rows.at(y);
    const auto& v = v_rows.at(y);
    std::uint8_t* out = picture.at(0, y);
    for (std::size_t x = 0; x < u.size(); ++x) {
      write_pixel(out + 3 * x, matrix, *sample++, u[x], v[x]);
    }
  }
  return picture;
}

}  // namespace sinew::vision
