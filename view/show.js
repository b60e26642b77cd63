'use strict';
// A show: cues one after the other, each with what every projector shows, how long it stays and how long it fades in.

const HOLD_MAX = 3600, FADE_MAX = 60; // seconds

// One content turning into another. Both are drawn in full and added up by their shares, as video mixers do.
class FadeContent {
  constructor(from, to, seconds) {
    this.from = from instanceof FadeContent ? from.to : from; // a fade that is cut short goes on from its end
    this.to = to, this.seconds = seconds, this.began = performance.now();
    this.name = to.name;
  }
  get share() { return clamp((performance.now() - this.began) / (1000 * this.seconds), 0, 1); }
  get done() { return this.share >= 1; }
  get live() { return true; }
  draw(context, width, height, fit) {
    const {share} = this;
    for (const [content, part] of [[this.from, 1 - share], [this.to, share]]) {
      const layer = this.layer && this.layer.width === width && this.layer.height === height ? this.layer : makeCanvas(width, height);
      this.layer = layer;
      const own = layer.getContext('2d');
      own.clearRect(0, 0, width, height);
      own.save();
      content.draw(own, width, height, fit);
      own.restore();
      context.save();
      context.globalCompositeOperation = 'lighter', context.globalAlpha = part;
      context.drawImage(layer, 0, 0);
      context.restore();
    }
  }
  free() { this.from.free(), this.to.free(); }
}

const checkCue = (cue) => ({
  name: String((cue && cue.name) || 'Cue').slice(0, 80), hold: number('cues: hold', cue && cue.hold, 0, HOLD_MAX),
  fade: number('cues: fade', cue && cue.fade, 0, FADE_MAX), shown: list('cues: shown', cue && cue.shown, PROJECTORS_MAX),
});

class Show {
  constructor(app) {
    this.app = app, this.cues = [], this.at = -1, this.playing = false, this.started = 0;
  }

  // Adds the projectors' present contents as a cue.
  add() {
    const {app} = this, shown = app.projectors.map((p) => describeContent(app, p.content));
    if (this.cues.length >= CUES_MAX) throw new Message(`A show has at most ${CUES_MAX} cues.`);
    if (shown.includes(null)) throw new Message('The webcam cannot be part of a cue.');
    this.cues.push({name: shortName(app.projector.content.name), hold: 5, fade: 1, shown});
    this.changed();
  }

  remove(index) {
    this.cues.splice(index, 1);
    if (!this.cues.length) this.stop();
    this.changed();
  }

  changed() { this.app.changed('cues'); }

  // Fades to a cue; while the show plays, the next one follows.
  async go(index) {
    const {app} = this, cue = this.cues[index], started = ++this.started;
    if (!cue) return;
    clearTimeout(this.timer);
    this.at = index;
    const contents = await Promise.all(cue.shown.map((described) => contentOf(app, described)));
    if (started !== this.started) return contents.forEach((content) => content.free());
    contents.forEach((content, i) => {
      if (app.projectors[i]) app.fadeTo(content, app.projectors[i], cue.fade);
      else content.free();
    });
    if (this.playing) this.timer = setTimeout(attempt(() => this.go((index + 1) % this.cues.length)), 1000 * Math.max(cue.fade + cue.hold, 0.1));
    this.changed();
  }

  play() {
    if (!this.cues.length) throw new Message('There are no cues yet: show something, then add it as a cue.');
    this.playing = true;
    return this.go(0);
  }

  stop() {
    clearTimeout(this.timer);
    this.started++;
    if (!this.playing) return;
    this.playing = false;
    this.changed();
  }
}

// The list of cues in the panel.
function buildShow(app) {
  const {show} = app, box = $('cues');
  const amount = (cue, name, most, title) => {
    const input = element('input', {type: 'number', min: 0, max: most, step: 0.5, value: cue[name], title});
    input.setAttribute('aria-label', title);
    input.onchange = () => {
      cue[name] = clamp(Number(input.value) || 0, 0, most);
      show.changed();
    };
    return input;
  };
  const refresh = () => {
    box.replaceChildren(...show.cues.map((cue, i) => {
      const go = choose(element('button', {textContent: `${i + 1}  ${cue.name}`, title: 'Go to this cue', className: 'cue'}), i === show.at);
      const remove = element('button', {textContent: '×', className: 'small', title: `Remove cue ${i + 1}`});
      go.onclick = attempt(() => show.go(i));
      remove.onclick = () => show.remove(i);
      return element('li', {className: 'row'}, [go, amount(cue, 'fade', FADE_MAX, 'Seconds to fade in'), amount(cue, 'hold', HOLD_MAX, 'Seconds to stay'), remove]);
    }));
    $('cues-head').hidden = !show.cues.length;
    $('play').textContent = show.playing ? 'Stop' : 'Play in a loop';
  };
  $('add-cue').onclick = attempt(() => show.add());
  $('play').onclick = attempt(() => show.playing ? show.stop() : show.play());
  app.listeners.push((what) => { if (what === 'cues') refresh(); });
  refresh();
}
