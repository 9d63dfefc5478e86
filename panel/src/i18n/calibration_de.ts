/** Der Kalibrierassistent, mit den Schlüsseln von calibration_en.ts. */
import type { calibrationEn } from './calibration_en';
import type { ComplaintWords } from './complaints';

export const calibrationDe: Record<keyof typeof calibrationEn, string> = {
  'cal.calibrate': 'Kalibrieren',
  'cal.calibrate.again': 'Neu kalibrieren',
  'cal.continue': 'Kalibrierung fortsetzen',
  'cal.under_way': 'Eine Kalibrierung läuft. Nicht gespeicherte Ansichten: {count}.',
  'cal.refused': 'Die gespeicherte Kalibrierung gilt nicht: {why}.',
  'cal.title': '{camera} kalibrieren',
  'cal.step.print': 'Drucken',
  'cal.step.board': 'Tafel',
  'cal.step.sheet': 'Tisch',
  'cal.step.touch': 'Roboter',
  'cal.step.result': 'Ergebnis',

  'cal.print.how': 'Tafel und Blatt mit 100 % (tatsächlicher Größe) drucken.',
  'cal.paper': 'Papier',
  'cal.paper.a4': 'A4',
  'cal.paper.a3': 'A3',
  'cal.paper.letter': 'Letter',
  'cal.print.board': 'Tafel',
  'cal.print.board.how': 'Auf etwas Ebenes kleben. Sie halten die Tafel vor die Kamera.',
  'cal.print.sheet': 'Blatt',
  'cal.print.sheet.how': 'Liegt auf dem Tisch und ist der Ursprung seiner Koordinaten.',
  'cal.print.form': '{what} als {form}',
  'cal.print.ruler': 'Das Lineal auf jedem Druck muss 100 mm lang sein. Sonst ohne Skalierung neu drucken.',
  'cal.print.next': 'Ansichten aufnehmen',
  'cal.print.anew': 'Die {count} Ansichten bisher sind mit anderem Papier aufgenommen: Sie gehen dann verloren.',
  'cal.simulated': 'Diese Kamera ist simuliert: Eine simulierte Hand hält die Tafel und bewegt sie nach jeder Ansicht.',

  'cal.board.how': 'Die Tafel ruhig halten: in mehreren Winkeln bis 45 Grad, nah und fern, in allen Teilen des Bildes.',
  'cal.found': '{count} Marken',
  'cal.take': 'Ansicht aufnehmen',
  'cal.taking': 'Ansicht wird aufgenommen',
  'cal.taken': 'Ansicht {view} ist aufgenommen.',
  'cal.views': 'Ansichten',
  'cal.views.enough': '{count} Ansichten: genug',
  'cal.views.count': '{count} von {enough} Ansichten',
  'cal.board.next': 'Zum Tisch',
  'cal.view': 'Ansicht {view}',
  'cal.view.tags': '{count} Marken',
  'cal.view.residual': 'Abweichung: Abstand der Ecken von ihrem Modell, quadratisches Mittel',
  'cal.view.delete': 'Ansicht {view} löschen',

  'cal.sheet.how': 'Das Blatt flach auf den Tisch legen. Der Arm und alles andere darf seine vier Marken nicht verdecken.',
  'cal.sheet.simulated': 'Das simulierte Blatt liegt auf dem Tisch. Würfel und Korb sind solange beiseitegelegt.',
  'cal.sheet.take': 'Blatt aufnehmen',

  'cal.touch.how':
    'Einen Stift oder Zahnstocher in das Werkzeug von {robot} klemmen. Seine Spitze auf drei oder mehr Zeichen bringen, weit auseinander und nicht auf einer Linie. Der Arm fährt dann dorthin, wo die Kamera etwas sieht.',
  'cal.touch.pin': 'Der Stift steht vor um',
  'cal.touch.marks': 'Zeichen des Blattes',
  'cal.touch.take': 'Die Spitze ist auf {mark}',
  'cal.touch.taken': '{mark} ist aufgenommen.',
  'cal.touch.no_tip': 'Dieser Roboter hat keine Spitze. Links einen Arm wählen.',
  'cal.touch.touched': 'Berührte Zeichen',
  'cal.touch.none': 'Noch kein Zeichen berührt.',
  'cal.touch.off': '{mm} mm',
  'cal.touch.off.how': 'Neben dem Ort, den die anderen Zeichen ergeben',
  'cal.touch.delete': '{mark} löschen',
  'cal.touch.is_touched': '{mark}, berührt',
  'cal.touch.error': 'Fehler des Tisches im Roboter (95 %)',
  'cal.touch.rms': 'Rest der Zeichen, quadratisches Mittel',
  'cal.touch.moved': 'Abstand vom Ort in der Zellendatei',
  'cal.touch.better': 'Auch {mark} berühren: Der Fehler wird {mm} mm.',
  'cal.touch.next': 'Zum Ergebnis',
  'cal.touch.skip': 'Überspringen',
  'cal.touch.skipped': 'Sonst muss das Blatt dort liegen, wo die Zellendatei es sagt.',
  'cal.touch.not_measured': 'nicht gemessen',

  'cal.result.none': 'Es gibt noch kein Ergebnis.',
  'cal.result.error': 'Fehler am Tisch (95 %)',
  'cal.result.honest':
    'Gemessen: Jede Ansicht wird einmal zurückgehalten, und ihre Marken werden mit der Linse bestimmt, die die anderen Ansichten ergeben.',
  'cal.result.reprojection': 'Reprojektionsfehler (RMS)',
  'cal.result.views': 'Ansichten der Tafel',
  'cal.result.height': 'Kamera über dem Tisch',
  'cal.result.focal': 'Brennweite',
  'cal.result.ambiguous': 'Zwei Posen erklären die Ansicht des Blattes. Das Blatt neu aufnehmen, mehr von oben oder aus der Nähe.',
  'cal.result.better': 'Für ein besseres Ergebnis: {how}',
  'cal.result.more': 'Weitere Ansichten',
  'cal.result.stays': 'Das Blatt bleibt auf dem Tisch. Programme halten dann an, wenn die Kamera bewegt wurde.',
  'cal.result.touched_before': '{robot} hat früher gemessen, wo das Blatt liegt. Speichern verwirft das: die Zeichen in Schritt 4 neu berühren.',
  'cal.save': 'Speichern',
  'cal.save.file': 'Speichern schreibt {file}',
  'cal.save.nowhere': 'Diese Zelle wurde nicht aus einer Datei gelesen: Es gibt keinen Ort zum Speichern.',
  'cal.saved': 'Gespeichert. Die Kamera verwendet die Kalibrierung ab sofort; ein Neustart ist nicht nötig.',
  'cal.saved.file': 'Datei: {file}',
  'cal.saved.stays': 'Lassen Sie das Blatt liegen.',
  'cal.saved.sheet_off': 'Das Blatt darf weg. Eine bewegte Kamera wird nicht bemerkt: Kalibrieren Sie dann neu.',
  'cal.saved.close': 'Schließen',

  'cal.leave': 'Kalibrierung verlassen',
  'cal.leave.empty': 'Die Kalibrierung hat noch keine Ansichten. Eine früher gespeicherte Kalibrierung bleibt.',
  'cal.leave.unsaved':
    'Nicht gespeicherte Ansichten: {count}. Behalten, um später fortzufahren, solange die Zelle läuft; oder verwerfen. Eine früher gespeicherte Kalibrierung bleibt.',
  'cal.leave.stay': 'Bleiben',
  'cal.leave.later': 'Später fortsetzen',
  'cal.leave.discard': 'Verwerfen',
};

/** Was die Steuerung an einer Ansicht auszusetzen hat und was sie rät: src/sinew/calibration. Ein Test hält beide aneinander. */
export const calibrationSentencesDe: ComplaintWords = {
  sentences: {
    'No tag of the board is seen. Hold the printed board so that it fills half of the picture; sinew camera board prints it.':
      'Keine Marke der Tafel ist zu sehen. Die gedruckte Tafel so halten, dass sie das halbe Bild füllt; Schritt 1 druckt sie.',
    'No tag of the sheet is seen. Lay the printed sheet on the table in the middle of the picture; sinew camera sheet prints it.':
      'Keine Marke des Blattes ist zu sehen. Das gedruckte Blatt in die Bildmitte auf den Tisch legen; Schritt 1 druckt es.',
    'Only {seen} of the 4 tags of the sheet are seen ({least} needed). Clear what covers the sheet.':
      'Nur {seen} der 4 Marken des Blattes sind zu sehen ({least} nötig). Was das Blatt verdeckt, muss weg.',
    'Only {seen} tags of the board are seen ({least} needed). Show more of the board.':
      'Nur {seen} Marken der Tafel sind zu sehen ({least} nötig). Mehr von der Tafel zeigen.',
    'The picture has {size}, the views before have {other}. Set the camera to its former size, or begin the calibration again.':
      'Das Bild hat {size}, die Ansichten davor haben {other}. Die Kamera auf ihre frühere Größe stellen oder die Kalibrierung neu beginnen.',
    'The picture is blurred: edges are {width} px wide (limit {most} px). Hold everything still, use more light, or focus the camera.':
      'Das Bild ist unscharf: Kanten sind {width} px breit (Grenze {most} px). Alles ruhig halten, mehr Licht machen oder die Kamera scharf stellen.',
    '{most} views are the most. Delete one.': 'Mehr als {most} Ansichten gehen nicht. Eine löschen.',
    'The board is where view {view} shows it already. Move, tilt or turn the board.':
      'Die Tafel ist dort, wo Ansicht {view} sie schon zeigt. Die Tafel verschieben, kippen oder drehen.',
    'Hold the board flat in front of the camera, so that it fills half of the picture.':
      'Die Tafel gerade vor die Kamera halten, sodass sie das halbe Bild füllt.',
    'Tilt the board by about 30 deg about its horizontal edge.': 'Die Tafel um etwa 30 Grad um ihre waagrechte Kante kippen.',
    'Tilt the board by about 30 deg about its vertical edge.': 'Die Tafel um etwa 30 Grad um ihre senkrechte Kante kippen.',
    'Move the board to {place}.': 'Die Tafel verschieben: {place}.',
    'Move the board to twice its distance, or half of it.': 'Die Tafel doppelt so weit weg halten oder halb so weit.',
    'Take another view, with the board tilted and turned differently: {count} of {enough} views.':
      'Noch eine Ansicht aufnehmen, die Tafel anders gekippt und gedreht: {count} von {enough} Ansichten.',
    'The picture of view {view} has another size than expected, or a point lies outside of it. Use pictures of one size from one camera.':
      'Das Bild von Ansicht {view} hat eine andere Größe, oder ein Punkt liegt außerhalb. Bilder einer Größe von einer Kamera verwenden.',
    'Too few points of view {view}: {measured}, at least {limit} needed. Show more of the board.':
      'Zu wenige Punkte in Ansicht {view}: {measured}, mindestens {limit} nötig. Mehr von der Tafel zeigen.',
    'The points of view {view} are nearly on one line: {length} long, {measured} wide, at least {limit} wide needed. Add a point away from the line.':
      'Die Punkte von Ansicht {view} liegen fast auf einer Linie: {length} lang, {measured} breit, mindestens {limit} nötig.',
    'All views are parallel within {measured} (at least {limit} needed), so the focal length cannot be found. Tilt the board by about 30 deg about its horizontal edge.':
      'Alle Ansichten sind auf {measured} parallel (mindestens {limit} nötig): Die Brennweite ist so nicht zu finden. Die Tafel um etwa 30 Grad um ihre waagrechte Kante kippen.',
    'The focal length is uncertain by {measured} (limit {limit}). Add views with the board tilted by about 30 deg about its horizontal edge and about its vertical edge.':
      'Die Brennweite ist auf {measured} unsicher (Grenze {limit}). Ansichten mit um etwa 30 Grad gekippter Tafel hinzufügen.',
    'The fit of view {view} did not converge: {measured} remain (limit {limit}). Check the dimensions of the board and that all pictures show this board.':
      'Ansicht {view} passt nicht: {measured} bleiben (Grenze {limit}). Maße der Tafel prüfen, und ob alle Bilder diese Tafel zeigen.',
    'The fit did not converge: {measured} remain (limit {limit}). Check the dimensions of the board and that all pictures show this board.':
      'Die Ansichten passen nicht zusammen: {measured} bleiben (Grenze {limit}). Maße der Tafel prüfen, und ob alle Bilder diese Tafel zeigen.',
    'The fit of view {view} found no pose that explains what is seen. Check the dimensions of the board and that all pictures show this board.':
      'Ansicht {view} passt zu keiner Lage der Tafel. Maße der Tafel prüfen, und ob alle Bilder diese Tafel zeigen.',
    'The fit found no pose that explains what is seen. Check the dimensions of the board and that all pictures show this board.':
      'Die Ansichten passen zu keiner Lage der Tafel. Maße der Tafel prüfen, und ob alle Bilder diese Tafel zeigen.',
    'The sheet has no such mark; its marks are {list}.': 'Das Blatt hat kein solches Zeichen; es hat {list}.',
    '{robot} is a platform: it has no tip to touch marks with.': '{robot} ist eine Plattform: Sie hat keine Spitze, die etwas berührt.',
    '{robot} moves. Wait until it is at rest.': '{robot} bewegt sich. Warten, bis er ruht.',
    'It is not known where {robot} stands. Enable it, home it in Setup, then touch the mark.':
      'Wo {robot} steht, ist nicht bekannt. Einschalten, in der Einrichtung referenzieren, dann das Zeichen berühren.',
    'The jaws of {robot} are not closed. Close them on the pin, so that the tool has one tip, then touch the mark.':
      'Die Backen von {robot} sind nicht geschlossen. Auf dem Stift schließen, damit das Werkzeug eine Spitze hat, dann das Zeichen berühren.',
    'The other marks were touched by {robot}. Go on with it, or delete these marks.':
      'Die anderen Zeichen hat {robot} berührt. Mit ihm weitermachen oder diese Zeichen löschen.',
    'This camera is on an arm: sinew camera calibrate finds its lens, and sinew camera hand-eye where it is.':
      'Diese Kamera sitzt auf einem Arm: sinew camera calibrate findet ihre Linse, sinew camera hand-eye ihren Ort.',
    'This mark was not touched.': 'Dieses Zeichen wurde nicht berührt.',
    'The marks that were touched do not say where the sheet lies. Touch more of them, or delete them.':
      'Die berührten Zeichen sagen nicht, wo das Blatt liegt. Mehr berühren, oder sie löschen.',
    'too few marks: {count} ({list}), at least 3 needed, not on one line. Touch more of {left}: bring the tip of the tool there':
      'Zu wenige Zeichen: {count} ({list}), mindestens 3 nötig, nicht auf einer Linie. Mehr berühren: {left}',
    '{list} are nearly on one line: {length} mm long, {width} mm wide, at least {least} mm wide needed. Touch more of {left}: bring the tip of the tool there':
      '{list} liegen fast auf einer Linie: {length} mm lang, {width} mm breit, mindestens {least} mm nötig. Mehr berühren: {left}',
    'the tool was at the same position for {one} and {other}: {moved} mm apart, and these marks are {apart} mm apart. Touch the one that is wrong again':
      'Bei {one} und {other} war das Werkzeug am selben Ort: {moved} mm auseinander, die Zeichen aber {apart} mm. Das falsche noch einmal berühren',
    'the marks are in mirrored order: with {list} as given, the sheet would lie face down. Seen from above, cross1 to cross4 follow each other clockwise; touch them again under their own names':
      'Die Zeichen sind spiegelverkehrt: Mit {list} läge das Blatt verkehrt herum. Von oben gesehen folgen cross1 bis cross4 im Uhrzeigersinn; jedes noch einmal unter seinem Namen berühren',
    'the touches do not fit the sheet: {rms} mm rms (limit {limit} mm). With {one} and {other} exchanged they fit: were they touched in the other order? Then touch both again':
      'Die Berührungen passen nicht zum Blatt: {rms} mm (Grenze {limit} mm). Mit {one} und {other} vertauscht passen sie: Wurden sie andersherum berührt? Dann beide noch einmal berühren',
    'the touches do not fit the sheet: {rms} mm rms (limit {limit} mm). {mark} is off by {off}; the others agree to {rest} mm rms. Touch it again':
      'Die Berührungen passen nicht zum Blatt: {rms} mm (Grenze {limit} mm). {mark} liegt {off} daneben; die anderen passen auf {rest} mm. Noch einmal berühren',
    "the touches do not fit the sheet: {rms} mm rms (limit {limit} mm). Touched distances are {share} % {by} than those of {paper} paper. Measure the sheet's ruler (100 mm), then check which paper it is and the robot's lengths":
      'Die Berührungen passen nicht zum Blatt: {rms} mm (Grenze {limit} mm). Berührte Abstände sind {share} % {by} als auf {paper}. Das Lineal des Blattes messen (100 mm), dann Papier und Längen des Roboters prüfen',
    "the touches do not fit the sheet: {rms} mm rms (limit {limit} mm). {mark} fits least. Check the tool (jaws closed, length of the pin), that the sheet did not move, and that the robot's zeros are right (sinew commission {robot}); then touch the marks again":
      'Die Berührungen passen nicht zum Blatt: {rms} mm (Grenze {limit} mm). {mark} passt am wenigsten. Werkzeug (Backen zu, Länge des Stifts), Lage des Blattes und Nullpunkte des Roboters prüfen (sinew commission {robot}); dann die Zeichen noch einmal berühren',
    'The calibration has no result yet: it needs {least} views of the board and one of the sheet.':
      'Die Kalibrierung hat noch kein Ergebnis: Sie braucht {least} Ansichten der Tafel und eine des Blattes.',
    '{camera} has given no picture. Check the camera and its cable.': '{camera} hat kein Bild geliefert. Kamera und Kabel prüfen.',
    'This cell was not read from a file, so there is no place for a calibration.':
      'Diese Zelle wurde nicht aus einer Datei gelesen: Es gibt keinen Ort für eine Kalibrierung.',
    'No calibration of {camera} is under way. Begin one: camera.calibration.begin.':
      'Für {camera} läuft keine Kalibrierung (mehr). Bei Schritt 1 neu beginnen.',
    'Another client has begun the calibration of {camera} again. Continue with its views, or begin again.':
      'Von einem anderen Bedienfeld wurde die Kalibrierung von {camera} neu begonnen. Mit dessen Ansichten fortfahren oder neu beginnen.',
    'A calibration with paper {paper} is under way. Continue it, or begin again (anew).':
      'Eine Kalibrierung mit Papier {paper} läuft. Fortsetzen oder neu beginnen.',
    'There is no view {view} (any more).': 'Ansicht {view} gibt es nicht (mehr).',
    "{word} runs on {robot}: stop the program, then save the calibration": '{word} läuft auf {robot}: das Programm beenden, dann die Kalibrierung speichern',
    '{file} is not there': '{file} ist nicht da',
    '{file} is of another camera: {other}; this one is {own}': '{file} gehört zu einer anderen Kamera: {other}; diese hier ist {own}',
  },
  endings: {},
  parts: {
    by: { longer: 'länger', shorter: 'kürzer' },
    place: {
      'the upper left corner of the picture': 'in die linke obere Ecke des Bildes',
      'the upper right corner of the picture': 'in die rechte obere Ecke des Bildes',
      'the lower left corner of the picture': 'in die linke untere Ecke des Bildes',
      'the lower right corner of the picture': 'in die rechte untere Ecke des Bildes',
      'the upper edge of the picture, left of the middle': 'an den oberen Rand, links der Mitte',
      'the upper edge of the picture, right of the middle': 'an den oberen Rand, rechts der Mitte',
      'the lower edge of the picture, left of the middle': 'an den unteren Rand, links der Mitte',
      'the lower edge of the picture, right of the middle': 'an den unteren Rand, rechts der Mitte',
      'the left edge of the picture': 'an den linken Rand',
      'the right edge of the picture': 'an den rechten Rand',
      'the picture, left of the middle': 'links neben die Bildmitte',
      'the picture, right of the middle': 'rechts neben die Bildmitte',
    },
  },
};
