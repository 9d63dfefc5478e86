// The pictures of the README, made anew: docs/pictures/panel_*.webp, each below 200 kB.
//
//   node tests/panel/pictures.mjs [FOLDER]      (environment: bench.mjs)
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { ask, bench, ready, root, status, until, upright } from './bench.mjs';

const folder = path.resolve(process.argv[2] ?? path.join(root, 'docs/pictures'));
const kBytesMax = 200_000;
const sample = (name) => readFileSync(path.join(root, 'robots', name), 'utf8');

const here = await bench(sample('../cells/five.toml'));

/** Drawn as with a graphics processor, without the tour. */
async function open(colorScheme, address) {
  const context = await here.browser.newContext({ viewport: { width: 1440, height: 900 }, locale: 'en-GB', colorScheme });
  await context.addInitScript(() => {
    localStorage.setItem('sinew.drawing', 'full');
    localStorage.setItem('sinew.tour', 'seen');
  });
  const page = await context.newPage();
  page.setDefaultTimeout(60_000);
  await page.goto(here.url);
  await page.locator('.scene-label').nth(4).waitFor({ state: 'attached' });
  await page.evaluate((to) => void (location.hash = to), address);
  return page;
}

async function take(page, name) {
  await page.waitForTimeout(2500);
  const png = await page.screenshot({ timeout: 60_000 });
  if (process.env.PANEL_SHOTS) writeFileSync(path.join(process.env.PANEL_SHOTS, `${name}.png`), png);
  const paper = await page.context().newPage();
  for (const quality of [0.92, 0.85, 0.75, 0.6]) {
    const address = await paper.evaluate(
      async ([bytes, share]) => {
        const image = new Image();
        image.src = `data:image/png;base64,${bytes}`;
        await image.decode();
        const canvas = Object.assign(document.createElement('canvas'), { width: image.width, height: image.height });
        canvas.getContext('2d').drawImage(image, 0, 0);
        return canvas.toDataURL('image/webp', share);
      },
      [png.toString('base64'), quality],
    );
    const webp = Buffer.from(address.split(',')[1], 'base64');
    if (webp.length > kBytesMax) continue;
    writeFileSync(path.join(folder, `${name}.webp`), webp);
    console.log(`${name}.webp: ${Math.round(webp.length / 1000)} kB`);
    await page.context().close();
    return;
  }
  assert.fail(`${name} is larger than ${kBytesMax} bytes`);
}

const run = (page, robot, text, name) =>
  page.evaluate(([who, rows, title]) => globalThis.__sinew.store.run(who, rows, title), [robot, text, name]);
const over = (robot) => until(`${robot}: over`, async () => (await ask('job.status', { robot })).over, 300, 240_000);

try {
  // At a glance: every robot where it really is, some of them at work.
  let page = await open('dark', '#/robots/learm/jog');
  for (const robot of ['arm', 'learm', 'big', 'max', 'platform']) await ready(page, robot);
  for (const robot of ['big', 'platform']) await page.evaluate((name) => globalThis.__sinew.rpc.call('robot.declare', { robot: name }), robot);
  // Its boards hear from a busy machine too late: then once more.
  for (let attempt = 1; attempt <= 3; ++attempt) {
    await ready(page, 'arm');
    await run(page, 'arm', 'home\njoint base=25deg shoulder=-20deg elbow=-35deg forearm_roll=0deg wrist_bend=50deg flange_roll=0deg\n', 'first moves');
    await over('arm');
    if ((await ask('job.status', { robot: 'arm' })).phase === 'done') break;
  }
  // What stands there in fault is in no picture: an arm that is off says less.
  if ((await status('arm')).state === 'fault') {
    await ready(page, 'arm');
    await page.evaluate(() => globalThis.__sinew.store.disable('arm'));
  }
  await page.getByRole('button', { name: 'Whole cell' }).click();
  await upright(page, 'learm');
  await run(page, 'max', sample('maxarm/stack.sinew'), 'stack');
  await until('waving', async () => {
    const { job, state } = await status('learm');
    if (job?.title === 'wave' && job.phase === 'running') return job.progress > 0.3;
    if (state === 'ready') await run(page, 'learm', sample('learm/wave.sinew'), 'wave');
    else await ready(page, 'learm');
    return false;
  }, 50);
  await take(page, 'panel_glance');

  // A program, checked while it is written, and its ghost.
  page = await open('light', '#/robots/learm/programs');
  await upright(page, 'learm');
  await page.evaluate(() => (globalThis.__sinew.store.seen.value = Infinity));
  await page.getByLabel('Text of the program').fill(sample('learm/square.sinew'));
  await page.locator('.run-bar .verdict.fine').waitFor();
  const scrub = page.getByLabel('Look at it: time in the program');
  await scrub.evaluate((one) => {
    one.value = String(0.62 * Number(one.max));
    one.dispatchEvent(new Event('input', { bubbles: true }));
  });
  await take(page, 'panel_program');

  // Setup: what is asked, and which joint is meant.
  page = await open('dark', '#/robots/learm/setup');
  await ready(page, 'learm');
  await page.getByRole('button', { name: 'Begin, or go on' }).click();
  const asked = (step) => until(step, async () => {
    const now = await ask('procedure.status', { robot: 'learm' });
    assert.ok(!now.over, now.trouble);
    return now.step?.id === step && now.asks?.ready;
  }, 100, 120_000);
  const press = (name) => page.locator('.question').getByRole('button', { name, exact: true }).click();
  for (const step of ['supply', 'clear']) {
    await asked(step);
    await press('Yes, it is so');
  }
  await asked('first_move');
  await press('Go');
  for (const word of ['Left', 'Forward']) {
    const joint = { Left: 'base', Forward: 'shoulder' }[word];
    await asked(`direction.${joint}`);
    await press('Go');
    await asked(`direction.${joint}`);
    await until('seen', async () => (await ask('procedure.status', { robot: 'learm' })).asks?.choices?.includes('nothing'));
    if (word === 'Left') await press(word);
  }
  await take(page, 'panel_setup');
} finally {
  await here.end();
}
