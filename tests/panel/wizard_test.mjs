// Setup and plots in a browser against a simulated cell: what the page asks, what the machines really
// did, what was found and kept.
//
//   node --test tests/panel/wizard_test.mjs     (environment: bench.mjs)
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { gunzipSync } from 'node:zlib';
import { apart, ask, bench, patiently, ready, rests, root, shown, status, truth, until, upright } from './bench.mjs';

const kCell = `title = "Tests"

[[robot]]
name = "left"
robot = "learm"
profile = "bus"

[[robot]]
name = "spare"
robot = "learm"
profile = "bus"
y_mm = 900

[[robot]]
name = "third"
robot = "learm"
profile = "bus"
y_mm = -900

[[robot]]
name = "six"
robot = "hexapod"
x_mm = 1500

[[robot]]
name = "arm"
robot = "robot-arm-2"
x_mm = -2000
time_scale = 60
`;

let here, folder;
before(async () => {
  folder = mkdtempSync(path.join(tmpdir(), 'sinew-wizard-'));
  here = await bench(kCell);
});
after(async () => {
  await here?.end();
  rmSync(folder, { recursive: true, force: true });
});
afterEach(() => here.clear());

const procedure = (robot) => ask('procedure.status', { robot });
const press = (page, name) => page.locator('.question').getByRole('button', { name, exact: true }).click();
/** Until this step is asked about, with these words to answer by. */
const asked = (robot, step, choice) =>
  until(`asked: ${step}`, async () => {
    const now = await procedure(robot);
    assert.ok(!now.over, `over at ${now.step?.id}: ${now.trouble}`);
    const fits = now.step?.id === step && now.asks?.ready;
    return fits && (!choice || now.asks.choices.includes(choice)) && now;
  }, 100);

test('commissioning: nothing moves before Go, behind a reload it goes on at its step, what was found is kept', async () => {
  const page = await here.open();
  // What was answered is kept: another one, where it has to be tried again.
  await patiently('commissioning', (attempt) => commission(page, ['left', 'spare', 'third'][attempt - 1]));
  await here.close(page, 'commissioning');
});

async function commission(page, robot) {
  await page.evaluate((name) => void (location.hash = `#/robots/${name}/setup`), robot);
  await page.getByRole('button', { name: 'Begin, or go on' }).click();
  await asked(robot, 'supply');
  await press(page, 'Yes, it is so');
  await asked(robot, 'clear');
  await press(page, 'Yes, it is so');
  await asked(robot, 'first_move');
  const begin = await rests(robot, 1e-3);

  // It belongs to the controller: the page finds it at its step when it is there again.
  await page.reload();
  await shown(page);
  await page.getByText('It waits at this step').waitFor();
  const left = await procedure(robot);
  assert.equal(left.client_lost, true);
  assert.equal(left.step.id, 'first_move');
  assert.ok(apart(await truth(robot), begin) < 5e-3, 'nothing has moved');
  await page.getByRole('button', { name: 'Go on here' }).click();
  await asked(robot, 'first_move');
  await until('the answers are kept', async () => (await page.locator('.look-done').count()) >= 3);
  assert.ok(apart(await rests(robot, 1e-3), begin) < 5e-3, 'nothing has moved yet');
  await press(page, 'Go');

  const words = { base: 'Right', shoulder: 'Forward', elbow: 'Forward', wrist: 'Forward', roll: 'Left' };
  for (const [i, [joint, word]] of Object.entries(Object.entries(words))) {
    await asked(robot, `direction.${joint}`, 'go');
    const rest = await rests(robot, 1e-3);
    await until(`${joint} is marked`, () =>
      page.evaluate((k) => globalThis.sinewScene.mark?.of.joint === k, Number(i)));
    await press(page, 'Go');
    await asked(robot, `direction.${joint}`, 'nothing');
    const went = (await truth(robot)).map((one, k) => Math.abs(one - rest[k]));
    assert.ok(went[i] > 0.08 && went[i] < 0.2, `${joint} went ${went[i]} rad`);
    went.splice(Number(i), 1);
    assert.ok(Math.max(...went) < 0.04, 'no other joint');
    await press(page, word);
  }
  await asked(robot, 'jaws', 'go');
  await press(page, 'Go');
  await asked(robot, 'jaws_seen');
  await press(page, 'They are open');
  await asked(robot, 'trim.base');
  const field = page.locator('.answer-field input');
  await field.fill('20');
  await press(page, 'Answer');
  await page.getByText('It has to be between −15.0 ° and 15.0 °.').waitFor();
  assert.equal((await procedure(robot)).step.id, 'trim.base', 'nothing was answered');
  await field.fill('2,5');
  await press(page, 'Answer');
  for (const joint of ['shoulder', 'elbow', 'wrist', 'roll']) {
    await asked(robot, `trim.${joint}`);
    await press(page, 'Skip');
  }
  await page.getByText('Commissioning: done').waitFor();
  await page.getByText('base, sense of rotation').waitFor();
  await page.getByText('2.50°').waitFor();
  const end = await procedure(robot);
  assert.equal(end.settings['joint.base.turn'], 'other');
  assert.ok(Math.abs(Number(end.settings['joint.base.trim_rad']) - (2.5 * Math.PI) / 180) < 1e-6);
  const kept = JSON.parse(readFileSync(end.file, 'utf8'));
  assert.equal(kept.finished, true);
  assert.deepEqual(kept.settings, end.settings);
  assert.equal(Object.keys(kept.settings).length, 2, JSON.stringify(kept.settings));
}

test('recovery: a leg goes by the amount that was pressed, and Space stops it with its question', async () => {
  const page = await here.open({}, '#/robots/six/setup');
  await patiently('recovery', async () => {
    if ((await status('six')).state === 'fault') await ready(page, 'six');
    await recover(page);
  });
  await here.close(page, 'recovery');
});

test('who watches a procedure sees its question and answers none', async () => {
  const page = await here.open({}, '#/robots/six/setup');
  // Somebody who is no page: what it asks for ends with its connection, at once.
  const watched = page.getByText('you watch');
  await until('seen', async () => {
    // Refused while the one of the turn before is still under way.
    const begun = ask('procedure.start', { robot: 'six', kind: 'recover' }).catch(() => undefined);
    const seen = await watched.waitFor({ timeout: 900 }).then(() => true, () => false);
    const locked = seen && (await page.locator('fieldset.answers').evaluateAll((all) => all.every((one) => one.disabled)));
    await begun;
    return locked;
  });
  await here.close(page, 'watched');
});

async function recover(page) {
  await page.getByRole('button', { name: 'Begin recovery' }).click();
  // Until it has begun, the one before is what the cell tells.
  await until('begun', async () => !(await procedure('six')).over, 20);
  await asked('six', 'adjust.leg1');
  const begin = await rests('six', 1e-6);
  await page.locator('.answer-field input').fill('11');
  await press(page, 'Move');
  await page.getByText('It has to be between').waitFor();
  await page.getByRole('button', { name: 'Move by −0.1 mm', exact: true }).click();
  await until('leg1 has gone', async () => (await procedure('six')).phase === 'working', 30);
  await asked('six', 'adjust.leg1');
  const there = await rests('six', 1e-6);
  assert.ok(Math.abs(there[0] - begin[0] + 1e-4) < 1.5e-5, `leg1 went ${(there[0] - begin[0]) * 1e3} mm`);
  assert.ok(apart(there.slice(1), begin.slice(1)) < 1e-5, 'no other leg');

  await page.getByRole('button', { name: 'Move by −2 mm', exact: true }).click();
  await page.locator('.question-progress').waitFor();
  await until('under way', async () => (await truth('six'))[0] < there[0] - 2e-5);
  await page.keyboard.press('Space');
  await page.locator('.question-trouble', { hasText: 'stopped on the way' }).waitFor();
  const stopped = await rests('six', 1e-6);
  assert.ok(stopped[0] > there[0] - 1.5e-3, `stopped ${(stopped[0] - there[0]) * 1e3} mm on`);
  await asked('six', 'adjust.leg1');
  for (let leg = 1; leg <= 6; ++leg) {
    await asked('six', `adjust.leg${leg}`);
    await press(page, 'It stands right');
  }
  await asked('six', 'place');
  await press(page, 'Back');
  await asked('six', 'adjust.leg6');
  await press(page, 'It stands right');
  await asked('six', 'place');
  await page.getByRole('button', { name: 'At its home' }).click();
  await page.locator('.question-trouble', { hasText: 'leg1 cannot stand at' }).waitFor();
  await page.locator('.answer-reason input').fill('put there by hand');
  await page.getByRole('button', { name: 'At its home' }).click();
  await page.getByText('Recovery: done').waitFor();
}

test('homing: each joint is marked as it looks for its end stop, Space stops the search with its question', async () => {
  const page = await here.open({}, '#/robots/arm/setup');
  await patiently('homing', async () => {
    await ready(page, 'arm');
    await page.getByRole('button', { name: 'Begin homing' }).click();
    await asked('arm', 'clear');
    const rest = await rests('arm', 1e-4);
    await press(page, 'Yes, it is so');
    await asked('arm', 'search', 'go');
    assert.ok(apart(await rests('arm', 1e-4), rest) < 1e-4, 'a question moves nothing');
    await press(page, 'Go');
    await page.locator('.question-progress').waitFor();
    await until('a joint is marked', () => page.evaluate(() => globalThis.sinewScene.mark?.of.joint >= 0));
    await until('it searches', async () => apart(await truth('arm'), rest) > 0.05);
    await page.keyboard.press('Space');
    await page.locator('.question-trouble').waitFor();
    const stopped = await rests('arm', 1e-4);
    await page.waitForTimeout(500);
    assert.ok(apart(await truth('arm'), stopped) < 1e-4, 'nothing goes on by itself');
    assert.equal((await status('arm')).position, 'lost', 'half a search finds nothing');
    await asked('arm', 'search', 'go');
    await press(page, 'Go');
    await asked('arm', 'again');
    await press(page, 'Skip');
    await asked('arm', 'home', 'go');
    await press(page, 'Go');
    await page.getByText('Homing: done').waitFor();
  });
  const now = await status('arm');
  assert.notEqual(now.position, 'lost');
  const stands = await rests('arm', 1e-4);
  for (const [i, joint] of now.joints.entries()) {
    assert.ok(Math.abs((joint.position_rad ?? joint.commanded_rad) - stands[i]) < 0.01, `${joint.name} is where it is said to be`);
  }
  await here.close(page, 'homing');

  // The same arm's page has what its registers say.
  const device = await here.open({}, '#/robots/arm/device');
  const first = device.locator('.device-part', { has: device.locator('h4', { hasText: /^base$/ }) });
  await first.waitFor();
  const registers = first.locator('table.registers tbody tr');
  await until('registers', async () => (await registers.count()) > 1);
  const rows = await registers.evaluateAll((all) => all.map((row) => [...row.children].map((cell) => cell.textContent)));
  const told = (await ask('device.status', { robot: 'arm' })).axes[0];
  assert.deepEqual(rows.map(([name]) => name.split(' ')[0]), told.registers.map((one) => one.register.toUpperCase()));
  assert.ok(rows.every(([, , raw]) => /^[0-9A-F]{2}( [0-9A-F]{2})*$/i.test(raw)), JSON.stringify(rows));
  await here.close(device, 'registers');
});

test('plots: what moved is in the picture and in its table', async () => {
  const page = await here.open({}, '#/robots/third/plots');
  await page.getByLabel('Velocity').check();
  await page.getByLabel('Tracking error').uncheck();
  await upright(page, 'third');
  await patiently('plots', async () => {
    await upright(page, 'third');
    assert.ok(await page.evaluate(() => globalThis.__sinew.store.run('third', 'joint base=20deg speed=40%', 'test')));
    const end = await until('over', async () => {
      const job = await ask('job.status', { robot: 'third' });
      return job.over && job;
    });
    assert.equal(end.phase, 'done', JSON.stringify(end));
  });
  await rests('third', 1e-3);
  await page.waitForTimeout(600); // of rest, so that the picture ends in it
  await page.getByRole('button', { name: 'Pause', exact: true }).click();
  assert.equal(await page.locator('.chart').count(), 2);
  const [download] = await Promise.all([
    page.waitForEvent('download'),
    page.getByRole('button', { name: 'CSV of what is seen' }).click(),
  ]);
  const rows = readFileSync(await download.path(), 'utf8').trim().split('\n').map((row) => row.split(','));
  const column = (name) => {
    const at = rows[0].indexOf(name);
    assert.ok(at > 0, `${name} in ${rows[0]}`);
    return rows.slice(1).map((row) => (row[at] === '' ? NaN : Number(row[at])));
  };
  const base = column('third.base.position_deg');
  const speed = column('third.base.velocity_deg_s').filter((one) => !Number.isNaN(one));
  const end = (await truth('third'))[0];
  assert.ok(Math.abs(base.at(-1) - (end * 180) / Math.PI) < 0.6, `${base.at(-1)} and ${end} rad`);
  assert.ok(base.at(-1) - Math.min(...base) > 17, 'the way is in it');
  // 40 % of 180 deg/s is not reached on so short a way; it went, and it rests.
  assert.ok(Math.max(...speed) > 15 && Math.max(...speed) < 100, `${Math.max(...speed)} deg/s`);
  // The last four have neighbours on one side only: one step of the sensor, 0.24 deg, is 4 deg/s there.
  assert.ok(Math.abs(speed.at(-5)) < 1.5, `${speed.slice(-9)} deg/s at rest`);
  // The picture stands while it is held.
  const held = await page.locator('.chart output').first().innerText();
  await page.waitForTimeout(700);
  assert.equal(await page.locator('.chart output').first().innerText(), held);
  await here.close(page, 'plots');
});

test('a record is played in the 3D view, and no machine moves by that', async () => {
  const page = await here.open({}, '#/robots/left/plots');
  const before = [await rests('left', 1e-3), await rests('six', 1e-6)];
  await page.getByRole('radio', { name: 'Record' }).click();
  const bytes = gunzipSync(readFileSync(path.join(root, 'panel/src/logic/hexapod.fixture.mcap.gz')));
  const good = path.join(folder, 'leg.mcap');
  writeFileSync(good, bytes);
  const bad = path.join(folder, 'bad.mcap');
  const digit = bytes.indexOf('"position_m":0.') + '"position_m":0.'.length;
  bytes[digit] ^= 1;
  writeFileSync(bad, bytes);
  await page.locator('input[type=file]').setInputFiles(bad);
  await page.getByText('It is damaged').waitFor();
  await page.locator('input[type=file]').setInputFiles(good);
  await page.getByText('927 samples').waitFor();
  assert.equal(await page.locator('.record-on select').inputValue(), 'six');
  const time = page.getByLabel('Time in the record');
  await time.focus();
  await page.keyboard.press('End');
  await until('the ghost', () => page.evaluate(() => globalThis.sinewScene.ghost?.robot === 'six'));
  await page.keyboard.press('Home');
  await page.getByRole('button', { name: 'Play the record' }).click();
  await until('it plays', async () => Number(await time.inputValue()) > 0.5);
  await page.getByRole('button', { name: 'Pause the record' }).click();
  assert.ok(apart(await truth('left'), before[0]) < 5e-3);
  assert.ok(apart(await truth('six'), before[1]) < 1e-5);
  await here.close(page, 'record');
});
