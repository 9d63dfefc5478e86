// The calibration of a simulated camera in a browser, from the prints to a saved file: its figure is checked against
// where the simulation knows the camera to be.
//
//   node --test tests/panel/calibration_test.mjs      (bench.mjs says what can be set)
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { ask, bench, ready, until as soon } from './bench.mjs';

/** Pictures are rendered, with what processors have left over. */
const kRendered = 240_000; // ms
const until = (what, done) => soon(what, done, 50, kRendered);

let here;
before(async () => {
  here = await bench(`title = "Cubes"
time_scale = 20
[[robot]]
name = "left"
robot = "learm"
profile = "bus"
[[camera]]
name = "eye"
device = "simulated"
x_mm = 150
y_mm = 40
[[camera]]
name = "gone"
device = "no_such_picture.jpg"
[basket]
name = "tray"
length_mm = 110
width_mm = 110
height_mm = 50
x_mm = 60
y_mm = 180
[[cube]]
color = "red"
x_mm = 170
y_mm = -20
rz_deg = 25
`);
});
after(() => here?.end());
afterEach(() => here.clear());

const address = '#/robots/left/camera';
const lens = async () => (await ask('cell.describe')).cameras[0].lens;
const taken = (page) => page.locator('.calibrate-views li');
const button = (page, name) => page.getByRole('button', { name, exact: true });
const file = () => path.join(here.folder, 'camera-eye.toml');

/** The wizard, without the tour of a first visit before it. */
async function wizard(options, name, of = 'eye') {
  const page = await here.open(options, address);
  page.setDefaultTimeout(kRendered);
  const skip = page.locator('.tour [data-tour=skip]');
  await skip.click();
  await page.getByRole('radio', { name: of }).click();
  await button(page, name).click();
  return page;
}

/** Clicks, and waits until the wizard has taken a view or said why not. */
async function take(page, name = 'Take view') {
  const before = await taken(page).count();
  await button(page, name).click();
  await until('an answer', async () => (await taken(page).count()) > before || (await page.locator('.calibrate-told.refused').count()) > 0);
}

/** Joints of the arm with the tip of a pin of 20 mm in its jaws on marks of the sheet, deg. */
const kMarks = {
  cross1: [68.788, 21.643, 65.804, 82.552],
  cross2: [33.87, 62.887, 9.072, 78.041],
  cross5: [18.435, 24.204, 60.838, 89.958],
  tag581: [28.519, 39.553, 47.346, 68.102],
  cross3: [-15.219, 54.729, 16.023, 89.248],
};

async function go(page, rows) {
  assert.ok(await page.evaluate((text) => globalThis.__sinew.store.run('left', text, 'touch'), rows));
  await until('the arm is there', async () => (await ask('job.status', { robot: 'left' })).over);
  const job = await ask('job.status', { robot: 'left' });
  assert.equal(job.phase, 'done', JSON.stringify(job.error));
}

/** The third step: the arm touches marks of the sheet. */
async function touchMarks(page) {
  const told = page.locator('.calibrate-told');
  await button(page, 'Skip').waitFor();
  assert.ok(await button(page, 'The tip is on cross1').isDisabled(), 'it is not said how far the pin stands out');
  await page.getByLabel('The pin stands out by').fill('20');
  await page.getByLabel('The pin stands out by').press('Enter');
  await ready(page, 'left');
  await go(page, 'jaws 40mm\n');
  await page.getByRole('radio', { name: 'cross1' }).click();
  await button(page, 'The tip is on cross1').click();
  await until('that the jaws are open', async () => /jaws of left are not closed/.test(await told.innerText()));
  await go(page, 'joint base=0deg shoulder=0deg elbow=45deg wrist=45deg roll=0deg\njaws 0mm\n');
  for (const [mark, [base, shoulder, elbow, wrist]] of Object.entries(kMarks)) {
    await go(page, `joint base=${base}deg shoulder=${shoulder - 15}deg elbow=${elbow}deg wrist=${wrist}deg roll=0deg\njoint shoulder=${shoulder}deg\n`);
    await page.getByRole('radio', { name: mark }).click();
    await button(page, `The tip is on ${mark}`).click();
    await until(`${mark} taken`, async () => (await page.locator('.calibrate-mark.touched').count()) > Object.keys(kMarks).indexOf(mark));
    await go(page, `joint shoulder=${shoulder - 15}deg\n`);
  }
  const facts = page.locator('.calibrate-facts dd');
  await until('figures', async () => (await facts.count()) === 3);
  const [error, rms, moved] = (await facts.allInnerTexts()).map(Number.parseFloat);
  assert.ok(error > 0 && error < 10, `error of the table ${error} mm`);
  // Its servos stand up to half a degree from where they were sent, and so beside the marks.
  assert.ok(rms < 4 && moved < 8, `rms ${rms} mm, ${moved} mm from where it lies`);
  await here.close(page, 'calibration-touch');
  // One that is deleted is touched again.
  const marks = page.locator('.calibrate-mark.touched');
  await button(page, 'Delete cross3').click();
  await until('one less', async () => (await marks.count()) === 4);
  const [base, shoulder, elbow, wrist] = kMarks.cross3;
  await go(page, `joint base=${base}deg shoulder=${shoulder}deg elbow=${elbow}deg wrist=${wrist}deg roll=0deg\n`);
  await page.getByRole('radio', { name: 'cross3' }).click();
  await button(page, 'The tip is on cross3').click();
  await until('it again', async () => (await marks.count()) === 5);
  await go(page, `joint shoulder=${shoulder - 15}deg\n`);
  console.log(`# error of the table in the robot ${error} mm, rms ${rms} mm, ${moved} mm from where it lies`);
}

/** Where a pixel of the picture meets the table (z = 0 of the cell), m; the lens has no errors. */
function onTable(one, x, y) {
  const { quaternion_wxyz: [w, a, b, c], x_m, y_m, z_m } = one.pose;
  const d = [(x - one.width_px / 2) / one.fx_px, (y - one.height_px / 2) / one.fy_px, 1];
  const [u, v] = [[a, b, c], d];
  const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
  const uv = cross(u, v);
  const uuv = cross(u, uv);
  const out = v.map((value, i) => value + 2 * (w * uv[i] + uuv[i]));
  const far = -z_m / out[2];
  return [x_m + far * out[0], y_m + far * out[1]];
}

test('a simulated camera is calibrated to the end, and hangs where the simulation knows it to hang', async () => {
  const truth = await lens();
  const page = await wizard({ viewport: { width: 1280, height: 900 } }, 'Calibrate again');
  const [download] = await Promise.all([page.waitForEvent('download'), button(page, 'Board as PDF').click()]);
  assert.equal(download.suggestedFilename(), 'sinew-board-a4.pdf');
  assert.match(readFileSync(await download.path(), 'latin1'), /^%PDF-/);
  await here.close(page, 'calibration-print');
  await button(page, 'Take views').click();
  await page.getByText('0 of 8 views').waitFor();
  assert.ok(await button(page, 'To the table').isDisabled(), 'there are no views yet');
  await until('tags in the live picture', async () => (await page.locator('.calibrate-tag').count()) > 10);
  for (let i = 0; i < 5; ++i) await take(page);
  assert.equal(await taken(page).count(), 5);
  await here.close(page, 'calibration-board');

  // A page that is loaded again goes on with the views; one of them is deleted.
  await page.reload();
  await page.getByText('Views not saved: 5').waitFor();
  await button(page, 'Continue the calibration').click();
  await until('the views again', async () => (await taken(page).count()) === 5);
  await button(page, 'Delete view 2').click();
  await until('one less', async () => (await taken(page).count()) === 4);
  for (let i = 0; i < 20 && (await taken(page).count()) < 9; ++i) await take(page);
  assert.ok((await taken(page).count()) >= 9, await page.locator('.calibrate').innerText());
  for (const text of await page.locator('.calibrate-residual b').allInnerTexts()) {
    assert.ok(Number.parseFloat(text) < 1, `residual ${text}`);
  }
  assert.ok((await page.locator('.calibrate-cell.seen').count()) >= 10, 'most of the picture is covered');
  await here.close(page, 'calibration-views');

  await button(page, 'To the table').click();
  await until('the sheet', async () => (await page.locator('.calibrate-tag').count()) >= 3);
  await here.close(page, 'calibration-sheet');
  await button(page, 'Take the sheet').click();
  await button(page, 'Skip').click();
  const figure = page.locator('.calibrate-figure strong');
  await figure.waitFor();
  const millimetres = Number.parseFloat(await figure.innerText());
  assert.ok(millimetres > 0 && millimetres < 2, `error at the table ${millimetres} mm`);
  await here.close(page, 'calibration-result');
  assert.ok(!existsSync(file()), 'nothing is written before Save');
  await button(page, 'Save').click();
  await page.getByText('no restart is needed').waitFor();
  await here.close(page, 'calibration-saved');

  const text = readFileSync(file(), 'utf8');
  assert.match(text, /name = "eye"/);
  assert.match(text, /identity = "simulated"/);
  assert.match(text, /width = 640/);
  assert.doesNotMatch(text, /\[table\]/);
  const found = await lens();
  assert.notEqual(found.fx_px, truth.fx_px, 'what was measured counts');
  const off = Math.hypot(found.pose.x_m - truth.pose.x_m, found.pose.y_m - truth.pose.y_m, found.pose.z_m - truth.pose.z_m);
  assert.ok(off < 0.01, `the camera is ${1000 * off} mm from where it hangs`);
  for (const [x, y] of [[160, 120], [480, 120], [320, 240], [160, 360], [480, 360]]) {
    const [there, where] = [onTable(truth, x, y), onTable(found, x, y)];
    const apart = 1000 * Math.hypot(there[0] - where[0], there[1] - where[1]);
    // Center and lens of what was found are left out here: they are small.
    assert.ok(apart < 4, `${x}, ${y} px: ${apart} mm apart on the table`);
  }
  await button(page, 'Close').click();
  await page.getByText(`right to ${millimetres.toFixed(1)} mm`).waitFor();
  console.log(`# error at the table ${millimetres} mm, camera ${(1000 * off).toFixed(1)} mm from where it hangs`);
});

test('an arm touches marks of the sheet, and so is measured where it lies', async () => {
  const page = await wizard({ viewport: { width: 1280, height: 900 } }, 'Calibrate again');
  await button(page, 'Take views').click();
  for (let i = 0; i < 20 && (await taken(page).count()) < 6; ++i) await take(page);
  await button(page, 'To the table').click();
  await button(page, 'Take the sheet').click();
  await touchMarks(page);
  await button(page, 'To the result').click();
  await page.locator('.calibrate-figure strong').waitFor();
  assert.doesNotMatch(await page.locator('.calibrate').innerText(), /not measured/);
  await button(page, 'Save').click();
  await page.getByText('no restart is needed').waitFor();
  await here.close(page, 'calibration-touched');
  assert.match(readFileSync(file(), 'utf8'), /\[table\].*\nrobot = "left"\n/);
  const { table } = (await ask('cell.describe')).cameras[0];
  assert.notEqual(table.x_m, 0.15, 'the table is where it was touched');
  assert.ok(Math.hypot(table.x_m - 0.15, table.y_m - 0.04) < 0.01, JSON.stringify(table));
});

test('leaving says what is lost, and what was saved stays', async () => {
  const before = await lens();
  const page = await wizard({}, 'Calibrate again');
  await button(page, 'Take views').click();
  await take(page);
  await button(page, 'Leave the calibration').click();
  await page.getByText('Views not saved: 1').waitFor();
  await button(page, 'Stay').click();
  await button(page, 'Leave the calibration').click();
  await button(page, 'Discard').click();
  await button(page, 'Calibrate again').waitFor();
  assert.equal((await ask('camera.calibration.status', { camera: 'eye' })).under_way, false);
  assert.deepEqual(await lens(), before);
  await here.close(page, 'calibration-left');
});

test('a camera without a picture says why, on a telephone and in German', async () => {
  const page = await wizard({ viewport: { width: 390, height: 844 }, locale: 'de-DE' }, 'Kalibrieren', 'gone');
  await here.close(page, 'calibration-telephone-print');
  await button(page, 'Ansichten aufnehmen').click();
  await button(page, 'Ansicht aufnehmen').click();
  await until('why not', async () => /kein Bild/.test(await page.locator('.calibrate').innerText()));
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(wide <= 0, `the page is ${wide} px too wide`);
  await page.getByRole('radio', { name: 'eye' }).click();
  await button(page, 'Neu kalibrieren').click();
  await button(page, 'Ansichten aufnehmen').click();
  for (let i = 0; i < 20 && (await taken(page).count()) < 2; ++i) await take(page, 'Ansicht aufnehmen');
  assert.equal(await taken(page).count(), 2, await page.locator('.calibrate').innerText());
  await page.getByText('Die Tafel um etwa 30 Grad').waitFor();
  await here.close(page, 'calibration-telephone');
});
