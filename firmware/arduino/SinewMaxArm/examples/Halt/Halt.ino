// Swings the arm to and fro. A button on pin 2 (to GND), or any key in the serial monitor, halts
// it.
//
// Wiring: Arduino pin 6 to IO32 of the arm, pin 7 to IO33, GND to GND. See README.md for levels.

#include <SinewMaxArm.h>
#include <SoftwareSerial.h>

SoftwareSerial port(7, 6);  // RX, TX
SinewMaxArm arm(port);

const uint8_t kButton = 2;
const uint16_t kSwingMs = 4000;
uint32_t swing_start = 0;
bool to_right = false;
bool halted = false;

bool halt_wanted() {
  return digitalRead(kButton) == LOW || Serial.read() >= 0;
}

void setup() {
  Serial.begin(115200);
  port.begin(9600);
  pinMode(kButton, INPUT_PULLUP);
  swing_start = millis() - kSwingMs;
}

void loop() {
  if (halted) return;
  if (halt_wanted()) {
    const MaxArmResult result = arm.halt();
    Serial.print("halt: ");
    Serial.println(result);
    halted = bool(result);  // tried again where the arm did not reply
    return;
  }
  if (millis() - swing_start < kSwingMs) return;
  swing_start = millis();
  to_right = !to_right;
  Serial.println(arm.move_to(to_right ? 150 : -150, -150, 120, kSwingMs));
}
