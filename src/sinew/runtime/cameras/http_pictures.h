#pragma once

#include <expected>
#include <string>

#include "sinew/io/clock.h"
#include "sinew/runtime/cameras/camera_source.h"

namespace sinew::runtime {

/// Pictures of a camera in the network: an MJPEG stream, or a JPEG that is requested again for each
/// picture. Connects once to see that there are some, and anew where a connection was lost or has
/// been left alone for so long that old pictures wait in it. A picture counts where its first byte
/// came kPictureDelay after it was asked for.
/// @param address  as read_http_address reads it
/// @error  a sentence with the address: no address, no server listens there, no pictures there
std::expected<CameraSource, std::string> http_pictures(const std::string& address,
                                                       const io::Clock& clock = io::Clock());

}  // namespace sinew::runtime
