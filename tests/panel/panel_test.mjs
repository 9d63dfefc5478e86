// The page in a browser against a simulated cell, and what the machines really did: through the page
// goes what a person does, through simulation.truth comes what is held against it.
//
//   node --test tests/panel/panel_test.mjs      (bench.mjs says what can be set)
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { apart, bench, patiently, rests, seen, truth, until, upright } from './bench.mjs';

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
const open = (options) => here.open(options);
const close = (page, name) => here.close(page, name);
const view = (page, name) => page.locator('.tabs a', { hasText: name }).click();

/** Where no joint is near its limit, ready, in the view of moves. */
async function stand() {
  const page = await here.shared();
  await upright(page, 'left');
  await page.locator('.card-face', { has: page.locator('text="left"') }).click();
  await view(page, 'Move');
  const reset = page.getByRole('button', { name: 'Back to where it stands' });
  if (await reset.isEnabled()) await reset.click();
  await page.locator('.slider-field', { hasText: 'Speed' }).locator('input').fill('0.5');
  return page;
}

test('what is previewed does not move before Move, and then goes there', () => patiently('preview', async () => {
  const page = await stand();
  const begin = await rests('left', 1e-3);
  await page.getByLabel('base, target').fill('40deg');
  await page.getByLabel('base, target').press('Enter');
  await page.locator('.verdict.fine').waitFor();
  await page.locator('.dock .plot canvas').waitFor();
  assert.ok(apart(await rests('left', 1e-3), begin) < 5e-3);
  const last = (await seen(page, 'left')).job?.job ?? 0;
  await page.locator('[data-tour=go]:enabled').click();
  await until('it ran', async () => {
    const { job } = await seen(page, 'left');
    return job?.job > last && job.over;
  });
  assert.equal((await seen(page, 'left')).job.phase, 'done');
  assert.ok(Math.abs((await rests('left', 1e-3))[0] - (40 * Math.PI) / 180) < 0.03);
  await close(page, 'preview');
}));

test('a target that is refused says why, and cannot be moved to', async () => {
  const page = await stand();
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

test('Space stops a motion under way, whatever has the focus', () => patiently('Space', async () => {
  const page = await stand();
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
  await until('the job has ended', async () => (await seen(page, 'left')).job?.over);
  assert.equal((await seen(page, 'left')).job.phase, 'stopped');
  await close(page, 'stop');
}));

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

test('an action that fails says so beside the button that was pressed, at every size', async () => {
  const page = await here.open({ viewport: { width: 1440, height: 900 } }, '#/robots/left/move');
  const button = page.locator('.card.chosen .card-actions button').first();
  await button.waitFor();
  await page.evaluate(() => (globalThis.__sinew.rpc.call = () => Promise.reject(new Error('not today'))));
  const card = page.locator('#pressed-note');
  const beside = () =>
    page.evaluate(() => {
      const a = document.querySelector('[aria-describedby=pressed-note]').getBoundingClientRect();
      const b = document.querySelector('#pressed-note').getBoundingClientRect();
      const apart = Math.max(b.top - a.bottom, a.top - b.bottom);
      const inside = b.left >= 0 && b.top >= 0 && b.right <= innerWidth && b.bottom <= innerHeight;
      const near = b.left <= a.right && b.right >= a.left;
      return { apart, inside, near, role: document.querySelector('#pressed-note').getAttribute('role') };
    });
  for (const [width, height] of [[1440, 900], [1024, 700], [390, 844]]) {
    await page.setViewportSize({ width, height });
    await button.scrollIntoViewIfNeeded();
    await button.click();
    await card.filter({ hasText: 'not today' }).waitFor();
    const { apart, ...found } = await beside();
    assert.deepEqual(found, { inside: true, near: true, role: 'alert' }, `${width} x ${height}`);
    assert.ok(apart >= 0 && apart < 12, `${apart} px away`);
    const shots = process.env.PANEL_SHOTS;
    if (shots) await page.screenshot({ path: `${shots}/pressed_${width}.png` });
  }
  // What is pressed next ends it; the list of all has it then.
  await page.evaluate(() => delete globalThis.__sinew.rpc.call);
  await page.locator('.card-face').first().click();
  await card.waitFor({ state: 'detached' });
  assert.equal(await page.locator('.notes .note', { hasText: 'not today' }).count(), 3);
  await close(page, 'pressed');
});
