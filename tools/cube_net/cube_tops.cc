// cube_tops PICTURE...: all that looks like a top in each picture, for belief.py: a line
// PICTURE x y network alike stretch corners pale(0, 1) each, x and y its middle (px), the others as
// TopEvidence has them.

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <vector>

#include "sinew/vision/picture_file.h"
#include "sinew/vision/shapes.h"
#include "sinew/vision/top_belief.h"

int main(int argc, char** argv) {
  using namespace sinew::vision;
  for (int i = 1; i < argc; ++i) {
    std::ifstream file(argv[i], std::ios::binary);
    const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
    const auto picture =
        decode_picture({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    if (!picture) {
      std::fprintf(stderr, "%s: %s\n", argv[i], picture.error().c_str());
      return 1;
    }
    const std::vector<Top> tops = things_in(*picture).tops;
    const std::vector<TopEvidence> evidence = evidence_of(tops);
    for (std::size_t k = 0; k < tops.size(); ++k) {
      const Pixel middle = middle_of(tops[k].quad);
      std::printf("%s %.2f %.2f %.4f %.4f %.4f %.0f %d\n", argv[i], middle.x, middle.y,
                  evidence[k].network, evidence[k].alike, evidence[k].stretch, evidence[k].corners,
                  tops[k].color ? 0 : 1);
    }
  }
}
