// Picks an object with the suction and places it elsewhere. Ends where a step fails.
//
// Wiring: Arduino pin 6 to IO32 of the arm, pin 7 to IO33, GND to GND. See README.md for levels.

#include <SinewMaxArm.h>
#include <SoftwareSerial.h>

SoftwareSerial port(7, 6);  // RX, TX
SinewMaxArm arm(port);

struct Point {
  float x, y, z;  // mm
};
const Point kPick = {100, -160, 60};
const Point kPlace = {-100, -160, 60};
const float kLift = 60;  // mm above both

// Moves, waits, and reads back.
bool go(float x, float y, float z, uint16_t time_ms) {
  MaxArmResult result = arm.move_to(x, y, z, time_ms);
  if (result) {
    delay(time_ms + 300);
    result = arm.at_target();
  }
  if (!result) Serial.println(result);
  return bool(result);
}

bool pick_and_place() {
  if (!go(kPick.x, kPick.y, kPick.z + kLift, 1000)) return false;
  if (!go(kPick.x, kPick.y, kPick.z, 800)) return false;
  if (!arm.set_SuctionNozzle(kSuctionOn)) return false;
  delay(600);
  Serial.println("picked");
  if (!go(kPick.x, kPick.y, kPick.z + kLift, 800)) return false;
  if (!go(kPlace.x, kPlace.y, kPlace.z + kLift, 1500)) return false;
  if (!go(kPlace.x, kPlace.y, kPlace.z, 800)) return false;
  if (!arm.set_SuctionNozzle(kSuctionRelease)) return false;
  delay(300);
  Serial.println("placed");
  if (!arm.set_SuctionNozzle(kSuctionOff)) return false;
  return go(kPlace.x, kPlace.y, kPlace.z + kLift, 800);
}

void setup() {
  Serial.begin(115200);
  port.begin(9600);
  Serial.println(pick_and_place() ? "done" : "failed");
}

void loop() {}
