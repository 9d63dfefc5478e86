// What outlives the controller, and what several pages keep from each other: previews, events, settings.
//
//   node --test tests/panel/outlives_test.mjs     (environment: bench.mjs)
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, afterEach, before, test } from 'node:test';
import { apart, ask, bench, patiently, rests, shown, status, truth, until, upright } from './bench.mjs';

const arm = (name, y_mm) => `[[robot]]\nname = "${name}"\nrobot = "learm"\nprofile = "bus"\ny_mm = ${y_mm}\n`;
let here;
before(async () => {
  here = await bench(`title = "Tests"\n${arm('left', 0)}${arm('right', 900)}`);
});
after(() => here?.end());
afterEach(() => here.clear());

const view = (page, name, what) => page.evaluate((to) => void (location.hash = to), `#/robots/${name}/${what}`);
const slider = (page, joint) => page.locator('.joint-slider', { hasText: joint }).locator('input.slider');
const verdict = (page) => page.locator('.verdict.fine strong');
const ghostOf = (page) => page.evaluate(() => globalThis.sinewScene.ghost?.robot);

/** This joint is sent elsewhere in the preview; its slider's value then. */
async function aim(page, name, joint, value) {
  await view(page, name, 'move');
  await until('its sliders', () => slider(page, joint).isEnabled());
  // Not by fill(): the value need not be one of the slider's steps.
  await slider(page, joint).evaluate((input, to) => {
    input.value = String(to);
    input.dispatchEvent(new Event('input', { bubbles: true }));
  }, value);
  await verdict(page).waitFor();
  return Number(await slider(page, joint).inputValue());
}

test('a preview begins where the robot stands: what has moved meanwhile is seen anew before Move', () => patiently('anew', async () => {
  const page = await here.open({}, '#/robots/left/move');
  await upright(page, 'left');
  await aim(page, 'left', 'base', 0.5);
  const short = parseFloat(await verdict(page).innerText());
  assert.ok(await page.evaluate(() => globalThis.__sinew.store.run('left', 'joint base=-60deg', 'elsewhere')));
  await until('it rests there', async () => Math.abs((await truth('left'))[0] + Math.PI / 3) < 0.03);
  await rests('left', 1e-3);
  await until('a longer way', async () => (await verdict(page).isVisible()) && parseFloat(await verdict(page).innerText()) > 1.3 * short);
  assert.ok(Math.abs(Number(await slider(page, 'base').inputValue()) - 0.5) < 0.01, 'to the same place');
  await page.locator('[data-tour=go]:enabled').click();
  await until('there', async () => Math.abs((await truth('left'))[0] - 0.5) < 0.03);
  await rests('left', 1e-3);
  await here.close(page, 'outlives_anew');
}));

test('settings of two robots are in nobody’s way; of one robot the second sees what the first has set', async () => {
  const open = async (name) => {
    const page = await here.open({}, `#/robots/${name}/setup`);
    await page.getByText('Settings', { exact: true }).click();
    await page.locator('.settings form').waitFor();
    return page;
  };
  const pages = [await open('left'), await open('right'), await open('left')];
  const trim = (page) => page.locator('.settings form').getByLabel('base: Trim');
  for (const [i, page] of pages.entries()) await trim(page).fill(String(i + 1));
  const save = async (page, told) => {
    await page.locator('.settings form').getByRole('button', { name: 'Save', exact: true }).click();
    await page.locator('.settings form').getByText(told).waitFor();
  };
  await save(pages[0], 'Saved in');
  await save(pages[1], 'Saved in');
  await save(pages[2], 'Somebody else has just changed the settings of this robot');
  assert.match(await pages[2].locator('.settings form [role=alert]').innerText(), /joint\.base\.trim_rad 0\.0174/);
  const set = async (name) => Number((await ask('settings.get', { robot: name })).now['joint.base.trim_rad']) * (180 / Math.PI);
  assert.ok(Math.abs((await set('left')) - 1) < 1e-3, 'nothing is overwritten unasked');
  assert.ok(Math.abs((await set('right')) - 2) < 1e-3);
  assert.equal(await trim(pages[2]).inputValue(), '3.00', 'what was typed is still there');
  await save(pages[2], 'Saved in');
  assert.ok(Math.abs((await set('left')) - 3) < 1e-3);
  for (const [i, page] of pages.entries()) await here.close(page, `outlives_settings_${i}`);
});

test('previews and what happened are there again behind kill -9, and nothing moves by that', async () => {
  const page = await here.open({}, '#/robots/left/move');
  await patiently('prepared', async () => {
    await upright(page, 'left');
    await upright(page, 'right');
  });
  const wished = { left: await aim(page, 'left', 'base', 0.5), right: await aim(page, 'right', 'shoulder', 0.4) };
  await page.waitForTimeout(700); // kept a moment behind the last change
  const before = (await ask('events.list')).events;
  assert.ok(before.some((one) => one.kind === 'job'));
  here.signal('SIGKILL');
  await page.locator('.veil', { hasText: 'Connection lost' }).waitFor();
  await here.again();
  await page.locator('.veil').waitFor({ state: 'detached' });

  // Nothing of what the page knew has gone, and it says what has happened to the controller.
  const after = (await ask('events.list')).events;
  assert.deepEqual(after.slice(0, before.length), before, 'all that was told once is told');
  await view(page, 'left', 'events');
  await page.locator('.event', { hasText: 'the controller began anew' }).last().waitFor();
  const rows = await page.locator('.event').count();
  assert.ok(rows > 3, `${rows} rows`);
  await page.reload();
  await shown(page);
  await page.locator('.event', { hasText: 'the controller began anew' }).last().waitFor();

  const stands = [await rests('left', 1e-3), await rests('right', 1e-3)];
  for (const [name, joint] of [['left', 'base'], ['right', 'shoulder']]) {
    await view(page, name, 'move');
    await until(`the ghost of ${name}`, async () => (await ghostOf(page)) === name);
    assert.ok(Math.abs(Number(await slider(page, joint).inputValue()) - wished[name]) < 1e-6, `${name}'s target`);
    assert.equal((await status(name)).state, 'off', 'nobody has switched it on');
  }
  await page.waitForTimeout(1000);
  assert.ok(apart([...(await truth('left')), ...(await truth('right'))], stands.flat()) < 5e-3, 'nothing moves by itself');
  const file = (await ask('settings.get', { robot: 'left' })).file.replace('/settings/', '/events/').replace(/json$/, 'jsonl');
  assert.ok(readFileSync(file, 'utf8').split('\n').length > before.length, 'kept in a file that people can read');
  page.errors = page.errors.filter((one) => !one.startsWith('WebSocket connection to'));
  await here.close(page, 'outlives_kill');
});

test('a program outlives its page: paused by a reload, taken over by the page that resumes it', () => patiently('reload', async () => {
  const page = await here.open({}, '#/robots/left/programs');
  await upright(page, 'left');
  const begun = await page.evaluate(() =>
    globalThis.__sinew.store.run('left', 'joint base=60deg speed=5%\njoint base=50deg', 'long one'));
  assert.ok(begun);
  await until('under way', async () => (await status('left')).state === 'moving');
  await page.reload();
  await shown(page);
  await until('paused', async () => (await status('left')).job?.client_lost === true);
  const lost = await status('left');
  assert.equal(lost.job.phase, 'paused');
  assert.ok(Math.abs((await rests('left', 1e-3))[0]) < Math.PI / 3 - 0.05, 'on its path');
  await page.locator('.run-bar .progress', { hasText: 'its client is gone' }).waitFor();
  await page.locator('.run-bar [data-tour=resume]').click();
  await until('done', async () => (await status('left')).job?.over);
  assert.equal((await status('left')).job.phase, 'done');
  assert.ok(Math.abs((await rests('left', 1e-3))[0] - (50 * Math.PI) / 180) < 0.03);
  await here.close(page, 'outlives_reload');
}));

test('a second page takes over, finds the program paused and ends it', () => patiently('taken over', async () => {
  const [first, second] = [await here.open({}, '#/robots/left/programs'), await here.open({}, '#/robots/left/programs')];
  await upright(first, 'left');
  await first.evaluate(() => globalThis.__sinew.store.run('left', 'joint base=60deg speed=5%', 'long one'));
  await until('under way', async () => (await status('left')).state === 'moving');
  await second.getByRole('button', { name: 'Take over' }).first().click();
  await until('paused', async () => (await status('left')).state === 'held');
  await second.locator('.run-bar .progress', { hasText: 'its client is gone' }).waitFor();
  await second.locator('.run-bar').getByRole('button', { name: 'End it' }).click();
  await until('over', async () => (await status('left')).job?.over);
  assert.equal((await status('left')).job.phase, 'stopped');
  for (const [i, page] of [first, second].entries()) await here.close(page, `outlives_taken_over_${i}`);
}));
