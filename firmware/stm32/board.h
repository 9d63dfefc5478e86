#pragma once

/// Where what stands on the board: a "Black Pill" (F401) or "Blue Pill" (F103), which have these
/// pins in common. docs/firmware has the wiring table.
namespace sinew::stm32::board {

struct Place {
  char port;
  unsigned pin;
};

inline constexpr Place kStep{'A', 8};  ///< TIM1 channel 1
inline constexpr Place kDirection{'B', 12};
inline constexpr Place kEnable{'B', 13};      ///< low: current in the windings
inline constexpr Place kEndStop{'B', 14};     ///< low: closed
inline constexpr Place kStopLine{'B', 15};    ///< low: no pulse
inline constexpr Place kDriverFault{'B', 0};  ///< low: the power stage shut itself down
inline constexpr Place kEncoderA{'A', 0};     ///< quadrature of the joint: TIM2
inline constexpr Place kEncoderB{'A', 1};
inline constexpr Place kSelect{'A', 4};  ///< NSS
inline constexpr Place kClock{'A', 5};
inline constexpr Place kMiso{'A', 6};
inline constexpr Place kMosi{'A', 7};
inline constexpr Place kMotorClock{'B', 6};  ///< I2C1: the sensor on the motor's shaft
inline constexpr Place kMotorData{'B', 7};
inline constexpr Place kJointClock{'B',
                                   10};   ///< I2C2: one on the joint's; its data pin is the chip's
inline constexpr Place kLineOut{'A', 2};  ///< USART2: the node of a sensor on the joint's
inline constexpr Place kLineIn{'A', 3};
inline constexpr Place kLineDriver{'B', 1};  ///< high: the transceiver drives the line
inline constexpr Place kLed{'C', 13};        ///< low: on

}  // namespace sinew::stm32::board
