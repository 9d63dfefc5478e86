// Other hands than a mouse: fingers on a tablet, and the keyboard where a robot moves in steps.
//
//   node --test tests/panel/hands_test.mjs     (environment: bench.mjs)
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { apart, ask, bench, patiently, ready, rests, status, truth, until, upright } from './bench.mjs';

const robot = (name, kind, x_mm, more = '') => `[[robot]]\nname = "${name}"\nrobot = "${kind}"\nx_mm = ${x_mm}\n${more}\n`;
let here;
before(async () => {
  here = await bench(`title = "Tests"\n${robot('left', 'learm', 0, 'profile = "bus"')}${robot('max', 'maxarm', 1200)}`);
});
after(() => here?.end());
afterEach(() => here.clear());

const kTablet = { viewport: { width: 1024, height: 768 }, hasTouch: true };

/** A finger; the browser's own events come of it. */
async function finger(page) {
  const wire = await page.context().newCDPSession(page);
  const touch = (type, points) => wire.send('Input.dispatchTouchEvent', { type, touchPoints: points });
  let is = false;
  const ends = (type) => {
    const was = is;
    is = false;
    return was && touch(type, []);
  };
  return {
    down: ([x, y]) => {
      is = true;
      return touch('touchStart', [{ x, y }]);
    },
    move: ([x, y]) => touch('touchMove', [{ x, y }]),
    up: () => ends('touchEnd'),
    cancel: () => ends('touchCancel'),
  };
}
const middle = async (at) => {
  await at.scrollIntoViewIfNeeded();
  const box = await at.boundingBox();
  return [box.x + box.width / 2, box.y + box.height / 2];
};

test('a finger holds a button: the arm moves, and rests when it is lifted, cancelled, or the view is another', () => patiently('touch', async () => {
  const page = await here.open(kTablet, '#/robots/left/jog');
  await upright(page, 'left');
  const hand = await finger(page);
  const plus = page.locator('button.hand[aria-label="base plus"]:enabled');
  const held = async () => {
    const [from] = await truth('left');
    await until('under way', async () => {
      if (!(await page.evaluate(() => document.querySelector('.jog-live')?.dataset.on === 'true'))) {
        await hand.cancel();
        await hand.down(await middle(plus));
        await page.waitForTimeout(300);
      }
      return Math.abs((await truth('left'))[0] - from) > 0.03;
    });
  };
  const ends = {
    lifted: () => hand.up(),
    cancelled: () => hand.cancel(),
    'another view': () => page.evaluate(() => void (location.hash = '#/robots/left/move')),
  };
  for (const [how, end] of Object.entries(ends)) {
    await held();
    const [there] = await truth('left');
    await end();
    const [rest] = await rests('left', 1e-4);
    assert.ok(Math.abs(rest - there) < 0.25, `${how}: ${rest - there} rad on`);
    await page.waitForTimeout(700);
    assert.ok(apart(await truth('left'), [rest, ...(await truth('left')).slice(1)]) < 5e-3, `${how}: nothing goes on`);
  }
  await hand.cancel();
  await here.close(page, 'hands_touch');
}));

test('a slider follows a finger, and a step of a program is dragged by its grip', () => patiently('drag', async () => {
  const page = await here.open({ ...kTablet, viewport: { width: 1366, height: 1024 } }, '#/robots/left/move');
  await upright(page, 'left');
  const hand = await finger(page);
  const slider = page.locator('.joint-slider', { hasText: 'base' }).locator('input.slider');
  await middle(slider);
  const box = await slider.boundingBox();
  const at = (share) => [box.x + share * box.width, box.y + box.height / 2];
  await hand.down(at(0.5));
  for (const share of [0.6, 0.7, 0.8]) await hand.move(at(share)); // more than a finger trembles
  await hand.up();
  await page.locator('.verdict.fine').waitFor();
  const value = Number(await slider.inputValue());
  assert.ok(value > 0.15, `${value} rad`);

  await page.evaluate(() => void (location.hash = '#/robots/left/programs'));
  await page.getByLabel('Text of the program').fill('joint base=10deg\nwait 1s\njoint base=20deg\n');
  const grips = page.locator('.grip');
  await until('three rows', async () => (await grips.count()) === 3);
  const [from, to] = [await middle(grips.nth(2)), await middle(grips.nth(0))];
  await hand.down(from);
  for (let i = 1; i <= 6; ++i) await hand.move([from[0], from[1] + ((to[1] - 12 - from[1]) * i) / 6]);
  await hand.up();
  await until('its row is the first', async () =>
    (await page.getByLabel('Text of the program').inputValue()) === 'joint base=20deg\njoint base=10deg\nwait 1s\n');

  // A longer program than can be seen: held at the edge the list goes on.
  const rows = Array.from({ length: 40 }, (_, i) => `wait ${i + 1}s`);
  await page.getByLabel('Text of the program').fill(`${rows.join('\n')}\n`);
  await until('forty rows', async () => (await grips.count()) === 40);
  const begin = await middle(grips.nth(39));
  const top = await page.locator('.steps').evaluate((list) => {
    for (let at = list; at; at = at.parentElement) {
      if (at.scrollHeight > at.clientHeight && /auto|scroll/.test(getComputedStyle(at).overflowY)) return at.getBoundingClientRect().top;
    }
    return 0;
  });
  await hand.down(begin);
  await hand.move([begin[0], begin[1] - 40]);
  await hand.move([begin[0], top + 15]);
  await until('the first row', async () => (await grips.nth(0).boundingBox()).y >= top);
  await hand.up();
  await until('the last row is near the top', async () =>
    (await page.getByLabel('Text of the program').inputValue()).split('\n').slice(0, 4).includes('wait 40s'));
  await here.close(page, 'hands_drag');
}));

test('a robot that moves in steps takes one from each press of a key', () => patiently('steps', async () => {
  const page = await here.open({}, '#/robots/max/jog');
  await ready(page, 'max');
  const home = (await status('max')).joints.length;
  assert.equal(home, 3);
  await page.evaluate(() => globalThis.__sinew.store.run('max', 'home', 'begin')).catch(() => undefined);
  await rests('max', 1e-3);
  const joints = page.getByRole('radiogroup', { name: 'Along' }).getByRole('radio', { name: 'Joints', exact: true });
  await joints.click();
  await page.getByRole('button', { name: 'Keyboard', exact: true }).click();
  await page.getByText('Each press is one step.').waitFor();
  await page.evaluate(() => document.activeElement?.blur());
  const job = async () => (await status('max')).job?.job ?? 0;
  const [last, [from]] = [await job(), await rests('max', 1e-3)];
  await page.keyboard.press('1');
  await page.keyboard.down('Equal');
  await until('its step', async () => (await job()) === last + 1 && (await status('max')).job.over);
  await page.keyboard.down('Equal'); // as a held key repeats itself
  await page.waitForTimeout(600);
  await page.keyboard.up('Equal');
  const [to] = await rests('max', 1e-3);
  assert.equal(await job(), last + 1, 'a key that is held is one press');
  assert.ok(Math.abs(to - from - (5 * Math.PI) / 180) < 0.02, `${to - from} rad`);
  await page.keyboard.press('Minus');
  await until('back', async () => Math.abs((await truth('max'))[0] - from) < 0.02);
  await here.close(page, 'hands_steps');
}));

test('Enter ticks a box, since Space is Stop', async () => {
  const page = await here.open({}, '#/robots/left/plots');
  const box = page.getByLabel('Velocity');
  await box.focus();
  const was = await box.isChecked();
  await page.keyboard.press('Enter');
  assert.equal(await box.isChecked(), !was);
  await page.keyboard.press('Space');
  assert.equal(await box.isChecked(), !was, 'Space ticks nothing');
  await page.locator('[aria-live=assertive]', { hasText: 'Stop' }).waitFor({ state: 'attached' });
  await page.keyboard.press('Enter');
  assert.equal(await box.isChecked(), was);
  await here.close(page, 'hands_enter');
});

test('what is kept for all is deleted when it is asked for twice', async () => {
  const page = await here.open({}, '#/robots/left/programs');
  await upright(page, 'left');
  await page.locator('.programs').getByRole('radio', { name: 'Points', exact: true }).click();
  await page.locator('[data-tour=take]').click();
  const point = page.locator('.point', { hasText: 'point1' });
  await point.waitFor();
  const kept = async () => (await ask('points.list', { robot: 'left' })).points.map((one) => one.name);
  await until('kept', async () => (await kept()).includes('point1'));
  await point.getByRole('button', { name: 'Delete point1' }).click();
  await point.getByRole('button', { name: 'Keep it' }).click();
  await page.waitForTimeout(300);
  assert.deepEqual(await kept(), ['point1']);
  await point.getByRole('button', { name: 'Delete point1' }).click();
  await point.locator('.sure').getByRole('button', { name: 'Delete point1' }).click();
  await point.waitFor({ state: 'detached' });
  await until('gone', async () => (await kept()).length === 0);
  await here.close(page, 'hands_delete');
});
