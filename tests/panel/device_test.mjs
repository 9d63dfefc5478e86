// What a device says of itself, and every byte of its wire, in a browser: held against the simulated
// machine behind the port, against the log of its own end of the wire, and against the truth.
//
//   node --test tests/panel/device_test.mjs      (bench.mjs says what can be set)
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { ask, bench, root, seen, until } from './bench.mjs';

/** `sinew sim`: a machine on a port of its own, which shows its truth when it is asked. */
function machine(robot, fault, log) {
  const program = process.env.SINEW ?? path.join(root, 'build/release/sinew');
  const child = spawn(program, ['sim', robot, '--json', '--fault', fault, '--log', log]);
  const told = [];
  let rest = '';
  child.stdout.on('data', (data) => {
    const lines = (rest + data).split('\n');
    rest = lines.pop();
    told.push(...lines.filter((line) => line.startsWith('{')).map((line) => JSON.parse(line)));
  });
  return {
    port: () => until('the port', () => told[0]?.port),
    truth: async () => {
      const before = told.length;
      child.stdin.write('\n');
      return (await until('the truth', () => told[before])).truth;
    },
    /** Its log is whole then. */
    end: () => new Promise((ended) => {
      child.on('exit', ended);
      child.kill('SIGINT');
    }),
  };
}

let here, six, loose, board, folder;
before(async () => {
  folder = mkdtempSync(path.join(tmpdir(), 'sinew-device-'));
  six = machine('hexapod', 'supply=6.8V@0s', path.join(folder, 'six.log'));
  loose = machine('hexapod', 'lead=J3:loose@0s', path.join(folder, 'loose.log'));
  board = machine(path.join(root, 'robots/examples/ar4-grbl.toml'), 'probe=J2@1deg@0s', path.join(folder, 'board.log'));
  here = await bench(`title = "Devices"

[[robot]]
name = "six"
robot = "hexapod"
port = "${await six.port()}"

[[robot]]
name = "loose"
robot = "hexapod"
x_mm = 4000
port = "${await loose.port()}"

[[robot]]
name = "six-axes"
robot = "${path.join(root, 'robots/examples/ar4-grbl.toml')}"
x_mm = 6000
port = "${await board.port()}"

[[robot]]
name = "left"
robot = "learm"
profile = "bus"
x_mm = 1500

[[robot]]
name = "big"
robot = "bigrobotarm"
wire = "framed"
x_mm = 9000

[[robot]]
name = "axes"
robot = "robot-arm-2"
wire = "link"
x_mm = 12000
`);
});
after(async () => {
  await here?.end();
  await six?.end();
  await loose?.end();
  await board?.end();
  if (folder) rmSync(folder, { recursive: true, force: true });
});
afterEach(() => here.clear());

const at = (name, options = {}) => here.open({ acceptDownloads: true, ...options }, `#/robots/${name}/device`);
const count = async (page) => Number(/^[\d.,]+/.exec(await page.locator('.wire-foot [role=status]').innerText())[0].replace(/\D/g, ''));
/** The part of the page with this head. */
const part = (page, name) => page.locator('.device-part', { has: page.locator('h4', { hasText: new RegExp(`^${name}$`) }) });
/** The saved file's rows: which way, and the bytes. */
async function saved(page) {
  const [download] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Save' }).click()]);
  const rows = readFileSync(await download.path(), 'utf8').split('\n').filter((row) => row && !row.startsWith('#'));
  return rows.map((row) => {
    const [, time, way, hex] = /^\s*([\d.]+) {2}(host -> device|device -> host) {2}\S+ {2}((?:[0-9A-F]{2} ?)+) {2}/.exec(row);
    return { time: Number(time), way, hex };
  });
}

test('a BigRobotArm with our firmware: its steps, what they count from, its port, and frames that are read', async () => {
  const page = await at('big');
  await page.evaluate(() => void globalThis.__sinew.store.enable('big'));
  const steps = part(page, 'Step counters');
  await steps.getByText('at rest').waitFor();
  await steps.getByText('what a host has set').waitFor();
  const firmware = part(page, 'Firmware');
  await firmware.getByText('0 bytes lost, 0 damaged frames').waitFor();
  const told = await ask('device.status', { robot: 'big' });
  assert.deepEqual(told.arm.joints.map((one) => one.steps), [0, 0, 0, 0, 0]);
  await here.close(page, 'device_arm_link');
});

test('boards of the axis link: the magnets of their encoders, and how their answers came', async () => {
  const page = await at('axes');
  await page.evaluate(() => void globalThis.__sinew.store.enable('axes'));
  await part(page, 'base').getByText('motor good', { exact: true }).waitFor();
  await part(page, 'forearm_roll').getByText('motor good, joint good').waitFor();
  const { axes } = (await ask('device.status', { robot: 'axes' }));
  assert.deepEqual(axes.map((axis) => axis.health.joint_magnet), [undefined, undefined, undefined, 'good', 'good', 'good']);
  assert.ok(axes.every((axis) => axis.late_frames === 0 && axis.failed_frames < 8));
  await here.close(page, 'device_axis_link');
});

test('a hexapod with a failing supply: flags, twelve bytes and what to do, as the machine has them', async () => {
  const page = await at('six');
  await page.getByText('Nothing that the device complains of').waitFor();
  assert.match(await part(page, 'leg1').innerText(), /not told yet/);
  await page.evaluate(() => void globalThis.__sinew.store.enable('six'));
  const warning = page.locator('.device-warning', { hasText: 'Supply too low' });
  await warning.waitFor();
  // A leg is asked behind the other.
  await until('all six tell', async () => (await warning.innerText()).includes('leg1, leg2, leg3, leg4, leg5, leg6'));
  assert.match(await warning.innerText(), /Look at the supply and its wires/);
  assert.ok(Math.abs((await six.truth()).supply_v - 6.8) < 1e-6, 'that is how it is');
  const told = await ask('device.status', { robot: 'six' });
  for (const leg of told.legs) {
    const bytes = leg.bytes.split(' ').map((one) => parseInt(one, 16));
    assert.equal(bytes.length, 12);
    assert.equal(bytes[4] & 0x10, 0x10, `${leg.joint}: UV2 in ${leg.bytes}`);
  }
  const first = part(page, 'leg1');
  await first.locator('summary').click();
  assert.equal(await first.locator('.leg-bytes li').count(), 12);
  assert.match(await first.locator('.leg-bytes li').nth(4).innerText(), /Supply too low/);
  await here.close(page, 'device_hexapod');
});

test('step loss of one leg: its flags, what is known of its position, and what the leg really did', async () => {
  const page = await at('loose');
  await page.evaluate(() => void globalThis.__sinew.store.enable('loose'));
  await until('ready', async () => (await seen(page, 'loose')).state === 'ready');
  await page.evaluate(() => globalThis.__sinew.rpc.call('robot.declare', { robot: 'loose' }));
  const legs = async () => (await loose.truth()).joints.map((joint) => joint.q_mm);
  const before = await legs();
  const row = `joint ${['leg1', 'leg2', 'leg3', 'leg4', 'leg5', 'leg6'].map((leg) => `${leg}=268.2mm`).join(' ')}`;
  await until('it goes', () => page.evaluate((text) => globalThis.__sinew.store.run('loose', text, 'up'), row));
  await until('its fault', async () => (await seen(page, 'loose')).state === 'fault');
  const warning = page.locator('.device-warning', { hasText: 'Step loss' });
  await warning.waitFor();
  assert.match(await warning.innerText(), /leg3[\s\S]*find the position anew/);
  const told = (await ask('device.status', { robot: 'loose' })).legs;
  const flags = told.map((leg) => (leg.bytes ? parseInt(leg.bytes.split(' ')[4], 16) & 0x60 : 0));
  assert.equal(flags[2], 0x60, `step loss and defect in ${told[2].bytes}`);
  assert.ok(flags.every((one, i) => i === 2 || one === 0), JSON.stringify(flags));
  const joints = (await ask('robot.status', { robot: 'loose' })).joints;
  assert.equal(joints[2].quality, 'uncertain');
  const after = await legs();
  assert.ok(Math.abs(after[2] - before[2]) < 5e-3, 'without current it went nowhere but to its next full step');
  await here.close(page, 'device_step_loss');
});

test('a board’s inputs: a probe that closes, and where that was', async () => {
  const name = 'six-axes';
  const page = await at(name);
  await page.evaluate((robot) => void globalThis.__sinew.store.enable(robot), name);
  await until('ready', async () => (await seen(page, name)).state === 'ready');
  const inputs = part(page, 'Inputs');
  await inputs.getByText('open', { exact: true }).waitFor();
  const call = (method, params) =>
    page.evaluate(([what, more]) => globalThis.__sinew.rpc.call(what, more), [method, { robot: name, ...params }]);
  await call('robot.declare', {});
  await call('robot.nudge', { joint: 'shoulder', way: 0.05, until_probe: true });
  await inputs.getByText('closed', { exact: true }).waitFor();
  await inputs.getByText(/shoulder at 1\.00\d°/).waitFor();
  const { q_deg } = (await board.truth()).joints[1];
  assert.ok(q_deg > 1 && q_deg < 1.2, `it stands just behind it: ${q_deg}`);
  await here.close(page, 'device_inputs');
});

test('a fault says in German what happened, what it means and what to do, and goes only by being acknowledged', async () => {
  const page = await here.open({ locale: 'de-DE' }, '#/robots/six/events');
  await page.evaluate(() => void globalThis.__sinew.store.enable('six'));
  const card = page.locator('article.callout', { hasText: 'six' });
  await card.getByText('Die Platine von leg').waitFor();
  assert.match(await card.innerText(), /Versorgung[\s\S]*Schritte verloren[\s\S]*Netzteil/);
  assert.equal((await seen(page, 'six')).state, 'fault');
  const row = page.locator('.events .event.grave', { hasText: 'Die Platine von leg' }).first();
  await row.locator('.remedy').waitFor();
  await page.waitForTimeout(1500);
  assert.ok(await card.isVisible(), 'nothing goes away by itself');
  await card.getByRole('button', { name: 'Quittieren' }).click();
  await until('acknowledged', async () => (await seen(page, 'six')).state === 'off');
  await card.waitFor({ state: 'detached' });
  assert.ok(await row.isVisible(), 'what happened stays in the list');
  await here.close(page, 'device_fault');
});

test('every byte that is shown has passed at the machine’s own end, in the same order', async () => {
  const page = await at('six');
  await page.evaluate(() => void globalThis.__sinew.store.enable('six'));
  await until('a status on the wire', async () =>
    page.evaluate(() => [...document.querySelectorAll('.wire-text')].some((one) => one.textContent.startsWith('status:'))));
  await page.getByRole('button', { name: 'Pause' }).click();
  const rows = await saved(page);
  assert.ok(rows.length > 20, `${rows.length} messages`);
  const shown = (way) => rows.filter((row) => row.way === way).map((row) => row.hex.trim()).join(' ');
  const log = () => readFileSync(path.join(folder, 'six.log'), 'utf8').split('\n').filter((row) => row && !row.startsWith('#'));
  const logged = (way) => log().filter((row) => row.includes(way)).map((row) => /(?:device|host) {2}((?:[0-9a-f]{2} )+)/.exec(row)[1].trim()).join(' ').toUpperCase();
  for (const way of ['host -> device', 'device -> host']) {
    assert.ok(shown(way).length > 20);
    await until(`${way} as the machine has logged it`, () => logged(way).includes(shown(way)));
  }
  await here.close(page, 'device_log');
});

test('a battery, servos read back, and a list that is filtered, paused, chosen from and cleared', async () => {
  const page = await at('left');
  assert.match(await page.locator('.wire-list').innerText(), /Nothing has passed yet/);
  if ((await seen(page, 'left')).state === 'off') await page.evaluate(() => void globalThis.__sinew.store.enable('left'));
  await until('enabled', async () => (await seen(page, 'left')).state === 'ready');
  const battery = part(page, 'Battery');
  await battery.getByText(/\d\.\d\d V/).waitFor();
  const volts = Number(/([\d.]+) V/.exec(await battery.locator('.device-state').innerText())[1]);
  assert.ok(Math.abs(volts - (await ask('simulation.truth', { robot: 'left' })).supply_v) < 0.3, `${volts} V`);
  assert.match(await battery.locator('.raw').innerText(), /^55 55 04 0F( [0-9A-F]{2}){2}$/);
  assert.match(await part(page, 'Action groups').innerText(), /does not offer it/);

  await page.getByLabel('Words or bytes').fill('55 55 04 0F');
  await until('answers only', async () => {
    const texts = await page.locator('.wire-row').allInnerTexts();
    return texts.length > 0 && texts.every((text) => /battery: V/.test(text) && /from device/.test(text));
  });
  await page.getByRole('radio', { name: 'To device' }).click();
  await page.getByText('Nothing that fits the filter.').waitFor();
  await page.getByLabel('Words or bytes').fill('battery');
  await until('questions only', async () =>
    (await page.locator('.wire-row').allInnerTexts()).some((text) => /battery\?/.test(text)));
  assert.equal(await page.locator('.wire-row.to-host').count(), 0);
  await page.getByRole('radio', { name: 'Both ways' }).click();

  await page.getByRole('button', { name: 'Pause' }).click();
  const still = await count(page);
  await page.waitForTimeout(2500);
  assert.equal(await count(page), still, 'paused');
  await page.locator('.wire-list').focus();
  await page.keyboard.press('Home');
  await page.keyboard.press('ArrowDown');
  const chosen = await page.locator('.wire-row[aria-selected=true]').getAttribute('id');
  assert.equal(await page.locator('.wire-list').getAttribute('aria-activedescendant'), chosen);
  await page.locator('.wire-open dl, .wire-open .raw').first().waitFor();
  await page.getByRole('button', { name: 'Go on' }).click();
  await until('it goes on', async () => (await count(page)) > still);
  await page.getByRole('button', { name: 'Clear the list' }).click();
  assert.ok((await count(page)) < still);
  assert.equal((await seen(page, 'left')).state, 'ready', 'nothing of it has moved or stopped anything');
  await here.close(page, 'device_learm');
});

test('in German no word of the device stays as the wire calls it', async () => {
  const page = await at('left', { locale: 'de-DE', colorScheme: 'light' });
  await part(page, 'Batterie').waitFor();
  await until('Nachrichten', async () => (await page.locator('.wire-row').count()) > 3);
  const texts = (await page.locator('.wire-text').allInnerTexts()).join('\n');
  assert.match(texts, /Batterie\?|Stellungen\?|Gruppen anhalten/);
  assert.doesNotMatch(texts, /battery|positions|stop group|servos? \d+ \d/);
  await here.close(page, 'device_german');
});
