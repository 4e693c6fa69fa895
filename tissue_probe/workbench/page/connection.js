// The line to the server: requests and their answers, what is told unasked, and coming back.

import { unpacked } from "./messages.js";

/** A request that could not be done: the server's sentence, and the fields that it names. */
export class Refused extends Error {
  /**
   * @param {string} told
   * @param {string[]} fields
   * @param {boolean} cancelled
   */
  constructor(told, fields, cancelled) {
    super(told);
    this.fields = fields;
    this.cancelled = cancelled;
  }
}

/** How long to wait before trying again whether the server is back [ms]. */
const AGAIN = 700;

/** @typedef {Record<string, import("./messages.js").Numbers>} Arrays */
/** @typedef {import("./told.js").Requests} Requests */
/** @typedef {import("./told.js").Answers} Answers */
/**
 * The answer to a request, by its name.
 * @template {keyof Requests} N
 * @typedef {{ok: Answers[N], arrays: Arrays}} Answer
 */
/**
 * What comes unasked, by its kind; live news with its arrays.
 * @typedef {import("./told.js").News} News
 * @typedef {Omit<News, "live" | "live_map"> & {live: News["live"] & {arrays: Arrays},
 *   live_map: News["live_map"] & {arrays: Arrays}}} Heard
 */

export class Connection {
  /**
   * @param {<K extends keyof Heard>(kind: K, told: Heard[K]) => void} hear told what comes unasked
   * @param {(there: boolean) => void} change told when the server comes and goes
   */
  constructor(hear, change) {
    this.hear = hear;
    this.change = change;
    this.count = 0;
    /** @type {Map<number, {done: (answer: Answer<never>) => void, failed: (error: Error) => void}>} */
    this.waiting = new Map();
    /** @type {WebSocket | null} */
    this.socket = null;
    this.connect();
  }

  connect() {
    const socket = new WebSocket(`ws://${location.host}/socket`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.socket = socket;
      this.change(true);
    };
    socket.onmessage = (event) => this.take(event.data);
    socket.onclose = () => {
      this.socket = null;
      for (const { failed } of this.waiting.values()) {
        failed(new Refused("the server is gone", [], true));
      }
      this.waiting.clear();
      this.change(false);
      setTimeout(() => this.retry(), AGAIN);
    };
  }

  /** A WebSocket that fails is an error in the console; a server that is not there is none. */
  async retry() {
    try {
      await fetch("/icon.svg", { method: "HEAD", mode: "no-cors" });
    } catch {
      setTimeout(() => this.retry(), AGAIN);
      return;
    }
    this.connect();
  }

  /** @param {string | ArrayBuffer} data */
  take(data) {
    /** @type {Arrays} */
    let arrays = {};
    let head;
    if (typeof data === "string") head = JSON.parse(data);
    else ({ head, arrays } = unpacked(data));
    const waiting = this.waiting.get(head.id);
    if (waiting) {
      this.waiting.delete(head.id);
      if ("refused" in head) waiting.failed(new Refused(head.refused, head.fields, head.cancelled));
      else waiting.done({ ok: /** @type {never} */ (head.ok), arrays });
      return;
    }
    if ("live" in head) this.hear("live", { ...head.live, arrays });
    if ("live_map" in head) this.hear("live_map", { ...head.live_map, arrays });
    for (const kind of /** @type {const} */ (["choices", "study", "desk", "job"])) {
      if (kind in head) this.hear(kind, head[kind]);
    }
  }

  /**
   * @template {keyof Requests} N
   * @param {N} name
   * @param {Requests[N]} [more]
   * @returns {Promise<Answer<N>>}
   */
  ask(name, more) {
    const socket = this.socket;
    if (!socket) return Promise.reject(new Refused("the server is gone", [], true));
    const id = ++this.count;
    return new Promise((done, failed) => {
      this.waiting.set(id, { done, failed });
      socket.send(JSON.stringify({ id, do: name, ...more }));
    });
  }
}

/**
 * One request at a time, and of those that come meanwhile only the newest: what follows a slider or
 * a wheel must not queue.
 * @template Q, A
 * @param {(asked: Q) => Promise<A>} ask
 * @param {(answer: A) => void} show
 * @param {(error: unknown) => void} fail
 * @returns {(asked: Q) => void}
 */
export function newest(ask, show, fail) {
  let busy = false;
  /** @type {{asked: Q} | null} */
  let next = null;
  return function want(asked) {
    if (busy) {
      next = { asked };
      return;
    }
    busy = true;
    ask(asked)
      .then(show, fail)
      .finally(() => {
        busy = false;
        const following = next;
        next = null;
        if (following) want(following.asked);
      });
  };
}
