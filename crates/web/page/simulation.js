// The simulation in its worker, as the page sees it.

export class Simulation {
  constructor() {
    this.worker = null;
    this.requests = new Map();
    this.count = 0;
  }

  // Starts the worker. Rejects if the browser cannot run the simulation.
  async start() {
    this.module ??= await compile();
    this.worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
    this.worker.addEventListener("message", ({ data }) => this.answer(data));
    this.worker.addEventListener("error", (event) => {
      this.end(new Error(event.message ?? "the worker of the simulation cannot start"));
    });
    await this.ask("start", { module: this.module });
  }

  // Asks the worker to do something, and returns its answer.
  ask(kind, message = {}, transfer = []) {
    return new Promise((resolve, reject) => {
      const id = ++this.count;
      this.requests.set(id, { resolve, reject });
      this.worker.postMessage({ id, kind, ...message }, transfer);
    });
  }

  answer({ id, error, isFatal, ...answer }) {
    const request = this.requests.get(id);
    if (!request) return;
    this.requests.delete(id);
    if (error === undefined) {
      request.resolve(answer);
      return;
    }
    const failure = Object.assign(new Error(error), { isFatal });
    request.reject(failure);
    if (isFatal) this.end(failure);
  }

  // Ends the worker. What it has not answered fails.
  end(error) {
    this.worker.terminate();
    for (const { reject } of this.requests.values()) reject(Object.assign(error, { isFatal: true }));
    this.requests.clear();
  }
}

async function compile() {
  const response = await fetch(new URL("supple_web_bg.wasm", import.meta.url));
  if (!response.ok) throw new Error(`supple_web_bg.wasm cannot be read: ${response.status} ${response.statusText}`);
  try {
    return await WebAssembly.compile(await response.arrayBuffer());
  } catch (error) {
    throw new Error(
      "this browser cannot run the simulation, which needs WebAssembly with SIMD: Chrome or Edge 97, Firefox 114, " +
        `Safari 16.4, or a later version (${error.message})`,
    );
  }
}
