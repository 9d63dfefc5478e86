#include "sinew/runtime/cameras/written_pictures.h"

#include <chrono>
#include <filesystem>
#include <optional>
#include <utility>

#include "sinew/core/error_code.h"
#include "sinew/io/clock.h"
#include "sinew/runtime/cameras/read_picture.h"

namespace sinew::runtime {
namespace {

constexpr Duration kBetween = std::chrono::milliseconds(20);  // looks at the file
constexpr std::size_t kBytesMax = std::size_t{64} << 20U;

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

CameraSource written_pictures(std::string path) {
  return [path = std::move(path)](const std::stop_token& ending) -> Expected<vision::Picture> {
    const auto begun = std::filesystem::file_time_type::clock::now();
    const io::Clock clock;
    while (!ending.stop_requested()) {
      if (auto picture = newer_than(path, begun + kPictureDelay)) return std::move(*picture);
      if (clock.now() - Instant{} > kPicturePatience) break;
      clock.pause(kBetween);
    }
    return std::unexpected(Error{ErrorCode::kCameraLost, -1, to_seconds(kPicturePatience)});
  };
}

}  // namespace sinew::runtime
