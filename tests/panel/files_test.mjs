// What the controller keeps for its people, in a browser against a simulated cell: records, programs and
// points that every browser sees, settings beside the cell's file.
//
//   node --test tests/panel/files_test.mjs      (bench.mjs says what can be set)
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { ask, bench, root, seen, shown, truth, until } from './bench.mjs';

const kCell = `title = "Tests"

[[robot]]
name = "left"
robot = "learm"
profile = "bus"

[[robot]]
name = "six"
robot = "hexapod"
x_mm = 1500

[[robot]]
name = "big"
robot = "bigrobotarm"
x_mm = 4000
`;

let here;
before(async () => {
  here = await bench(kCell);
});
after(() => here?.end());
afterEach(() => here.clear());

const kLarge = { viewport: { width: 1440, height: 900 } };
async function open(view, options = {}, robot = 'left') {
  const page = await here.open({ ...kLarge, ...options }, `#/robots/${robot}/${view}`);
  const skip = page.locator('[data-tour=skip]');
  if (await skip.isVisible()) await skip.click();
  return page;
}
const textOf = (page) => page.getByLabel('Text of the program').inputValue();
const write = (page, text) => page.getByLabel('Text of the program').fill(text);
const pick = (page, name) => page.locator('select.open').selectOption({ label: name });
const offers = (page, name) =>
  until(`${name} is offered`, () => page.locator('select.open option').evaluateAll((all, one) => all.some((each) => each.textContent === one), name));
const save = async (page, name) => {
  await page.locator('.program-head input[type=text]').fill(name);
  await page.locator('.program-head .save').click();
};
const kept = async (name) => {
  const { folder } = await ask('programs.list', { robot: 'left' });
  const file = path.join(folder, `${name}.sinew`);
  return existsSync(file) ? readFileSync(file, 'utf8') : null;
};

/** Enabled, and from wherever it is to a place that is known. */
const drive = (page) =>
  until('there', async () => {
    // The job before this one is over, too.
    const before = (await seen(page, 'left')).job?.job;
    const began = await page.evaluate(async () => {
      const { store } = globalThis.__sinew;
      if (store.status.value.left.state === 'off') await store.enable('left');
      return store.run('left', 'joint base=0deg shoulder=0deg elbow=0deg wrist=0deg roll=0deg\njoint base=20deg\n', 'test');
    });
    if (!began) return false;
    const end = await until('over', async () => {
      const { job } = await seen(page, 'left');
      return job?.over && job.job !== before && job;
    });
    return end.phase === 'done';
  }, 1000);

test('a move is recorded, listed, downloaded, played and deleted', async () => {
  const page = await open('plots');
  await page.getByLabel('Name of the record').fill('my move');
  await page.getByRole('button', { name: 'Record', exact: true }).click();
  await page.locator('.recording').waitFor();
  await drive(page);
  const base = (await truth('left'))[0];
  await page.getByRole('button', { name: 'Stop recording' }).click();
  await page.getByRole('radio', { name: 'Record' }).click();
  const row = page.locator('.records-list li', { hasText: 'my-move' });
  // Its last samples are written behind the button.
  await row.filter({ hasText: / s · \d+(\.\d)? [kM]B/ }).waitFor();
  assert.match(await row.innerText(), /left[\s\S]*my-move/);

  const taken = async (button) => {
    const [file] = await Promise.all([page.waitForEvent('download'), row.getByRole('button', { name: button, exact: true }).click()]);
    return { name: file.suggestedFilename(), bytes: readFileSync(await file.path()) };
  };
  const { folder, records } = await ask('records.list', {});
  const { record } = records.find((one) => one.title === 'my-move');
  assert.ok(records.some((one) => one.title?.startsWith('run-')), 'the run itself left one, too');
  const mcap = await taken('MCAP');
  assert.equal(mcap.name, record);
  assert.deepEqual(mcap.bytes, readFileSync(path.join(folder, record)), 'byte for byte');
  const csv = await taken('CSV');
  assert.match(csv.name, /\.csv$/);
  const rows = csv.bytes.toString().trim().split('\n').map((one) => one.split(','));
  const at = rows[0].indexOf('base_position_rad');
  assert.ok(at > 0 && rows.length > 100, `${rows.length} rows of ${rows[0]}`);
  assert.ok(Math.abs(Number(rows.at(-1)[at]) - base) < 0.03, `${rows.at(-1)[at]} and ${base}`);

  const before = await truth('left');
  await row.getByRole('button', { name: /^Play/ }).click();
  const time = page.getByLabel('Time in the record');
  await time.waitFor();
  // Where it began nobody knew where the arm stood.
  await time.focus();
  await page.keyboard.press('End');
  await until('the ghost', () => page.evaluate(() => globalThis.sinewScene.ghost?.robot === 'left'));
  await page.keyboard.press('Home');
  await page.getByRole('button', { name: 'Play the record' }).click();
  await until('it plays', async () => Number(await time.inputValue()) > 0.3);
  assert.ok(Math.max(...(await truth('left')).map((one, i) => Math.abs(one - before[i]))) < 5e-3, 'no machine moves by that');
  await here.close(page, 'files_record');

  await row.getByRole('button', { name: /^Delete/ }).click();
  await page.getByRole('button', { name: 'Delete for good' }).click();
  await until('gone', () => !existsSync(path.join(folder, record)));
  await row.waitFor({ state: 'detached' });
});

test('what one browser saves another one sees, and neither overwrites the other unasked', async () => {
  const one = await open('programs');
  const other = await open('programs');
  await write(one, 'wait 1s\n');
  await save(one, 'swing');
  await until('on the disk', async () => (await kept('swing')) === 'wait 1s\n');
  await offers(other, 'swing');
  await pick(other, 'swing');
  assert.equal(await textOf(other), 'wait 1s\n');

  // What was only opened follows; what was changed stays, and asks.
  await write(one, 'wait 2s\n');
  await save(one, 'swing');
  await until('it follows', async () => (await textOf(other)) === 'wait 2s\n');
  await write(other, 'wait 3s\n');
  await write(one, 'wait 4s\n');
  await save(one, 'swing');
  await until('on the disk', async () => (await kept('swing')) === 'wait 4s\n');
  await save(other, 'swing');
  await other.getByText('Somebody else has changed swing').waitFor();
  assert.equal(await kept('swing'), 'wait 4s\n', 'nothing was overwritten');
  assert.equal(await textOf(other), 'wait 3s\n', 'nothing is lost');
  await other.getByRole('button', { name: 'Put mine in its place' }).click();
  await until('asked for', async () => (await kept('swing')) === 'wait 3s\n');

  // Points too.
  await other.getByRole('radio', { name: 'Points' }).click();
  await drive(other);
  await other.getByLabel('Name of the point').fill('here');
  await other.locator('[data-tour=take]').click();
  await other.locator('.point', { hasText: 'here' }).waitFor();
  await one.getByRole('radio', { name: 'Points' }).click();
  await one.locator('.point', { hasText: 'here' }).waitFor();
  await one.getByRole('button', { name: 'Rename here' }).click();
  await one.locator('.point .rename').fill('there');
  await one.keyboard.press('Enter');
  await other.locator('.point', { hasText: 'there' }).waitFor();
  const { file } = await ask('points.list', { robot: 'left' });
  assert.match(readFileSync(file, 'utf8'), /^\[points\.there\]\nrobot = "learm"\njoints_deg = \[/);
  await here.close(one, 'files_shelf');
  await here.close(other, 'files_other');
});

test('what a browser kept by itself is offered to the controller, and nothing there is overwritten', async () => {
  // Before the page is there, which keeps its own shelf anew when it hears of a change.
  await ask('programs.save', { robot: 'left', name: 'old', text: 'wait 9s\n', revision: 0 });
  const page = await open('programs');
  await page.evaluate(() => {
    const shelf = { programs: { old: 'wait 5s\n', mine: 'wait 6s\n' }, points: [{ name: 'p9', joints: [0, 0.1, 0.2, 0.3, 0] }], draft: { name: '', text: '' } };
    localStorage.setItem('sinew.shelf.learm', JSON.stringify(shelf));
  });
  await page.reload();
  await shown(page);
  await page.getByText('In this browser only: old, mine, p9').waitFor();
  await page.getByRole('button', { name: 'Hand them over' }).click();
  await until('there', async () => (await kept('mine')) === 'wait 6s\n' && (await kept('old2')) === 'wait 5s\n');
  assert.equal(await kept('old'), 'wait 9s\n');
  await until('the point too', async () => (await ask('points.list', { robot: 'left' })).points.some((one) => one.name === 'p9'));
  await page.getByText('In this browser only').waitFor({ state: 'detached' });
  await here.close(page, 'files_handed_over');
});

test('files of other programs are opened as rows, rows are saved as theirs, and what has no row is refused with its line', async () => {
  const page = await open('programs', {}, 'six');
  const given = (name, buffer) => page.locator('.programs input[type=file]').setInputFiles({ name, mimeType: 'text/plain', buffer });
  const row = 'move x=1.5mm y=-2mm z=251mm rx=0.5deg ry=1deg rz=2deg\n';
  await write(page, row);
  const [file] = await Promise.all([
    page.waitForEvent('download'),
    page.getByRole('button', { name: 'Save the pose as .pos 1,5, with decimal commas for German PCs' }).click(),
  ]);
  assert.match(file.suggestedFilename(), /\.pos$/);
  const pose = readFileSync(await file.path(), 'utf8');
  assert.match(pose, /^-?\d+,\d+/);
  // As Windows writes it.
  await given('stand.pos', Buffer.from(`\ufeff${pose.replaceAll('\n', '\r\n')}`, 'utf16le'));
  await until('its row', async () => (await textOf(page)).endsWith(row) && (await textOf(page)).startsWith('# heads fit'));
  await given('arc.nc', Buffer.from('G21 G90\nG2 X1 I1\n'));
  await page.locator('.file-told', { hasText: 'the file:2:1' }).waitFor();
  assert.ok((await textOf(page)).endsWith(row), 'nothing is opened then');
  await write(page, `${row}wait 1s\n`);
  await page.getByRole('button', { name: 'Save the pose as .pos', exact: true }).click();
  await page.locator('.file-told', { hasText: 'one row that moves' }).waitFor();
  await here.close(page, 'files_foreign');
});

test('a bad setting is refused where it stands, a good one lies beside the cell’s file and counts from the next start', async () => {
  const page = await open('setup');
  await page.getByText('Settings', { exact: true }).click();
  const form = page.locator('.settings form');
  const saves = form.getByRole('button', { name: 'Save', exact: true });
  await form.getByLabel('base: Trim').fill('20');
  await form.getByText('a trim is a number from -15 to 15 degrees').waitFor();
  assert.ok(await saves.isDisabled());
  await form.getByLabel('base: Trim').fill('2.5');
  await form.getByLabel('Simulated, no device').uncheck();
  await form.getByLabel('Port', { exact: true }).fill('/etc/passwd');
  await form.getByText('a port is').waitFor();
  assert.ok(await saves.isDisabled());
  await assert.rejects(
    ask('settings.set', { robot: 'left', settings: { port: '/etc/passwd' }, revision: 0 }),
    /nothing was changed/,
  );
  await form.getByLabel('Simulated, no device').check();
  await form.getByLabel('elbow: Turns the other way').check();
  await until('it may be saved', () => saves.isEnabled());
  await saves.click();
  await form.getByText('Saved in').waitFor();
  await form.getByText('Start it anew for these to count').waitFor();
  const told = await ask('settings.get', { robot: 'left' });
  const file = JSON.parse(readFileSync(told.file, 'utf8'));
  assert.equal(file.robots.left.settings['joint.elbow.turn'], 'other');
  assert.ok(Math.abs(Number(file.robots.left.settings['joint.base.trim_rad']) - (2.5 * Math.PI) / 180) < 1e-6);
  assert.equal(readFileSync(file.cell, 'utf8'), kCell, 'the cell’s file is as it was');
  await here.close(page, 'files_settings');

  // The next start of the same cell runs with them, and one that cannot be says which file it is.
  const state = path.resolve(path.dirname(told.file), '../..');
  const start = () =>
    new Promise((end) => {
      const environment = { ...process.env, XDG_STATE_HOME: state, XDG_RUNTIME_DIR: state };
      const program = process.env.SINEW ?? path.join(root, 'build/release/sinew');
      const again = spawn(program, ['serve', file.cell, '--listen', 'none', '--socket', path.join(state, 'again.sock')], { env: environment });
      let said = '';
      again.stderr.on('data', (text) => {
        said += text;
        if (said.includes('Ctrl-C ends it')) again.kill('SIGINT');
      });
      again.on('exit', () => end(said));
    });
  assert.match(await start(), /left: as set in .*cell-[0-9a-f]+\.json/);
  file.robots.left.settings.profile = 'nonsense';
  writeFileSync(told.file, JSON.stringify(file));
  assert.match(await start(), /cell-[0-9a-f]+\.json: left: 'nonsense' is none of/);
});

test('the sequence that comes with the BigRobotArm is among the examples and opens as steps', async () => {
  const page = await open('programs', {}, 'big');
  await offers(page, 'sequence');
  await pick(page, 'sequence');
  const text = readFileSync(path.join(root, 'robots/bigrobotarm/sequence.txt'), 'utf8');
  const rows = await ask('program.import', { robot: 'big', form: 'sequence', text });
  await until('it is open', async () => (await textOf(page)) === rows.text);
  assert.equal(await page.locator('.program-head input[type=text]').inputValue(), 'sequence');
  await page.locator('li[data-line]').first().waitFor();
  // The file's own text is checked, too, and its lines are the file's.
  const check = await ask('program.check', { robot: 'big', text });
  assert.ok(check.fine, JSON.stringify(check));
  assert.deepEqual(check.rows.map((row) => row.line).slice(0, 2), [4, 5]);
});
