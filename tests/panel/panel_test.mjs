// The page in a browser against a simulated cell, and what the machines really did: through the page
// goes what a person does, through simulation.truth comes what is held against it.
//
//   node --test tests/panel/panel_test.mjs      (bench.mjs says what can be set)
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { apart, bench, rests, seen, truth, until } from './bench.mjs';

const kCell = `title = "Tests"

[[robot]]
name = "left"
robot = "learm"
profile = "bus"

[[robot]]
name = "six"
robot = "hexapod"
x_mm = 1500
`;

let here;
before(async () => {
  here = await bench(kCell);
});
after(() => here?.end());
afterEach(() => here.clear());
const open = (options) => here.open(options);
const close = (page, name) => here.close(page, name);

const view = (page, name) => page.locator('.tabs a', { hasText: name }).click();
const robot = (page, name) =>
  page.locator('.card-face', { has: page.locator(`text="${name}"`) }).click();

async function enable(page, name) {
  await robot(page, name);
  if ((await seen(page, name)).state === 'off') await page.locator('.callout button.primary').click();
  await until(`${name} ready`, async () => (await seen(page, name)).state === 'ready');
}

/**
 * To where no joint is near its limit, by the page's own means. A computer with too much to do ends
 * motions that it could not watch over: then again.
 */
async function stand(page) {
  await enable(page, 'left');
  await view(page, 'Move');
  await until('the way home', async () => {
    await page.getByRole('button', { name: 'Home', exact: true }).click();
    await page.locator('[data-tour=go]:enabled').click();
    const before = (await seen(page, 'left')).job?.job ?? 0;
    await until('the end of the way home', async () => {
      const now = await seen(page, 'left');
      const other = (now.job?.job ?? 0) > 0 && now.job.job >= before && now.job.over;
      return other && now.state !== 'moving' && now.state !== 'recovering';
    });
    return Math.max(...(await truth('left')).map(Math.abs)) < 0.05;
  });
}

test('a held button jogs, and letting go stops', async () => {
  const page = await open();
  await stand(page);
  await view(page, 'Jog');
  const begin = await rests('left', 1e-3);
  const button = page.getByRole('button', { name: 'base plus', exact: true });
  const held = () => page.evaluate(() => document.querySelector('.jog-live').dataset.on === 'true');
  await until('moved by 3 deg', async () => {
    if (!(await held())) {
      await page.mouse.up();
      await button.hover();
      await page.mouse.down();
      await page.waitForTimeout(300);
    }
    return (await truth('left'))[0] - begin[0] > 0.05;
  });
  await page.mouse.up();
  assert.equal(await held(), false);
  const end = await rests('left', 1e-3);
  assert.ok(end[0] > begin[0] + 0.05 && end[0] < 1.4, `at ${end[0]} rad`);
  assert.ok(apart(end.slice(1), begin.slice(1)) < 0.02, 'only the base has moved');
  await close(page, 'jog');
});

test('what is previewed does not move before Move, and then goes there', async () => {
  const page = await open();
  await stand(page);
  const begin = await rests('left', 1e-3);
  await page.getByLabel('base, target').fill('40deg');
  await page.getByLabel('base, target').press('Enter');
  await page.locator('.verdict.fine').waitFor();
  await page.locator('.dock .plot canvas').waitFor();
  assert.ok(apart(await rests('left', 1e-3), begin) < 5e-3);
  await page.locator('[data-tour=go]:enabled').click();
  await until('there', async () => Math.abs((await truth('left'))[0] - (40 * Math.PI) / 180) < 0.03);
  await close(page, 'preview');
});

test('a target that is refused says why, and cannot be moved to', async () => {
  const page = await open();
  await stand(page);
  const begin = await rests('left', 1e-3);
  for (const [joint, value] of [['base', '50'], ['shoulder', '40'], ['elbow', '35']]) {
    await page.getByLabel(`${joint}, target`).fill(value);
    await page.getByLabel(`${joint}, target`).press('Enter');
  }
  await page.locator('.verdict.fine').waitFor();
  await page.getByLabel('X, target', { exact: true }).fill('600');
  await page.getByLabel('X, target', { exact: true }).press('Enter');
  const refusal = page.locator('.verdict.refused');
  await refusal.waitFor();
  assert.match(await refusal.innerText(), /out of reach by/);
  assert.ok(await page.locator('[data-tour=go]').isDisabled());
  await page.getByRole('button', { name: 'Show what would work' }).click();
  await page.locator('.verdict.fine').waitFor();
  assert.ok(apart(await rests('left', 1e-3), begin) < 5e-3);
  await close(page, 'refused');
});

test('Space stops a motion under way, whatever has the focus', async () => {
  const page = await open();
  await stand(page);
  await page.locator('.slider-field', { hasText: 'Speed' }).locator('input').fill('0.05');
  await page.getByLabel('base, target').fill('80deg');
  await page.getByLabel('base, target').press('Enter');
  await page.locator('.verdict.fine').waitFor();
  await page.locator('[data-tour=go]:enabled').click();
  const begin = await truth('left');
  await until('under way', async () => apart(await truth('left'), begin) > 0.03);
  await page.locator('.top-tools button').first().focus();
  await page.keyboard.press('Space');
  const end = await rests('left', 1e-3);
  assert.ok(end[0] < (75 * Math.PI) / 180, `stopped at ${end[0]} rad`);
  await until('the job has ended', async () => (await seen(page, 'left')).job?.phase === 'stopped');
  await close(page, 'stop');
});

test('another tab, without control, stops what this one moves', async () => {
  const page = await open();
  const other = await open();
  await stand(page);
  await page.locator('.slider-field', { hasText: 'Speed' }).locator('input').fill('0.05');
  await page.getByLabel('base, target').fill('80deg');
  await page.getByLabel('base, target').press('Enter');
  await page.locator('.verdict.fine').waitFor();
  await page.locator('[data-tour=go]:enabled').click();
  const begin = await truth('left');
  await until('under way', async () => apart(await truth('left'), begin) > 0.03);
  await other.getByRole('button', { name: 'Stop', exact: true }).click();
  const end = await rests('left', 1e-3);
  assert.ok(end[0] < (75 * Math.PI) / 180, `stopped at ${end[0]} rad`);
  await close(other, 'other_tab');
  await close(page, 'stopped_by_other');
});

test('speaks German, keeps its language, and says its states to a screen reader', async () => {
  const page = await open({ locale: 'de-DE', colorScheme: 'light' });
  assert.equal(await page.locator('button.stop').innerText(), 'Stopp');
  assert.equal(await page.evaluate(() => document.documentElement.lang), 'de');
  assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), 'light');
  assert.equal(await page.locator('[aria-live=assertive]').count(), 1);
  await page.locator('button.stop').click();
  await until('told', async () =>
    (await page.locator('[aria-live=assertive]').innerText()).includes('Stopp an alle'));
  assert.ok(!(await page.url()).includes('token'));
  await close(page, 'german');
});

test('the cell is drawn within its bounds', async () => {
  const page = await open();
  await until('drawn', () => page.evaluate(() => globalThis.sinewScene?.frames.length > 3));
  const triangles = await page.evaluate(() => globalThis.sinewScene.triangles);
  assert.ok(triangles > 1000 && triangles < 200_000, String(triangles));
  await close(page, 'scene');
});
