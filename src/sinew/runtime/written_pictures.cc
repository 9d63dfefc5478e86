#include "sinew/runtime/written_pictures.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "sinew/io/clock.h"
#include "sinew/runtime/read_picture.h"

namespace sinew::runtime {
namespace {

constexpr Duration kBetween = std::chrono::milliseconds(20);  // looks at the file
constexpr std::size_t kBytesMax = std::size_t{64} << 20U;

/// Whether it is as good as one colour: black, covered, or all white. Noise of a covered lens stays
/// below, any table with something on it far above.
bool is_blind(const vision::Picture& picture) {
  constexpr int kParts = 16;
  constexpr int kApart = 12;  // of 255, between the darkest and the brightest part
  const vision::Picture parts = vision::shrunk(picture, kParts);
  int darkest = 255, brightest = 0;
  for (int y = 0; y < parts.height; ++y) {
    for (int x = 0; x < parts.width; ++x) {
      const int green = parts.at(x, y)[1];
      darkest = std::min(darkest, green);
      brightest = std::max(brightest, green);
    }
  }
  return brightest - darkest < kApart;
}

/// A whole picture that was written after `from`; nothing where there is none yet.
std::optional<vision::Picture> newer_than(const std::string& path,
                                          std::filesystem::file_time_type from) {
  std::error_code error;
  const auto written = std::filesystem::last_write_time(path, error);
  if (error || written <= from) return std::nullopt;
  auto picture = read_picture(path, kBytesMax);
  return picture ? std::optional(std::move(*picture)) : std::nullopt;
}

}  // namespace

CubeEyes::Source written_pictures(std::string path) {
  auto last = std::make_shared<vision::Picture>();
  return
      [path = std::move(path), last](const std::stop_token& ending) -> Expected<vision::Picture> {
        const auto begun = std::filesystem::file_time_type::clock::now();
        const io::Clock clock;
        while (!ending.stop_requested()) {
          auto picture = newer_than(path, begun + kPictureDelay);
          if (picture) {
            if (is_blind(*picture)) return std::unexpected(Error{ErrorCode::kCameraBlind});
            if (picture->rgb == last->rgb) return std::unexpected(Error{ErrorCode::kCameraFrozen});
            *last = *picture;
            return std::move(*picture);
          }
          if (clock.now() - Instant{} > kPicturePatience) break;
          clock.pause(kBetween);
        }
        return std::unexpected(Error{ErrorCode::kCameraLost, -1, to_seconds(kPicturePatience)});
      };
}

}  // namespace sinew::runtime
