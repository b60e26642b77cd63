'use strict';
// Undo: one gesture is one step, in the order in which they were made. No document, no drawing: tests run it alone.

const UNDO_MAX = 60;

// States of some work. `take()` reads the state of now, `same(a, b)` compares two, `put(state)` brings one back (a promise),
// `ready()` is false while nothing is to be noted, `told()` hears of every change.
class Undo {
  constructor({take, same, put, ready = () => true, told = () => {}}) {
    Object.assign(this, {take, same, put, ready, told});
    this.states = [take()], this.at = 0, this.busy = false;
    this.held = new Set(), this.waiting = [];
  }

  // A gesture begins, such as a pointer that goes down; what was done until then is a step by itself.
  begin(id) {
    this.note();
    this.held.add(id);
  }

  // It ends; after the last of several the whole is one step.
  end(id) {
    this.held.delete(id);
    if (this.held.size) return;
    this.note();
    for (const go of this.waiting.splice(0)) go();
  }

  // A promise of a moment without a gesture, for what arrives late.
  rest() { return this.held.size ? new Promise((go) => this.waiting.push(go)) : Promise.resolve(); }

  // A difference from the last state becomes a step; in the midst of a gesture only if `part` of one is wanted.
  note(part = false) {
    if (this.busy || (this.held.size && !part) || !this.ready()) return;
    const state = this.take();
    if (this.same(state, this.states[this.at])) return;
    this.states.splice(this.at + 1, this.states.length, state);
    if (this.states.length > UNDO_MAX) this.states.shift();
    this.at = this.states.length - 1;
    this.told();
  }

  // By steps back (negative) or forward.
  async go(step) {
    this.note(true);
    const to = this.at + step;
    if (this.busy || !this.states[to]) return;
    this.busy = true;
    try {
      await this.put(this.states[to]);
      this.at = to;
    } finally {
      this.busy = false;
    }
    this.told();
  }
}
