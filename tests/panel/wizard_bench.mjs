// What the browser tests share: a simulated cell of their own, a browser, pages, and what the machines
// really did.
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

export const root = path.resolve(path.dirname(new URL(import.meta.url).pathname), '../..');
const { chromium } = createRequire(path.join(root, 'panel/package.json'))('playwright-core');
export const kPatience = 60_000; // ms, on a machine that does something else as well

export async function until(what, done, interval = 50, patience = kPatience) {
  const end = Date.now() + patience;
  while (Date.now() < end) {
    const value = await done();
    if (value) return value;
    await new Promise((go) => setTimeout(go, interval));
  }
  throw new Error(`not in ${patience / 1000} s: ${what}`);
}

export const apart = (a, b) => Math.max(...a.map((one, i) => Math.abs(one - b[i])));

export class Bench {
  contexts = new Set();

  async start(cell) {
    this.url = process.env.PANEL_URL ?? (await this.serve(cell));
    door = new URL(this.url);
    this.browser = await chromium.launch({
      executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
      args: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox'],
    });
  }

  /** A cell of its own with a door on a free port. @return  the link that it prints */
  serve(cell) {
    this.folder = mkdtempSync(path.join(tmpdir(), 'sinew-panel-'));
    const file = path.join(this.folder, 'cell.toml');
    writeFileSync(file, cell);
    const program = process.env.SINEW ?? path.join(root, 'build/release/sinew');
    const env = { ...process.env, XDG_STATE_HOME: this.folder, XDG_RUNTIME_DIR: this.folder };
    this.server = spawn(program, ['serve', file, '--listen', '127.0.0.1:0'], { env });
    let said = '';
    return new Promise((found, fail) => {
      const read = (text) => {
        said += text;
        const link = /http:\/\/\S+#token=\S+/.exec(said);
        if (link) found(link[0]);
      };
      this.server.stderr.on('data', read);
      this.server.stdout.on('data', read);
      this.server.on('exit', () => fail(new Error(`sinew serve has ended: ${said}`)));
    });
  }

  async end() {
    await this.browser?.close();
    this.server?.kill('SIGINT');
    if (this.folder) rmSync(this.folder, { recursive: true, force: true });
  }

  /** What a failed test has left open would draw on, and hold up the next one. */
  async closePages() {
    for (const context of this.contexts) await context.close();
    this.contexts.clear();
  }

  async open(options = {}, address = '') {
    const context = await this.browser.newContext({
      viewport: { width: 1000, height: 660 },
      locale: 'en-GB',
      colorScheme: 'dark',
      ...options,
    });
    this.contexts.add(context);
    const page = await context.newPage();
    page.setDefaultTimeout(kPatience);
    page.errors = [];
    page.on('pageerror', (error) => page.errors.push(error.message));
    page.on('console', (message) => {
      if (message.type() === 'error') page.errors.push(message.text());
    });
    await page.goto(this.url);
    await shown(page);
    if (address) await page.evaluate((to) => void (location.hash = to), address);
    return page;
  }

  async close(page, name) {
    const shots = process.env.PANEL_SHOTS;
    if (shots) await page.screenshot({ path: path.join(shots, `${name}.png`) });
    assert.deepEqual(page.errors, []);
  }
}

/** The first pictures cost a computer without a graphics processor more than a lease lasts. */
export async function shown(page) {
  await page.waitForSelector('.card-name');
  await until('drawn', () => page.evaluate(() => globalThis.sinewScene?.frames.length > 3), 200);
}

/** As the page itself asks, over its own connection: what needs its lease. */
export const call = (page, method, params) =>
  page.evaluate(([m, p]) => globalThis.__sinew.rpc.call(m, p), [method, params]);

let door;
/** Past the page: what is held against it does not wait for it. */
export async function ask(method, params) {
  const answer = await fetch(new URL('/rpc', door), {
    method: 'POST',
    headers: { 'Content-Type': 'application/json', Authorization: `Bearer ${door.hash.replace('#token=', '')}` },
    body: JSON.stringify({ jsonrpc: '2.0', id: 1, method, params }),
  });
  const { result, error } = await answer.json();
  if (error) throw new Error(error.message);
  return result;
}
export const status = (robot) => ask('robot.status', { robot });
export const truth = async (robot) =>
  (await ask('simulation.truth', { robot })).joints.map((joint) => joint.position_rad ?? joint.position_m);

/** Until the machine itself does not move any more. */
export async function rests(robot, nearly) {
  let last = await truth(robot);
  return until(`${robot} at rest`, async () => {
    const now = await truth(robot);
    const still = apart(now, last) < nearly;
    last = now;
    return still && now;
  }, 400);
}
