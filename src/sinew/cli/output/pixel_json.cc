#include "sinew/cli/output/pixel_json.h"

#include <cmath>

namespace sinew::cli {

Json pixel_json(vision::Pixel p) {
  return {std::round(10 * p.x) / 10, std::round(10 * p.y) / 10};
}

}  // namespace sinew::cli
