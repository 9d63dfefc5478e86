// What a newcomer meets first: robots that show what they can do, and stop for whoever takes over.
//
//   node --test tests/panel/demonstration_test.mjs      (bench.mjs says what can be set)
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { apart, ask, bench, rests, status, truth, until } from './bench.mjs';

const kNames = ['left', 'big', 'six'];
const kCell = `title = "Shown"

[[robot]]
name = "left"
robot = "learm"
profile = "bus"

[[robot]]
name = "big"
robot = "bigrobotarm"
x_mm = 2000

[[robot]]
name = "six"
robot = "hexapod"
x_mm = 4000
time_scale = 200
`;

let here;
before(async () => {
  here = await bench(kCell, ['--demo']);
});
after(() => here?.end());
afterEach(() => here.clear());

const banner = (page) => page.getByText('The robots show what they can do.');

/** Each has really gone from where it was. */
async function allMove() {
  const from = Object.fromEntries(await Promise.all(kNames.map(async (name) => [name, await truth(name)])));
  const still = new Set(kNames);
  await until(() => `a motion of ${[...still]}`, async () => {
    for (const name of still) {
      const far = name === 'six' ? 1e-4 : 0.01; // m, rad
      if (apart(await truth(name), from[name]) > far) still.delete(name);
    }
    return still.size === 0;
  }, 100);
}

test('the demonstration moves every robot, says so, and ends for who takes one: all of them rest first', async () => {
  const page = await here.open();
  await banner(page).waitFor();
  await allMove();
  assert.match(await page.locator('.card', { hasText: 'six' }).first().innerText(), /×\s?200|200\s?×|x200/);

  // What anybody does: an arm is chosen, and a key of its jog is held.
  await page.evaluate(() => void (location.hash = '#/robots/left/jog'));
  await page.evaluate(() => globalThis.__sinew.store.control('left', true));
  await banner(page).waitFor({ state: 'detached' });
  const resting = Object.fromEntries(await Promise.all(kNames.map(async (name) => [name, await rests(name, 1e-5)])));
  assert.equal((await ask('cell.status')).demonstration, undefined);
  await page.waitForTimeout(3000);
  for (const name of kNames) {
    assert.ok(apart(await truth(name), resting[name]) < 1e-3, `${name} has not begun again`);
    assert.notEqual((await status(name)).state, 'moving');
  }
  // It is the visitor's now. An arm that was taken over a cube may have no way aside, and says so.
  const rows = [`joint base=${resting.left[0] > 0 ? -20 : 20}deg`, `joint roll=${resting.left[4] > 0 ? -30 : 30}deg`, 'home'];
  let job;
  for (const row of rows) {
    await until('an arm that obeys', () => page.evaluate((text) => globalThis.__sinew.store.run('left', text, 'mine'), row));
    await until('an end', async () => (job = (await status('left')).job).over && job.title === 'mine');
    if (job.phase === 'done') break;
  }
  assert.ok(apart(await truth('left'), resting.left) > 0.1, JSON.stringify(job));
  for (const name of ['big', 'six']) assert.ok(apart(await truth(name), resting[name]) < 1e-3, `${name} rests on`);
  await here.close(page, 'demonstration');
});
