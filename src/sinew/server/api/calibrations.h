#pragma once

#include <cstdint>
#include <expected>
#include <map>
#include <string>

#include "sinew/runtime/camera_calibration.h"
#include "sinew/server/json/json_rpc.h"

namespace sinew::server {

/// The calibrations of a cell's cameras that are under way, one a camera, which all clients share:
/// they outlive a client that goes. Waits for cameras; for one thread.
class Calibrations {
 public:
  using Result = std::expected<Json, RpcError>;

  /// @param cell  outlives this
  explicit Calibrations(runtime::RunningCell& cell) : cell_(cell) {}

  // All of a camera that is open. @param session  that the client means; 0: whichever it is
  Result status(std::size_t camera) const;
  Result begin(std::size_t camera, const std::string& paper, bool anew);
  Result expect(std::size_t camera, std::uint64_t session, const std::string& step);
  Result take(std::size_t camera, std::uint64_t session);
  Result touch(std::size_t camera, std::uint64_t session, std::size_t robot,
               const std::string& mark, double pin);
  Result drop(std::size_t camera, std::uint64_t session, std::uint64_t view);
  Result lift(std::size_t camera, std::uint64_t session, const std::string& mark);
  Result save(std::size_t camera, std::uint64_t session, bool sheet_stays);
  Result end(std::size_t camera, std::uint64_t session);

 private:
  struct One {
    std::uint64_t session = 0;
    runtime::CameraCalibration calibration;
  };
  std::expected<One*, RpcError> found(std::size_t camera, std::uint64_t session);

  runtime::RunningCell& cell_;
  std::map<std::size_t, One> under_way_;  ///< by camera
  std::uint64_t last_ = 0;
};

}  // namespace sinew::server
