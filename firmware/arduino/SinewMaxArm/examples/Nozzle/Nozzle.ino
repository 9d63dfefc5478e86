// Turns the nozzle servo to 90, 45 and 135 degrees.
//
// Wiring: Arduino pin 6 to IO32 of the arm, pin 7 to IO33, GND to GND. See README.md for levels.

#include <SinewMaxArm.h>
#include <SoftwareSerial.h>

SoftwareSerial port(7, 6);  // RX, TX
SinewMaxArm arm(port);

void turn(float angle_deg) {
  const MaxArmResult result = arm.set_pwmservo(angle_deg, 1000);
  Serial.print(angle_deg);
  Serial.print(" deg: ");
  Serial.println(result);
  delay(1500);
}

void setup() {
  Serial.begin(115200);
  port.begin(9600);
  turn(90);
  turn(45);
  turn(135);
  turn(-5);  // refused
}

void loop() {}
