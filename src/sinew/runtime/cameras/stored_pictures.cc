#include "sinew/runtime/cameras/stored_pictures.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "sinew/core/error_code.h"
#include "sinew/io/file.h"
#include "sinew/runtime/cameras/read_picture.h"
#include "sinew/vision/avi_frames.h"
#include "sinew/vision/camera_jpeg.h"
#include "sinew/vision/y4m_frames.h"

namespace sinew::runtime {
namespace {

Expected<vision::Picture> no_more_pictures() {
  return std::unexpected(Error{ErrorCode::kCameraLost});
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// The number at the beginning without its leading zeros; takes it off.
std::string_view take_number(std::string_view& text) {
  const auto end = std::ranges::find_if_not(text, is_digit);
  std::string_view number(text.begin(), end);
  text.remove_prefix(number.size());
  number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
  return number;
}

/// A file's bytes for what reads them piece by piece; behind an error the file ends.
vision::ReadAt reader_of(const std::string& path) {
  return [path](std::uint64_t offset, std::size_t size) {
    const auto part = io::read_part(path, offset, size);
    return part ? std::vector<std::uint8_t>(part->begin(), part->end())
                : std::vector<std::uint8_t>();
  };
}

/// Why it cannot be read; empty where it can.
std::string file_fault(const std::string& path) {
  const auto beginning = io::read_part(path, 0, 1);
  return beginning ? std::string() : beginning.error().sentence;
}

}  // namespace

bool comes_before(std::string_view a, std::string_view b) {
  const std::pair whole(a, b);
  while (!a.empty() && !b.empty()) {
    if (is_digit(a.front()) && is_digit(b.front())) {
      const std::string_view first = take_number(a);
      const std::string_view second = take_number(b);
      if (first.size() != second.size()) return first.size() < second.size();
      if (first != second) return first < second;
      continue;
    }
    if (a.front() != b.front()) return a.front() < b.front();
    a.remove_prefix(1);
    b.remove_prefix(1);
  }
  if (a.empty() != b.empty()) return a.empty();
  return whole.first < whole.second;  // 01 and 1
}

bool is_image_name(std::string_view name) {
  std::string lower(name);
  std::ranges::transform(lower, lower.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::array<std::string_view, 3> kEndings{".jpg", ".jpeg", ".png"};
  return std::ranges::any_of(kEndings,
                             [&](std::string_view ending) { return lower.ends_with(ending); });
}

std::expected<CameraSource, std::string> folder_pictures(const std::string& folder) {
  std::error_code error;
  std::filesystem::directory_iterator entry(folder, error);
  std::vector<std::string> names;
  while (!error && entry != std::filesystem::directory_iterator()) {
    std::string name = entry->path().filename();
    if (is_image_name(name)) names.push_back(std::move(name));
    entry.increment(error);
  }
  if (error) return std::unexpected(io::system_error(folder, error.value()).sentence);
  if (names.empty()) return std::unexpected(folder + ": has no JPEG or PNG files in it");
  std::ranges::sort(names, comes_before);
  return [folder, names = std::move(names),
          next = std::size_t{0}](const std::stop_token& ending) mutable {
    while (next < names.size() && !ending.stop_requested()) {
      auto picture = read_picture(folder + "/" + names[next++]);
      if (picture) return Expected<vision::Picture>(std::move(*picture));
    }
    return no_more_pictures();
  };
}

std::expected<CameraSource, std::string> avi_pictures(const std::string& path) {
  if (std::string fault = file_fault(path); !fault.empty()) return std::unexpected(fault);
  auto opened = vision::AviFrames::open(reader_of(path));
  if (!opened) return std::unexpected(path + ": " + opened.error());
  return [frames = std::move(*opened)](const std::stop_token& ending) mutable {
    while (!ending.stop_requested()) {
      const auto frame = frames.next();
      if (!frame) break;
      auto picture = vision::decode_camera_jpeg(*frame);
      if (picture) return Expected<vision::Picture>(std::move(*picture));
    }
    return no_more_pictures();
  };
}

std::expected<CameraSource, std::string> y4m_pictures(const std::string& path) {
  if (std::string fault = file_fault(path); !fault.empty()) return std::unexpected(fault);
  auto opened = vision::Y4mFrames::open(reader_of(path));
  if (!opened) return std::unexpected(path + ": " + opened.error());
  return [frames = std::move(*opened)](const std::stop_token&) mutable {
    auto picture = frames.next();
    return picture ? Expected<vision::Picture>(std::move(*picture)) : no_more_pictures();
  };
}

}  // namespace sinew::runtime
