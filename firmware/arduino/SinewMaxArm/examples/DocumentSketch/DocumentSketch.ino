// The calls of the maker's example, with its class name: such a sketch needs no change but that
// the maker's MaxArm_ctl.h and .cpp are taken out of its folder.
//
// Wiring: Arduino pin 6 to IO32 of the arm, pin 7 to IO33, GND to GND. See README.md for levels.

#include <MaxArm_ctl.h>

MaxArm_ctl arm;

uint8_t angles[3] = {120, 100, 120};
int16_t points[2][3] = {{120, -180, 85}, {-120, -180, 85}};

void show(const char* name, const int* numbers) {
  Serial.print(name);
  for (int i = 0; i < 3; ++i) {
    Serial.print(' ');
    Serial.print(numbers[i]);
  }
  Serial.println();
}

void setup() {
  Serial.begin(115200);
  arm.serial_begin();
}

void loop() {
  arm.set_angles(angles, 1000);
  delay(1500);
  arm.set_xyz(points[0], 1000);
  delay(1500);
  arm.set_xyz(points[1], 1000);
  delay(1500);

  arm.set_pwmservo(90, 1000);
  delay(1500);
  arm.set_pwmservo(45, 1000);
  delay(1500);
  arm.set_pwmservo(135, 1000);
  delay(1500);

  arm.set_SuctioNnozzle(1);
  delay(1500);
  arm.set_SuctioNnozzle(2);
  delay(200);
  arm.set_SuctioNnozzle(3);
  delay(1500);

  int read[3] = {0, 0, 0};
  if (arm.read_angles(read)) show("angles", read);
  if (arm.read_xyz(read)) show("xyz", read);
  delay(100);
}
