// Sound, light and vibration: the force is a tone, a rupture a click, an alarm a lamp.
"use strict";

const trocarListen = (() => {
  /** Length of the vibration at a rupture, in ms. */
  const TICK_MS = 60;
  let sound = null;
  let playing = null;
  let clicks = 0;

  function nodes() {
    if (sound) return sound;
    const context = new AudioContext();
    const volume = context.createGain();
    volume.connect(context.destination);
    const tone = context.createOscillator();
    tone.type = "triangle";
    const loudness = context.createGain();
    loudness.gain.value = 0;
    tone.connect(loudness).connect(volume);
    tone.start();
    const noise = context.createBuffer(1, context.sampleRate / 8, context.sampleRate);
    const samples = noise.getChannelData(0);
    for (let i = 0; i < samples.length; i += 1) samples[i] = (Math.random() * 2 - 1) * Math.exp((-8 * i) / samples.length);
    sound = { context, volume, tone, loudness, noise };
    return sound;
  }

  /** Starts the sound; browsers allow this only after a user gesture. `volume` is from 0 to 1. */
  function start(volume) {
    const { context, volume: gain } = nodes();
    context.resume();
    gain.gain.value = volume;
  }

  /** Plays the click of a rupture. */
  function click() {
    if (!sound) return;
    const source = sound.context.createBufferSource();
    source.buffer = sound.noise;
    source.connect(sound.volume);
    source.start();
    clicks += 1;
  }

  /** Vibrates once, on a telephone and on every gamepad. */
  function vibrate() {
    navigator.vibrate?.(TICK_MS);
    for (const pad of navigator.getGamepads?.() ?? []) {
      pad?.vibrationActuator?.playEffect("dual-rumble", { duration: TICK_MS, strongMagnitude: 1, weakMagnitude: 1 }).catch(() => {});
    }
  }

  /** Lights the lamp of an alarm for a moment. */
  function light(lamp) {
    lamp.classList.add("on");
    lamp.setAttribute("aria-label", "on: alarm");
    setTimeout(() => {
      lamp.classList.remove("on");
      lamp.setAttribute("aria-label", "off");
    }, 350);
  }

  /** Sets the tone of a force: a larger force is higher and louder. */
  function force(newtons, full) {
    if (!sound) return;
    const share = Math.min(1, Math.max(0, newtons / full));
    const { context, tone, loudness } = sound;
    tone.frequency.setTargetAtTime(110 + 440 * share, context.currentTime, 0.01);
    loudness.gain.setTargetAtTime(0.25 * share, context.currentTime, 0.01);
  }

  const quiet = () => sound?.loudness.gain.setTargetAtTime(0, sound.context.currentTime, 0.02);

  function stop(button, output) {
    if (!playing) return;
    cancelAnimationFrame(playing.frame);
    playing = null;
    button.textContent = "Listen";
    output.textContent = "";
    quiet();
  }

  /** Plays the displayed time window in real time. */
  function play({ button, output, lamp, volume }, frame, which) {
    start(Number(volume.value));
    const panel = trocarPictures.panel("feedback-force");
    const [times, feedback] = panel.lines.find((line) => line.name === frame.runs[which].name).points;
    const max = feedback.reduce((largest, value) => (value > largest ? value : largest), 1e-6);
    const [from, to] = [panel.x.low, panel.x.high];
    const within = (events) => events.filter((at) => at >= from && at <= to).sort((a, b) => a - b);
    const [ruptures, alarms] = [within(panel.ruptures), within(panel.alarms)];
    const began = performance.now();
    let index = 0;
    playing = { frame: 0 };
    button.textContent = "Stop";
    const step = (at) => {
      if (!playing) return;
      const time = from + (at - began) / 1000;
      sound.volume.gain.value = Number(volume.value);
      while (index + 1 < times.length && times[index + 1] <= time) index += 1;
      force(feedback[index] || 0, max);
      for (; ruptures[0] <= time; ruptures.shift()) click();
      for (; alarms[0] <= time; alarms.shift()) light(lamp);
      trocarPictures.point(time);
      output.textContent = `${time.toFixed(1)} s of ${to.toFixed(1)} s`;
      if (time >= to) stop(button, output);
      else playing.frame = requestAnimationFrame(step);
    };
    playing.frame = requestAnimationFrame(step);
  }

  return {
    begin(parts) {
      parts.button.addEventListener("click", () => {
        const frame = trocarPictures.frame();
        if (playing) stop(parts.button, parts.output);
        else if (frame) play(parts, frame, Number(parts.scheme.value));
      });
      // The tone of a hidden page would continue, because the page is not redrawn.
      document.addEventListener("visibilitychange", () => document.hidden && stop(parts.button, parts.output));
    },
    start,
    click,
    vibrate,
    light,
    force,
    quiet,
    /** Returns the state of the sound, for tests. */
    state: () => sound && { clicks, state: sound.context.state, hertz: sound.tone.frequency.value, loudness: sound.loudness.gain.value },
  };
})();
