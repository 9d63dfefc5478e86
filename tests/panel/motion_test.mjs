// What moves a robot through the page, and what shows it: the handle in the 3D view, sliders, jog by buttons,
// keys and a gamepad, the run bar, rides, the switches of the 3D view, device pages. Held against
// simulation.truth, robot.status and device.status.
//
//   node --test tests/panel/motion_test.mjs     (environment: bench.mjs)
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import path from 'node:path';
import { apart, ask, bench, patiently, rests, root, seen, status, truth, until, upright } from './bench.mjs';

const robot = (name, kind, x_mm, more = '') =>
  `[[robot]]\nname = "${name}"\nrobot = "${kind}"\nx_mm = ${x_mm}\n${more}\n`;
const kBox = '[[object]]\nname = "box"\nlength_mm = 200\nwidth_mm = 200\nheight_mm = 100\nx_mm = -700\nz_mm = 50\n';
const kCell = `title = "Tests"\n${robot('left', 'learm', 0, 'profile = "bus"')}${robot('six', 'hexapod', 1500)}${kBox}`;
const kDevices = `title = "Devices"\n${robot('arm', 'robot-arm-2', 0, 'wire = "link"')}${robot('max', 'maxarm', 1500)}\
${robot('big', 'bigrobotarm', -1500)}${robot('any', path.join(root, 'robots/examples/ar4.toml'), -3000)}${robot('so', path.join(root, 'robots/examples/so-101-feetech.toml'), 3000)}`;
const deg = (value) => (value * Math.PI) / 180;

let here;
before(async () => {
  here = await bench(kCell);
});
after(() => here?.end());

/** What moves is watched over in real time. */
const moves = (name, open, go) => test(name, () => patiently(name, async () => {
  const page = await open();
  await go(page);
  await here.close(page, `motion_${name.split(/\W/, 4).join('_')}`);
}));
const button = (at, name) => at.getByRole('button', { name, exact: true });
const choose = (page, group, name) =>
  page.getByRole('radiogroup', { name: group }).getByRole('radio', { name, exact: true }).click();

async function drag(page, from, to, steps) {
  await page.mouse.move(...from);
  await page.mouse.down();
  await page.mouse.move(...to, { steps });
  await page.mouse.up();
}

/** A view, the robot upright at its zeros. */
async function stand(view) {
  const page = await here.shared({ viewport: { width: 1440, height: 900 } });
  if (await page.locator('[data-tour=skip]').isVisible()) await page.locator('[data-tour=skip]').click();
  await upright(page, 'left');
  await page.locator('.card-face', { has: page.locator('text="left"') }).click();
  await page.locator('.tabs a', { hasText: view }).click();
  return page;
}
const lastJob = async (name = 'left') => (await status(name)).job?.job ?? 0;
/** The job behind `last` has come to its end. */
async function done(last, name = 'left') {
  const job = await until(`the end of a way of ${name}`, async () => {
    const { job: now } = await status(name);
    return now?.job > last && now.over && now;
  });
  assert.equal(job.phase, 'done', JSON.stringify(job));
}
async function run(page, row, name = 'left') {
  const last = await lastJob(name);
  assert.ok(await page.evaluate(([who, text]) => globalThis.__sinew.store.run(who, text, 'way'), [name, row]));
  await done(last, name);
  return rests(name, 1e-3);
}
/** Its elbow bent: it can go to all sides. */
const bend = (page) => run(page, 'joint base=0deg shoulder=40deg elbow=35deg');

const way = (from, to) => to.map((one, i) => one - from[i]);
/** Where the tool is, m in the base, and where its own axes point. */
async function tool() {
  const { x_m: x, y_m: y, z_m: z, quaternion_wxyz: [w, i, j, k] } = (await status('left')).tool;
  const axes = [
    [1 - 2 * (j * j + k * k), 2 * (i * j + w * k), 2 * (i * k - w * j)],
    [2 * (i * j - w * k), 1 - 2 * (i * i + k * k), 2 * (j * k + w * i)],
    [2 * (i * k + w * j), 2 * (j * k - w * i), 1 - 2 * (i * i + j * j)],
  ];
  return { p: [x, y, z], axes };
}

/** What the page has as its target: joints in rad, the tool in m. */
async function target(page) {
  const p = [];
  for (const name of ['X', 'Y', 'Z']) {
    const text = await page.getByLabel(`${name}, target`, { exact: true }).inputValue();
    p.push(Number(text.replace('−', '-')) / 1000);
  }
  return { joints: await page.locator('.joint-slider input.slider').evaluateAll((all) => all.map((one) => Number(one.value))), p };
}
/** All has been drawn: the camera and the parts of the handle are where they were drawn last. */
const settled = (page) => page.waitForTimeout(300).then(() =>
  until('drawn', () => page.evaluate(() => !globalThis.sinewScene.dirty)));
const ghost = (page) => page.evaluate(() => Boolean(globalThis.sinewScene.ghost?.body.group.parent));
/** A ghost is elsewhere, with a time, and nothing has moved; Move goes there. */
async function seenThenMoved(page, begin) {
  await page.locator('.verdict.fine').waitFor();
  assert.match(await page.locator('.verdict.fine strong').innerText(), /^\d.* s$/);
  assert.ok(await ghost(page), 'a ghost stands there');
  const there = await target(page);
  assert.ok(apart(there.joints, begin) > 0.05, 'somewhere else');
  assert.ok(apart(await rests('left', 1e-3), begin) < 5e-3, 'a preview moves nothing');
  const last = await lastJob();
  await page.locator('[data-tour=go]:enabled').click();
  await done(last);
  const end = await rests('left', 1e-3);
  assert.ok(apart(there.joints, end) < 0.03, `at ${end}, not ${there.joints}`);
  await until('the ghost is gone', async () => !(await ghost(page)));
  return there;
}

moves('the handle in the 3D view is dragged: a ghost stands there, nothing moves before Move', () => stand('Move'), async (page) => {
  const begin = await bend(page);
  await button(page.locator('.view-bar'), 'left').click();
  const from = await target(page);
  await settled(page);
  const at = await page.evaluate(() => {
    const { gizmo, gizmoTarget, camera, renderer } = globalThis.sinewScene;
    const centre = gizmoTarget.getWorldPosition(camera.position.clone());
    // As large as three.js draws it from here; nearer to its middle it has squares for two axes.
    const size = (centre.distanceTo(camera.position) * 1.9 * Math.tan((Math.PI * camera.fov) / 360) * gizmo.size) / 4;
    const box = renderer.domElement.getBoundingClientRect();
    return [0, 0.06].map((further) => {
      const place = centre.clone();
      place.y += 0.55 * size + further;
      place.project(camera);
      return [box.left + ((place.x + 1) / 2) * box.width, box.top + ((1 - place.y) / 2) * box.height];
    });
  });
  await page.mouse.move(...at[0]);
  await settled(page); // three.js works out the plane of a drag as it draws the arrow that is meant
  assert.equal(await page.evaluate(() => globalThis.sinewScene.gizmo.axis), 'Y', 'its arrow is under the mouse');
  // The profile below appears meanwhile, and takes nothing from under the mouse.
  await page.mouse.down();
  for (let i = 1; i <= 5; ++i) {
    await page.mouse.move(...at[0].map((from, k) => from + ((at[1][k] - from) * i) / 5));
    await page.waitForTimeout(150);
  }
  await page.mouse.up();
  const dragged = way(from.p, (await target(page)).p);
  assert.ok(apart(dragged, [0, 0.06, 0]) < 3e-3, `dragged by ${dragged} m`);
  const there = await seenThenMoved(page, begin);
  assert.ok(apart((await tool()).p, there.p) < 12e-3, `the tool is at ${(await tool()).p}, not ${there.p}`);
});

moves('the slider of a joint is dragged: a ghost and a time, nothing moves before Move', () => stand('Move'), async (page) => {
  const begin = await rests('left', 1e-3);
  const box = await page.locator('.joint-slider', { hasText: 'shoulder' }).locator('input.slider').boundingBox();
  const at = (share) => [box.x + share * box.width, box.y + box.height / 2];
  await drag(page, at(0.5), at(0.6), 6);
  const { joints } = await seenThenMoved(page, begin);
  assert.ok(joints[1] > deg(8) && apart([...joints.slice(2), joints[0]], [...begin.slice(2, joints.length), begin[0]]) < 0.01);
});

const live = (page) => page.evaluate(() => document.querySelector('.jog-live')?.dataset.on === 'true');
const kSpeed = 0.1 * 0.2; // m/s, a tenth of what a jog by hand has
async function byHand(frame, how = 'Hold to move') {
  const page = await stand('Jog');
  await bend(page);
  await choose(page, 'Along', frame);
  await choose(page, 'How', how);
  await page.locator('.slider-field', { hasText: 'Speed' }).locator('input').fill('0.1');
  return page;
}
/** Held until `there`; once more where it was ended, by a page that had no time. A pad is looked at each 20 ms.
 * @param before  where letting go is more than that: what is before a hold */
async function held(page, [hold, letGo, before = letGo], there) {
  await until('under way', async () => {
    if (!(await live(page))) {
      await before();
      await page.waitForTimeout(60);
      await hold();
      await page.waitForTimeout(200);
    }
    return there();
  });
}
/** Held until the tool has gone 15 mm along `axis` (in the base, or its own), then let go: it rests near there. */
async function pushed(page, [hold, letGo, rest], axis) {
  const [before, begin] = [await rests('left', 1e-3), await tool()];
  await held(page, [hold, letGo, rest], async () => Math.hypot(...way(begin.p, (await tool()).p)) > 0.015);
  const [there, from] = [await tool(), Date.now()];
  await letGo();
  const took = (Date.now() - from) / 1000;
  await until('let go', async () => !(await live(page)), 20, 5000);
  assert.ok(apart(await rests('left', 1e-4), before) > 0.01, 'the machine itself has moved');
  const end = await tool();
  const on = Math.hypot(...way(there.p, end.p));
  assert.ok(on < kSpeed * (took + 0.5) + 3e-3, `${on} m on after ${took} s`);
  const gone = way(begin.p, end.p);
  const wanted = typeof axis === 'function' ? axis(begin.axes) : axis;
  const share = gone.reduce((sum, one, i) => sum + one * wanted[i], 0) / Math.hypot(...gone);
  assert.ok(share > 0.95, `${gone} m is not along ${wanted}`);
}
const mouse = (page, name) => [() => button(page, name).hover().then(() => page.mouse.down()), () => page.mouse.up()];

moves('jog in the base frame goes along its axes while a button is held', () => byHand('Base'), async (page) => {
  await pushed(page, mouse(page, 'X minus'), [-1, 0, 0]);
  await pushed(page, mouse(page, 'Y plus'), [0, 1, 0]);
  await pushed(page, mouse(page, 'Z plus'), [0, 0, 1]);
});

moves('jog in the tool frame goes along the tool’s own axes', () => byHand('Tool'), async (page) => {
  // Else the base would do as well.
  assert.ok((await tool()).axes.every((axis, i) => i === 1 || Math.abs(axis[i]) < 0.9));
  await pushed(page, mouse(page, 'Z minus'), (axes) => axes[2].map((one) => -one));
  await pushed(page, mouse(page, 'X plus'), (axes) => axes[0]);
});

moves('a step goes as far as was chosen, once a click', () => byHand('Base', 'Steps'), async (page) => {
  for (const [mm, name, axis] of [['10', 'X minus', [-1, 0, 0]], ['50', 'Y plus', [0, 1, 0]]]) {
    await choose(page, 'Step, mm', mm);
    const [begin, last] = [await tool(), await lastJob()];
    await page.locator(`button.hand[aria-label="${name}"]:enabled`).click();
    await done(last);
    await rests('left', 1e-3);
    const gone = way(begin.p, (await tool()).p);
    assert.ok(apart(gone, axis.map((one) => (one * mm) / 1000)) < 4e-3, `${mm} mm: ${gone} m`);
  }
});

moves('keys jog while they are held, once the keyboard is switched on', () => byHand('Base'), async (page) => {
  const key = (name) => [() => page.keyboard.down(name), () => page.keyboard.up(name)];
  const begin = await rests('left', 1e-3);
  await page.keyboard.press('ArrowUp', { delay: 600 });
  assert.ok(apart(await rests('left', 1e-3), begin) < 5e-3, 'not before');
  await button(page, 'Keyboard').click();
  await page.getByText('Arrows: X and Y. Page up and down: Z.').waitFor();
  await pushed(page, key('ArrowUp'), [0, 1, 0]);
  await pushed(page, key('PageUp'), [0, 0, 1]);
});

moves('a key is let go by its place, whatever Shift has made of it meanwhile', () => byHand('Joints'), async (page) => {
  if ((await button(page, 'Keyboard').getAttribute('aria-pressed')) !== 'true') await button(page, 'Keyboard').click();
  await page.evaluate(() => document.activeElement?.blur()); // a slider keeps its keys
  const rest = await rests('left', 1e-3);
  await page.keyboard.down('Shift');
  await held(page, [() => page.keyboard.down('Equal'), () => page.keyboard.up('Equal')], async () =>
    apart(await truth('left'), rest) > 0.02);
  await page.keyboard.up('Shift');
  await page.keyboard.up('Equal');
  await until('let go', async () => !(await live(page)), 20, 5000);
  await rests('left', 1e-4);
});

moves('a gamepad moves with one shoulder button held and turns with the other; its middle and its loss stop', () => byHand('Base'), async (page) => {
  const [kLeft, kRight] = [4, 5]; // shoulder buttons
  const push = (x, y, plugged = true, held = kLeft) =>
    page.evaluate(([lx, ly, there, shoulder]) => {
      const buttons = Array.from({ length: 17 }, (_, i) => ({ pressed: i === shoulder, touched: i === shoulder, value: Number(i === shoulder) }));
      const pad = { id: 'Stub (test)', index: 0, connected: there, mapping: 'standard', axes: [lx, ly, 0, 0], buttons };
      const was = Boolean(navigator.getGamepads()[0]);
      navigator.getGamepads = () => [there ? pad : null];
      const event = new Event(there ? 'gamepadconnected' : 'gamepaddisconnected');
      if (was !== there) window.dispatchEvent(Object.assign(event, { gamepad: pad }));
    }, [x, y, plugged, held]);
  await button(page, 'Gamepad').click();
  await page.getByText('No gamepad').waitFor();
  await push(0, 0, true, -1);
  await page.getByText('Stub: hold L1 to move, R1 to turn.').waitFor();
  const begin = await rests('left', 1e-3);
  await push(0, -0.9, true, -1);
  await page.waitForTimeout(600);
  assert.ok(apart(await rests('left', 1e-3), begin) < 5e-3, 'nothing moves without a shoulder button');
  await push(0, 0);
  await page.getByText('Left stick: X, Y.').waitFor();
  await pushed(page, [() => push(0, -0.9), () => push(0, 0)], [0, 1, 0]);
  await pushed(page, [() => push(-0.9, 0), () => push(0, 0)], [-1, 0, 0]);
  await push(0, 0, true, kRight);
  await page.getByText('Left stick: roll, pitch.', { exact: false }).waitFor();
  const before = await tool();
  const roll = (await truth('left'))[4];
  const turn = [() => push(0.9, 0, true, kRight), () => push(0, 0, true, kRight)];
  await held(page, turn, async () => Math.abs((await truth('left'))[4] - roll) > 0.05);
  await turn[1]();
  await rests('left', 1e-3);
  assert.ok(apart((await tool()).p, before.p) < 8e-3, 'and stays where it is');
  await pushed(page, [() => push(0, -0.9), () => push(0, -0.9, false), () => push(0, 0)], [0, 1, 0]);
  await page.getByText('No gamepad').waitFor();
});

/** The view of programs with this one, or with the form of rides. */
async function programs(tab, text) {
  const page = await stand('Programs');
  await page.locator('.programs').getByRole('radio', { name: tab, exact: true }).click();
  if (!text) return page;
  await page.getByLabel('Text of the program').fill(text);
  await page.locator('.run-bar .verdict.fine').waitFor();
  return page;
}
/** rad/s of the base, over a second of ours. */
async function pace() {
  const [[from], begin] = [await truth('left'), performance.now()];
  await new Promise((go) => setTimeout(go, 1000));
  return (((await truth('left'))[0] - from) / (performance.now() - begin)) * 1000;
}

const kLong = 'joint base=85deg speed=10%\n';
moves('a lower pace slows a program down, Pause rests, Go on goes on', () => programs('Program', kLong), async (page) => {
  const last = await lastJob();
  await page.locator('[data-tour=run]:enabled').click();
  await until('under way', async () => (await truth('left'))[0] > deg(8));
  const fast = await pace();
  const slider = page.locator('.run-sliders .slider-field', { hasText: 'Pace' }).locator('input');
  await slider.fill('0.2');
  await until('told', async () => Math.abs((await status('left')).feed - 0.2) < 1e-6);
  await page.waitForTimeout(500);
  const slow = await pace();
  assert.ok(slow > 0.05 * fast && slow < 0.4 * fast, `${fast} rad/s, then ${slow}`);
  await page.locator('[data-tour=pause]').click();
  await page.locator('[data-tour=resume]').waitFor();
  const pause = await rests('left', 1e-3);
  await page.waitForTimeout(1000);
  assert.ok(apart(await truth('left'), pause) < 5e-3 && pause[0] < deg(80), `paused at ${pause[0]} rad`);
  assert.equal((await status('left')).job.over, false);
  await slider.fill('1');
  await page.locator('[data-tour=resume]').click();
  await until('on', async () => (await truth('left'))[0] > pause[0] + 0.05);
  await done(last);
  assert.ok(Math.abs((await rests('left', 1e-3))[0] - deg(85)) < 0.03);
  assert.equal((await status('left')).feed, 1);
});

const kThree = 'joint base=15deg\njoint base=30deg\njoint base=45deg\n';
moves('Step goes one order on, Back to where the last one began', () => programs('Program', kThree), async (page) => {
  for (const [name, angle] of [['Step', 15], ['Step', 30], ['Back', 15], ['Step', 30]]) {
    await button(page.locator('.run-keys'), name).click();
    await until(`${name}: at ${angle} deg, paused`, async () =>
      Math.abs((await truth('left'))[0] - deg(angle)) < 0.03 && (await seen(page, 'left')).job?.phase === 'paused');
  }
  await button(page.locator('.run-keys'), 'End it').click();
  await until('ended', async () => (await seen(page, 'left')).job.phase === 'stopped');
  assert.ok(Math.abs((await rests('left', 1e-3))[0] - deg(30)) < 0.03, 'the last row was left out');
});

moves('a ride with a seed and a time of one’s own moves, and ends when told', () => programs('Bull ride'), async (page) => {
  await page.getByLabel('Seed').fill('7');
  await page.getByLabel('Time, s').fill('25');
  const begin = await rests('left', 1e-3);
  await page.evaluate(() => {
    const { rpc } = globalThis.__sinew;
    rpc.call = (method, params, ...more) => {
      if (method === 'robot.bullride') globalThis.ridden = params;
      return Object.getPrototypeOf(rpc).call.call(rpc, method, params, ...more);
    };
  });
  await page.locator('[data-tour=ride]:enabled').click();
  await until('under way', async () => apart(await truth('left'), begin) > 0.1);
  assert.deepEqual(await page.evaluate(() => globalThis.ridden), { robot: 'left', seed: 7, duration_s: 25 });
  await page.evaluate(() => delete globalThis.__sinew.rpc.call);
  const { title, predicted_s: long } = (await status('left')).job;
  assert.ok(title === 'bullride' && Math.abs(long - 25) < 8, `${title}, ${long} s`);
  await button(page, 'End the ride').click();
  const job = await until('over', async () => (await status('left')).job.over && (await status('left')).job);
  assert.ok(job.phase === 'stopped' && job.elapsed_s < 20, `${job.phase} after ${job.elapsed_s} s`);
  const rest = await rests('left', 1e-3);
  await page.waitForTimeout(1000);
  assert.ok(apart(await truth('left'), rest) < 5e-3);
});

/** Each picture that the page draws by itself is kept as it is. */
const keepPictures = (page) =>
  page.evaluate(() => {
    const scene = globalThis.sinewScene;
    scene.draw = () => {
      Object.getPrototypeOf(scene).draw.call(scene);
      globalThis.picture = scene.renderer.domElement.toDataURL();
    };
    scene.invalidate();
  });
/** The picture once nothing is left to draw, and how many meshes and lines with something in them. */
const drawn = (page) => settled(page).then(() => page.evaluate(() => {
  let parts = 0;
  globalThis.sinewScene.scene.traverseVisible((one) => {
    if ((one.isMesh || one.isLine) && one.geometry.drawRange.count > 0) ++parts;
  });
  return { parts, picture: globalThis.picture };
}));

moves('each switch of the 3D view changes what is drawn, and back', () => stand('Jog'), async (page) => {
  await bend(page);
  await keepPictures(page);
  const plain = await drawn(page);
  const differs = async (what, more, go) => {
    await go();
    const now = await drawn(page);
    assert.ok(more ? now.parts > plain.parts : now.parts < plain.parts, `${what}: ${now.parts} parts, ${plain.parts} before`);
    assert.ok(now.picture !== plain.picture, `${what} is to be seen`);
  };
  for (const [name, more] of [['Trail', false], ['Reach', true], ['Bodies', true], ['Objects', false]]) {
    const one = button(page.getByRole('group', { name: 'Shown' }), name);
    assert.equal(await one.getAttribute('aria-pressed'), String(!more), name);
    await differs(name, more, () => one.click());
    await one.click();
    assert.ok((await drawn(page)).picture === plain.picture, `${name}: all is as it was`);
  }
  await differs('limits of a joint', true, () => page.locator('.joint-rows li').nth(1).hover());
  await page.locator('.pane-body .slider-field').first().hover();
  assert.ok((await drawn(page)).picture === plain.picture, 'no limits any more');
});

moves('presets, one robot, the whole cell and the mouse change where it is seen from', () => stand('Jog'), async (page) => {
  await keepPictures(page);
  const before = new Map();
  const differs = async (name, go) => {
    await go();
    const { picture } = await drawn(page);
    for (const [other, old] of before) assert.ok(picture !== old, `${name} looks as ${other} does`);
    before.set(name, picture);
  };
  const click = (name) => button(page.locator('.view-bar'), name).click();
  for (const name of ['Whole cell', 'Front', 'Side', 'Top', 'Oblique', 'left', 'Corner']) await differs(name, () => click(name));
  const box = await page.locator('.canvas canvas').boundingBox();
  const [x, y] = [box.x + 0.15 * box.width, box.y + 0.8 * box.height];
  await differs('dragged', () => drag(page, [x, y], [x + 120, y - 40], 4));
  await differs('wheel', () => page.mouse.wheel(0, -300));
  await click('Corner');
  assert.ok((await drawn(page)).picture === before.get('Corner'), 'back at the corner');
});

const part = (page, name) => page.locator('.device-part', { has: page.locator('h4', { hasText: new RegExp(`^${name}$`) }) });
const table = (at) => at.locator('tbody tr').evaluateAll((rows) =>
  rows.map((row) => [...row.children].map((cell) => cell.textContent.replace('−', '-'))));
/** The page asks twice a second: once it has heard the same; at the end it is wrong. */
const agrees = (what, go) =>
  until(what, () => go().then(() => true, (error) => assert.equal(error.code, 'ERR_ASSERTION', error)), 200, 15_000).catch(go);
/** Messages come, until Pause; a filter hides them.
 * @param speak  makes a device say something that is silent at rest */
async function monitor(page, some, speak = () => undefined) {
  const newest = () => page.locator('.wire-row').last().getAttribute('id');
  const first = await newest();
  await speak();
  await until('messages come', async () => (await newest()) !== first);
  await page.locator('.wire-head').getByRole('button', { name: 'Pause' }).click();
  await page.waitForTimeout(500);
  const last = await newest();
  await page.waitForTimeout(2500);
  assert.equal(await newest(), last, 'paused');
  await page.getByLabel('Words or bytes').fill(some);
  await until(`${some} only`, async () => {
    const texts = await page.locator('.wire-row').allInnerTexts();
    return texts.length > 0 && texts.every((text) => text.includes(some));
  });
  await page.getByLabel('Words or bytes').fill('no such words');
  await page.getByText('Nothing that fits the filter.').waitFor();
  await page.getByLabel('Words or bytes').fill('');
  await page.locator('.wire-head').getByRole('button', { name: 'Go on' }).click();
  await speak();
  await until('it goes on', async () => (await newest()) !== last);
}

moves('free drive in the page: the motors go off behind a second word, nothing moves, Hold takes the arm where it is', () => stand('Jog'), async (page) => {
  const freeDrive = async (on) => until(`free drive ${on}`, async () => (await status('left')).free_drive === on);
  await button(page, 'Free drive').click();
  assert.equal((await status('left')).free_drive, false, 'asked once more');
  await button(page, 'Hold the arm first: it falls. Switch the motors off?').click();
  await freeDrive(true);
  const hold = button(page, 'Hold');
  await hold.waitFor();
  await choose(page, 'Along', 'Joints');
  assert.ok(await button(page, 'base plus').isDisabled(), 'no jog with hands on the arm');
  const last = await lastJob();
  await page.evaluate(() => globalThis.__sinew.rpc.call('program.run', { robot: 'left', text: 'joint base=10deg' }));
  const refused = await until('the program has ended', async () => {
    const { job } = await status('left');
    return job.job > last && job.over && job;
  });
  assert.match(JSON.stringify(refused), /free_drive/);
  await hold.click();
  await freeDrive(false);
  const there = await rests('left', 2e-2);
  assert.ok(there.every(Number.isFinite), 'it stands');
  await upright(page, 'left');
});

test('the device pages of five robots say what device.status says, and their monitors show frames', async () => {
  await here.end();
  here = await bench(kDevices);
  const page = await here.shared({ viewport: { width: 1440, height: 900 } });
  const open = async (name) => {
    await page.evaluate((to) => void (location.hash = to), `#/robots/${name}/device`);
    await page.evaluate((who) => void globalThis.__sinew.store.enable(who), name);
    await until(`${name} enabled`, async () => (await status(name)).state === 'ready');
  };
  const told = (name) => ask('device.status', { robot: name });

  await open('arm');
  await agrees('six axes', async () => {
    const { axes } = await told('arm');
    assert.ok(axes.length === 6 && axes.every((one) => one.health), 'each has told its health');
    assert.equal(await page.locator('.device-parts .device-part').count(), 6);
    for (const [i, axis] of axes.entries()) {
      const text = (await part(page, axis.joint).innerText()).replace(/\s+/g, ' ').replaceAll(' :', ':').replaceAll('−', '-');
      const [, shown] = /Encoder (-?[\d.]+)°/.exec(text) ?? [];
      assert.ok(Math.abs(shown - (axis.position_rad * 180) / Math.PI) < 0.03, `${axis.joint}: ${text}, told ${axis.position_rad}`);
      assert.match(text, /Following error follows nothing now/);
      const yes = (flag) => (axis.flags[flag] ? 'yes' : 'no');
      const words = [`${axis.health.supply_v.toFixed(1)} V`, `Failed frames ${axis.failed_frames} `];
      for (const one of [...words, `end stop: ${yes('end_stop')}`, `homed: ${yes('homed')}`]) assert.ok(text.includes(one), text);
    }
  });
  await monitor(page, 'accepted');

  await open('max');
  await run(page, 'joint base=140deg', 'max');
  await agrees('told, read back, nozzle', async () => {
    const { told: sent, angles, position } = await told('max');
    const rows = angles.servos.map((one, i) =>
      [one.joint, String(sent.servos[i].pulse), String(one.pulse), `${((one.position_rad * 180) / Math.PI).toFixed(1)}°`]);
    assert.deepEqual(await table(part(page, 'Servos, read back')), rows);
    assert.match(await part(page, 'Answers').innerText(), /Arduino program/);
    assert.ok((await part(page, 'Nozzle').innerText()).includes(`${position.xyz_mm.join(', ')} mm`));
    assert.ok(Math.abs(angles.servos[0].position_rad - (await truth('max'))[0]) < 0.01 && rows[0][3] !== '120.0°');
  });
  await monitor(page, 'angles');

  await open('big');
  await page.evaluate(() => globalThis.__sinew.rpc.call('robot.declare', { robot: 'big' }));
  await run(page, 'joint base=10deg elbow=20deg', 'big');
  await agrees('counters', async () => {
    const { status: now } = await told('big');
    const rows = now.joints.map((one) =>
      [one.joint, String(one.steps), one.speed_rev_s.toFixed(2), one.acceleration_rev_s2.toFixed(2)]);
    assert.deepEqual(await table(part(page, 'Step counters')), rows);
    assert.ok(now.joints[0].steps !== 0 && now.joints[2].steps !== 0 && now.joints[3].steps === 0, JSON.stringify(rows));
    assert.match(await part(page, 'Step counters').innerText(), new RegExp(`servo at ${now.gripper.servo_deg}°`));
  });
  let base = 10;
  await monitor(page, 'steps', () => run(page, `joint base=${(base += 5)}deg`, 'big'));

  await open('so');
  await run(page, 'joint pan=30deg', 'so');
  await agrees('six servos', async () => {
    const { bus_servos: servos } = await told('so');
    const rows = await table(part(page, 'Servos'));
    assert.equal(rows.length, 6);
    for (const [i, one] of servos.entries()) {
      assert.equal(rows[i][0], one.joint);
      assert.equal(rows[i][1], String(one.servo));
      const [shown] = /[\d.]+/.exec(rows[i][2]);
      const measured = one.position_rad === undefined ? 1000 * one.width_m : Math.abs(one.position_rad) / deg(1);
      assert.ok(Math.abs(shown - measured) < 0.3, `${rows[i]}, told ${measured}`);
      assert.deepEqual(rows[i].slice(4), [String(one.temperature_c), one.volts.toFixed(1), 'on']);
    }
  });
  await monitor(page, 'reply');

  // An arm of which the table and the limits are known, no more.
  await open('any');
  await run(page, 'joint shoulder=20deg wrist=45deg', 'any');
  await monitor(page, 'state');
  await page.evaluate(() => void (location.hash = '#/robots/any/jog'));
  await choose(page, 'Along', 'Joints');
  await choose(page, 'How', 'Hold to move');
  const [hold, letGo] = mouse(page, 'base plus');
  await held(page, [hold, letGo], async () => (await truth('any'))[0] > deg(3));
  await letGo();
  assert.ok((await rests('any', 1e-5))[0] > deg(3));
  await here.close(page, 'motion_devices');
});
