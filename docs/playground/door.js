// The way to the core: a request as JSON goes into the module's memory, an answer comes out.

/** Opens a compiled module; it imports nothing. Workers get this function as text, so it needs nothing around it. */
export function opened(instance) {
  const { memory, room, answer, address } = instance.exports;
  return request => {
    const bytes = new TextEncoder().encode(JSON.stringify(request));
    // A call that makes the memory grow gives it another buffer, so views are made after it.
    const place = room(bytes.length);
    new Uint8Array(memory.buffer, place, bytes.length).set(bytes);
    const length = answer();
    const said = JSON.parse(new TextDecoder().decode(new Uint8Array(memory.buffer, address(), length)));
    if ('error' in said) throw new Error(said.error);
    return said.ok;
  };
}

/** The module that the page carries. */
export async function compiled() {
  const text = atob(document.getElementById('module').textContent.trim());
  return WebAssembly.compile(Uint8Array.from(text, letter => letter.charCodeAt(0)));
}

/** The core on this thread, for frames. */
export async function core(module) {
  return opened(await WebAssembly.instantiate(module, {}));
}

/** The core on another thread, for whole runs and fits: the animation goes on meanwhile. */
export function helper(module) {
  const work = `const opened = ${opened};
    let ask, wait = new Promise(ready => onmessage = async ({ data }) => {
      if (data.module) { ask = opened(await WebAssembly.instantiate(data.module, {})); return ready(); }
      await wait;
      try { postMessage({ id: data.id, ok: ask(data.request) }); }
      catch (error) { postMessage({ id: data.id, error: error.message }); }
    });`;
  const worker = new Worker(URL.createObjectURL(new Blob([work], { type: 'text/javascript' })));
  const open = new Map();
  let last = 0;
  worker.onmessage = ({ data: { id, ok, error } }) => {
    const { done, fail } = open.get(id);
    open.delete(id);
    error === undefined ? done(ok) : fail(new Error(error));
  };
  worker.postMessage({ module });
  return request => new Promise((done, fail) => {
    open.set(++last, { done, fail });
    worker.postMessage({ id: last, request });
  });
}
