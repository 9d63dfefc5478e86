// Moves, checks that the arm arrived, and prints its position twice a second.
//
// Wiring: Arduino pin 6 to IO32 of the arm, pin 7 to IO33, GND to GND. See README.md for levels.

#include <SinewMaxArm.h>
#include <SoftwareSerial.h>

SoftwareSerial port(7, 6);  // RX, TX
SinewMaxArm arm(port);

template <class Number>
void print_three(const char* name, const Number* numbers) {
  Serial.print(name);
  for (uint8_t i = 0; i < 3; ++i) {
    Serial.print(' ');
    Serial.print(numbers[i]);
  }
  Serial.println();
}

void setup() {
  Serial.begin(115200);
  port.begin(9600);

  const int16_t point[3] = {0, -200, 120};
  Serial.println(arm.set_xyz(point, 1000));
  delay(1500);
  Serial.println(arm.at_target());
}

void loop() {
  int16_t xyz[3];
  const MaxArmResult result = arm.read_xyz(xyz);
  if (result) {
    print_three("xyz mm", xyz);
  } else {
    Serial.println(result);
  }

  float angles[3];
  if (arm.read_angles(angles)) print_three("servos deg", angles);

  switch (arm.checksum()) {
    case ReplyChecksum::kSpec:
      Serial.println("checksum spec");
      break;
    case ReplyChecksum::kWithHeader:
      Serial.println("checksum with header");
      break;
    case ReplyChecksum::kUnknown:
      Serial.println("checksum unknown");
      break;
  }
  if (arm.checksum_changes() > 0) Serial.println("the checksum changed: another arm, or noise");
  delay(500);
}
