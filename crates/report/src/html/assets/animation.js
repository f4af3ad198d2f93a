// The animation of a rupture: needle, drawn tissue, hand and felt force of one or two runs, from data with a value per frame.
// A panel draws one run at one time; it is also the field of an insertion by hand.
"use strict";

const trocarAnimation = (() => {
  /** The namespace of SVG. A report contains no address of another site, not even as a name. */
  const SVG = new DOMParser().parseFromString("<svg></svg>", "text/html").querySelector("svg").namespaceURI;
  const MODES = ["teleoperation", "frozen", "re-engaging"];
  /** Places of a wide and of a narrow panel, in pixels: force bar, rail of the hand, left end of the tissue, place of the needle. */
  const WIDE = { bar: 8, wide: 16, hand: 64, tissue: 98, needle: 0.45 };
  const NARROW = { bar: 4, wide: 12, hand: 42, tissue: 64, needle: 0.11 };
  const NARROW_BELOW = 280;
  /** Margins above and below the depths. */
  const TOP = 22;
  const BOTTOM = 22;
  /** Half the width of the needle, and the length of its bevel. */
  const NEEDLE = 3;
  const BEVEL = 12;
  /** Time for which a loop rests at its last frame, in s. */
  const REST_S = 1.2;

  function svg(name, attributes = {}, parent = null) {
    const made = document.createElementNS(SVG, name);
    for (const [attribute, value] of Object.entries(attributes)) made.setAttribute(attribute, value);
    if (parent) parent.append(made);
    return made;
  }

  function html(name, attributes = {}, text = "") {
    const made = document.createElement(name);
    for (const [attribute, value] of Object.entries(attributes)) made.setAttribute(attribute, value);
    made.textContent = text;
    return made;
  }

  const setText = (element, text) => {
    if (element.textContent !== text) element.textContent = text;
  };

  /** Returns a round length of about a quarter of a range. */
  const roundLength = (range) => [0.5, 1, 2, 5, 10, 20, 50, 100].findLast((length) => length <= range / 3) ?? range / 4;

  /** One run: needle, tissue, hand and force at one time. */
  class Panel {
    /** `scheme` is "classical" or "augmented". */
    constructor(parent, name, scheme) {
      this.figure = html("figure", { class: `needle-panel ${scheme}` });
      const caption = html("figcaption");
      this.name = html("strong", {}, name);
      this.state = html("span", { class: "state" });
      caption.append(this.name, this.state);
      this.svg = svg("svg", { role: "img" });
      this.note = html("p", { class: "note-line" });
      this.figure.append(caption, this.svg, this.note);
      parent.append(this.figure);
      this.drawn = null;
      this.size = [0, 0];
      new ResizeObserver(() => this.measure()).observe(this.svg);
    }

    /** Sets what does not change with time: `{ layers: [{ label, top_mm }], range_mm, max_force_n, note }`. */
    setScene(scene) {
      this.scene = scene;
      setText(this.note, scene.note ?? "");
      this.note.hidden = !scene.note;
      this.lay();
    }

    measure() {
      const { width, height } = this.svg.getBoundingClientRect();
      if (width === this.size[0] && height === this.size[1]) return;
      this.size = [width, height];
      this.lay();
    }

    /** Makes the parts for the current size and scene. */
    lay() {
      const [width, height] = this.size;
      if (!this.scene || width < 20 || height < 60) return;
      const { range_mm: [from, to], layers } = this.scene;
      this.perMm = (height - TOP - BOTTOM) / (to - from);
      this.y = (mm) => TOP + (mm - from) * this.perMm;
      const at = width < NARROW_BELOW ? NARROW : WIDE;
      this.at = at;
      this.needleAt = at.tissue + at.needle * (width - at.tissue);
      this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
      this.svg.replaceChildren();
      const add = (name, attributes) => svg(name, attributes, this.svg);
      const text = (x, y, words, anchor = "middle", kind = "") => {
        const made = add("text", { x, y, "text-anchor": anchor, class: kind });
        made.textContent = words;
        return made;
      };
      this.tissue = layers.map((_, index) => [`fill-${index % 2}`, "line"].map((kind) => add("path", { class: `tissue-${kind}` })));
      this.tears = layers.map(() => add("path", { class: "tear" }));
      let free = -Infinity;
      this.labels = layers.map(({ label, top_mm }, index) => {
        const next = index + 1 < layers.length ? this.y(layers[index + 1].top_mm) : height;
        // The label of a thin layer stands above it.
        const top = Math.max(this.y(top_mm), 0);
        const y = next - top < 16 ? top - 4 : top + 13;
        const fits = label && y > free && y < height - 4 && next > 0;
        if (fits) free = y + 13;
        return text(width - 6, y, fits ? label : "", "end", "small");
      });
      this.level = add("line", { class: "level", x1: at.hand, x2: this.needleAt });
      this.bracket = add("path", { class: "bracket" });
      this.overshoot = text(0, 0, "", "start", "overshoot");
      this.needle = add("g", { class: "needle" });
      // The tip is the origin.
      svg("path", { d: `M ${-NEEDLE} ${-2 * height} V 0 L ${NEEDLE} ${-BEVEL} V ${-2 * height} Z` }, this.needle);
      this.clamp = svg("g", { class: "clamp" }, this.svg);
      for (const side of [-1, 1]) {
        svg("rect", { x: this.needleAt + side * (NEEDLE + 7) - 6, y: 2, width: 12, height: 15, rx: 2 }, this.clamp);
      }
      add("line", { class: "rail", x1: at.hand, x2: at.hand, y1: TOP - 8, y2: height - BOTTOM + 4 });
      this.hand = add("g", { class: "hand" });
      svg("rect", { x: -17, y: -9, width: 34, height: 18, rx: 8 }, this.hand);
      for (const x of [-8, 0, 8]) svg("line", { x1: x, x2: x, y1: -4, y2: 4 }, this.hand);
      text(at.hand, height - 5, "hand", "middle", "small");
      const tall = height - TOP - BOTTOM;
      add("rect", { class: "track", x: at.bar, y: TOP, width: at.wide, height: tall, rx: 3 });
      this.bar = add("rect", { class: "force", x: at.bar, width: at.wide, rx: 3 });
      this.force = text(2, TOP - 8, "", "start", "force-text");
      // In a narrow panel only the unit tells that the bar is a force.
      if (at === WIDE) text(2, height - 5, "force", "start", "small");
      const length = roundLength(to - from);
      const end = height - 8;
      add("path", { class: "scale", d: `M ${this.at.tissue + 6} ${end - length * this.perMm} h 6 m -3 0 V ${end} m -3 0 h 6` });
      text(this.at.tissue + 15, end - 2, `${length} mm`, "start", "small");
      if (this.drawn) this.draw(this.drawn);
    }

    /** Returns the outline of a layer's top, dipping to `depth` (mm) at the needle. */
    top(top_mm, depth) {
      const [width] = this.size;
      const [flat, dip] = [this.y(top_mm), this.y(depth)];
      const reach = Math.min(26 + 0.7 * (dip - flat), 0.95 * (this.needleAt - this.at.tissue));
      const [at, half] = [this.needleAt, NEEDLE + 1];
      const side = (sign) => [at + sign * (half + reach), at + sign * (half + 0.45 * reach), at + sign * (half + 0.2 * reach), at + sign * half];
      const [l, r] = [side(-1), side(1)];
      return `M ${this.at.tissue} ${flat} H ${l[0]} C ${l[1]} ${flat} ${l[2]} ${dip} ${l[3]} ${dip} H ${r[3]} C ${r[2]} ${dip} ${r[1]} ${flat} ${r[0]} ${flat} H ${width}`;
    }

    /**
     * Draws one time: `{ tip_mm, hand_mm, felt_n, mode, tops_mm, torn: [bool], from_mm, reached_mm, overshoot }`. `overshoot` is
     * the text of the bracket; an empty text draws no bracket.
     */
    draw(now) {
      this.drawn = now;
      const mode = MODES[now.mode];
      const state = now.hasEnded ? "ended" : now.isRupturing ? "rupture" : mode;
      setText(this.state, state);
      this.figure.dataset.state = state;
      if (!this.needle || !this.size[0]) return;
      const [width, height] = this.size;
      this.scene.layers.forEach(({ top_mm }, index) => {
        const depth = now.tops_mm[index] ?? top_mm;
        const top = this.top(top_mm, depth);
        const [fill, line] = this.tissue[index];
        fill.setAttribute("d", `${top} V ${height} H ${this.at.tissue} Z`);
        line.setAttribute("d", top);
        const y = this.y(depth);
        const isOpen = now.torn[index] && now.tip_mm > depth;
        const deep = Math.min(16, this.y(now.tip_mm) - y);
        const [at, wide] = [this.needleAt, NEEDLE + 7];
        this.tears[index].setAttribute("d", isOpen ? `M ${at - wide} ${y - 1} Q ${at - NEEDLE - 1} ${y} ${at - NEEDLE} ${y + deep} H ${at + NEEDLE} Q ${at + NEEDLE + 1} ${y} ${at + wide} ${y - 1} Z` : "");
      });
      this.needle.setAttribute("transform", `translate(${this.needleAt} ${this.y(now.tip_mm)})`);
      this.clamp.setAttribute("visibility", now.mode === 1 ? "visible" : "hidden");
      const hand = Math.min(Math.max(this.y(now.hand_mm), -4), height + 4);
      this.hand.setAttribute("transform", `translate(${this.at.hand} ${hand})`);
      this.level.setAttribute("y1", hand);
      this.level.setAttribute("y2", hand);
      const tall = height - TOP - BOTTOM;
      const share = Math.min(1, Math.abs(now.felt_n) / this.scene.max_force_n);
      this.bar.setAttribute("y", TOP + (1 - share) * tall);
      this.bar.setAttribute("height", share * tall);
      this.bar.classList.toggle("pulls", now.felt_n < 0);
      // Without the sign of a negative zero.
      setText(this.force, `${(Math.round(100 * now.felt_n) / 100 || 0).toFixed(2)} N`);
      const has = Boolean(now.overshoot);
      const [low, high] = has ? [this.y(now.from_mm), this.y(now.from_mm + now.reached_mm)] : [0, 0];
      const x = this.needleAt + (this.at === WIDE ? 24 : 16);
      this.bracket.setAttribute("d", has ? `M ${x - 8} ${low} H ${x} V ${high} H ${x - 8}` : "");
      setText(this.overshoot, has ? now.overshoot : "");
      this.overshoot.setAttribute("x", x + 6);
      this.overshoot.setAttribute("y", Math.min((low + high) / 2 + 5, height - 6));
    }

    describe(text) {
      this.svg.setAttribute("aria-label", text);
    }
  }

  /** The player: panels side by side, a clock, and a slider over the frames. */
  class Player {
    constructor(parent, classes = "") {
      this.element = html("div", { class: `animation ${classes}` });
      this.panelsAt = html("div", { class: "needle-panels" });
      const bar = html("div", { class: "player no-print" });
      this.button = html("button", { type: "button" }, "Play");
      this.slider = html("input", { type: "range", min: "0", step: "1", "aria-label": "Time in the animation" });
      this.clock = html("output", { class: "clock" });
      bar.append(this.button, this.slider, this.clock);
      this.title = html("p", { class: "quiet animation-title" });
      this.element.append(this.panelsAt, bar, this.title);
      parent.append(this.element);
      this.panels = [];
      this.data = null;
      this.at = 0;
      this.isPlaying = false;
      this.isVisible = true;
      this.still = window.matchMedia("(prefers-reduced-motion: reduce)");
      this.still.addEventListener("change", () => (this.still.matches ? this.rest() : this.play()));
      this.button.addEventListener("click", () => (this.isPlaying ? this.pause() : this.play()));
      this.slider.addEventListener("input", () => {
        this.pause();
        this.show(Number(this.slider.value));
      });
      new IntersectionObserver((entries) => {
        this.isVisible = entries[entries.length - 1].isIntersecting;
      }).observe(this.element);
      window.addEventListener("beforeprint", () => this.data && this.show(this.data.still));
    }

    /** Shows an animation. A playing one continues at the same time. */
    setData(data) {
      const isFirst = this.data === null;
      this.element.hidden = data === null;
      if (data === null) return;
      this.data = data;
      const schemes = data.panels.map((panel) => panel.scheme + panel.name).join();
      if (schemes !== this.schemes) {
        this.schemes = schemes;
        this.panelsAt.replaceChildren();
        this.panels = data.panels.map((panel) => new Panel(this.panelsAt, panel.name, panel.scheme));
      }
      const { range_mm, max_force_n } = data;
      this.panels.forEach((panel, index) => {
        const { layers, note, name, rupture } = data.panels[index];
        panel.setScene({ layers, note, range_mm, max_force_n });
        const overshoot = rupture ? ` The needle advances by ${rupture.text} in the 0.5 s after the rupture.` : "";
        panel.describe(`Needle, tissue and hand of the run ${name}.${overshoot} ${note}`);
      });
      const bracket = data.panels.some((panel) => panel.rupture) ? " The bracket is the overshoot in 0.5 s." : "";
      setText(this.title, `${data.title}.${bracket}`);
      this.slider.max = data.time_s.length - 1;
      if (isFirst && !this.still.matches) this.play();
      else this.show(isFirst ? data.still : Math.min(this.at, data.time_s.length - 1));
    }

    /** Draws a frame. */
    show(frame) {
      const { data } = this;
      this.at = frame;
      this.panels.forEach((panel, index) => panel.draw(this.state(index, frame)));
      const after = data.time_s[frame] - data.origin_s;
      const ms = Math.round(1000 * Math.abs(after));
      const clock = `${ms} ms ${after < 0 ? "before" : "after"} the ${data.origin}`;
      setText(this.clock, clock);
      this.slider.value = frame;
      if (!this.isPlaying) this.slider.setAttribute("aria-valuetext", clock);
    }

    /** Returns what a panel draws at a frame. */
    state(index, frame) {
      const run = this.data.panels[index];
      const time = this.data.time_s[frame];
      const { rupture } = run;
      const isAfter = rupture !== null && time >= rupture.time_s - 1e-9;
      const reached = isAfter ? rupture.reached_mm[frame] : 0;
      const last = rupture?.reached_mm[rupture.reached_mm.length - 1];
      return {
        tip_mm: run.tip_mm[frame],
        hand_mm: run.hand_mm[frame],
        felt_n: run.felt_n[frame],
        mode: run.mode[frame],
        tops_mm: run.tops_mm[frame],
        torn: run.layers.map((layer) => layer.torn_s !== null && time >= layer.torn_s - 1e-9),
        from_mm: rupture?.from_mm,
        reached_mm: reached,
        // While it grows, the number has fewer digits than the metric.
        overshoot: isAfter ? (reached === last ? rupture.text : `${reached.toFixed(1)} mm`) : "",
        isRupturing: run.mode[frame] === 0 && isAfter && time < rupture.time_s + 0.06,
      };
    }

    play() {
      if (!this.data || this.isPlaying) return;
      this.isPlaying = true;
      setText(this.button, "Pause");
      const frames = () => this.data.time_s.length - 1;
      const length = () => this.data.slowness * (this.data.time_s[frames()] - this.data.time_s[0]);
      let began = performance.now() - (1000 * length() * (this.at >= frames() ? 0 : this.at)) / Math.max(1, frames());
      const step = (now) => {
        if (!this.isPlaying) return;
        const played = (now - began) / 1000;
        if (played > length() + REST_S) began = now;
        const frame = Math.min(frames(), Math.max(0, Math.floor((played / length()) * frames())));
        if (this.isVisible && frame !== this.at) this.show(frame);
        requestAnimationFrame(step);
      };
      requestAnimationFrame(step);
    }

    pause() {
      this.isPlaying = false;
      setText(this.button, "Play");
    }

    /** Stops at the frame that is displayed at rest. */
    rest() {
      this.pause();
      if (this.data) this.show(this.data.still);
    }
  }

  return { Panel, Player, MODES };
})();
