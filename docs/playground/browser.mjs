// Chromium, driven by its own protocol through two pipes: no package, no port.

import { spawn } from 'node:child_process';

export async function start(program) {
  const process = spawn(program, ['--headless=new', '--no-sandbox', '--disable-dev-shm-usage', '--remote-debugging-pipe',
    '--hide-scrollbars', '--proxy-server=127.0.0.1:9', 'about:blank'], { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
  const open = new Map(), listeners = [];
  let last = 0, rest = '';
  process.stdio[4].setEncoding('utf8').on('data', text => {
    const parts = (rest + text).split('\0');
    rest = parts.pop();
    for (const part of parts) {
      const { id, result, error, method, params, sessionId } = JSON.parse(part);
      if (id) {
        const { done, fail } = open.get(id);
        open.delete(id);
        error ? fail(new Error(error.message)) : done(result);
      } else listeners.forEach(listener => listener(method, params, sessionId));
    }
  });
  const send = (method, params = {}, sessionId) => new Promise((done, fail) => {
    open.set(++last, { done, fail });
    process.stdio[3].write(`${JSON.stringify({ id: last, method, params, sessionId })}\0`);
  });
  return {
    close: async () => {
      await Promise.race([send('Browser.close'), new Promise(done => setTimeout(done, 2000))]);
      process.kill();
    },
    page: (...given) => page(send, listeners, ...given),
  };
}

/** A page of a width, with all that it complained of and asked for. */
async function page(send, listeners, { width, height, dark = false }) {
  const { targetId } = await send('Target.createTarget', { url: 'about:blank' });
  const { sessionId } = await send('Target.attachToTarget', { targetId, flatten: true });
  const own = (method, params) => send(method, params, sessionId);
  const complaints = [], requests = [];
  listeners.push((method, params, session) => {
    if (session !== sessionId) return;
    if (method === 'Runtime.exceptionThrown') complaints.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
    if (method === 'Runtime.consoleAPICalled' && ['error', 'warning'].includes(params.type)) complaints.push(JSON.stringify(params.args.map(({ value }) => value)));
    if (method === 'Log.entryAdded' && params.entry.level === 'error') complaints.push(params.entry.text);
    if (method === 'Network.requestWillBeSent') requests.push(params.request.url.slice(0, 80));
  });
  for (const domain of ['Page', 'Runtime', 'Log', 'Network', 'DOM']) await own(`${domain}.enable`);
  const size = (width, height) => own('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: 1, mobile: width < 600 });
  await size(width, height);
  await own('Emulation.setEmulatedMedia', { features: [{ name: 'prefers-color-scheme', value: dark ? 'dark' : 'light' }] });
  const run = async expression => {
    const { result, exceptionDetails } = await own('Runtime.evaluate', { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(`${expression.slice(0, 90)}: ${exceptionDetails.exception?.description ?? exceptionDetails.text}`);
    return result.value;
  };
  return {
    complaints, requests, run, size,
    go: url => own('Page.navigate', { url }),
    until: async (expression, seconds = 15) => {
      const end = Date.now() + 1000 * seconds;
      while (!(await run(expression))) {
        if (Date.now() > end) throw new Error(`not within ${seconds} s: ${expression}; ${complaints.join('; ')}`);
        await new Promise(done => setTimeout(done, 50));
      }
    },
    key: async (key, code, number) => {
      for (const type of ['keyDown', 'keyUp']) {
        await own('Input.dispatchKeyEvent', { type, key, code, windowsVirtualKeyCode: number, ...(type === 'keyDown' && key.length === 1 ? { text: key } : {}) });
      }
    },
    /** From one place to the next with the button down, or only moved to the one. */
    mouse: async (...places) => {
      const send = (type, [x, y], more = {}) => own('Input.dispatchMouseEvent', { type, x, y, ...more });
      const pressed = { button: 'left', buttons: 1, clickCount: 1 };
      await send('mouseMoved', places[0]);
      if (places.length === 1) return;
      await send('mousePressed', places[0], pressed);
      for (const place of places.slice(1)) await send('mouseMoved', place, pressed);
      await send('mouseReleased', places.at(-1), { button: 'left', clickCount: 1 });
    },
    media: media => own('Emulation.setEmulatedMedia', { media }),
    twice: async ([x, y]) => {
      for (const clickCount of [1, 2]) for (const type of ['mousePressed', 'mouseReleased']) {
        await own('Input.dispatchMouseEvent', { type, x, y, button: 'left', buttons: 1, clickCount });
      }
    },
    files: async (selector, files) => {
      const { root } = await own('DOM.getDocument');
      const { nodeId } = await own('DOM.querySelector', { nodeId: root.nodeId, selector });
      await own('DOM.setFileInputFiles', { nodeId, files });
    },
    picture: async (clip, format = 'webp') => {
      const { data } = await own('Page.captureScreenshot', { format, ...(format === 'webp' && { quality: 80 }), ...(clip && { captureBeyondViewport: true, clip: { ...clip, scale: 1 } }) });
      return Buffer.from(data, 'base64');
    },
  };
}
