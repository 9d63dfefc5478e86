// What the panel's browser tests share: a simulated cell of their own, a browser, and the way from the
// page to what the machines really did.
//
//   SINEW        the program, build/release/sinew
//   CHROMIUM     the browser, /usr/bin/chromium
//   PANEL_URL    a cell that runs already, instead of one of its own
//   PANEL_DIST   a folder with a built panel, shown instead of the one that the program has in it
//   PANEL_SHOTS  a folder for pictures of each test's end
//   PANEL_PATIENCE_S  how long anything may take, 60
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { createReadStream, existsSync, mkdtempSync, rmSync, statSync, writeFileSync } from 'node:fs';
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
  throw new Error(`not in ${patience / 1000} s: ${what}`);
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

/** A cell of its own with a door on a free port, and a browser. */
export async function bench(cellText) {
  let folder, server, fronted;
  const contexts = new Set();
  const serve = () => {
    folder = mkdtempSync(path.join(tmpdir(), 'sinew-panel-'));
    const cell = path.join(folder, 'cell.toml');
    writeFileSync(cell, cellText);
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
  };
  let url = process.env.PANEL_URL ?? (await serve());
  door = new URL(url);
  if (process.env.PANEL_DIST) {
    fronted = await front(path.resolve(process.env.PANEL_DIST), new URL(url));
    url = `http://127.0.0.1:${fronted.address().port}/${new URL(url).hash}`;
  }
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox'],
  });
  return {
    url,
    /** A page of its own; what it complains of is kept. */
    async open(options = {}, address = '') {
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
      await shown(page);
      if (address) await page.evaluate((to) => void (location.hash = to), address);
      return page;
    },
    async close(page, name) {
      const shots = process.env.PANEL_SHOTS;
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
      if (folder) rmSync(folder, { recursive: true, force: true });
    },
  };
}

/** The first pictures cost a computer without a graphics processor more than a lease lasts. */
export async function shown(page) {
  await page.waitForSelector('.card-name');
  await until('drawn', () => page.evaluate(() => globalThis.sinewScene?.frames.length > 3), 200);
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

/** Until the machine itself does not move any more. */
export async function rests(robot, nearly) {
  let last = await truth(robot);
  return until(`${robot} at rest`, async () => {
    const now = await truth(robot);
    const still = apart(now, last) < nearly;
    last = now;
    return still && now;
  }, 300);
}
