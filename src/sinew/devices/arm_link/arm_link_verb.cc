#include <array>

#include "sinew/cli/cells/device_verb.h"
#include "sinew/devices/arm_link/arm_link_settings.h"

/// What a person may ask of the BigRobotArm's board with our firmware.
namespace sinew::cli {
namespace {

constexpr std::array<DeviceAction, 1> kArmLinkAll{
    {{.name = "firmware", .note = "which image runs on the board", .alone = tell_firmware}}};

}  // namespace

extern const DeviceActions kArmLinkActions;
constexpr DeviceActions kArmLinkActions{
    .whose = "a BigRobotArm with Sinew's firmware",
    .are_of = [](const Device& device) { return device.settings.is<ArmLinkDevice>(); },
    .all = kArmLinkAll};

}  // namespace sinew::cli
