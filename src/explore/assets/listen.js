// Sound and light: the feedback force is a tone, an alarm is a click and a lamp.
"use strict";

const trocarListen = (() => {
  let sound = null;
  let playing = null;

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

  /** Plays the click and lights the lamp. */
  function cue(lamp) {
    if (sound) {
      const click = sound.context.createBufferSource();
      click.buffer = sound.noise;
      click.connect(sound.volume);
      click.start();
    }
    lamp.classList.add("on");
    lamp.setAttribute("aria-label", "on: alarm");
    setTimeout(() => {
      lamp.classList.remove("on");
      lamp.setAttribute("aria-label", "off");
    }, 350);
  }

  /** Sets the tone of a force: a larger force is higher and louder. */
  function force(newtons, max) {
    if (!sound) return;
    const share = Math.min(1, Math.max(0, newtons / max));
    const { context, tone, loudness } = sound;
    tone.frequency.setTargetAtTime(110 + 440 * share, context.currentTime, 0.01);
    loudness.gain.setTargetAtTime(0.25 * share, context.currentTime, 0.01);
  }

  function stop(button, output) {
    if (!playing) return;
    cancelAnimationFrame(playing.frame);
    playing = null;
    button.textContent = "Listen";
    output.textContent = "";
    if (sound) sound.loudness.gain.setTargetAtTime(0, sound.context.currentTime, 0.02);
  }

  /** Plays the displayed time window in real time. */
  function play({ button, output, lamp, volume }, frame, which) {
    const { context, volume: gain } = nodes();
    context.resume();
    gain.gain.value = Number(volume.value);
    const panel = trocarPictures.panel("feedback-force");
    const [times, feedback] = panel.lines.find((line) => line.name === frame.runs[which].name).points;
    const max = feedback.reduce((largest, value) => (value > largest ? value : largest), 1e-6);
    const [from, to] = [panel.x.low, panel.x.high];
    const cues = panel.alarms.filter((at) => at >= from && at <= to).sort((a, b) => a - b);
    const began = performance.now();
    let index = 0;
    playing = { frame: 0 };
    button.textContent = "Stop";
    const step = (at) => {
      if (!playing) return;
      const time = from + (at - began) / 1000;
      gain.gain.value = Number(volume.value);
      while (index + 1 < times.length && times[index + 1] <= time) index += 1;
      force(feedback[index] || 0, max);
      while (cues.length > 0 && cues[0] <= time) {
        cues.shift();
        cue(lamp);
      }
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
      // A hidden page is not redrawn, and its tone would continue.
      document.addEventListener("visibilitychange", () => document.hidden && stop(parts.button, parts.output));
    },
    cue,
  };
})();
