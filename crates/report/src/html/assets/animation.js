// The animation of a rupture, and the field of an insertion by hand. Both are drawn from descriptions: shapes with a
// role, their positions, and states with the first frame of each. This script only places them; the theme has the style
// of each role.
"use strict";

const trocarAnimation = (() => {
  /** The namespace of SVG, read from the browser because a report contains no address of another site. */
  const SVG = new DOMParser().parseFromString("<svg></svg>", "text/html").querySelector("svg").namespaceURI;
  /** Width in pixels below which the narrow drawing of a panel is displayed. */
  const NARROW_BELOW = 280;
  /** Duration of the last frame in a loop, in s. */
  const REST_S = 1.2;

  function html(name, attributes = {}, text = "") {
    const node = document.createElement(name);
    for (const [attribute, value] of Object.entries(attributes)) node.setAttribute(attribute, value);
    node.textContent = text;
    return node;
  }

  const setText = (element, text) => {
    if (element.textContent !== text) element.textContent = text;
  };

  /** One run with its name, state and drawing. */
  class Panel {
    /** `scheme` is "classical" or "augmented". */
    constructor(parent, name, scheme) {
      this.figure = html("figure", { class: `needle-panel ${scheme}` });
      const caption = html("figcaption");
      this.name = html("strong", {}, name);
      this.state = html("span", { class: "state" });
      caption.append(this.name, this.state);
      this.svg = document.createElementNS(SVG, "svg");
      this.svg.setAttribute("role", "img");
      this.svg.setAttribute("preserveAspectRatio", "xMinYMid");
      this.note = html("p", { class: "note-line" });
      this.figure.append(caption, this.svg, this.note);
      this.note.hidden = true;
      parent.append(this.figure);
      this.frame = 0;
      new ResizeObserver(() => this.drawings && this.choose()).observe(this.svg);
    }

    /** Sets the drawings: `[wide, narrow]`, or one for any width. */
    setDrawings(drawings) {
      this.drawings = drawings;
      this.drawing = null;
      this.choose();
    }

    choose() {
      const isNarrow = this.svg.clientWidth < NARROW_BELOW;
      const drawing = this.drawings[isNarrow ? this.drawings.length - 1 : 0];
      if (drawing === this.drawing) return;
      this.drawing = drawing;
      this.svg.setAttribute("viewBox", `0 0 ${drawing.size.join(" ")}`);
      const isSame = this.shapes?.length === drawing.shapes.length && this.shapes.every(({ role, kind }, index) => role === drawing.shapes[index].role && kind === drawing.shapes[index].kind);
      if (!isSame) {
        this.elements = drawing.shapes.map(({ kind, role, anchor }) => {
          const node = document.createElementNS(SVG, kind);
          node.setAttribute("class", role);
          if (anchor) node.setAttribute("text-anchor", anchor);
          return node;
        });
        this.svg.replaceChildren(...this.elements);
      }
      this.shapes = drawing.shapes;
      this.placed = this.shapes.map(() => null);
      this.show(this.frame);
    }

    /** Places the shapes of a frame. */
    show(frame) {
      this.frame = frame;
      this.shapes.forEach(({ kind, x, states }, index) => {
        const state = states.findLast(([from]) => from <= frame);
        if (state === this.placed[index]) return;
        this.placed[index] = state;
        const [, y, text] = state;
        const element = this.elements[index];
        element.setAttribute("visibility", y.length ? "visible" : "hidden");
        if (!y.length) element.textContent = "";
        else if (kind === "text") {
          element.setAttribute("x", x[0]);
          element.setAttribute("y", y[0]);
          setText(element, text);
        } else element.setAttribute("points", y.map((down, at) => `${x[at]},${down}`).join(" "));
      });
    }

    /** Displays a state such as "frozen". */
    tell(state) {
      setText(this.state, state);
      this.figure.dataset.state = state;
    }

    /** Returns the height of a pointer event in the drawing. */
    height({ clientX, clientY }) {
      return new DOMPoint(clientX, clientY).matrixTransform(this.svg.getScreenCTM().inverse()).y;
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
      /** State of the charts' cursor: "quiet" without values, "read" with values, "held" if the charts set it. */
      this.cursor = "quiet";
      this.isVisible = true;
      this.still = window.matchMedia("(prefers-reduced-motion: reduce)");
      this.still.addEventListener("change", () => (this.still.matches ? this.rest() : this.play()));
      this.button.addEventListener("click", () => (this.isPlaying ? this.pause() : this.play()));
      this.slider.addEventListener("input", () => {
        this.pause();
        this.cursor = "read";
        this.show(Number(this.slider.value));
      });
      // The cursor of the charts sets the frame. When it leaves, a playing animation continues.
      window.addEventListener("charttime", ({ detail: { time, isKept } }) => {
        if (!this.data) return;
        if (isKept) this.pause();
        this.cursor = time === null ? "quiet" : "held";
        this.show(time === null ? this.at : this.frameAt(time));
      });
      new IntersectionObserver((entries) => {
        this.isVisible = entries[entries.length - 1].isIntersecting;
      }).observe(this.element);
      window.addEventListener("beforeprint", () => this.data && this.show(this.data.still));
    }

    /** Displays an animation. If one is playing, it continues at the same time. */
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
      this.at = isFirst ? data.still : Math.min(this.at, data.time_s.length - 1);
      this.panels.forEach((panel, index) => {
        const { drawings, note, alt } = data.panels[index];
        setText(panel.note, note);
        panel.note.hidden = !note;
        panel.frame = this.at;
        panel.setDrawings(drawings);
        panel.describe(alt);
      });
      setText(this.title, data.title);
      this.slider.max = data.time_s.length - 1;
      this.show(this.at);
      if (isFirst && !this.still.matches) this.play();
    }

    /** Returns the frame nearest to a time in s. */
    frameAt(time) {
      const times = this.data.time_s;
      return times.reduce((best, at, frame) => (Math.abs(at - time) < Math.abs(times[best] - time) ? frame : best), 0);
    }

    /** Stops at a time in s. */
    seek(time) {
      this.pause();
      this.cursor = "read";
      this.show(this.frameAt(time));
    }

    /** Draws a frame and moves the cursor of the charts to its time. */
    show(frame) {
      const { clocks, panels } = this.data;
      this.at = frame;
      this.panels.forEach((panel, index) => {
        panel.show(frame);
        panel.tell(panels[index].states[frame]);
      });
      setText(this.clock, clocks[frame]);
      this.slider.value = frame;
      if (!this.isPlaying) this.slider.setAttribute("aria-valuetext", clocks[frame]);
      if (this.cursor !== "held") trocarCharts.time(this.data.time_s[frame], this.cursor === "quiet");
    }

    play() {
      if (!this.data || this.isPlaying) return;
      this.isPlaying = true;
      this.cursor = "quiet";
      setText(this.button, "Pause");
      const frames = () => this.data.time_s.length - 1;
      /** The playing time in s from the beginning to a frame. */
      const playedTo = (frame) => this.data.slowness * (this.data.time_s[frame] - this.data.time_s[0]);
      let began = performance.now() - 1000 * playedTo(this.at >= frames() ? 0 : this.at);
      const step = (now) => {
        if (!this.isPlaying) return;
        if (this.cursor === "held") began = now - 1000 * playedTo(this.at);
        const played = (now - began) / 1000;
        if (played > playedTo(frames()) + REST_S) began = now;
        const frame = this.frameAt(this.data.time_s[0] + Math.max(0, played) / this.data.slowness);
        if (this.isVisible && this.cursor !== "held" && frame !== this.at) this.show(frame);
        requestAnimationFrame(step);
      };
      requestAnimationFrame(step);
    }

    pause() {
      this.isPlaying = false;
      setText(this.button, "Play");
    }

    /** Stops at the rest frame. */
    rest() {
      this.pause();
      if (this.data) this.show(this.data.still);
    }
  }

  return { Panel, Player };
})();
