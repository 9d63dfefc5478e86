#include "sinew/runtime/written_pictures.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "sinew/io/file.h"
#include "sinew/vision/picture_file.h"

namespace sinew::runtime {
namespace {

constexpr Duration kBetween = std::chrono::milliseconds(20);  // looks at the file
constexpr std::size_t kBytesMax = std::size_t{64} << 20U;

/// Whether it is as good as one colour: black, covered, or all white. Noise of a covered lens stays
/// below, any table with something on it far above.
bool is_blind(const vision::Picture& picture) {
  constexpr int kCells = 16;
  constexpr int kApart = 12;  // of 255, between the darkest and the brightest part
  int darkest = 255, brightest = 0;
  for (int v = 0; v < kCells; ++v) {
    for (int u = 0; u < kCells; ++u) {
      long sum = 0, count = 0;
      for (int y = v * picture.height / kCells; y < (v + 1) * picture.height / kCells; y += 2) {
        for (int x = u * picture.width / kCells; x < (u + 1) * picture.width / kCells; x += 2) {
          sum += picture.at(x, y)[1];
          ++count;
        }
      }
      if (count == 0) continue;
      darkest = std::min(darkest, static_cast<int>(sum / count));
      brightest = std::max(brightest, static_cast<int>(sum / count));
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
  const auto text = io::read_file(path, kBytesMax);
  if (!text) return std::nullopt;
  auto picture =
      vision::decode_picture({reinterpret_cast<const std::uint8_t*>(text->data()), text->size()});
  return picture ? std::optional(std::move(*picture)) : std::nullopt;
}

}  // namespace

CubeEyes::Source written_pictures(std::string path) {
  auto last = std::make_shared<vision::Picture>();
  return
      [path = std::move(path), last](const std::stop_token& ending) -> Expected<vision::Picture> {
        const auto begun = std::filesystem::file_time_type::clock::now();
        while (!ending.stop_requested()) {
          auto picture = newer_than(path, begun + kPictureDelay);
          if (picture) {
            if (is_blind(*picture)) return std::unexpected(Error{ErrorCode::kCameraBlind});
            if (picture->rgb == last->rgb) return std::unexpected(Error{ErrorCode::kCameraFrozen});
            *last = *picture;
            return std::move(*picture);
          }
          const auto waited = std::filesystem::file_time_type::clock::now() - begun;
          if (waited > kPicturePatience) break;
          std::this_thread::sleep_for(kBetween);
        }
        return std::unexpected(Error{ErrorCode::kCameraLost, -1,
                                     std::chrono::duration<double>(kPicturePatience).count()});
      };
}

}  // namespace sinew::runtime
