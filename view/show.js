'use strict';
// A show: cues one after the other, each with the layers of every projector and how they are corrected, the view whose poses
// it takes, how long it fades in, and after how many seconds the next one follows (null: it waits for GO).

const FOLLOW_MAX = 3600, FADE_MAX = 600; // seconds

function checkCue(cue) {
  const {name, fade, pose, shown, follow = cue && cue.hold} = cue || {}; // stages once had `hold`
  return {
    name: String(name || 'Cue').slice(0, 80), fade: number('cues: fade', fade, 0, FADE_MAX),
    follow: follow === null ? null : number('cues: follow', follow, 0, FOLLOW_MAX), pose: pose === undefined || pose === null ? null : number('cues: pose', pose, 0, 1e6),
    shown: list('cues: shown', shown, PROJECTORS_MAX).map((p) => ({
      layers: checkLayers(p && p.layers ? p : {content: p}), correction: oneOf('cues: correction', (p && p.correction) || 'none', CORRECTIONS),
      watcher: p && p.watcher !== undefined ? p.watcher : 'now',
    })),
  };
}

// A show as it runs, from the browser's store: where it is, when the next cue follows, and how far films are.
function checkShow({armed, at, follows, seat, dark, test, films, kept}) {
  return {
    armed: armed === true, at: number('show: at', at, -1, CUES_MAX), follows: follows === null ? null : number('show: follows', follows, 0, 1e15),
    seat: seat && checkDevice(seat, {width: number('show: width', seat.width, 1, 1e5), height: number('show: height', seat.height, 1, 1e5)}),
    dark: dark === true, test: test === true, kept: number('show: kept', kept, 0, 1e15),
    films: list('show: films', films, PROJECTORS_MAX).map((layers) => list('show: films', layers, LAYERS_MAX).map((at) => at === null ? null : number('show: films', at, 0, 1e6))),
  };
}

const NO_WINDOW = ' No projector window is open.';
const DISARM = [600, 5000]; // ms between the two presses that it takes

class Show {
  constructor(app) {
    this.app = app, this.cues = [], this.at = -1, this.armed = this.playing = false, this.started = 0, this.fade = this.seat = this.follows = null;
    this.asked = -Infinity;
    this.coming = null; // the cue that a GO still waits for
  }

  // Where the last GO led to.
  get here() { return this.coming === null ? this.at : this.coming; }

  // Of what a reload would end (checkShow).
  get state() {
    const {armed, at, seat, app} = this, films = app.projectors.map((p) => p.layers.map(({source}) => source.video && source.live && !source.kind ? source.video.currentTime : null));
    return {armed, at, seat, follows: this.playing ? this.follows : null, dark: app.dark, test: app.test, films, kept: Date.now()};
  }

  // Goes on with it: films at the place where they would be by now.
  resume({armed, at, seat, follows, dark, test, films, kept}) {
    const {app} = this;
    Object.assign(app, {dark, test});
    Object.assign(this, {armed, seat: armed ? seat : null, at: Math.min(at, this.cues.length - 1)});
    films.forEach((layers, i) => layers.forEach((time, k) => {
      const layer = app.projectors[i] && app.projectors[i].layers[k], video = time !== null && layer && layer.source.video;
      if (video) video.currentTime = (time + (Date.now() - kept) / 1000) % (video.duration || Infinity);
    }));
    if (follows) this.follow(follows - Date.now());
    app.changed('windows');
    this.changed();
  }

  // The next cue after `wait` milliseconds.
  follow(wait) {
    this.playing = true, this.follows = Date.now() + wait;
    this.timer = setTimeout(attempt(() => this.go()), Math.max(wait, 100));
  }

  // The switch: while windows are open a show ends only by two presses, the second after a moment.
  press() {
    const now = performance.now(), since = now - this.asked;
    if (!this.armed || !this.app.windows.open.length || (since > DISARM[0] && since < DISARM[1])) return this.arm(!this.armed);
    this.asked = now;
    say('Still armed. To disarm, press again after a second.');
    this.changed();
  }

  // fade: seconds of the next GO in place of its cue's. seat: while the show is armed, the camera that corrections are for, so that the
  // audience's picture does not follow whoever looks around

  // The projectors as they are now, for a cue.
  shown() {
    const {app} = this;
    return app.projectors.map((p) => ({layers: describeLayers(app, p.layers), correction: p.correction, watcher: p.watcher}));
  }

  // NAME, NAME 2, NAME 3 ..: the first of them that no cue has, as OSC calls cues by name.
  unused(name, n = 1) {
    const tried = n > 1 ? `${name} ${n}` : name;
    return this.cues.some((cue) => cue.name.toLowerCase() === tried.toLowerCase()) ? this.unused(name, n + 1) : tried;
  }

  // Adds it as a cue.
  add() {
    if (this.cues.length >= CUES_MAX) throw new Message(`A show has at most ${CUES_MAX} cues.`);
    this.cues.push({name: this.unused(shortName(this.app.projector.content.name)), fade: 1, follow: null, pose: null, shown: this.shown()});
    this.changed();
  }

  // Puts it in a cue's place.
  record(index) {
    this.cues[index].shown = this.shown();
    say(`Cue ${index + 1} now has what the projectors show.`);
    this.changed();
  }

  remove(index) {
    this.cues.splice(index, 1);
    if (index <= this.at) this.at--;
    this.stop();
  }

  // Changes places with the cue before it.
  raise(index) {
    const {cues} = this;
    if (index < 1) return;
    [cues[index - 1], cues[index]] = [cues[index], cues[index - 1]];
    if (this.at === index || this.at === index - 1) this.at = 2 * index - 1 - this.at;
    this.changed();
  }

  changed() { this.app.changed('cues'); }

  arm(on) {
    this.armed = on, this.seat = on ? this.app.seat() : null, this.asked = -Infinity;
    this.app.invalidate();
    if (on) say(`Armed: Space or Enter is GO. Corrections keep the place that you look from now.${this.app.windows.open.length ? '' : NO_WINDOW}`);
    else this.stop();
    this.changed();
  }

  // Fades to a cue, the next one unless another is given; after the last comes the first. The next one of a GO that still
  // waits for its pictures is the one after its cue.
  async go(index = (this.here + 1) % this.cues.length) {
    const {app} = this, cue = this.cues[index];
    if (!cue) throw new Message(this.cues.length ? `There is no cue ${index + 1}.` : 'There are no cues yet: show something, then add it as a cue.');
    clearTimeout(this.timer);
    if (!this.playing && !app.windows.open.length) say(`Cue ${index + 1} is shown here alone: no projector window is open.`);
    const seconds = this.fade === null ? cue.fade : this.fade;
    this.fade = null;
    const started = ++this.started;
    this.coming = index;
    const shown = await Promise.all(cue.shown.map((p, i) => layersOf(app, p.layers, app.projectors[i] && app.projectors[i].layers)))
      .catch((error) => { if (started === this.started) this.coming = null; throw error; });
    if (started !== this.started) return app.release(shown.flat().map((layer) => layer.source));
    if (app.scene.views[cue.pose]) {
      app.jump(app.scene.views[cue.pose], true);
      if (this.armed) this.seat = app.seat();
    }
    shown.forEach((layers, i) => {
      const projector = app.projectors[i], {correction, watcher} = cue.shown[i];
      if (!projector) return app.release(layers.map((layer) => layer.source));
      const before = [projector.correction, projector.watcher].join();
      Object.assign(projector, {correction, watcher: app.scene.views[watcher] ? watcher : 'now'});
      app.setLayers(layers, projector, seconds, before !== [projector.correction, projector.watcher].join());
    });
    this.at = index, this.coming = null, this.playing = cue.follow !== null;
    if (this.playing) this.follow(1000 * (seconds + cue.follow));
    this.changed();
  }

  // The number of the cue of that name, from 0.
  find(name) {
    const at = this.cues.findIndex((cue) => cue.name.toLowerCase() === name.toLowerCase());
    if (at < 0 && /^[0-9]{1,4}$/.test(name)) return Number(name) - 1; // a desk's number as a text
    if (at < 0) throw new Message(`There is no cue "${name.slice(0, 80)}".`);
    return at;
  }

  // No cue follows any more; what is shown stays.
  stop() {
    clearTimeout(this.timer);
    this.started++;
    this.coming = null, this.playing = false;
    this.changed();
  }
}

// The list of cues in the panel.
function buildShow(app) {
  const {show} = app, box = $('cues');
  let open = null; // the cue whose second row is shown
  const field = (cue, name, most, title) => {
    const input = element('input', {type: 'number', min: 0, max: most, step: 0.5, value: cue[name] === null ? '' : cue[name], title, placeholder: 'GO'});
    input.setAttribute('aria-label', title);
    input.onchange = () => {
      cue[name] = input.value === '' && name === 'follow' ? null : clamp(Number(input.value) || 0, 0, most);
      if (cue[name] !== null) input.value = cue[name];
      show.changed();
    };
    return input;
  };
  const press = (text, title, work) => element('button', {textContent: text, title, className: 'small', onclick: attempt(work)});
  const first = (cue, i) => {
    const name = element('input', {type: 'text', value: cue.name, maxLength: 80});
    name.setAttribute('aria-label', `Name of cue ${i + 1}`);
    name.onchange = () => { cue.name = name.value = name.value || 'Cue'; show.changed(); };
    const go = press(i + 1, `Go to cue ${i + 1}`, () => show.go(i));
    const more = press('⋯', `More of cue ${i + 1}`, () => { open = open === cue ? null : cue; refresh(); });
    return element('div', {className: 'row'}, [go, name, field(cue, 'fade', FADE_MAX, 'Seconds to fade in'), field(cue, 'follow', FOLLOW_MAX, 'Seconds until the next follows; empty: it waits for GO'), more]);
  };
  const second = (cue, i) => {
    const pose = element('select', {title: 'Poses of camera and projector'}, [element('option', {value: '', textContent: 'poses stay'}),
      ...app.scene.views.map((view, k) => element('option', {value: k, textContent: viewName(view)}))]);
    pose.setAttribute('aria-label', pose.title);
    pose.value = cue.pose === null ? '' : cue.pose;
    pose.onchange = () => { cue.pose = pose.value === '' ? null : Number(pose.value); show.changed(); };
    return element('div', {className: 'row'}, [pose, press('Record', 'Put what the projectors show now into this cue', () => show.record(i)),
      press('↑', 'Earlier', () => show.raise(i)), press('×', `Remove cue ${i + 1}`, () => show.remove(i))]);
  };
  const kept = new WeakMap(); // rows by their cues: a press, or what is being typed, would get lost with a row
  const row = (cue, i) => {
    const key = `${i} ${cue === open}`;
    if (!kept.has(cue) || kept.get(cue).dataset.key !== key) {
      kept.set(cue, element('li', {}, cue === open ? [first(cue, i), second(cue, i)] : [first(cue, i)]));
      kept.get(cue).dataset.key = key;
    }
    choose(kept.get(cue).querySelector('button'), i === show.at);
    return kept.get(cue);
  };
  const refresh = () => {
    const rows = show.cues.map(row);
    if (rows.length !== box.children.length || rows.some((item, i) => item !== box.children[i])) box.replaceChildren(...rows);
    $('cues-head').hidden = $('go').hidden = !show.cues.length;
    $('go-bar').hidden = !show.cues.length && !app.windows.open.length && !app.dark;
    $('armed').checked = show.armed;
    $('hold').hidden = !show.playing;
    for (const name of ['dark', 'test']) $(name).setAttribute('aria-pressed', app[name]);
    $('held').textContent = ['dark', 'test'].filter((name) => app[name]).map((name) => $(name).textContent).join(', ');
    $('held').hidden = !$('held').textContent;
    $('all-back').hidden = !app.windows.missing.length && !app.windows.lost.size;
  };
  $('add-cue').onclick = attempt(() => show.add());
  $('go').onclick = attempt(() => show.go());
  $('hold').onclick = () => show.stop();
  $('dark').onclick = (event) => pressBlackout(app, event);
  $('test').onclick = () => testPicture(app);
  $('armed').onchange = () => show.press();
  $('all-back').onclick = attempt(() => app.windows.allBack());
  app.listeners.push((what) => { if (what === 'cues' || what === 'windows') refresh(); });
  refresh();
}
