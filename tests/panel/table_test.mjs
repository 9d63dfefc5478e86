// What lies on a camera's table, in a browser: a basket is dragged in the picture and sorted into, the reachable
// region is drawn, and cubes that cannot be had say why.
//
//   node --test tests/panel/table_test.mjs      (bench.mjs says what can be set)
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { ask, bench, ready, until } from './bench.mjs';

const kStand = 'joint base=-60deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg';
let here;
before(async () => {
  here = await bench(`title = "Table"
time_scale = 20
[[robot]]
name = "left"
robot = "learm"
profile = "bus"
[[camera]]
name = "eye"
device = "simulated"
x_mm = 170
y_mm = 60
[[basket]]
name = "tray"
length_mm = 110
width_mm = 110
height_mm = 50
x_mm = 100
y_mm = 190
[[cube]]
color = "red"
x_mm = 150
y_mm = -30
rz_deg = 25
[[cube]]
color = "blue"
x_mm = 180
y_mm = 45
rz_deg = 60
[[cube]]
color = "yellow"
x_mm = 310
y_mm = 70
`);
});
after(() => here?.end());
afterEach(() => here.clear());

const job = async () => (await ask('robot.status', { robot: 'left' })).job;
const tray = async () => (await ask('cell.describe')).baskets[0];
const counts = (page) => page.locator('.camera-counts tbody tr').allInnerTexts();

/** The page with the arm out of the camera's sight, and all cubes seen. */
async function opened(options = {}) {
  const page = await here.open(options, '#/robots/left/camera');
  await ready(page, 'left');
  await page.evaluate((rows) => globalThis.__sinew.store.run('left', rows, 'aside'), kStand);
  await until('aside', async () => (await job())?.over && (await job()).title === 'aside');
  await until('three cubes', async () => (await page.locator('.camera-cube').count()) === 3);
  return page;
}

test('a cube that cannot be had says why, and what would help', async () => {
  const page = await opened();
  const list = page.locator('.camera-cannot');
  await list.waitFor();
  assert.match(await list.innerText(), /Yellow\s+.*out of reach by \d+(\.\d)? mm.*To fix: move the cube nearer/is);
  const cube = page.locator('.camera-cube.cannot');
  // The arm was still in the picture before.
  await until('one of them', async () => (await cube.count()) === 1);
  assert.match(await cube.locator('title').textContent(), /out of reach by/i);
  await list.getByRole('button', { name: 'Yellow' }).click();
  assert.match(await page.locator('.camera-chosen').innerText(), /out of reach by/i);
  await here.close(page, 'table-why-not');
});

test('the reachable region is drawn around the cubes that can be had', async () => {
  const page = await opened();
  await page.getByRole('button', { name: 'Reachable region' }).click();
  await page.getByText('For single cubes of 25 mm').waitFor({ timeout: 120_000 });
  const around = (color) =>
    page.evaluate((name) => {
      const svg = document.querySelector('.camera-picture svg');
      const dot = svg.querySelector(`.camera-cube[aria-label^="${name}"] circle`);
      const p = new DOMPoint(Number(dot.getAttribute('cx')), Number(dot.getAttribute('cy')));
      return svg.querySelector('.camera-region .tilted').isPointInFill(p);
    }, color);
  assert.equal(await around('Red'), true);
  assert.equal(await around('Blue'), true);
  assert.equal(await around('Yellow'), false);
  await here.close(page, 'table-region');
});

test('a basket is dragged in the picture, and cubes go where it is then', async () => {
  const page = await opened();
  const before = await tray();
  const basket = page.locator('.camera-basket');
  const box = await basket.locator('.rim').boundingBox();
  const from = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(...from);
  await page.mouse.down();
  for (let k = 1; k <= 8; ++k) await page.mouse.move(from[0] - 5 * k, from[1] + 3 * k);
  await page.locator('.camera-basket.dragged').waitFor();
  await page.mouse.up();
  await until('moved', async () => Math.hypot((await tray()).x_m - before.x_m, (await tray()).y_m - before.y_m) > 0.01);
  const moved = await tray();
  assert.ok(moved.x_m < before.x_m - 0.01, JSON.stringify([before, moved]));
  // What is drawn lies over what the camera sees of it: the drawn rim has moved with the pointer.
  const after = await basket.locator('.rim').boundingBox();
  assert.ok(Math.abs(after.x + after.width / 2 - (from[0] - 40)) < 6, `${after.x} ${box.x}`);
  await page.getByRole('button', { name: 'All into tray' }).click();
  await until('sorted', async () => (await job()).title === 'Sort cubes' && (await job()).over, 50, 180_000);
  assert.equal((await job()).phase, 'done', JSON.stringify((await job()).error));
  await until('both in the tray', async () => {
    const rows = await counts(page);
    return rows.some((row) => /Red\s+0\s+1/.test(row)) && rows.some((row) => /Blue\s+0\s+1/.test(row));
  });
  await here.close(page, 'table-sorted');
});

test('a basket is moved by numbers, and one that is out of reach says so', async () => {
  const page = await opened();
  const x = page.getByLabel('Basket, x in the cell');
  await x.fill('700');
  await x.press('Enter');
  const note = page.locator('.camera-place .callout');
  await note.waitFor();
  assert.match(await note.innerText(), /left: the basket is out of reach by \d+/i);
  assert.ok(Math.abs((await tray()).x_m - 0.7) < 1e-6);
  await x.fill('60');
  await x.press('Enter');
  await until('in reach', async () => (await note.count()) === 0);
  assert.ok(Math.abs((await tray()).x_m - 0.06) < 1e-6);
  await here.close(page, 'table-numbers');
});

test('on a telephone, in German', async () => {
  const page = await opened({ viewport: { width: 390, height: 844 }, locale: 'de-DE' });
  await page.locator('.camera-cannot').waitFor();
  assert.match(await page.locator('.camera-cannot').innerText(), /außer Reichweite.*Abhilfe: den Würfel näher/s);
  await page.getByRole('button', { name: 'Greifbereich' }).click();
  await page.locator('.camera-region path').first().waitFor({ state: 'attached' });
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(wide <= 0, `the page is ${wide} px too wide`);
  await here.close(page, 'table-telephone');
});
