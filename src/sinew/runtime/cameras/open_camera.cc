#include "sinew/runtime/cameras/open_camera.h"

#include <cerrno>
#include <filesystem>

#include "sinew/io/file.h"
#include "sinew/runtime/cameras/http_pictures.h"
#include "sinew/runtime/cameras/stored_pictures.h"
#include "sinew/runtime/cameras/v4l2_pictures.h"
#include "sinew/runtime/cameras/written_pictures.h"

namespace sinew::runtime {
namespace {

bool is_avi(const std::string& device) {
  return device.ends_with(".avi") || device.ends_with(".AVI");
}
bool is_y4m(const std::string& device) {
  return device.ends_with(".y4m");
}

}  // namespace

bool is_stored(const std::string& device) {
  std::error_code error;
  return std::filesystem::is_directory(device, error) || is_avi(device) || is_y4m(device);
}

std::expected<CameraSource, std::string> open_camera(const std::string& device,
                                                     const CameraWanted& wanted) {
  if (device.starts_with("http://") || device.starts_with("https://")) {
    return http_pictures(device);
  }
  std::error_code error;
  const auto status = std::filesystem::status(device, error);
  const bool is_folder = status.type() == std::filesystem::file_type::directory;
  const bool is_device = status.type() == std::filesystem::file_type::character;
  const bool is_missing = status.type() == std::filesystem::file_type::not_found;
  if (is_device || (is_missing && device.starts_with("/dev/"))) {
    return v4l2_pictures(device, wanted);
  }
  if (is_folder) return folder_pictures(device);
  if (is_avi(device)) return avi_pictures(device);
  if (is_y4m(device)) return y4m_pictures(device);
  if (is_image_name(device)) return written_pictures(device);
  if (is_missing) {
    return std::unexpected(io::system_error(device, ENOENT).sentence +
                           "; compare its name, or create the folder");
  }
  return std::unexpected(
      device +
      ": no camera. Give /dev/videoN, http://HOST:PORT/PATH, a folder of JPEG and PNG files, a "
      ".avi or .y4m video, or a .jpg or .png that another program keeps writing");
}

}  // namespace sinew::runtime
