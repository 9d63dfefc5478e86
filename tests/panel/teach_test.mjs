// Points, programs and rides in a browser against a simulated cell: what a person does goes through the
// page, where the machine really is comes from simulation.truth.
//
//   node --test tests/panel/teach_test.mjs      (bench.mjs says what can be set)
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { apart, bench, patiently, rests, seen, truth, until, upright } from './bench.mjs';

const kCell = `title = "Tests"

[[robot]]
name = "left"
robot = "learm"
profile = "bus"
`;
const deg = (value) => (value * Math.PI) / 180;

let here;
before(async () => {
  here = await bench(kCell);
});
after(() => here?.end());

const toTab = (page, name) => page.locator('.programs').getByRole('radio', { name, exact: true }).click();
const textOf = (page) => page.getByLabel('Text of the program').inputValue();
const write = (page, text) => page.getByLabel('Text of the program').fill(text);
const fine = (page) => page.locator('.run-bar .verdict.fine').waitFor();
const face = (page, line) => page.locator(`li[data-line="${line}"] .step-face`);
const over = async (page) => {
  const { job, state } = await seen(page, 'left');
  return job && job.over && state !== 'moving' && job;
};

/** The view of programs, without the tour, the robot enabled and upright at its zeros. */
async function stand() {
  const page = await here.shared({ viewport: { width: 1440, height: 900 } });
  const skip = page.locator('[data-tour=skip]');
  if (await skip.isVisible()) await skip.click();
  await page.locator('.tabs a', { hasText: 'Programs' }).click();
  await toTab(page, 'Program');
  await upright(page, 'left');
  return page;
}

/** What moves is watched over in real time. */
const moves = (name, go) => test(name, () => patiently(name, go));

moves('a point that was taken is where the arm was, and is gone to only behind Move', async () => {
  const page = await stand();
  await toTab(page, 'Points');
  await page.getByLabel('Name of the point').fill('up');
  await page.locator('[data-tour=take]').click();
  await page.locator('.point', { hasText: 'up' }).waitFor();
  await toTab(page, 'Program');
  await write(page, 'joint base=30deg shoulder=20deg\n');
  await fine(page);
  await page.locator('[data-tour=run]:enabled').click();
  await until('there', async () => Math.abs((await truth('left'))[0] - deg(30)) < 0.03 && over(page));
  const begin = await rests('left', 1e-3);
  await toTab(page, 'Points');
  await page.getByRole('button', { name: 'Go to' }).click();
  await page.locator('.point-way .verdict.fine').waitFor();
  assert.ok(apart(await rests('left', 1e-3), begin) < 5e-3, 'a preview moves nothing');
  await page.locator('[data-tour=point-go]:enabled').click();
  await until('back at the point', async () => Math.max(...(await truth('left')).map(Math.abs)) < 0.05);
  // What a file of it says is what sinew run reads.
  const [file] = await Promise.all([
    page.waitForEvent('download'),
    page.getByRole('button', { name: 'Save the points as points.toml' }).click(),
  ]);
  assert.match(readFileSync(await file.path(), 'utf8'), /^\[points\.up\]\nrobot = "learm"\njoints_deg = \[/);
  await here.close(page, 'teach_points');
});

test('a program is changed by its rows and by its text, and both are one', async () => {
  const page = await stand();
  await write(page, '# it\nwait 1s\nloop 2\n  joint base=10deg  # a\nend\n');
  await fine(page);
  await face(page, 4).click();
  const base = page.locator('.row-field', { hasText: 'base' }).locator('input');
  await base.fill('200');
  await base.press('Enter');
  assert.match(await page.locator('.row-fields .wrong-words').innerText(), /At most 90deg/);
  assert.match(await textOf(page), /base=10deg {2}# a/);
  await base.fill('0,5rad');
  await base.press('Enter');
  assert.equal(await textOf(page), '# it\nwait 1s\nloop 2\n  joint base=0.5rad  # a\nend\n');
  // By the keyboard the wait goes into the loop, and out behind it.
  await page.locator('li[data-line="2"] .grip').press('ArrowDown');
  assert.equal(await textOf(page), '# it\nloop 2\n  wait 1s\n  joint base=0.5rad  # a\nend\n');
  // Dragged by its handle to before the loop.
  const from = await page.locator('li[data-line="3"] .grip').boundingBox();
  const to = await page.locator('li[data-line="2"] .step-row').boundingBox();
  await page.mouse.move(from.x + 8, from.y + 10);
  await page.mouse.down();
  await page.mouse.move(to.x + 20, to.y + 2, { steps: 4 });
  await page.mouse.up();
  assert.equal(await textOf(page), '# it\nwait 1s\nloop 2\n  joint base=0.5rad  # a\nend\n');
  await page.locator('[data-tour=add-step]').click();
  await page.locator('.add-words button', { hasText: 'jaws' }).click();
  assert.match(await textOf(page), /wait 1s\njaws 20mm\nloop 2/);
  await page.getByRole('button', { name: 'Undo' }).click();
  assert.ok(!(await textOf(page)).includes('jaws'));
  await page.getByLabel('Name', { exact: false }).first().fill('mine');
  await page.getByRole('button', { name: 'Save', exact: true }).click();
  await page.reload();
  await page.waitForSelector('.card-name');
  await page.locator('select.open option', { hasText: 'mine' }).waitFor({ state: 'attached' });
  assert.match(await textOf(page), /base=0.5rad/);
  await here.close(page, 'teach_rows');
});

moves('a program goes to points that were taught, where the arm was when they were', async () => {
  const page = await stand();
  const places = {};
  for (const [name, angle] of [['near', 15], ['far', -25]]) {
    await toTab(page, 'Program');
    await write(page, `joint base=${angle}deg shoulder=20deg elbow=30deg\n`);
    await fine(page);
    await page.locator('[data-tour=run]:enabled').click();
    await until(name, async () => Math.abs((await truth('left'))[0] - deg(angle)) < 0.03 && over(page));
    places[name] = await rests('left', 1e-3);
    await toTab(page, 'Points');
    await page.getByLabel('Name of the point').fill(name);
    await page.locator('[data-tour=take]').click();
    await page.locator('.point', { hasText: name }).waitFor();
  }
  await toTab(page, 'Program');
  await write(page, 'joint to=near\nwait 1s\njoint to=far speed=50%\nmove to=near\n');
  await fine(page);
  const last = (await seen(page, 'left')).job.job;
  await page.locator('[data-tour=run]:enabled').click();
  await until('at the first one', async () => apart(await truth('left'), places.near) < 0.03);
  await until('over', async () => (await over(page))?.job > last);
  assert.equal((await over(page)).phase, 'done');
  assert.ok(apart(await rests('left', 1e-3), places.near) < 0.03);
  await here.close(page, 'teach_points');
});

test('a row that is refused says so where it stands, and nothing runs', async () => {
  const page = await stand();
  const begin = await rests('left', 1e-3);
  await write(page, 'joint base=10deg\njoint shoulder=40deg elbow=30deg\nline z=900mm\nline dz=10mm\n');
  await page.locator('li[data-line="3"][data-verdict=refused]').waitFor();
  assert.match(await page.locator('li[data-line="3"] .step-why').innerText(), /out of reach by/);
  assert.equal(await page.locator('li[data-verdict=fine]').count(), 2);
  assert.equal(await page.locator('li[data-line="4"]').getAttribute('data-verdict'), 'unchecked');
  assert.ok(await page.locator('[data-tour=run]').isDisabled());
  await write(page, 'joint to=nowhere\n');
  await page.locator('.verdict.refused', { hasText: 'There is no point nowhere.' }).waitFor();
  await write(page, 'jump\n');
  await page.locator('.verdict.refused', { hasText: 'unknown step' }).waitFor();
  assert.ok(apart(await rests('left', 1e-3), begin) < 5e-3);
  await here.close(page, 'teach_refused');
});

moves('a program is stepped, paused, and its running row is marked; Space stops it', async () => {
  const page = await stand();
  await write(page, 'joint base=10deg\njoint base=20deg\njoint base=85deg speed=5%\n');
  await fine(page);
  await page.locator('[data-tour=step]:enabled').click();
  const paused = () => until('paused', async () => (await seen(page, 'left')).job?.phase === 'paused');
  await paused();
  const first = await rests('left', 1e-3);
  assert.ok(Math.abs(first[0] - deg(10)) < 0.03, `one order: ${first[0]} rad`);
  await page.locator('[data-tour=step]').click();
  await until('the second order', async () => Math.abs((await truth('left'))[0] - deg(20)) < 0.03);
  await paused();
  await page.locator('[data-tour=resume]').click();
  await page.locator('li[data-line="3"][data-running=true]').waitFor();
  await until('under way', async () => (await truth('left'))[0] > deg(23));
  await page.locator('.top-tools button').first().focus();
  await page.keyboard.press('Space');
  const end = await rests('left', 1e-3);
  assert.ok(end[0] < deg(80), `stopped at ${end[0]} rad`);
  await until('the job has ended', async () => (await seen(page, 'left')).job?.phase === 'stopped');
  await here.close(page, 'teach_steps');
});

moves('a program is run from one of its rows', async () => {
  const page = await stand();
  await write(page, 'joint base=60deg\njoint shoulder=15deg\n');
  await fine(page);
  await face(page, 2).click();
  await page.locator('[data-tour=run-from]:enabled').click();
  await until('there', async () => Math.abs((await truth('left'))[1] - deg(15)) < 0.03);
  const end = await rests('left', 1e-3);
  assert.ok(Math.abs(end[0]) < 0.03, 'the first row was left out');
  await here.close(page, 'teach_from_line');
});

moves('a ride moves, and ends when told', async () => {
  const page = await stand();
  await toTab(page, 'Bull ride');
  const begin = await truth('left');
  await page.locator('[data-tour=ride]:enabled').click();
  await until('under way', async () => apart(await truth('left'), begin) > 0.1);
  await page.getByRole('button', { name: 'End the ride' }).click();
  await until('over', () => over(page));
  await rests('left', 1e-3);
  await here.close(page, 'teach_ride');
});

test('the tour comes once, has five steps, and is called again from help', async () => {
  const page = await here.open({ viewport: { width: 1024, height: 768 } });
  const tour = page.locator('.tour');
  await tour.waitFor();
  for (let step = 1; step <= 5; ++step) {
    await tour.getByText(`${step} of 5`).waitFor();
    // It covers neither Stop nor the controls.
    const box = await tour.boundingBox();
    const pane = await page.locator('.pane').boundingBox();
    assert.ok(box.x + box.width <= pane.x && box.y > 60, 'beside the controls');
    await tour.locator('button.primary').click();
  }
  await tour.waitFor({ state: 'detached' });
  await page.reload();
  await page.waitForSelector('.card-name');
  await page.locator('.tabs a', { hasText: 'Help' }).click();
  assert.equal(await tour.count(), 0);
  await page.locator('dl.facts').first().waitFor();
  await page.getByRole('radio', { name: 'About' }).click();
  assert.match(await page.locator('.about').innerText(), /Version \d+\.\d+\.\d+/);
  await page.getByRole('button', { name: 'Show the tour' }).click();
  await tour.waitFor();
  await here.close(page, 'teach_tour');
});
