// Moves by servo angles and by points, and shows refusals.
//
// Wiring: Arduino pin 6 to IO32 of the arm, pin 7 to IO33, GND to GND. See README.md for levels.

#include <SinewMaxArm.h>
#include <SoftwareSerial.h>

SoftwareSerial port(7, 6);  // RX, TX
SinewMaxArm arm(port);

void report(const char* name, const MaxArmResult& result) {
  Serial.print(name);
  Serial.print(": ");
  Serial.println(result);
}

void setup() {
  Serial.begin(115200);
  port.begin(9600);

  const int16_t angles[3] = {120, 100, 120};  // degrees of the servos
  report("angles", arm.set_angles(angles, 1000));
  delay(1500);

  const int16_t right[3] = {120, -180, 85};  // mm
  report("right", arm.set_xyz(right, 1000));
  delay(1500);

  report("left", arm.move_to(-120, -180, 85.5, 1000));
  delay(1500);

  // Refused before a byte is sent.
  report("too high", arm.move_to(0, -100, 240, 1000));
  report("too fast", arm.move_to(0, -200, 120, 5));
}

void loop() {}
