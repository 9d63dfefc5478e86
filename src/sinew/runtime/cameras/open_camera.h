#pragma once

#include <expected>
#include <string>

#include "sinew/io/video_modes.h"
#include "sinew/runtime/cameras/camera_source.h"

namespace sinew::runtime {

/// Size of the calibration, px, and pictures per second; 0 where it does not matter. Cameras at
/// this computer are set to it; others give what they give.
using CameraWanted = io::VideoWanted;

/// The pictures of a camera, by the text of its device:
///
///   /dev/video0, /dev/v4l/by-id/...  a camera at this computer (Video4Linux2)
///   http://HOST:PORT/PATH            an MJPEG stream or a JPEG in the network, as phones give it
///   FOLDER                           stored JPEG and PNG files, one for each call
///   FILE.avi, FILE.y4m               stored video, one frame for each call
///   FILE.jpg, FILE.jpeg, FILE.png    an image that another program keeps writing
///
/// A camera is opened at once, so that what is wrong with it is known before anything else begins.
/// An image file need not be there yet.
/// @error  a sentence that names the device, what is wrong with it and what to do
std::expected<CameraSource, std::string> open_camera(const std::string& device,
                                                     const CameraWanted& wanted);

/// Whether its pictures were taken before: a folder, or a stored video. Each look uses one up.
bool is_stored(const std::string& device);

}  // namespace sinew::runtime
