'use strict';
// The page's side of its projectors' windows (wire.js): moved to the real projectors and made full screen there, they show
// the pictures for them.

// Tells which projector this is, where its picture ends and whether its pixels are the screen's: a frame one pixel wide, a
// field of single pixels, a grid, the number and the size.
function drawTest(context, width, height, projector) {
  const step = Math.max(16, Math.round(height / 12)), middle = [width / 2, height / 2];
  context.fillStyle = '#000', context.fillRect(0, 0, width, height);
  context.fillStyle = '#666';
  for (let x = step; x < width; x += step) context.fillRect(x, 0, 1, height);
  for (let y = step; y < height; y += step) context.fillRect(0, y, width, 1);
  context.fillStyle = '#fff';
  for (const [x, y, w, h] of [[0, 0, width, 1], [0, height - 1, width, 1], [0, 0, 1, height], [width - 1, 0, 1, height]]) context.fillRect(x, y, w, h);
  for (let y = step; y < 2 * step; y++)
    for (let x = step + y % 2; x < 2 * step; x += 2) context.fillRect(x, y, 1, 1);
  context.fillStyle = projector.colour, context.textAlign = 'center', context.textBaseline = 'middle';
  context.font = `700 ${4 * step}px system-ui, sans-serif`;
  context.fillText(projector.number, ...middle);
  context.font = `${step / 2}px system-ui, sans-serif`;
  context.fillText(`${width} × ${height}`, middle[0], middle[1] + 2.5 * step);
}

const showWindows = (app) => app.projectors.forEach((projector) => projector.window.show());

// Blackout of all projector windows, and back: the show goes on behind it.
function blackout(app, on = !app.dark) {
  app.dark = on;
  if (!app.windows.open.length) say(`Blackout is ${on ? 'on' : 'off'}.${NO_WINDOW}`);
  else say(on ? 'Blackout: the projector windows are black until you press . or Blackout again.' : 'The projector windows show their pictures again.');
  app.changed('windows'); // tells them
}

// By a hand, which may press twice in haste: then the first press holds.
const HASTE = 400; // ms
function pressBlackout(app, {timeStamp}) {
  if (timeStamp - (app.pressed || -HASTE) < HASTE) return;
  app.pressed = timeStamp;
  blackout(app);
}

// The test picture in place of the content, and back.
function testPicture(app) {
  app.test = !app.test;
  app.changed('windows');
  if (!app.windows.open.length) say('The test picture appears in the projector windows, none of which is open yet.');
  showWindows(app);
}

const newId = () => Math.random().toString(36).slice(2, 10) + Date.now().toString(36);

const PING = 1000, SILENT = 4, STARTS = 8000, ANSWERS = 1200; // ms; pings without an answer

class ProjectorWindow {
  constructor(app, projector) {
    this.app = app, this.projector = projector;
    this.kept = {};
    this.id = null;     // of the window that is or was this projector's
    this.isOpen = this.stale = false;
    this.where = null;  // {left, top, width, height, full}: the window's place, to which it comes back
    this.owed = 0;      // answers to pings
    this.drawing = false; // a picture is on its way; the next follows when it was drawn
    this.sent = this.pinged = 0; // pictures so far; those on their way at the last ping
  }

  post(is, more = {}) { this.app.windows.post({to: this.id, is, ...more}); }

  open() {
    if (this.isOpen) return this.show();
    this.opening = this.opening || this.begin().finally(() => { this.opening = null; });
    return this.opening;
  }

  async begin() {
    const {left, top, width = 800, height = 600} = this.where || {};
    // other screens are open to pages that may know of them
    if (this.where && screen.isExtended && window.getScreenDetails) await getScreenDetails().catch(() => {});
    this.id = newId();
    const came = new Promise((done) => { this.came = done; });
    const opened = window.open(`${location.href.split('#')[0]}#projector-${this.projector.number}-${this.id}`, '',
      `popup,${APART ? 'noopener,' : ''}width=${width},height=${height}${this.where ? `,left=${left},top=${top}` : ''}`);
    if (opened) this.app.windows.wire.peers.add(opened);
    const late = new Promise((done) => setTimeout(done, APART || opened ? STARTS : 0));
    await Promise.race([came, late]);
    if (!this.isOpen) throw new Message('The browser blocked the projector window: allow this page to open windows.');
  }

  // A message of the window.
  hear({is, place, key}) {
    this.owed = 0;
    if (is === 'bye') return this.gone('was closed');
    if (!this.isOpen || is === 'here') return this.meet(place);
    if (is === 'place') this.notePlace(place);
    const lost = is === 'pong' && this.drawing && this.pinged === this.sent;
    if (is === 'drawn' || lost) {
      this.drawing = false;
      if (this.stale || lost) this.show();
    }
    if (is === 'tick' && this.next) this.next();
    if (is === 'dropped') say('Files are dropped on the page, not on a projector window.');
    if (is === 'key') pressThere(this.app, key, {timeStamp: performance.now()});
  }

  // A window that was opened, was reloaded, or is found again.
  meet(place) {
    const full = this.where && this.where.full;
    this.isOpen = true, this.drawing = false;
    this.post('claim', {...this.state, full: full && !place.full});
    if (!this.where || !this.came) this.notePlace(place); // one that was opened again keeps its own
    if (this.came) this.came();
    this.came = null;
    this.show();
    this.app.changed('windows');
  }

  get state() { return {armed: this.app.show.armed, dark: this.app.dark}; }

  gone(how) {
    if (!this.isOpen) return;
    this.isOpen = this.drawing = false;
    this.app.reschedule();
    this.app.changed('windows');
    say(`Projector ${this.projector.number}'s window ${how}. Press W: it comes back where it was.`, this.app.show.armed);
  }

  // Where the window is; one that fills its screen keeps the size that it had.
  notePlace({left, top, width, height, full}) {
    const {width: w, height: h, full: was} = this.where || {};
    this.where = {left, top, ...(full ? {width: w || 800, height: h || 600} : {width, height}), full};
    if (was && !full && this.app.show.armed) say(`Projector ${this.projector.number}'s window no longer fills its screen: click it, or press F there.`, true);
    this.app.changed('windows');
  }

  // The window's next frame, for a page that is hidden and has none; returns how to cancel it.
  frame(work) {
    this.next = () => { this.next = null; work(); };
    this.post('tick');
    return () => { this.next = null; };
  }

  // The window's picture behind any blackout: {width, height, bytes}, without bytes for black.
  picture() {
    const {app: {test, graphics}, projector} = this, {panel} = projector, {width, height} = panel || projector.grid;
    if (!(projector.on || test)) return {width, height};
    if (!test) return {width, height, bytes: panelPicture(graphics, projector, panel, this.kept).data};
    const context = makeCanvas(width, height).getContext('2d', {willReadFrequently: true});
    drawTest(context, width, height, projector);
    return {width, height, bytes: context.getImageData(0, 0, width, height).data};
  }

  // After the projector's pattern has changed.
  show() {
    this.stale = this.drawing;
    if (!this.isOpen || this.drawing) return;
    this.drawing = true, this.sent++;
    this.post('picture', {...this.picture(), exact: !!this.projector.panel});
  }

  close() {
    if (this.isOpen) this.post('close');
    this.isOpen = false, this.id = null;
  }
}

// A key in a projector window.
function pressThere(app, key, event) {
  if (key === ' ' || key === 'Enter') go(app);
  if (key === '.' || key === 't' || key === 'T' || key === 'Escape') KEYS[key.length > 1 ? key : key.toLowerCase()](app, event);
}

// All windows of this page, and those of pages that are gone.
class Windows {
  constructor(app) {
    this.app = app, this.me = newId();
    this.lost = new Map(); // windows that no page has: id to what they said last
    this.taken = new Set(); // ids of those that another page has
    this.settled = false;
    this.wire = new Wire(WIRE, (message) => this.hear(message));
    setInterval(() => this.ping(), PING);
    app.listeners.push((what) => { if (what === 'windows' || what === 'cues') for (const {window: w} of this.open) w.post('state', w.state); });
  }

  get open() { return this.app.projectors.filter((projector) => projector.window.isOpen); }

  post(message) { this.wire.post({from: this.me, ...message}); }

  hear(message) {
    const {is, ids, window: id} = message, {app} = this;
    if (is === 'who' && !id) return this.post({is: 'mine', ids: this.open.map((projector) => projector.window.id)});
    if (is === 'mine' && !id) return ids.forEach((one) => { this.taken.add(one); this.lost.delete(one); });
    if (!id || this.taken.has(id)) return;
    const projector = app.projectors.find((p) => p.window.id === id);
    if (projector && (this.settled || projector.window.came)) return projector.window.hear(message);
    if (is === 'bye') this.lost.delete(id); else if (is === 'here') this.lost.set(id, message); else return;
    app.changed('windows');
  }

  // Finds the windows that this page had before it was reloaded: pages that are there still say which are theirs.
  async find() {
    this.post({to: '*', is: 'who'});
    await new Promise((done) => setTimeout(done, ANSWERS));
    this.settled = true;
    for (const [id, message] of [...this.lost]) {
      if (!this.app.projectors.some((projector) => projector.window.id === id)) continue;
      this.lost.delete(id);
      this.hear(message);
    }
    this.app.changed('windows');
  }

  ping() {
    for (const {window: w} of this.open)
      if (++w.owed > SILENT) w.gone('does not answer any more');
      else w.pinged = w.drawing ? w.sent : 0, w.post('ping');
  }

  // Projectors whose windows are not there.
  get missing() { return this.app.projectors.filter((projector) => !projector.window.isOpen && (projector.window.where || this.lost.size)); }

  // Takes windows that have lost their page, and opens those that were closed, where they were.
  async allBack() {
    for (const projector of this.missing) {
      const found = [...this.lost.values()].find(({number}) => number === projector.number) || [...this.lost.values()][0];
      if (!found) {
        await projector.window.open();
        continue;
      }
      this.lost.delete(found.window);
      projector.window.id = found.window;
      projector.window.hear(found);
    }
    this.app.changed('windows');
  }
}
