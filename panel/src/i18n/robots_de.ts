/** Eine Seite zu jeder Art Roboter; dieselben Seiten mit denselben Zeilen wie in robots_en.ts. */
import type { RobotHelp } from './robots_en';

export const robotsDe: Record<string, RobotHelp> = {
  learm: {
    wiring: [
      ['Leitung', '9600 Baud, 8N1, ohne Prüfsumme'],
      ['Platine lsc6, bus', 'Stifte TX, RX und GND über einen USB-TTL-Adapter mit 3,3 oder 5 V; er erscheint als /dev/ttyUSB0'],
      ['Ihre USB-Buchse', 'Bei der klassischen Platine keine serielle Schnittstelle (HID): nicht zu gebrauchen'],
      ['Platine esp32', 'Ihre USB-Buchse ist eine serielle Schnittstelle; ein Taster wählt zwischen ihr und Bluetooth'],
      ['Servos', 'Nummer 6 base, 5 shoulder, 4 elbow, 3 wrist, 2 roll, 1 Backen'],
    ],
    before: [
      'Den Arm vor dem Einschalten etwa in die Mitte stellen: die erste Fahrt von PWM-Servos beginnt mit einem Sprung dorthin, gleich wie viel Zeit sie hat. Keine Steuerung kann das verhindern.',
      'Die vorhandene Platine als Profil nennen: lsc6, bus oder esp32. Sie sehen gleich aus und sind es nicht.',
      'Wie herum die Backen schließen, ist je nach Bausatz verschieden; die Inbetriebnahme fragt danach und nach Richtung und Abgleich jedes Servos.',
    ],
    works: [
      'Achsfahrten, Geraden, Kreise und Splines des Werkzeugs, Handfahrt in Achsen, Basis und Werkzeug, Backen',
      'Lage aus Ort, pitch und roll: fünf Achsen können nicht jede Drehung, die nächste wird genannt',
      'Mit bus-Platinen wird die Lage zurückgelesen; Warten auf Ruhe und Bedingungen an den Backen',
    ],
    simulated: [
      'Alle drei Platinen, mit Servos, Gewicht, Versorgung und schlechten Kabeln; Servodaten aus Katalogen',
      'Die Längen sind Messungen des Autors; der Unterarm ist vielleicht 9 mm kürzer',
    ],
    position: 'Unbekannt, bis die erste langsame Fahrt vorbei ist. Dann wie befohlen, mit bus-Platinen gemessen.',
    stops: 'Spätestens 72 ms nach dem Stopp soll er stehen; die simulierten Servos taten es binnen 225 ms. In der allerersten Fahrt einer lsc6 hilft kein Stopp: sie geht langsam weiter, bis zu 65 s.',
  },
  bigrobotarm: {
    wiring: [
      ['Leitung', '250000 Baud, 8N1, USB der ATmega2560-Platine (MKS Gen L, Treiber TMC2208)'],
      ['Protokoll', 'Bytes, oder Text von 2021 und 2026; es wird selbst erkannt (wire „probe“)'],
      ['Öffnen der Schnittstelle', 'Kann die Platine zurücksetzen, die dann ihre Lage vergisst'],
      ['Achsen', 'Basis, Schulter, Ellbogen, Unterarmdrehung, Handgelenk; ein Servogreifer'],
      ['Endschalter, Geber', 'Keine: Null ist, wo er beim Einschalten stand'],
    ],
    before: [
      'Vor dem Einschalten gerade nach oben stellen: von dort zählt er.',
      'Seine ganze Reichweite freiräumen. Eine begonnene Fahrt führt er zu Ende.',
      'Die Motoren halten immer und werden nie losgelassen.',
    ],
    works: [
      'Ganze Fahrten von Ort zu Ort; Geraden des Werkzeugs als viele kurze Fahrten von Halt zu Halt',
      'Der Greifer, und seine eigenen Sequenzen (G0, BEGIN .. END) von der Kommandozeile',
      'Zufallsritte; Programme mit Schleifen, Pausen und Punkten',
    ],
    simulated: [
      'Die Firmware mit jedem bekannten Fehler, rutschende Motoren, ein fallender Arm',
      'Tempo und Beschleunigung sind Annahmen',
      'Über das Byte-Protokoll sind einige Lagen nicht zu senden: Basis 46,1 bis 49,6 Grad wird abgelehnt',
    ],
    position: 'Wie befohlen. Nach einem Zurücksetzen unsicher, bis jemand sagt, wo er steht.',
    stops: 'Nichts: er führt seine Fahrt zu Ende. Was danach käme, wird nicht gesendet.',
  },
  maxarm: {
    wiring: [
      ['Leitung', '9600 Baud, 8N1, ohne Flusssteuerung, Schnittstelle roh'],
      ['Platine', 'Die Micro-USB-Buchse, oder ihre Stifte IO32 (empfängt) und IO33 (sendet)'],
      ['Firmware', 'Die ab Werk spricht dieses Protokoll nicht. Zuerst das Slave-Programm des Herstellers (Arduino oder MicroPython) aufspielen'],
      ['Werkzeuge', 'Saugpumpe und Ventil, Servo der Düse'],
    ],
    before: [
      'Wo nichts antwortet, zuerst nach der Firmware sehen.',
      'Nach einem Zurücksetzen schläft die MicroPython-Platine 10 s und sucht dann von selbst ihre Nulllage: Abstand halten.',
      'Es gibt zwei Arten von Prüfsummen; welche die Platine nutzt, wird selbst erkannt.',
    ],
    works: [
      'Ganze Fahrten nach Winkeln, Geraden als kurze Fahrten; Sauger on, release, off; die Düse',
      'Das Werkzeug bleibt waagrecht; seine Drehung lässt sich nicht verlangen',
      'Ziele werden hier geprüft: die Kinematik der Platine, die ans Ende schwingen kann, wird nie benutzt',
    ],
    simulated: ['Beide Firmwares und beide Summen, Bus-Servos, ein Gestänge, Lasten', 'Die Achsgeschwindigkeiten sind Annahmen'],
    position: 'Gemessen, auf 0,24 Grad je Puls.',
    stops: 'Es gibt keinen Stoppbefehl. Er wird gelesen und soll stehen, wo er ist; das dauert etwa eine Sekunde.',
  },
  hexapod: {
    wiring: [
      ['Versorgung', '12 V für sechs Schrittmodule an einem I2C-Bus hinter dem Steuergerät'],
      ['Leitung', 'RS-232 zum Steuergerät, 9600 Baud 8N1 angenommen, Schnittstelle roh'],
      ['Kabel', 'Beine 1 bis 6 in ihrer Reihenfolge, Motor für Motor, wie die Inbetriebnahme fragt'],
      ['Sensoren', 'Keine. Was gesendet und bestätigt wurde, ist alles, was man weiß'],
    ],
    before: [
      'Versorgung und Steuergerät in der Reihenfolge seines Dokuments einschalten, dann sagen, wo die Plattform steht.',
      'In Betrieb nehmen: wie herum jedes Bein geht, und ob ein Schritt zurück eine oder zwei Einheiten sind.',
      'Drehen nicht alle Motoren, ist die Versorgung zu schwach.',
    ],
    works: [
      'Lagen, Geraden, Kreise und Splines der Plattform, jedes Bein weniger als einen Schritt von seinem Weg',
      'Handfahrt der Beine und der Plattform, in Basis und Werkzeug; Pause, Weiter und Tempo',
      'Lagen, die keine Plattform haben kann, werden mit Bein und Betrag abgelehnt',
    ],
    simulated: [
      'Steuergerät und Schrittmodule in beiden Lesarten eines Dokuments, das sich widerspricht',
      'Er ist langsam: 240 Mikroschritte je Sekunde für alle Beine zusammen; 150 mm eines Beins dauern bestenfalls 47,6 min',
    ],
    position: 'Was zu Beginn gesagt wird, dann gezählt. Eine verlorene Antwort weitet sie um einen Mikroschritt.',
    stops: 'Zwischen zwei Mikroschritten: 4,2 ms und die eigene Zeit des Steuergeräts.',
  },
  'robot-arm-2': {
    wiring: [
      ['Versorgung', '24 V'],
      ['Bus', 'SPI Modus 0; für jede der sechs Achsen eine STM32-Platine mit eigener Auswahlleitung'],
      ['Eigene Platinen', 'Register bei 500 kHz, Handschlag und CRC-32. Auf die READY-Leitung wird nie gewartet'],
      ['Platinen von Sinew', 'Der Axis Link: 16 Bytes je Zyklus, CRC-32C, 500 kHz bis 4 MHz. Es gibt noch keine'],
      ['Geber', 'AS5600 an den Motoren und den Achsen 4 bis 6 über RS-485, Quadraturgeber an den Achsen 1 bis 3'],
    ],
    before: [
      'Bis er seine Nullpunkte gesucht hat, weiß er nicht, wo er steht: höchstens 17 Minuten, Achse für Achse. Dabei bleiben.',
      'Die erste Firmware, wie sie abgelegt wurde, antwortet nicht: sie wartet an einem anderen Stift auf ihre Auswahl.',
      'Eine Platine ohne Status gilt als fertig, wenn ihre Zeit um ist.',
    ],
    works: [
      'Register: ganze Fahrten, jede Achse beginnt 82 ms nach der vorigen; jede Platine hat ihr eigenes Tempo',
      'Axis Link: Geraden, Kreise, Splines, Überschleifen, Handfahrt, Pause und Tempo',
      'Nullpunktsuche mit einer Schranke für die Zeit, und der Weg heim von den Endschaltern',
    ],
    simulated: [
      'Platinen, Motoren, Spiel und Nachgeben der Getriebe, Endschalter, Geber, Versorgung und Wärme',
      'Alle Massen sind angenommen; die Längen aus einem Bild geschätzt (10 %, Flansch 40 %)',
      'Der Code für SPI und GPIO hat nie einen echten Bus gesehen',
    ],
    position: 'Unbekannt bis zur Nullpunktsuche. Dann mit Registern wie befohlen, mit Axis Link gemessen.',
    stops: 'Register: ein Nothalt an alle Platinen, schlimmstenfalls 112 ms. Axis Link: im nächsten Zyklus, dann innerhalb der Grenzen; 100 ms nach dem letzten guten Rahmen bremsen die Platinen selbst.',
  },
  puma560: {
    wiring: [['Leitung', 'Das ideale Gerät: Textzeilen, hier simuliert; ein Sketch, der sie spricht, würde über seine serielle Schnittstelle gefahren']],
    before: [],
    works: ['Alles: Linien, Kreise, Splines, Überschleifen, Tippen, Programme und Aufzeichnungen'],
    simulated: ['Ein Gerät, das innerhalb der Grenzen der Datei genau tut, was ihm gesagt wird: ohne Gewicht, Reibung und Rauschen'],
    position: 'Gemessen, auf ein Mikroradiant, von der ersten Antwort an.',
    stops: 'Eine Zeile, bis das Gerät es weiß, dann bremst es auf der Bahn, so stark die Gelenke dürfen. 100 ms nach der letzten Zeile bremst es in einer Bewegung selbst.',
  },
};
