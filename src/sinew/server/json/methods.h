#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>
#include <string_view>

#include "sinew/server/json/json_rpc.h"

/// What may be asked of a running cell: one table, from which requests are checked, and against
/// which docs/api.md is held by a test.
namespace sinew::server {

inline constexpr std::size_t kNumbersMax = 16;
inline constexpr std::size_t kTextsMax = 63;

enum class ParamType : std::uint8_t {
  kRobot,    ///< a robot's name in the cell
  kText,     ///< a string
  kNumber,   ///< finite
  kWhole,    ///< an integer, not negative
  kFlag,     ///< true or false
  kNumbers,  ///< a list of finite numbers, 16 at most
  kTexts,    ///< an object of strings, 63 at most
  kNames,    ///< a list of strings, 63 at most
};

struct Param {
  std::string_view name;
  ParamType type = ParamType::kText;
  bool required = true;
  std::string_view meaning;
};

enum class MethodId : std::uint8_t {
  kRpcDiscover,
  kCellDescribe,
  kCellStatus,
  kRobotStatus,
  kWatch,
  kEventsList,
  kObjectsList,
  kObjectsQuery,
  kObjectsSubscribe,
  kLeaseTake,
  kLeaseRenew,
  kLeaseRelease,
  kRobotEnable,
  kRobotDisable,
  kRobotAcknowledge,
  kRobotSelfTest,
  kRobotFreeDrive,
  kRobotStop,
  kRobotHold,
  kRobotResume,
  kRobotFeed,
  kRobotJog,
  kRobotNudge,
  kRobotDeclare,
  kProgramRun,
  kRobotRide,
  kProgramStep,
  kJobStatus,
  kProcedureStart,
  kProcedureAnswer,
  kProcedureBack,
  kProcedureCancel,
  kProcedureStatus,
  kSimulationTruth,
  kSimulationCamera,
  kRobotModel,
  kRobotPreview,
  kDeviceStatus,
  kWireRead,
  kCameraLook,
  kRobotCubes,
  kRobotCubeReach,
  kBasketMove,
  kCameraPrint,
  kCalibrationStatus,
  kCalibrationBegin,
  kCalibrationExpect,
  kCalibrationTake,
  kCalibrationTouch,
  kCalibrationDrop,
  kCalibrationSave,
  kCalibrationEnd,
  kProgramCheck,
  kProgramFormat,
  kProgramImport,
  kProgramExport,
  kProgramsList,
  kProgramsLoad,
  kProgramsSave,
  kProgramsRemove,
  kPointsList,
  kPointsSave,
  kPointsRemove,
  kPointsRename,
  kRecordStart,
  kRecordStop,
  kRecordsList,
  kRecordsRead,
  kRecordsCsv,
  kRecordsRemove,
  kSettingsGet,
  kSettingsCheck,
  kSettingsSet,
};

/// About what is kept, the last ones of the table: no robot moves, or stops, by them.
inline bool is_about_kept(MethodId id) {
  return id >= MethodId::kProgramCheck && id <= MethodId::kSettingsSet;
}

/// Of camera.calibration.
inline bool is_calibration(MethodId id) {
  return id >= MethodId::kCalibrationStatus && id <= MethodId::kCalibrationEnd;
}

struct Method {
  MethodId id{};
  std::string_view name;
  bool moves = false;  ///< for operators only: it moves something, or changes what is kept
  std::string_view meaning;
  std::span<const Param> params;
  std::string_view result;            ///< in words
  std::string_view schema = "Empty";  ///< its name in result_schemas()
};

std::span<const Method> methods();

/// The method that a request asks for, with params that fit it: none that it does not know, all
/// that it needs, each of its type.
std::expected<const Method*, RpcError> check(const RpcRequest& request);

std::string_view type_name(ParamType type);

}  // namespace sinew::server
