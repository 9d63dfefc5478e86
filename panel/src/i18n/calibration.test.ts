import { afterEach, describe, expect, it } from 'vitest';
import { complaintSentence, language } from '.';
import { source } from '../logic/source.fixture';
import { calibrationSentencesDe } from './calibration_de';

/** Where sentences of a calibration are made, and how many pieces of each text have to be found there. */
const kFiles = [
  'calibration/board_views.cc',
  'calibration/view_coverage.cc',
  'calibration/calibration_error.cc',
  'runtime/camera_calibration.cc',
  'server/api/calibrations.cc',
  'server/api/api_camera.cc',
  'cli/output/cell_cameras.cc',
  'calibration/sheet_touches.cc',
];
/** Their strings, those that stand behind each other as one. */
const kCode = kFiles.map((file) => source(`src/sinew/${file}`).replace(/"\s*\n\s*"/g, '')).join('\n');

describe('what a calibration says', () => {
  afterEach(() => void (language.value = 'en'));

  it('is known word for word', () => {
    for (const english of Object.keys(calibrationSentencesDe.sentences)) {
      for (const piece of english.split(/\{\w+\}|The fit/)) {
        const words = piece.replace(/^['"]|['"]$/g, '').trim();
        // " of view " and "The fit" are put together from two places.
        for (const part of words.split(/ of view|(?<=[.;:]) /)) {
          if (part.trim().length > 2) expect(kCode, english).toContain(part.trim());
        }
      }
    }
  });
  it('names each place of the picture', () => {
    language.value = 'de';
    const sides = ['left', 'right'];
    const places = sides.flatMap((side) => [
      `the upper ${side} corner of the picture`,
      `the lower ${side} corner of the picture`,
      `the upper edge of the picture, ${side} of the middle`,
      `the lower edge of the picture, ${side} of the middle`,
      `the ${side} edge of the picture`,
      `the picture, ${side} of the middle`,
    ]);
    for (const place of places) expect(complaintSentence(`Move the board to ${place}.`)).not.toMatch(/the |middle|edge/);
  });
  it('is said in German with its figures', () => {
    language.value = 'de';
    expect(complaintSentence('The board is where view 3 shows it already. Move, tilt or turn the board.')).toBe(
      'Die Tafel ist dort, wo Ansicht 3 sie schon zeigt. Die Tafel verschieben, kippen oder drehen.',
    );
    expect(
      complaintSentence(
        'The picture is blurred: edges are 7.2 px wide (limit 4.5 px). Hold everything still, use more light, or focus the camera.',
      ),
    ).toContain('7.2 px breit (Grenze 4.5 px)');
    expect(complaintSentence("'pick' runs on left: stop the program, then save the calibration")).toBe(
      "'pick' läuft auf left: das Programm beenden, dann die Kalibrierung speichern",
    );
  });
});
