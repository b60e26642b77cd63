'use strict';
// Effects: light that follows what is known of the object (effect.frag). Each has a colour and two controls, `speed` and `size`.
// Where an effect is depends on nothing but the time: of its round at `time`, the share phase + speed * time is over.

// kind of effect.frag; names of the controls
const EFFECTS = {
  scan: {kind: 0, name: 'Scan line', controls: ['Speed', 'Width']}, creases: {kind: 1, name: 'Creases', controls: ['Speed', 'Width']},
  sweep: {kind: 2, name: 'Depth sweep', controls: ['Speed', 'Length']}, sparkle: {kind: 3, name: 'Sparkle', controls: ['Speed', 'Size']},
  pulse: {kind: 4, name: 'Sound pulse', controls: ['Gain', 'Softness']}, lamp: {kind: 5, name: 'Moving lamp', controls: ['Speed', 'Height']},
};
const SPEED = [-2, 2], EFFECT = {speed: 0.2, size: 0.3, phase: 0}; // rounds a second; of a pulse doublings
const shareOf = (x) => x - Math.floor(x);

class EffectContent {
  constructor(effect, colour, values = {}) {
    const value = (name, [low, high]) => Number.isFinite(values[name]) ? Math.min(Math.max(values[name], low), high) : effect === 'pulse' && name === 'speed' ? 0 : EFFECT[name];
    this.effect = effect, this.colour = colour, this.name = EFFECTS[effect].name, this.size = null; // it fills the picture
    this.values = {speed: value('speed', SPEED), size: value('size', [0, 1]), phase: value('phase', [0, 1])};
  }
  get live() { return this.effect === 'pulse' || this.values.speed !== 0; }
  get description() { return {effect: this.effect, colour: this.colour, ...this.values}; }
  phaseAt(time) { return shareOf(this.values.phase + (this.effect === 'pulse' ? 0 : this.values.speed * time)); }

  // With other values from a time on: it goes on from where it is.
  with({colour = this.colour, ...values}, time) {
    const next = new EffectContent(this.effect, colour, {...this.values, ...values}), phase = shareOf(this.phaseAt(time) - next.phaseAt(time) + next.values.phase);
    next.values.phase = Math.round(1e4 * phase) / 1e4 % 1;
    return next;
  }

  // A sign for it, on its tile.
  paint(context, width, height) {
    const side = Math.min(width, height), middle = [width / 2, height / 2], {effect} = this;
    context.fillStyle = '#000';
    context.fillRect(0, 0, width, height);
    context.fillStyle = context.strokeStyle = this.colour, context.lineWidth = side / 16;
    context.translate(...middle);
    const disc = (x, y, r, alpha = 1) => { context.globalAlpha = alpha; context.beginPath(); context.arc(x * side, y * side, r * side, 0, 2 * Math.PI); context.fill(); };
    const line = (points) => { context.beginPath(); points.forEach(([x, y], k) => k ? context.lineTo(x * side, y * side) : context.moveTo(x * side, y * side)); context.stroke(); };
    if (effect === 'scan') [1, 0.4, 0.15].forEach((alpha, k) => { context.globalAlpha = alpha; context.fillRect(-0.4 * side, (0.1 * k - 0.1) * side, 0.8 * side, side / 14); });
    if (effect === 'creases') line([[-0.3, -0.15], [0, -0.3], [0.3, -0.15], [0.3, 0.2], [0, 0.35], [-0.3, 0.2], [-0.3, -0.15], [0, 0], [0.3, -0.15]]), line([[0, 0], [0, 0.35]]);
    if (effect === 'sweep') for (let k = 0; k < 4; k++) { context.globalAlpha = 1 - 0.24 * k; context.beginPath(); context.arc(0, 0.5 * side, (0.75 - 0.16 * k) * side, -0.75 * Math.PI, -0.25 * Math.PI); context.stroke(); }
    if (effect === 'sparkle') [[-0.25, -0.2, 0.05], [0.2, -0.28, 0.03], [0.05, 0.02, 0.07], [-0.2, 0.25, 0.03], [0.28, 0.2, 0.05], [-0.05, -0.33, 0.02]].forEach((at) => disc(...at));
    if (effect === 'pulse') [0.38, 0.27, 0.15].forEach((r, k) => disc(0, 0, r, 0.3 + 0.35 * k));
    if (effect === 'lamp') disc(0, 0.05, 0.28, 0.3), disc(-0.09, -0.05, 0.14, 0.7), disc(-0.32, -0.3, 0.08);
    context.globalAlpha = 1;
  }
  free() {}
}

const LEVEL_FALLS = 0.35; // seconds in which it falls to a third

// How loud it is, 0 to 1: of the microphone, or as it was told last.
class Sound {
  constructor() { this.given = null, this.stream = null, this.held = 0, this.heard = 0; }

  get running() { return !!this.stream && this.stream.active; }
  get told() { return this.running ? 'microphone' : this.given !== null ? '/level' : 'none'; }

  async start() {
    const {mediaDevices} = navigator;
    if (!mediaDevices || !mediaDevices.getUserMedia) throw new Message('This browser does not give this page a microphone.');
    this.stream = await mediaDevices.getUserMedia({audio: {echoCancellation: false, noiseSuppression: false, autoGainControl: false}}).catch((error) => {
      throw new Message(`The microphone cannot be used: ${error.message || error.name}. Send the level as /level by OSC or MIDI.`);
    });
    this.context = this.context || new AudioContext();
    await this.context.resume();
    this.analyser = this.context.createAnalyser();
    this.analyser.fftSize = 1024;
    this.context.createMediaStreamSource(this.stream).connect(this.analyser);
    this.samples = new Float32Array(this.analyser.fftSize);
  }

  stop() {
    if (this.stream) this.stream.getTracks().forEach((track) => track.stop());
    this.stream = null;
  }

  set(level) { this.given = level; }

  get level() {
    if (!this.running) return this.given || 0;
    this.analyser.getFloatTimeDomainData(this.samples);
    const loud = Math.min(1, 4 * Math.sqrt(this.samples.reduce((sum, x) => sum + x * x, 0) / this.samples.length)), now = performance.now() / 1000;
    this.held = Math.max(loud, this.held * Math.exp((this.heard - now) / LEVEL_FALLS)), this.heard = now;
    return this.held;
  }
}
