// What a device says is written, never obeyed: a port whose other end answers with markup, control
// characters and bytes that are no text.
//
//   node --test tests/panel/hostile_test.mjs      (bench.mjs says what can be set)
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { after, before, test } from 'node:test';
import { ask, bench, until } from './bench.mjs';

const kMarkup = "<img src=x onerror=\"pwned=1\"><script>pwned=1</script>";
/** A pseudo-terminal that says each line to everything it hears. */
const kDevice = String.raw`
import os, pty, sys, tty
ours, theirs = pty.openpty()
tty.setraw(theirs)
print(os.ttyname(theirs), flush=True)
lines = [b'<img src=x onerror="pwned=1">', b'<script>pwned=1</script>', b'\xe2\x80\xaegnp.\x1b[2J\x07\x01',
         b'\xff\xfe\xc3(', b'{"jsonrpc":"2.0"}', b'%s%n${7*7}{{7*7}}']
while os.read(ours, 256):
    os.write(ours, b''.join(b'Process command: ' + line + b'\r\n' for line in lines))
`;

let here, device;
before(async () => {
  device = spawn('python3', ['-c', kDevice], { stdio: ['ignore', 'pipe', 'inherit'] });
  let said = '';
  device.stdout.on('data', (text) => (said += text));
  await until('the port', () => said.endsWith('\n'));
  here = await bench(`title = ${JSON.stringify(kMarkup)}

[[robot]]
name = "big"
robot = "bigrobotarm"
wire = "text"
port = "${said.trim()}"
`);
});
after(async () => {
  await here?.end();
  device?.kill('SIGKILL');
});

/** Nothing of it has become a part of the page. */
async function harmless(page) {
  assert.equal(await page.evaluate(() => globalThis.pwned), undefined);
  assert.equal(await page.locator('img[src=x], img[onerror]').count(), 0);
  assert.equal(await page.locator('script', { hasText: 'pwned' }).count(), 0);
}

test('markup and bytes of a device, and of a cell’s title, are text wherever they are shown', async () => {
  const page = await here.open({}, '#/robots/big/device');
  assert.equal(await page.locator('h1').innerText(), kMarkup);
  await page.evaluate(() => void globalThis.__sinew.store.enable('big'));
  await until('its words in the list of messages', async () =>
    (await page.locator('.wire-text').allInnerTexts()).some((text) => text.includes('<img src=x onerror="pwned=1">')));
  await harmless(page);
  // Chosen, a message is shown with all that is in it.
  await page.locator('.wire-head').getByRole('button', { name: 'Pause' }).click();
  for (const words of ['<script>pwned', 'gnp.\\x1b[2J', '\\xff\\xfe', '{{7*7}}']) {
    await page.getByLabel('Words or bytes').fill(words);
    await page.locator('.wire-row', { hasText: words }).first().click();
    await page.locator('.wire-open dl, .wire-open .raw').first().waitFor();
    const text = await page.locator('.wire-open').innerText();
    assert.doesNotMatch(text, /[\u0000-\u0008\u000b-\u001f\u202a-\u202e\u2066-\u2069]/, `${words}: ${JSON.stringify(text)}`);
    await harmless(page);
  }
  // What the controller says of such a device, in every view that says it.
  await until('refused for what it answers', async () => (await ask('events.list')).events.some((one) => one.robot === 'big'));
  for (const view of ['events', 'move', 'jog', 'device']) {
    await page.evaluate((name) => void (location.hash = `#/robots/big/${name}`), view);
    await page.waitForTimeout(300);
    await harmless(page);
  }
  assert.notEqual((await ask('robot.status', { robot: 'big' })).state, 'ready');
  await here.close(page, 'hostile');
});
