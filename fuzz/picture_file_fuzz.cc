#include <cstddef>
#include <cstdint>

#include "sinew/core/assert.h"
#include "sinew/vision/cube_detection.h"
#include "sinew/vision/picture_file.h"

// Any bytes as a picture: a sentence, or pixels of which each stage of the detection makes
// something finite.

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sinew;
  const auto picture = vision::decode_picture({data, size});
  if (!picture) {
    SINEW_ASSERT(!picture.error().empty());
    return 0;
  }
  SINEW_ASSERT(picture->width > 0 && picture->height > 0);
  constexpr std::int64_t kQuick = 200'000;  // px
  if (std::int64_t{picture->width} * picture->height > kQuick) return 0;
  for (const vision::SeenCube& cube : vision::detect_cubes(*picture).cubes) {
    SINEW_ASSERT(cube.size > 0 && cube.size < 2.0 * (picture->width + picture->height));
    SINEW_ASSERT(cube.confidence >= 0 && cube.confidence <= 1);
  }
  return 0;
}
