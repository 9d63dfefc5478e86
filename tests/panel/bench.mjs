// What the panel's browser tests share: a simulated cell of their own, a browser, and the way from the
// page to what the machines really did.
//
//   SINEW        the program, build/release/sinew
//   CHROMIUM     the browser, /usr/bin/chromium
//   PANEL_URL    a cell that runs already, instead of one of its own
//   PANEL_DIST   a folder with a built panel, shown instead of the one that the program has in it
//   PANEL_SHOTS  a folder for pictures of each test's end
//   PANEL_PATIENCE_S  how long anything may take, 60
//
// These tests run against the clock, on machines that may do something else as well. What the machine was
// late for is tried again and said so (`patiently`); what the page did wrong is wrong at once.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { createReadStream, existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import http from 'node:http';
import { createRequire } from 'node:module';
import net from 'node:net';
import { tmpdir } from 'node:os';
import path from 'node:path';

export const root = path.resolve(path.dirname(new URL(import.meta.url).pathname), '../..');
const { chromium } = createRequire(path.join(root, 'panel/package.json'))('playwright-core');

export const kPatience = 1000 * Number(process.env.PANEL_PATIENCE_S ?? 60); // ms, on a machine that does something else as well

export async function until(what, done, interval = 50, patience = kPatience) {
  const end = Date.now() + patience;
  while (Date.now() < end) {
    const value = await done();
    if (value) return value;
    await new Promise((go) => setTimeout(go, interval));
  }
  throw new Error(`not in ${patience / 1000} s: ${typeof what === 'function' ? what() : what}`);
}

const kTypes = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml', '.woff2': 'font/woff2' };

/** Another build of the page before the door of a cell: its files from a folder, all else from there. */
function front(folder, door) {
  const policy = "default-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:";
  const server = http.createServer((request, answer) => {
    const name = path.normalize(decodeURIComponent(new URL(request.url, door).pathname));
    const file = path.join(folder, name === '/' ? 'index.html' : name);
    if (!file.startsWith(folder) || !existsSync(file) || !statSync(file).isFile()) {
      answer.writeHead(404).end();
      return;
    }
    answer.writeHead(200, {
      'Content-Type': kTypes[path.extname(file)] ?? 'application/octet-stream',
      'Content-Security-Policy': policy,
    });
    createReadStream(file).pipe(answer);
  });
  server.on('upgrade', (request, socket, rest) => {
    const there = net.connect(Number(door.port), door.hostname, () => {
      const lines = [`GET ${request.url} HTTP/1.1`];
      for (let i = 0; i < request.rawHeaders.length; i += 2) {
        const name = request.rawHeaders[i].toLowerCase();
        const value = { host: door.host, origin: door.origin }[name] ?? request.rawHeaders[i + 1];
        lines.push(`${request.rawHeaders[i]}: ${value}`);
      }
      there.write(`${lines.join('\r\n')}\r\n\r\n`);
      there.write(rest);
      socket.pipe(there).pipe(socket);
    });
    for (const [one, other] of [[socket, there], [there, socket]]) one.on('error', () => other.destroy());
  });
  return new Promise((ready) => server.listen(0, '127.0.0.1', () => ready(server)));
}

const kProgram = process.env.SINEW ?? path.join(root, 'build/release/sinew');

/**
 * A cell of its own with a door on a free port, and a browser.
 * @param cellText  the cell, or what makes it from the folder that all of it stands in
 * @param options  more words for `sinew serve`
 */
export async function bench(cellText, options = []) {
  const contexts = new Set();
  let kept;
  const folder = mkdtempSync(path.join(tmpdir(), 'sinew-panel-'));
  const devices = [];
  const device = (...options) => {
    const made = simulated(folder, ...options);
    devices.push(made);
    return made;
  };
  const cell = path.join(folder, 'cell.toml');
  writeFileSync(cell, typeof cellText === 'string' ? cellText : await cellText(device));
  let server, fronted;
  const serve = (listen) => {
    const environment = { ...process.env, XDG_STATE_HOME: folder, XDG_RUNTIME_DIR: folder };
    server = spawn(kProgram, ['serve', cell, '--listen', listen, ...options], { env: environment });
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
  };
  let url = process.env.PANEL_URL ?? (await serve('127.0.0.1:0'));
  door = new URL(url);
  if (process.env.PANEL_DIST) {
    fronted = await front(path.resolve(process.env.PANEL_DIST), new URL(url));
    url = `http://127.0.0.1:${fronted.address().port}/${new URL(url).hash}`;
  }
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    // WebGL in software; the page itself is put together without GL, which takes a sixth of the time then.
    args: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-gpu-compositing', '--disable-gpu-rasterization', '--no-sandbox'],
  });
  return {
    url,
    browser,
    folder,
    /** The link of those who only watch. */
    viewerUrl: () => url.replace(/token=.*/, `token=${readFileSync(path.join(folder, 'sinew/web/viewer.token'), 'utf8').trim()}`),
    signal: (name) => server.kill(name),
    /** Another server, where the one before it was. */
    again: () => serve(door.host),
    /** A page of its own; what it complains of is kept. */
    async open(options = {}, address = '', link = url) {
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
      await page.goto(link);
      await shown(page);
      if (address) await page.evaluate((to) => void (location.hash = to), address);
      return page;
    },
    /** The page that the tests of a file share; another one where the last test has not come to its end. */
    async shared(options) {
      if (!kept?.whole) {
        await this.clear();
        kept = await this.open(options);
      }
      kept.whole = false;
      return kept;
    },
    async close(page, name) {
      page.whole = true;
      const shots = process.env.PANEL_SHOTS;
      if (shots) mkdirSync(shots, { recursive: true });
      if (shots) await page.screenshot({ path: path.join(shots, `${name}.png`) });
      assert.deepEqual(page.errors, []);
    },
    /** What a failed test has left open would draw on, and hold up the next one. */
    async clear() {
      for (const context of contexts) await context.close();
      contexts.clear();
    },
    async end() {
      await browser.close();
      fronted?.closeAllConnections();
      fronted?.close();
      server?.kill('SIGINT');
      for (const one of devices) one.end();
      rmSync(folder, { recursive: true, force: true });
    },
  };
}

/** A device behind a port of its own, that outlives servers. */
function simulated(folder, robot, ...options) {
  const port = path.join(folder, robot);
  const child = spawn(kProgram, ['sim', robot, '--link', port, ...options], { stdio: ['ignore', 'ignore', 'pipe'] });
  let said = '';
  child.stderr.on('data', (text) => (said += text));
  return {
    port,
    there: () => until(`${robot} simulated`, () => existsSync(port)),
    /** Where it really stands, rad or m. */
    async truth() {
      const from = said.length;
      child.kill('SIGUSR1');
      const line = await until('its truth', () => /truth: (.*);/.exec(said.slice(from))?.[1], 10);
      const units = { deg: Math.PI / 180, mm: 1e-3 };
      return [...line.matchAll(/ (-?[\d.]+) (deg|mm)/g)].map(([, number, unit]) => Number(number) * units[unit]);
    },
    end: () => child.kill('SIGINT'),
  };
}

/** What the machine's own lateness ends: leases of a second, cycles of ten ms, a device that waits 50 ms. */
const kLate = new Set(['lease_ended', 'cycle_overrun', 'clock_gap', 'record_late']);
const kLateWords = /lease has ended|did not answer within|port was closed|answered nothing/;
const late = (event) =>
  kLate.has(event.cause) || (['fault', 'job', 'procedure'].includes(event.kind) && kLateWords.test(JSON.stringify(event)));

/** s that something has waited for a processor until now; nothing where the kernel does not say. */
function starved() {
  const text = existsSync('/proc/pressure/cpu') ? readFileSync('/proc/pressure/cpu', 'utf8') : '';
  return Number(/some .*total=(\d+)/.exec(text)?.[1] ?? NaN) / 1e6;
}

/**
 * Again, at most twice, where the controller has told that something came too late for it while processors
 * were short; that is said. Anything else that is wrong is wrong at once.
 */
export async function patiently(what, go) {
  for (let attempt = 1; ; ++attempt) {
    const before = (await ask('events.list')).events.at(-1)?.number ?? 0;
    const [waited, began] = [starved(), Date.now()];
    try {
      return await go(attempt);
    } catch (error) {
      const since = (await ask('events.list', { after: before }).catch(() => ({ events: [] }))).events;
      const why = since.find(late);
      const short = (starved() - waited) / ((Date.now() - began) / 1000);
      if (!why || short < 0.1 || attempt === 3) throw error;
      const share = Number.isNaN(short) ? 'unknown' : `${Math.round(100 * short)} %`;
      console.log(`# ${what}: ${why.robot} ${why.kind} ${why.cause ?? ''}; short of processors: ${share}; again`);
    }
  }
}

/** Enabled and without a fault, by the page's own means; control is this page's then. */
export function ready(page, robot) {
  return until(`${robot} ready`, async () => {
    const { state } = await status(robot);
    if (state === 'ready') return page.evaluate((name) => globalThis.__sinew.store.control(name, true), robot);
    const verb = { off: 'enable', fault: 'acknowledge' }[state];
    if (verb) await page.evaluate(([name, how]) => globalThis.__sinew.store[how](name), [robot, verb]);
    return false;
  }, 100);
}

/** At the zeros of its joints, where nothing is near a limit. */
export async function upright(page, robot) {
  await ready(page, robot);
  await patiently(`${robot} upright`, async () => {
    await ready(page, robot);
    const names = (await status(robot)).joints.map((joint) => joint.name);
    const known = (await status(robot)).joints.every((joint) => joint.quality !== 'lost');
    if (known && Math.max(...(await truth(robot)).map(Math.abs)) < 0.03) return;
    const row = `joint ${names.map((name) => `${name}=0deg`).join(' ')}`;
    assert.ok(await page.evaluate(([name, text]) => globalThis.__sinew.store.run(name, text, 'upright'), [robot, row]));
    const job = await until('the end of the way', async () => {
      const now = await ask('job.status', { robot });
      return now.over && now;
    });
    assert.equal(job.phase, 'done', JSON.stringify(job));
  });
  await until('ready behind it', async () => (await status(robot)).state === 'ready');
}

/** The first pictures cost a computer without a graphics processor more than a lease lasts. */
export async function shown(page) {
  await page.waitForSelector('.card-name');
  await until('drawn', () => page.evaluate(() => globalThis.sinewScene?.frames.length > 0 && !globalThis.sinewScene.dirty), 200);
}

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
export const apart = (a, b) => Math.max(...a.map((one, i) => Math.abs(one - b[i])));

/** What the page itself knows of a robot. */
export const seen = (page, robot) =>
  page.evaluate((name) => globalThis.__sinew.store.status.value[name], robot);

/** Until the machine itself does not move any more, and its controller moves nothing. */
export async function rests(robot, nearly) {
  let last = await truth(robot);
  let state;
  return until(() => `${robot} at rest; ${state} at ${last}`, async () => {
    ({ state } = await status(robot));
    const now = await truth(robot);
    const still = apart(now, last) < nearly && state !== 'moving' && state !== 'stopping';
    last = now;
    return still && now;
  }, 200);
}
