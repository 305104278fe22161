// The page's side of the worker: calls with answers, and a new worker where one has broken.

export class EngineProxy {
  #worker;
  #next = 0;
  #waiting = new Map();
  #onBroken;

  constructor(onBroken) {
    this.#onBroken = onBroken;
    this.#begin();
  }

  #begin() {
    this.#worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
    this.#worker.onmessage = ({ data: { id, value, error, isBroken } }) => {
      const { resolve, reject } = this.#waiting.get(id) ?? {};
      this.#waiting.delete(id);
      if (error === undefined) return resolve?.(value);
      reject?.(new Error(error));
      if (isBroken) this.#replace();
    };
    this.#worker.onerror = (event) => this.#fail(event.message ?? "the worker cannot be started");
  }

  #fail(what) {
    for (const { reject } of this.#waiting.values()) reject(new Error(what));
    this.#waiting.clear();
  }

  #replace() {
    this.#worker.terminate();
    this.#fail("the engine was started anew");
    this.#begin();
    this.#onBroken();
  }

  /** Calls the worker; the answer, or the error in words. */
  call(call, argument, transfer = []) {
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.#worker.postMessage({ id, call, argument }, transfer);
    });
  }
}
