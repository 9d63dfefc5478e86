#include "firmware/stm32/own_image.h"

#include <cstdint>

#include "sinew/core/assert.h"

// Begin and end of the image, as the linker script lays it out.
extern "C" {
extern const std::uint8_t flash_begin, image_end;
}

namespace sinew::stm32 {
namespace {

struct Label {
  std::array<char, 8> mark;
  std::array<char, 24> board;
  std::array<char, 16> version;
  const std::uint8_t* begin;
  const std::uint8_t* end;
};
[[gnu::used, gnu::section(".label")]] constinit const Label label{
    kImageMark, image_text<24>(SINEW_BOARD), image_text<16>(SINEW_VERSION), &flash_begin,
    &image_end};

}  // namespace

BoardImage own_image() {
  const auto image = read_image({label.begin, label.end});
  SINEW_ASSERT(image.has_value());
  return *image;
}

}  // namespace sinew::stm32
