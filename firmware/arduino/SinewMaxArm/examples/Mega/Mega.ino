// For boards with a second hardware port, as the Mega 2560: Serial1 has pins 18 (TX) and 19 (RX).
//
// Wiring: pin 18 to IO32 of the arm, pin 19 to IO33, GND to GND. See README.md for levels.

#include <SinewMaxArm.h>

SinewMaxArm arm(Serial1);

void setup() {
  Serial.begin(115200);
  Serial1.begin(9600);

  Serial.println(arm.move_to(0, -200, 120, 1000));
  delay(1500);
  Serial.println(arm.at_target());

  int16_t xyz[3];
  const MaxArmResult result = arm.read_xyz(xyz);
  if (!result) {
    Serial.println(result);
    return;
  }
  Serial.print("xyz mm");
  for (uint8_t i = 0; i < 3; ++i) {
    Serial.print(' ');
    Serial.print(xyz[i]);
  }
  Serial.println();
}

void loop() {}
