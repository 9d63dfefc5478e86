// What a camera sees, in a browser: cubes under a simulated one are picked with a click and sorted, and a
// camera that gives no pictures says so.
//
//   node --test tests/panel/camera_test.mjs      (bench.mjs says what can be set)
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { ask, bench, ready, until } from './bench.mjs';

const kStand = 'joint base=-60deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg';
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
[[cube]]
color = "blue"
x_mm = 180
y_mm = 45
rz_deg = 60
`);
});
after(() => here?.end());
afterEach(() => here.clear());

const job = async () => (await ask('robot.status', { robot: 'left' })).job;
const cubes = (page) => page.locator('.camera-cube');
const counts = (page) => page.locator('.camera-counts tbody tr').allInnerTexts();

test('a cube that is clicked is picked and placed, and the rest is sorted', async () => {
  const page = await here.open({}, '#/robots/left/camera');
  await ready(page, 'left');
  await page.evaluate((rows) => globalThis.__sinew.store.run('left', rows, 'aside'), kStand);
  await until('aside', async () => (await job())?.over);
  await until('two cubes', async () => (await cubes(page).count()) === 2);
  await page.locator('.camera-cube[aria-label^="Red"]').click();
  const chosen = page.locator('.camera-chosen');
  await chosen.waitFor();
  assert.match(await chosen.innerText(), /Red cube at 1[67]\d, [-−][12]\d mm/);
  await page.getByRole('button', { name: 'Into tray', exact: true }).click();
  await until('placed', async () => (await job()).title === 'Pick a cube' && (await job()).over);
  assert.equal((await job()).phase, 'done', JSON.stringify((await job()).error));
  await until('one in the tray', async () => (await counts(page)).some((row) => /Red\s+0\s+1/.test(row)));
  await page.getByRole('button', { name: 'All into tray' }).click();
  await until('sorted', async () => (await job()).title === 'Sort cubes' && (await job()).over, 50, 180_000);
  assert.equal((await job()).phase, 'done', JSON.stringify((await job()).error));
  await until('both in the tray', async () => (await counts(page)).some((row) => /Blue\s+0\s+1/.test(row)));
  await here.close(page, 'camera-sorted');
});

test('a hand in view pauses the program, and a person says when it goes on', async () => {
  const page = await here.open({ viewport: { width: 1280, height: 900 } }, '#/robots/left/camera');
  await ready(page, 'left');
  const wave = 'joint base=-75deg speed=20%\njoint base=-60deg speed=20%\n';
  const waves = `look\n${kStand}\n${wave.repeat(100)}`;
  await page.evaluate((rows) => globalThis.__sinew.store.run('left', rows, 'waves'), waves);
  await until('the arm is under way', async () => (await job())?.title === 'waves' && (await job()).line > 3);
  await page.getByRole('radio', { name: 'A hand in view' }).click();
  const callout = page.locator('.camera-paused');
  // Why it pauses comes a message later than that it does.
  await callout.filter({ hasText: 'came into the camera' }).waitFor({ timeout: 60_000 });
  assert.match(await callout.innerText(), /waves: paused/);
  assert.equal((await job()).phase, 'paused');
  await here.close(page, 'camera-hand');
  await page.getByRole('radio', { name: 'Nothing' }).click();
  await until('the hand is gone', async () => (await ask('camera.look')).trouble === 'none');
  assert.equal((await job()).phase, 'paused', 'it goes on by itself');
  await callout.getByRole('button').click();
  await until('goes on', async () => (await job()).phase === 'running');
  await until('no callout', async () => (await callout.count()) === 0);
  await page.getByRole('button', { name: 'Stop', exact: true }).first().click();
  await until('stopped', async () => (await job()).over);
  await here.close(page, 'camera-hand-gone');
});

test('what a running program sees is shown beside the 3D view, and its cubes in it', async () => {
  const page = await here.open({ viewport: { width: 1280, height: 900 } }, '#/robots/left/jog');
  await ready(page, 'left');
  const inset = page.locator('.looking-on');
  await until('no inset: no program runs', async () => (await inset.count()) === 0);
  const number = (await ask('camera.look', { take: false })).number;
  assert.equal((await ask('camera.look', { take: false })).number, number, 'to look on takes no pictures');
  const wave = 'joint base=-75deg speed=20%\njoint base=-60deg speed=20%\n';
  const waves = `${kStand}\nlook\n${wave.repeat(100)}`;
  await page.evaluate((rows) => globalThis.__sinew.store.run('left', rows, 'waves'), waves);
  await inset.locator('img').waitFor();
  await until('the picture of its look', async () => (await ask('camera.look', { take: false })).number > number);
  await until('its cubes', async () => /eye: [12] cubes?/.test(await inset.innerText()));
  await here.close(page, 'camera-beside');
  const again = await here.open({ viewport: { width: 1280, height: 900 } }, '#/robots/left/jog');
  await again.locator('.looking-on').click();
  await again.locator('.camera-picture img').waitFor();
  await again.getByRole('button', { name: 'Stop', exact: true }).first().click();
  await until('stopped', async () => (await job()).over);
  await here.close(again, 'camera-beside-opened');
});

test('a simulated camera that is unplugged is named, and comes back', async () => {
  const page = await here.open({}, '#/robots/left/camera');
  await page.locator('.camera-picture img').waitFor();
  await page.getByRole('radio', { name: 'Unplugged' }).click();
  await page.locator('.camera-fault').waitFor();
  await page.getByRole('radio', { name: 'Nothing' }).click();
  await until('no fault', async () => (await page.locator('.camera-fault').count()) === 0);
  await here.close(page, 'camera-unplugged');
});

test('a camera that gives no picture is named, and the other one goes on', async () => {
  const page = await here.open({}, '#/robots/left/camera');
  await page.getByRole('radio', { name: 'gone' }).click();
  await page.locator('.camera-fault').waitFor();
  assert.match(await page.locator('.camera-fault').innerText(), /has given no picture/);
  await page.getByRole('radio', { name: 'eye' }).click();
  await page.locator('.camera-picture img').waitFor();
  await until('no fault', async () => (await page.locator('.camera-fault').count()) === 0);
  await here.close(page, 'camera-gone');
});

test('on a telephone, in German', async () => {
  const page = await here.open({ viewport: { width: 390, height: 844 }, locale: 'de-DE' }, '#/robots/left/camera');
  await page.locator('.camera-picture img').waitFor();
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(wide <= 0, `the page is ${wide} px too wide`);
  await page.getByText('Kalibriert').waitFor();
  await here.close(page, 'camera-telephone');
});
