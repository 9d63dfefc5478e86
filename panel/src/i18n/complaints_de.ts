/**
 * Was die Steuerung an einem Text auszusetzen hat: an Programmen, an Punkten und an Dateien anderer Programme. Sie
 * selbst sagt es auf Englisch (src/sinew/program, src/sinew/config/points_file.cc); hier steht dasselbe je Satz. Ein
 * Test hält beide aneinander.
 */
import type { ComplaintWords } from './complaints';

/** Wörter und Zahlen einer Zeile. */
const words: Record<string, string> = {
  'too many words; write {example}': 'Zu viele Wörter; richtig ist {example}',
  'something is missing; write {example}': 'Hier fehlt etwas; richtig ist {example}',
  '{word}: a point is X,Y,Z, as in 200mm,0mm,150mm': '{word}: ein Ort ist X,Y,Z, wie 200mm,0mm,150mm',
  '{word} is farther away than 100 m': '{word} ist weiter weg als 100 m',
  'a number is missing': 'Hier fehlt eine Zahl',
  '{word} is not a finite number': '{word} ist keine endliche Zahl',
  '{word} needs a unit: {units}': '{word} braucht eine Einheit: {units}',
  "{word} ends in '{suffix}', which is none of {units}": "{word} endet mit '{suffix}', möglich sind {units}",
  '{word} has a control character in it': '{word} enthält ein Steuerzeichen',
};

/** Zeilen, die nichts bewegen, und Blöcke. */
const steps: Record<string, string> = {
  'unknown step {word}': 'Unbekannter Schritt {word}',
  '{word}: a condition is one number that is measured, above or below one that the row says, as in {example} or z<100mm':
    '{word}: eine Bedingung ist eine gemessene Zahl, größer oder kleiner als eine in der Zeile, wie {example} oder z<100mm',
  '{word} is nothing that is measured': '{word} wird nicht gemessen',
  '{word} is beyond what any machine measures': '{word} ist mehr, als irgendeine Maschine misst',
  'a wait is 0 s to one hour': 'Gewartet wird 0 s bis eine Stunde',
  'write seen, or seen color=red': 'Richtig ist seen oder seen color=red',
  '{word} is no color of a cube; there are {list}': '{word} ist keine Würfelfarbe; es gibt {list}',
  'place stops where it lets go: without blend=': 'place hält an, wo es loslässt: ohne blend=',
  'place stops where it releases: without blend= and time=': 'place hält an, wo es loslässt: ohne blend= und time=',
  "{word}: a basket's place is the cell's; beside it stand speed= and accel=":
    '{word}: wo ein Korb steht, sagt die Zelle; daneben stehen speed= und accel=',
  'this cell has no basket: write the lines [basket], name = "basket", x_mm = 60 and y_mm = 180 into the cell\'s file (cells/README.md) and start sinew serve again, or place NAME with a taught point':
    'Diese Zelle hat keinen Korb: die Zeilen [basket], name = "basket", x_mm = 60 und y_mm = 180 in die Datei der Zelle schreiben (cells/README.md) und sinew serve neu starten, oder place NAME mit einem Punkt',
  '{word}: this cell has several baskets; name one of {list}': '{word}: diese Zelle hat mehrere Körbe; einen davon nennen: {list}',
  '{word} is no basket of this cell and no taught point; its baskets are {list}':
    '{word} ist kein Korb dieser Zelle und kein Punkt; ihre Körbe sind {list}',
  "{word}: this cell has no calibrated camera; name one in the cell's file ([[camera]] with calibration, docs/vision.md)":
    '{word}: diese Zelle hat keine kalibrierte Kamera; eine in der Datei der Zelle nennen ([[camera]] mit calibration, docs/vision.md)',
  '{word} is no calibrated camera of this cell; there are {list}': '{word} ist keine kalibrierte Kamera dieser Zelle; es gibt {list}',
  'a wait does not look; write if seen, or repeat while seen':
    'Ein wait sieht nicht hin; richtig ist if seen oder repeat while seen',
  '{word}: write pick, pick color=red, or pick at=180mm,0mm,25mm': '{word}: richtig ist pick, pick color=red oder pick at=180mm,0mm,25mm',
  'say where: place basket, place NAME (a basket or a taught point), or place x=200mm y=0mm z=30mm':
    'Der Ort fehlt: place basket, place NAME (ein Korb oder ein Punkt) oder place x=200mm y=0mm z=30mm',
  'write repeat while seen, or repeat while seen color=red':
    'Richtig ist repeat while seen oder repeat while seen color=red',
  'write wait settled, or wait settled for 5s': 'Richtig ist wait settled oder wait settled for 5s',
  'say what for and how long at most, as in wait until z<100mm for 5s':
    'Worauf und wie lange höchstens muss dastehen, wie in wait until z<100mm for 5s',
  '{word}: a loop has 1 to 10000 rounds': '{word}: ein loop hat 1 bis 10000 Runden',
  'loops and ifs are nested at most 8 deep': 'loop und if dürfen höchstens 8 tief ineinander stehen',
  'else without if': 'else ohne if',
  'this if has an else already': 'Dieses if hat schon ein else',
  'end without loop or if': 'end ohne loop oder if',
  '{block} without end: write end behind its last step': '{block} ohne end: end gehört hinter seinen letzten Schritt',
  'with what it calls the program has more than 100000 rows': 'Mit allem, was es aufruft, hat das Programm mehr als 100000 Zeilen',
  '{word}: suction is on, release or off': '{word}: suction ist on, release oder off',
  'write how long it takes, as in time=1s': 'Hier muss stehen, wie lange es dauert, wie time=1s',
  'time is above 0 and at most 60 s': 'time ist größer als 0 und höchstens 60 s',
  'the width of what is held is above 0 and at most 500 mm': 'was gehalten wird, ist breiter als 0 und höchstens 500 mm',
  '{word}: a program is called by its name alone, letters, digits, - and _; it lies in the same folder':
    '{word}: ein Programm wird nur mit seinem Namen aufgerufen, Buchstaben, Ziffern, - und _; es liegt im selben Ordner',
  'a program cannot call itself: {chain}': 'Ein Programm kann sich nicht selbst aufrufen: {chain}',
  'calls are nested at most 8 deep': 'Aufrufe gehen höchstens 8 tief',
  'a program calls at most 63 others': 'Ein Programm ruft höchstens 63 andere auf',
  '{word}: nothing can be called from here': '{word}: von hier lässt sich nichts aufrufen',
  'the request does not bring the program {word}': 'Das Programm {word} wurde nicht mitgeschickt',
  'from_line: line {line} has no row that does something': 'In Zeile {line} steht nichts, womit das Programm beginnen könnte',
  'from_line: line {line} is inside the {block} of line {first}: begin there, or behind its end':
    'Zeile {line} steht im {block} von Zeile {first}: dort beginnen oder hinter seinem end',
};

/** Zeilen, die bewegen. */
const motions: Record<string, string> = {
  '{word}: write NAME=VALUE, as in {example}': '{word}: richtig ist NAME=WERT, wie {example}',
  '{word} is no joint of this robot': '{word} ist kein Gelenk dieses Roboters',
  '{word} is nothing that this row takes': 'Mit {word} kann diese Zeile nichts anfangen',
  "'speed' of the tool is named twice": "'speed' des Werkzeugs steht zweimal da",
  "'speed' of the joints is named twice": "'speed' der Gelenke steht zweimal da",
  '{word} is named twice': '{word} steht zweimal da',
  'accel is 0.001 mm/s2 to 100 m/s2': 'accel ist 0.001 mm/s2 bis 100 m/s2',
  "a tool's speed is 0.001 mm/s to 100 m/s": 'Ein Werkzeug hat 0.001 mm/s bis 100 m/s',
  'speed is 1% to 100%': 'speed ist 1% bis 100%',
  'blend is above 0 and at most 60 deg of the joints': 'blend ist größer als 0 und höchstens 60 deg der Gelenke',
  'time is above 0 and at most 24 h': 'time ist größer als 0 und höchstens 24 h',
  'write how long it takes, as in time=2s': 'Hier fehlt, wie lange es dauert, wie time=2s',
  "this robot's home looks for its end stops, as long as it takes":
    'home sucht bei diesem Roboter die Endschalter und dauert, so lange es dauert',
  'time= is of the whole motion, from stop to stop: without speed=, accel=, blend=':
    'time= gilt für die ganze Bewegung von Halt zu Halt: ohne speed=, accel=, blend=',
  'blend is above 0 and at most 1 m of the tool': 'blend ist größer als 0 und höchstens 1 m des Werkzeugs',
  'a joint is missing; write joint {example}': 'Hier fehlt ein Gelenk; richtig ist joint {example}',
  'a joint is missing; write {example}': 'Hier fehlt ein Gelenk; richtig ist {example}',
  "a share of the joint's limit is 1% to 100%": 'Der Anteil am Grenzwert der Achse ist 1% bis 100%',
  "a share of {name}'s limit is 1% to {count}": 'Der Anteil am Grenzwert von {name} ist 1% bis {count}',
  'a joint is missing: options alone move nothing': 'Hier fehlt ein Gelenk: speed, accel und blend allein bewegen nichts',
  '{word} is a place of the tool; write move to={name}, which finds the joints':
    '{word} ist ein Ort des Werkzeugs; move to={name} findet die Gelenke dazu',
  'to= names all joints; beside it a joint takes a difference, as in {example}':
    'to= nennt alle Gelenke; daneben kann von einem nur eine Differenz stehen, wie {example}',
  'rz alone turns this tool; rx, ry and rz together name an orientation':
    'rz allein dreht dieses Werkzeug; rx, ry und rz zusammen nennen eine Ausrichtung',
  'rx, ry and rz belong together: an orientation needs all three': 'rx, ry und rz gehören zusammen: eine Ausrichtung braucht alle drei',
  'an arc needs a point on its way; write via=200mm,0mm,180mm': 'Ein Bogen braucht einen Ort auf seinem Weg, wie via=200mm,0mm,180mm',
  'to= names the place already; beside it write differences, as in dz=50mm':
    'to= nennt den Ort schon; daneben stehen nur Differenzen, wie dz=50mm',
  '{axis} and {difference} are one number: write their sum': '{axis} und {difference} sind eine Zahl: ihre Summe hinschreiben',
  'frame= says along whose axes differences count; it needs one, as in dz=20mm':
    'frame= sagt, an wessen Achsen Differenzen gelten; dazu gehört eine, wie dz=20mm',
  'a target is missing': 'Hier fehlt ein Ziel',
  '{word}: a frame is base or tool': '{word}: frame ist base oder tool',
  '{word} is two turns at most': '{word} ist höchstens zwei Umdrehungen',
  'a spline has 1 to 256 points, as in 200mm,0mm,150mm': 'Ein spline hat 1 bis 256 Orte, wie 200mm,0mm,150mm',
  '{word}: there is no points.toml beside the program': '{word}: neben dem Programm liegt keine points.toml',
  '{word} is a point of {other}, not of {robot}': '{word} ist ein Punkt von {other}, nicht von {robot}',
  '{word} has degrees where {robot} has mm, or mm for degrees':
    '{word} hat Grade, wo {robot} mm hat, oder mm statt Graden',
  '{word} has {count} {joints}, {robot} has {own} {legs}': '{word} hat {count} {joints}, {robot} hat {own} {legs}',
  '{word} is no taught point; there is none of this robot': '{word} ist kein Punkt; dieser Roboter hat noch keinen',
  '{word} is no taught point': '{word} ist kein Punkt',
  '{word} cannot be used: {reason}': '{word} ist nicht zu gebrauchen: {reason}',
  "{word} has a pitch and a roll, which this robot's tool does not take":
    '{word} hat pitch und roll, die das Werkzeug dieses Roboters nicht hat',
  "{word} has an orientation; this robot's tool turns with its base and takes none":
    '{word} hat eine Ausrichtung; das Werkzeug dieses Roboters dreht sich mit seiner Basis und nimmt keine an',
  '{word}: its legs give no place of the platform': '{word}: mit diesen Beinen hat die Plattform keinen Ort',
};

/** points.toml: davor steht der Schlüssel, um den es geht. */
const points: Record<string, string> = {
  'is missing: which robot\'s point is it? as in robot = "learm"': 'fehlt: von welchem Roboter ist der Punkt? wie robot = "learm"',
  'no point has this key': 'diesen Schlüssel hat kein Punkt',
  'must be a string, not {type}': 'muss ein Text sein, nicht {type}',
  'must be 1 to 200 bytes without control characters': 'muss 1 bis 200 Byte ohne Steuerzeichen sein',
  'must be a number, not {type}': 'muss eine Zahl sein, nicht {type}',
  'must be -{limit} to {most}, not {value}': 'muss -{limit} bis {most} sein, nicht {value}',
  'has no place: joints_deg, legs_mm, joints, or x_mm, y_mm and z_mm':
    'hat keinen Ort: joints_deg, legs_mm, joints oder x_mm, y_mm und z_mm',
  '{key} says that': 'das sagt schon {key}',
  'must be texts with their units, as in ["90deg", "-20mm"]': 'müssen Texte mit ihren Einheiten sein, wie ["90deg", "-20mm"]',
  'must be a list of 1 to {count} texts': 'muss eine Liste von 1 bis {count} Texten sein',
  "{key} names the place already: a point is joints or the tool's, not both":
    '{key} nennt den Ort schon: ein Punkt gilt den Gelenken oder dem Werkzeug, nicht beiden',
  'must be a list of 1 to {count} numbers': 'muss eine Liste von 1 bis {count} Zahlen sein',
  'needs {keys} beside it': 'braucht daneben {keys}',
  'x_mm, y_mm and z_mm are missing': 'x_mm, y_mm und z_mm fehlen',
  'rx_deg, ry_deg and rz_deg say the orientation already': 'die Ausrichtung sagen schon rx_deg, ry_deg und rz_deg',
  'must be a table: write each point below its [points.NAME]': 'muss eine Tabelle sein: jeder Punkt steht unter seinem [points.NAME]',
  'must be a table: {header}': 'muss eine Tabelle sein: {header}',
  'a name is a letter and then letters, digits, - and _, 40 at most':
    'ein Name ist ein Buchstabe, dann Buchstaben, Ziffern, - und _, höchstens 40',
  'has more than 10000 points': 'hat mehr als 10000 Punkte',
  'a file of points has nothing but [points.NAME]': 'eine Datei von Punkten hat nichts als [points.NAME]',
  'the point {word} is there, but not as a table {header}; change it by hand':
    'Den Punkt {word} gibt es, aber nicht als Tabelle {header}; von Hand ändern',
  'there is no point {word}': 'Einen Punkt {word} gibt es nicht',
  'there is a point {word} already': 'Einen Punkt {word} gibt es schon',
  'too many complaints; mend these first': 'Zu viele Fehler; zuerst diese beheben',
  'the file is longer than 1 MiB': 'Die Datei ist länger als 1 MiB',
  'the line is longer than 400 bytes': 'Die Zeile ist länger als 400 Byte',
  'only strings and comments may hold characters beyond ASCII': 'Andere Zeichen als ASCII dürfen nur in Texten und Bemerkungen stehen',
};

/** Sequenzen des BigRobotArm, hinein und heraus. */
const sequences: Record<string, string> = {
  'BEGIN without END: write END behind the last command of the block': 'BEGIN ohne END: END gehört hinter den letzten Befehl des Blocks',
  '{word}: {what} is a whole number, as in {example}': '{word}: {what} ist eine ganze Zahl, wie {example}',
  '{word}: {what} must be {lower}..{upper}': '{word}: {what} muss zwischen {lower} und {upper} liegen',
  '{name} takes one to five words, {letters} in this order': 'Zu {name} gehören ein bis fünf Wörter, {letters} in dieser Folge',
  '{word} stands where {letter} is due: the arm reads by place, {letters}':
    '{word} steht, wo {letter} hingehört: der Arm liest nach der Stelle, {letters}',
  '{name} stands alone; remove {word}': '{name} steht allein; {word} löschen',
  'M503 asks for the status, which a program has no use for; remove the line':
    'M503 fragt nach dem Zustand, womit ein Programm nichts anfängt; die Zeile löschen',
  'unknown command {word}': 'Unbekannter Befehl {word}',
  'G1 takes E0 or E1 and a position, as in G1 E1 P90': 'Zu G1 gehören E0 oder E1 und eine Stellung, wie G1 E1 P90',
  'BEGIN inside the block of line {line}: blocks do not nest; write END first':
    'BEGIN im Block von Zeile {line}: Blöcke stehen nicht ineinander; zuerst kommt END',
  'BEGIN takes the number of rounds, as in BEGIN I5': 'Zu BEGIN gehört die Zahl der Runden, wie BEGIN I5',
  'END without BEGIN: remove it, or write BEGIN I1 above': 'END ohne BEGIN: löschen oder darüber BEGIN I1 schreiben',
  'a block holds at most {count} commands: end it above and begin another':
    'Ein Block fasst höchstens {count} Befehle: ihn darüber beenden und einen neuen beginnen',
  'no command of a sequence says this row: it has joint, gripper and loop':
    'Diese Zeile kann kein Befehl einer Sequenz sagen: sie hat joint, gripper und loop',
  'a block of the firmware holds 20 commands': 'Ein Block der Firmware fasst 20 Befehle',
  'G0 has no speed=, accel=, blend= or time=': 'G0 hat kein speed=, accel=, blend= oder time=',
  'a difference goes elsewhere in each round; G0 says places': 'Eine Differenz führt in jeder Runde anderswohin; G0 nennt Orte',
  'in a loop a row names all joints: the others may stand elsewhere in the next round, and a G0 says them all':
    'In einer Schleife nennt eine Zeile alle Gelenke: Die anderen stehen in der nächsten Runde vielleicht anderswo, und ein G0 nennt alle',
  'in a loop gripper says its angle: the next round may begin elsewhere':
    'In einer Schleife nennt gripper seinen Winkel: Die nächste Runde beginnt vielleicht anderswo',
  '{joint} would go beyond what a G0 counts': '{joint} ginge weiter, als ein G0 zählt',
  'a sequence has no other tool than gripper': 'Eine Sequenz hat kein anderes Werkzeug als gripper',
  'G1 says an angle, and no row before this one does': 'G1 nennt einen Winkel, und bis hierher tut das keine Zeile',
  'G1 takes whole degrees of the gripper': 'G1 nimmt ganze Grade des Greifers',
  'blocks of a sequence are not nested': 'Blöcke einer Sequenz stehen nicht ineinander',
  'a block of a sequence has 127 rounds at most': 'Ein Block einer Sequenz hat höchstens 127 Runden',
  "sequences are the BigRobotArm's; {robot} is none": 'Sequenzen sind Sache des BigRobotArm; {robot} ist keiner',
};

/** Lagen einer Plattform. */
const poses: Record<string, string> = {
  '{word}: has more than one decimal mark': '{word} hat mehr als ein Dezimalzeichen',
  '{word}: the decimal mark was {mark} in line {line}; a file has one kind':
    '{word}: das Dezimalzeichen war {mark} in Zeile {line}; eine Datei hat nur eines',
  '{word}: a number is missing': '{word}: hier fehlt eine Zahl',
  '{word} is beyond any platform': '{word} ist mehr, als irgendeine Plattform kann',
  '{file} has {count} rows, this one {own}': '{file} hat {count} Zeilen, diese {own}',
  ".pos files are a platform's; {robot} is none": '.pos-Dateien sind Sache einer Plattform; {robot} ist keine',
  'a .pos file is one pose: it takes a program of one row that moves':
    'Eine .pos-Datei ist eine einzige Lage: dazu gehört ein Programm mit einer einzigen Zeile, die bewegt',
  "it is a platform's file; {robot} is none": 'Diese Datei ist für eine Plattform; {robot} ist keine',
  "these heads are no place of {robot}'s platform: they are up to {off} mm off, {allowed} mm is allowed":
    'So können die Köpfe der Plattform von {robot} nicht liegen: sie liegen bis zu {off} mm daneben, erlaubt sind {allowed} mm',
};

const gcode: Record<string, string> = {
  '{word} stands behind the end of the program (M2, M30)': '{word} steht hinter dem Ende des Programms (M2, M30)',
  'a remark begins with ( and has no )': 'Eine Bemerkung beginnt mit ( und hat kein )',
  '{word}: a word is a letter and a number, as in X12.5': '{word}: ein Wort ist ein Buchstabe und eine Zahl, wie X12.5',
  '{word} is beyond any machine': '{word} ist mehr, als irgendeine Maschine kann',
  'a line has at most 64 words': 'Eine Zeile hat höchstens 64 Wörter',
  '{word} stands twice in one line': '{word} steht zweimal in einer Zeile',
  '{word} is no word that is read here: {all} are': '{word} wird hier nicht gelesen, nur {all}',
  '{word} needs an F of its own behind G93': '{word} braucht hinter G93 ein eigenes F',
  '{word} is no time behind G93: 60/F seconds are 0.1 ms to 24 h':
    '{word} ist hinter G93 keine Zeit: 60/F Sekunden sind 0.1 ms bis 24 h',
  '{word} belongs to a G4': '{word} gehört zu einem G4',
  '{word} belongs to an M3 in its line': '{word} gehört zu einem M3 in derselben Zeile',
  '{word} takes no X, Y or Z here: write the motion in a line of its own':
    'Zu {word} gehört hier kein X, Y oder Z: die Bewegung in eine eigene Zeile schreiben',
  '{word} and another motion stand in one line': '{word} und eine andere Bewegung stehen in einer Zeile',
  '{word} and {other} cannot stand in one line': '{word} und {other} können nicht in einer Zeile stehen',
  '{word} is an arc in a plane of the machine; write it as lines, or as a row arc via=X,Y,Z x= y= z= of a program':
    '{word} ist ein Bogen in einer Ebene der Maschine; als Geraden schreiben oder als Zeile arc via=X,Y,Z x= y= z= eines Programms',
  "{word} means the zero of a workpiece; here zero is the robot's base":
    '{word} meint den Nullpunkt eines Werkstücks; hier ist null die Basis des Roboters',
  '{word} is not read here: {all} are': '{word} wird hier nicht gelesen, nur {all}',
  '{word} is no speed: F is above 0, mm or inches a minute': '{word} ist kein Tempo: F ist größer als 0, mm oder Zoll je Minute',
  '{word} needs P, the seconds that it waits': '{word} braucht P, die Sekunden, die gewartet wird',
  '{word} is no wait: 0 to 3600 seconds': '{word} ist keine Wartezeit: 0 bis 3600 Sekunden',
  '{word} moves without a G0 or G1 before it': '{word} bewegt, ohne dass ein G0 oder G1 davor steht',
  '{word} has no speed: a G1 needs an F in or before its line': '{word} hat kein Tempo: ein G1 braucht ein F in seiner Zeile oder davor',
  '{word} has no meaning for the tool of {robot}': '{word} bedeutet dem Werkzeug von {robot} nichts',
  '{word} needs S, {amount}': '{word} braucht S, {amount}',
  '{word} says nothing to a pump that is on or off': '{word} sagt einer Pumpe nichts, die nur an oder aus ist',
};

export const complaintsDe: ComplaintWords = {
  sentences: { ...words, ...steps, ...motions, ...points, ...sequences, ...poses, ...gcode },
  endings: {
    'did you mean {meant}?': 'ist {meant} gemeint?',
    'steps are {all}': 'Schritte sind {all}',
    'commands are {all}': 'Befehle sind {all}',
    'there are {all} and more': 'es gibt {all} und weitere',
    'there are {all}': 'es gibt {all}',
    'it has {all}': 'möglich sind {all}',
  },
  parts: {
    example: {
      'home, or home time=5s': 'home oder home time=5s',
      'look, or look CAMERA': 'look oder look CAMERA',
      'gripper on or gripper off': 'gripper on oder gripper off',
      'suction release or suction off': 'suction release oder suction off',
    },
    chain: { ' calls ': ' ruft ' },
    joints: { joints: 'Gelenke', legs: 'Beine' },
    legs: { joints: 'Gelenke', legs: 'Beine' },
    type: {
      'a date or time': 'ein Datum oder eine Zeit',
      'true or false': 'true oder false',
      'a whole number': 'eine ganze Zahl',
      'a real number': 'eine Kommazahl',
      'a string': 'ein Text',
      'a list': 'eine Liste',
      'a table': 'eine Tabelle',
    },
    what: {
      'a position in steps': 'eine Stellung in Schritten',
      'a speed': 'ein Tempo',
      'an acceleration': 'eine Beschleunigung',
      'a gripper position': 'eine Stellung des Greifers',
      "the gripper's switch": 'der Schalter des Greifers',
      'the number of rounds': 'die Zahl der Runden',
    },
    file: { 'a .pos file': 'Eine .pos-Datei', 'a config.cfg': 'Eine config.cfg' },
    amount: { 'the degrees of the gripper': 'die Grade des Greifers', 'the width between the jaws, mm': 'die Weite zwischen den Backen in mm' },
  },
};
