// The page in a browser against a simulated cell, and what the machines really did: through the page
// goes what a person does, through simulation.truth comes what is held against it.
//
//   node --test tests/panel/panel_test.mjs
//   SINEW        the program, build/release/sinew
//   CHROMIUM     the browser, /usr/bin/chromium
//   PANEL_URL    a cell that runs already, instead of one of its own
//   PANEL_SHOTS  a folder for pictures of each test's end
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, afterEach, before, test } from 'node:test';

const root = path.resolve(import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname), '../..');
const { chromium } = createRequire(path.join(root, 'panel/package.json'))('playwright-core');

const kPatience = 60_000; // ms, on a machine that does something else as well
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

let folder, server, browser, url;

async function until(what, done, interval = 50) {
  const end = Date.now() + kPatience;
  while (Date.now() < end) {
    const value = await done();
    if (value) return value;
    await new Promise((go) => setTimeout(go, interval));
  }
  throw new Error(`not in ${kPatience / 1000} s: ${what}`);
}

/** A cell of its own with a door on a free port. @return  the link that it prints */
function serve() {
  folder = mkdtempSync(path.join(tmpdir(), 'sinew-panel-'));
  const cell = path.join(folder, 'cell.toml');
  writeFileSync(cell, kCell);
  const program = process.env.SINEW ?? path.join(root, 'build/release/sinew');
  const environment = { ...process.env, XDG_STATE_HOME: folder, XDG_RUNTIME_DIR: folder };
  server = spawn(program, ['serve', cell, '--listen', '127.0.0.1:0'], { env: environment });
  let said = '';
  return new Promise((found, fail) => {
    const read = (text) => {
      said += text;
      const link = /http:\/\/\S+#token=\S+/.exec(said);
      if (link) found(link[0]);
    };
    server.stderr.on('data', read);
    server.stdout.on('data', read);
    server.on('exit', () => fail(new Error(`sinew serve has ended: ${said}`)));
  });
}

before(async () => {
  url = process.env.PANEL_URL ?? (await serve());
  browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox'],
  });
});

after(async () => {
  await browser?.close();
  server?.kill('SIGINT');
  if (folder) rmSync(folder, { recursive: true, force: true });
});

// What a failed test has left open would draw on, and hold up the next one.
const contexts = new Set();
afterEach(async () => {
  for (const context of contexts) await context.close();
  contexts.clear();
});

async function open(options = {}) {
  const context = await browser.newContext({
    viewport: { width: 1100, height: 720 },
    locale: 'en-GB',
    colorScheme: 'dark',
    ...options,
  });
  contexts.add(context);
  const page = await context.newPage();
  page.setDefaultTimeout(kPatience);
  page.errors = [];
  page.on('pageerror', (error) => page.errors.push(error.message));
  page.on('console', (message) => {
    if (message.type() === 'error') page.errors.push(message.text());
  });
  await page.goto(url);
  await page.waitForSelector('.card-name');
  return page;
}

async function close(page, name) {
  const shots = process.env.PANEL_SHOTS;
  if (shots) await page.screenshot({ path: path.join(shots, `${name}.png`) });
  assert.deepEqual(page.errors, []);
}

const status = (page, robot) =>
  page.evaluate((name) => globalThis.__sinew.store.status.value[name], robot);
const truth = async (page, robot) => {
  const told = await page.evaluate(
    (name) => globalThis.__sinew.rpc.call('simulation.truth', { robot: name }),
    robot,
  );
  return told.joints.map((joint) => joint.position_rad ?? joint.position_m);
};
const apart = (a, b) => Math.max(...a.map((one, i) => Math.abs(one - b[i])));

/** Until the machine itself does not move any more. */
async function rests(page, robot, nearly) {
  let last = await truth(page, robot);
  return until(`${robot} at rest`, async () => {
    const now = await truth(page, robot);
    const still = apart(now, last) < nearly;
    last = now;
    return still && now;
  }, 300);
}

const view = (page, name) => page.locator('.tabs a', { hasText: name }).click();
const robot = (page, name) =>
  page.locator('.card-face', { has: page.locator(`text="${name}"`) }).click();

async function enable(page, name) {
  await robot(page, name);
  if ((await status(page, name)).state === 'off') await page.locator('.callout button.primary').click();
  await until(`${name} ready`, async () => (await status(page, name)).state === 'ready');
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
    const before = (await status(page, 'left')).job?.job ?? 0;
    await until('the end of the way home', async () => {
      const now = await status(page, 'left');
      const other = (now.job?.job ?? 0) > 0 && now.job.job >= before && now.job.over;
      return other && now.state !== 'moving' && now.state !== 'recovering';
    });
    return Math.max(...(await truth(page, 'left')).map(Math.abs)) < 0.05;
  });
}

test('a held button jogs, and letting go stops', async () => {
  const page = await open();
  await stand(page);
  await view(page, 'Jog');
  const begin = await rests(page, 'left', 1e-3);
  const button = page.getByRole('button', { name: 'base plus', exact: true });
  const held = () => page.evaluate(() => document.querySelector('.jog-live').dataset.on === 'true');
  await until('moved by 3 deg', async () => {
    if (!(await held())) {
      await page.mouse.up();
      await button.hover();
      await page.mouse.down();
      await page.waitForTimeout(300);
    }
    return (await truth(page, 'left'))[0] - begin[0] > 0.05;
  });
  await page.mouse.up();
  assert.equal(await held(), false);
  const end = await rests(page, 'left', 1e-3);
  assert.ok(end[0] > begin[0] + 0.05 && end[0] < 1.4, `at ${end[0]} rad`);
  assert.ok(apart(end.slice(1), begin.slice(1)) < 0.02, 'only the base has moved');
  await close(page, 'jog');
});

test('what is previewed does not move before Move, and then goes there', async () => {
  const page = await open();
  await stand(page);
  const begin = await rests(page, 'left', 1e-3);
  await page.getByLabel('base, target').fill('40deg');
  await page.getByLabel('base, target').press('Enter');
  await page.locator('.verdict.fine').waitFor();
  await page.locator('.dock .plot canvas').waitFor();
  assert.ok(apart(await rests(page, 'left', 1e-3), begin) < 5e-3);
  await page.locator('[data-tour=go]:enabled').click();
  await until('there', async () => Math.abs((await truth(page, 'left'))[0] - (40 * Math.PI) / 180) < 0.03);
  await close(page, 'preview');
});

test('a target that is refused says why, and cannot be moved to', async () => {
  const page = await open();
  await stand(page);
  const begin = await rests(page, 'left', 1e-3);
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
  assert.ok(apart(await rests(page, 'left', 1e-3), begin) < 5e-3);
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
  const begin = await truth(page, 'left');
  await until('under way', async () => apart(await truth(page, 'left'), begin) > 0.03);
  await page.locator('.top-tools button').first().focus();
  await page.keyboard.press('Space');
  const end = await rests(page, 'left', 1e-3);
  assert.ok(end[0] < (75 * Math.PI) / 180, `stopped at ${end[0]} rad`);
  await until('the job has ended', async () => (await status(page, 'left')).job?.phase === 'stopped');
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
  const begin = await truth(page, 'left');
  await until('under way', async () => apart(await truth(page, 'left'), begin) > 0.03);
  await other.getByRole('button', { name: 'Stop', exact: true }).click();
  const end = await rests(page, 'left', 1e-3);
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
