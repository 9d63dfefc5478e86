// The page for everybody: axe-core over every view of every kind of robot, the keyboard alone, a tablet, a page
// that is twice as large, people who want nothing to move that is no robot.
//
//   node --test tests/panel/access_test.mjs     (environment: bench.mjs)
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { bench, ready, root, seen, until } from './bench.mjs';

const axe = readFileSync(path.join(root, 'panel/node_modules/axe-core/axe.min.js'), 'utf8');
const kRobots = ['arm', 'learm', 'big', 'max', 'platform'];
const kViews = ['jog', 'move', 'programs', 'camera', 'setup', 'plots', 'device', 'events', 'help'];

let here;
before(async () => {
  here = await bench(readFileSync(path.join(root, 'cells/five.toml'), 'utf8'));
});
after(() => here?.end());
afterEach(() => here.clear());

async function open(options) {
  // Colours on their way from one to the other are neither.
  const page = await here.open({ viewport: { width: 1440, height: 900 }, reducedMotion: 'reduce', ...options });
  await page.locator('.tour [data-tour=skip]').click();
  await page.evaluate(axe);
  return page;
}
/** Without waiting for a change of address, which a page in the same place has none of. */
async function go(page, robot, view) {
  await page.evaluate((to) => void (location.hash = to), `#/robots/${robot}/${view}`);
  await page.locator(`.card.chosen .card-name:text-is("${robot}")`).waitFor();
  await page.locator(`.work[data-view=${view}]`).waitFor();
  await page.evaluate(() => new Promise((go) => requestAnimationFrame(() => requestAnimationFrame(go))));
}

/** What axe finds grave now, a line each. @param part  of the page; the rest of it has been looked at */
async function look(page, where, part) {
  const found = await page.evaluate(async (within) => {
    const { violations } = await globalThis.axe.run(within ?? document, { resultTypes: ['violations'] });
    return violations
      .filter((one) => one.impact === 'serious' || one.impact === 'critical')
      .flatMap((one) => one.nodes.map((node) => `${one.id}: ${node.target.join(' ')}: ${node.any[0]?.message ?? node.all[0]?.message ?? one.help}`));
  }, part);
  return found.map((one) => `${where}: ${one}`);
}
const none = (found) => assert.equal(found.length, 0, `\n${[...new Set(found)].join('\n')}`);

// Colours do not depend on the language, nor words on the theme: two of the four pairs see all of both.
for (const [colorScheme, locale] of [['dark', 'en-GB'], ['light', 'de-DE']]) {
  test(`axe finds nothing grave in any view of any robot: ${colorScheme}, ${locale}`, async () => {
    const page = await open({ colorScheme, locale });
    const found = [];
    for (const robot of kRobots) {
      for (const view of kViews) {
        await go(page, robot, view);
        found.push(...(await look(page, `${robot} ${view}`, robot === 'learm' ? undefined : '.pane')));
      }
    }
    // .. and in what a press brings: tabs, a refusal, a question, a robot that is on.
    const press = async (where, name, at = page.locator('.pane')) => {
      await at.getByRole('radio', { name }).click();
      found.push(...(await look(page, `${where} ${name}`)));
    };
    await ready(page, 'learm');
    await go(page, 'learm', 'jog');
    found.push(...(await look(page, 'learm ready, jog')));
    await press('jog', /^(Base|Basis)$/);
    await go(page, 'learm', 'programs');
    await page.getByLabel(/^(Text of the program|Text des Programms)$/).fill('joint elbow=130deg\nwait 1s\n');
    await page.locator('li[data-verdict=refused]').waitFor();
    found.push(...(await look(page, 'refused row')));
    await page.locator('li[data-line="2"] .step-face').click();
    found.push(...(await look(page, 'opened row')));
    await press('programs', /^(Points|Punkte)$/);
    await press('programs', /^(Bull ride|Rodeo)$/);
    await go(page, 'learm', 'plots');
    await press('plots', /^(Record|Aufzeichnung)$/);
    await go(page, 'learm', 'help');
    await press('help', /^(About|Über)/);
    await go(page, 'platform', 'setup');
    await page.getByRole('button', { name: /^(Begin recovery|Wiederfinden|Go on here|Hier fortfahren)/ }).click();
    await page.locator('.question').waitFor();
    found.push(...(await look(page, 'question')));
    await page.evaluate(() => globalThis.__sinew.store.note('refused', 'a sentence', 'learm'));
    await page.locator('.note').first().waitFor();
    found.push(...(await look(page, 'note')));
    none(found);
    await here.close(page, `access_${colorScheme}`);
    });
}

/** What reaches beyond the page, a line each: nobody should have to scroll sideways. */
const beyond = (page) =>
  page.evaluate(() => {
    const wide = document.documentElement.clientWidth;
    const told = [];
    if (document.documentElement.scrollWidth > wide) told.push(`the page is ${document.documentElement.scrollWidth} px wide`);
    for (const one of document.querySelectorAll('.rail, .pane, .pane-scroll, .tabs, .top, .view-bar, .dock')) {
      if (one.scrollWidth > one.clientWidth + 1) told.push(`${one.className}: ${one.scrollWidth} px in ${one.clientWidth}`);
    }
    for (const one of document.querySelectorAll('button, a, input, select, textarea')) {
      const box = one.getBoundingClientRect();
      if (!one.checkVisibility({ visibilityProperty: true }) || box.width < 2 || one.closest('.skip, .sr-only')) continue;
      // .. nor what it stands in: a part of a button is no button.
      for (let at = one.parentElement; at; at = at.parentElement) {
        const { overflowX } = getComputedStyle(at);
        const edge = at.getBoundingClientRect();
        if (overflowX === 'hidden' && (box.right > edge.right + 1 || box.left < edge.left - 1)) {
          told.push(`${one.className || one.tagName} "${one.textContent.trim()}" is cut off by ${at.className}`);
        }
      }
      if (box.left < -1 || box.right > wide + 1) told.push(`${one.className || one.tagName} "${one.textContent.trim()}" to ${Math.round(box.right)} px`);
    }
    return told;
  });

for (const [name, options] of [
  ['a tablet, 820 by 1180', { viewport: { width: 820, height: 1180 }, colorScheme: 'light' }],
  ['twice as large, 1440 by 900 at 200 %', { viewport: { width: 720, height: 450 }, deviceScaleFactor: 2, locale: 'de-DE' }],
]) {
  test(`${name}: nothing grave, and nothing beyond its edge`, async () => {
    const page = await open(options);
    const found = [];
    for (const view of kViews) {
      const robot = kRobots[kViews.indexOf(view) % kRobots.length];
      await go(page, robot, view);
      found.push(...(await look(page, view)));
      found.push(...(await beyond(page)).map((one) => `${view}: ${one}`));
    }
    assert.ok(await page.locator('button.stop').isVisible());
    none(found);
    await here.close(page, `access_${options.viewport.width}`);
    });
}

/** Presses Tab until it comes round; what had the focus, and whether that was to be seen. */
async function tabThrough(page) {
  await page.evaluate(() => {
    document.activeElement?.blur();
    window.getSelection()?.removeAllRanges();
    document.querySelector('.skip').focus();
  });
  // Whoever focuses by script sees no ring: the first one comes round at the end.
  await page.keyboard.press('Tab');
  const been = new Set();
  const unseen = [];
  for (let i = 0; i < 250; ++i) {
    const now = await page.evaluate(() => {
      const one = document.activeElement;
      if (!one || one === document.body) return null;
      one.dataset.been ??= String(Math.random());
      const box = one.getBoundingClientRect();
      const rings = [one, one.parentElement, one.parentElement?.parentElement].some((each) => {
        const style = each && getComputedStyle(each);
        return style && style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 2;
      });
      const inside = box.bottom > 0 && box.top < innerHeight && box.right > 0 && box.left < innerWidth;
      const name = `${one.tagName} ${one.className} "${(one.textContent || one.getAttribute('aria-label') || '').trim().slice(0, 30)}"`;
      return { id: one.dataset.been, rings, inside, name };
    });
    if (now && been.has(now.id)) break;
    if (now) {
      been.add(now.id);
      if (!now.rings || !now.inside) unseen.push(`focus on ${now.name} is not to be seen`);
    }
    await page.keyboard.press('Tab');
  }
  // Of a group of radio buttons one is reached, and the arrows do the rest.
  const missed = await page.evaluate(() =>
    [...document.querySelectorAll('button, a[href], input, select, textarea')]
      .filter((one) => !one.disabled && !one.closest('fieldset:disabled, [inert]') && one.checkVisibility({ visibilityProperty: true }))
      .filter((one) => !one.dataset.been && !(one.type === 'radio' || one.getAttribute('role') === 'radio'))
      .map((one) => `${one.tagName} ${one.className} "${one.textContent.trim().slice(0, 30)}" is not reached`),
  );
  await page.evaluate(() => document.querySelectorAll('[data-been]').forEach((one) => delete one.dataset.been));
  return { count: been.size, wrong: [...unseen, ...missed] };
}

test('by the keyboard alone every control is reached, and where one is can be seen', async () => {
  const page = await open();
  const wrong = [];
  await ready(page, 'learm');
  for (const view of kViews) {
    await go(page, 'learm', view);
    const told = await tabThrough(page);
    assert.ok(told.count > 10, `${view}: ${told.count}`);
    wrong.push(...told.wrong.map((one) => `${view}: ${one}`));
  }
  none(wrong);
  // Radio buttons by their arrows.
  await go(page, 'learm', 'jog');
  await page.getByRole('radio', { name: 'Joints' }).focus();
  await page.keyboard.press('ArrowRight');
  assert.equal(await page.getByRole('radio', { name: 'Base', exact: true }).getAttribute('aria-checked'), 'true');
  await here.close(page, 'access_keyboard');
});

test('Esc and Space stop in every view, Space writes in a text, and both can be switched off', async () => {
  const page = await open();
  const live = page.locator('[aria-live=assertive]');
  const stops = async (key) => {
    const before = (await page.evaluate(() => globalThis.__sinew.stops ?? 0));
    await page.keyboard.press(key);
    await page.waitForTimeout(30);
    return (await page.evaluate(() => globalThis.__sinew.stops ?? 0)) - before;
  };
  // What goes out, counted on its way.
  await page.evaluate(() => {
    const { rpc } = globalThis.__sinew;
    const call = rpc.call.bind(rpc);
    globalThis.__sinew.stops = 0;
    rpc.call = (method, ...more) => {
      if (method === 'robot.stop') ++globalThis.__sinew.stops;
      return call(method, ...more);
    };
  });
  for (const view of kViews) {
    await go(page, 'learm', view);
    await page.locator('.tabs a[aria-current=page]').focus();
    assert.equal(await stops('Escape'), 1, `Esc in ${view}`);
    assert.equal(await stops('Space'), 1, `Space in ${view}`);
  }
  await until('told', async () => (await live.innerText()).includes('Stop sent'));
  await go(page, 'learm', 'programs');
  const text = page.getByLabel('Text of the program');
  await text.fill('wait');
  await text.press('End');
  assert.equal(await stops('Space'), 0, 'a text takes Space');
  assert.equal(await text.inputValue(), 'wait ');
  assert.equal(await stops('Escape'), 1, 'Esc stops there, too');
  await page.getByRole('button', { name: 'Esc and Space stop: on' }).press('Enter');
  assert.equal(await stops('Escape'), 0);
  assert.equal(await stops('Space'), 0);
  await here.close(page, 'access_stop_keys');
});

test('who wants less motion gets none but the robots’ own', async () => {
  const page = await open({ reducedMotion: 'no-preference' });
  const running = () => page.evaluate(() => document.getAnimations().filter((one) => one.playState === 'running').length);
  await ready(page, 'learm');
  await page.evaluate(() =>
    globalThis.__sinew.store.run('learm', 'joint base=0deg shoulder=0deg elbow=0deg wrist=0deg roll=0deg speed=20%', 'slow'),
  );
  await until('it moves', async () => ['moving', 'recovering'].includes((await seen(page, 'learm')).state));
  await until('its dot pulses', async () => (await running()) > 0);
  await page.emulateMedia({ reducedMotion: 'reduce' });
  await page.locator('.top-tools button').first().hover();
  assert.equal(await running(), 0);
  assert.ok(['moving', 'recovering'].includes((await seen(page, 'learm')).state), 'it still moved');
  await page.keyboard.press('Escape');
  await here.close(page, 'access_motion');
});
