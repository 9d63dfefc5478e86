/** A page about each kind of robot. robots_de.ts has the same pages with the same rows. */

export interface RobotHelp {
  /** What is plugged where. */
  wiring: [string, string][];
  before: string[];
  works: string[];
  /** What nobody has seen on a real machine, and what is assumed under the simulated one. */
  simulated: string[];
  position: string;
  stops: string;
}

export const robotsEn: Record<string, RobotHelp> = {
  learm: {
    wiring: [
      ['Serial line', '9600 baud, 8N1, no checksum'],
      ['Board lsc6, bus', 'TX, RX and GND pins through a USB-to-TTL adapter of 3.3 or 5 V; it appears as /dev/ttyUSB0'],
      ['Its USB socket', 'On the classic board no serial port (HID): it cannot be used'],
      ['Board esp32', 'Its USB socket is a serial port; a button on the board chooses between it and Bluetooth'],
      ['Servos', 'Number 6 base, 5 shoulder, 4 elbow, 3 wrist, 2 roll, 1 jaws'],
    ],
    before: [
      'Put the arm near its middle before switching it on: the first move of PWM servos begins with a jump there, whatever time it was given. No controller can prevent that.',
      'Name the board that you have as the profile: lsc6, bus or esp32. They look alike and are not.',
      'Which way the jaws close differs by kit; commissioning asks for it, and for each servo’s direction and trim.',
    ],
    works: [
      'Joint moves, straight lines, circles and splines of the tool, jog in joints, base and tool, jaws',
      'Pose by position, pitch and roll: five joints cannot have every orientation, and the nearest one is named',
      'On bus boards the positions are read back; waiting until it rests, and conditions on the jaws',
    ],
    simulated: [
      'All three boards, with servos, weight, supply and bad cables; servo data of catalogues',
      'The lengths are the author’s measurements; the forearm may be some 9 mm shorter',
    ],
    position: 'Not known until the first slow move is over. Then as commanded; measured on bus boards.',
    stops: 'It is told to stand 72 ms after the stop at most; the simulated servos did within 225 ms. In the very first move of an lsc6 a stop does not help: it goes on slowly, for up to 65 s.',
  },
  bigrobotarm: {
    wiring: [
      ['Serial line', '250000 baud, 8N1, USB of the ATmega2560 board (MKS Gen L, TMC2208 drivers)'],
      ['Wire', 'Bytes, or text of 2021 and 2026; it finds out by itself (wire “probe”)'],
      ['Opening the port', 'May reset the board, which forgets its positions'],
      ['Axes', 'Base, shoulder, elbow, wrist rotate, wrist; a servo gripper'],
      ['End stops, encoders', 'None: zero is where it stood at power-up'],
    ],
    before: [
      'Stand it straight up before it is switched on: from there it counts.',
      'Clear its whole reach. It finishes a move that it has begun.',
      'The motors hold at all times and are never let go.',
    ],
    works: [
      'Whole moves from place to place; lines of the tool as many short moves from stop to stop',
      'The gripper, and its own sequences (G0, BEGIN .. END), from the command line',
      'Random rides; programs with loops, waits and points',
    ],
    simulated: [
      'The firmware with every known defect, motors that slip, an arm that falls',
      'Speeds and accelerations are assumptions',
      'On the byte wire a few positions cannot be sent: base 46.1 to 49.6 degrees is refused',
    ],
    position: 'As commanded. After a reset uncertain, until somebody says where it stands.',
    stops: 'Nothing: it finishes its move. What would come behind it is not sent.',
  },
  maxarm: {
    wiring: [
      ['Serial line', '9600 baud, 8N1, no flow control, port raw'],
      ['Board', 'The micro-USB socket, or its pins IO32 (receives) and IO33 (sends)'],
      ['Firmware', 'The one that it is sold with does not speak this wire. The maker’s slave program (Arduino or MicroPython) has to be installed first'],
      ['Tools', 'Suction pump and vent, nozzle servo'],
    ],
    before: [
      'Where nothing answers, look at the firmware first.',
      'After a reset the MicroPython board sleeps 10 s and then homes by itself: keep away.',
      'Two sums of answers exist; it finds out which one the board uses.',
    ],
    works: [
      'Whole moves by angles, lines of the tool as short moves; suction on, release, off; the nozzle',
      'The tool stays level; its orientation is not asked for',
      'Targets are checked here: the board’s own inverse kinematics, which swings to its ends, is never used',
    ],
    simulated: ['Both firmwares and both sums, bus servos, a rod linkage, loads', 'Joint speeds are assumptions'],
    position: 'Measured, to 0.24 degrees a pulse.',
    stops: 'There is no stop command. It is read and told to stand where it is, which takes about a second.',
  },
  hexapod: {
    wiring: [
      ['Supply', '12 V for six stepper modules, one I2C bus behind the controller'],
      ['Serial line', 'RS-232 to the controller, 9600 baud 8N1 assumed, port raw'],
      ['Cables', 'Legs 1 to 6 in their order; motor by motor, as commissioning asks'],
      ['Sensors', 'None. What was sent and acknowledged is all that anybody knows'],
    ],
    before: [
      'Switch supply and controller on in the order of its document, then say where the platform stands.',
      'Commission it: which way each leg goes, and whether a step down is one unit or two.',
      'If not all motors turn, the supply is too weak.',
    ],
    works: [
      'Poses, lines, circles and splines of the platform, each leg less than one step from its way',
      'Jog of legs, of the platform, in base and tool; pause, resume and pace',
      'Poses that no platform can have are refused with the leg and how far',
    ],
    simulated: [
      'Controller and stepper modules in both readings of a document that contradicts itself',
      'It is slow: 240 microsteps a second, all legs together; 150 mm of one leg take 47.6 min at best',
    ],
    position: 'What you say at the start, then counted. A lost answer widens it by one microstep.',
    stops: 'Between two microsteps: 4.2 ms, and the controller’s own time.',
  },
  'robot-arm-2': {
    wiring: [
      ['Supply', '24 V'],
      ['Bus', 'SPI mode 0; an STM32 board for each of six axes, each with its own chip select'],
      ['Its own boards', 'Registers at 500 kHz, handshake and CRC-32. The READY line is never waited for'],
      ['Sinew’s boards', 'The axis link: 16 bytes a cycle, CRC-32C, 500 kHz to 4 MHz. There are none yet'],
      ['Encoders', 'AS5600 on the motors and on joints 4 to 6 over RS-485, quadrature on joints 1 to 3'],
    ],
    before: [
      'It does not know where it stands until it was homed: 17 minutes at most, axis after axis. Stay with it.',
      'The first firmware as it was committed answers nothing: it waits for its chip select on another pin.',
      'A board without a status counts as done when its time is over.',
    ],
    works: [
      'Registers: whole moves, one axis starting 82 ms behind the other; each board has one pace of its own',
      'Axis link: lines, circles, splines, blends, jog, pause and pace',
      'Homing with a bound on its time, and the way home from the end stops',
    ],
    simulated: [
      'Boards, motors, play and give of the gears, end stops, encoders, supply and heat',
      'All masses are assumed; the lengths are estimated from a picture (10 %, flange 40 %)',
      'SPI and GPIO code has never met a real bus',
    ],
    position: 'Not known until homed. Then as commanded by registers, measured by the axis link.',
    stops: 'Registers: an emergency stop to all boards, 112 ms at the slowest. Axis link: in the next cycle, then inside its limits; boards brake by themselves 100 ms after the last good frame.',
  },
  puma560: {
    wiring: [['Wire', 'The ideal device: lines of text, simulated here; a sketch that speaks them would be driven over its serial port']],
    before: [],
    works: ['Everything: lines, circles, splines, blends, jog, programs and records'],
    simulated: ['A device that does exactly what it is told within the limits of the file: no weight, no friction, no noise'],
    position: 'Measured, to a microradian, from the first answer on.',
    stops: 'One line until the device knows, then as hard as its joints may brake, on the path. It brakes by itself 100 ms after the last line in a motion.',
  },
};
