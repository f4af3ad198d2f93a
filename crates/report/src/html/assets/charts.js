// Charts of trocar's pages, drawn from the descriptions of its figures: each panel is a chart. Dragging zooms, a double
// click or tap shows everything, and a click on a name in the legend hides its line. Keyboard: the arrow keys move the
// cursor, E moves it to the next rupture or alarm, + and - zoom around it, 0 shows everything. Charts of one group with
// the same horizontal axis share zoom and cursor. All charts over time share the time of the animation.
"use strict";

const trocarCharts = (() => {
  /** Pixels per point for line widths, and the margins around the axes. */
  const PER_POINT = 1.5;
  const MARGIN = { left: 56, right: 12, top: 9, bottom: 36 };
  /** Maximum number of values of a line at the cursor. */
  const MOST_CROSSINGS = 3;
  const FONT = '12px system-ui, "DejaVu Sans", Arial, sans-serif';
  const TIME = "Time (s)";
  const groups = new Map();
  const dark = window.matchMedia("(prefers-color-scheme: dark)");

  /** Cache of the theme's colours, because each query makes the browser recompute all styles. */
  const colours = new Map();
  dark.addEventListener("change", () => colours.clear());
  window.addEventListener("themechange", () => colours.clear());

  /** Returns a colour of the theme such as "blue", or a CSS colour, resolved for the current theme. */
  function colour(name) {
    if (!colours.has(name)) {
      // The browser resolves a colour for light or dark only on an element.
      const probe = document.body.appendChild(document.createElement("i"));
      probe.style.forcedColorAdjust = "none";
      probe.style.color = /^[a-z-]+$/.test(name) ? `var(--${name})` : name;
      colours.set(name, getComputedStyle(probe).color);
      probe.remove();
    }
    return colours.get(name);
  }

  /** Returns a number with four significant digits, or a dash if it is undefined. */
  function number(value) {
    if (!Number.isFinite(value)) return "—";
    const size = Math.abs(value);
    if (value === 0) return "0";
    if (size < 5e-5 || size >= 1e6) return value.toExponential(1);
    return value.toFixed(Math.min(4, Math.max(0, 3 - Math.floor(Math.log10(size)))));
  }

  /** Returns a number without trailing zeros. */
  function short(value) {
    const size = Math.abs(value);
    if (size !== 0 && (size < 1e-4 || size >= 1e6)) return value.toExponential(1).replace(".0e", "e");
    return String(Number(value.toPrecision(6)));
  }

  /** Returns about `count` round ticks for a part of an axis, in its coordinate (exponents of ten if logarithmic). */
  function ticks({ low, high, log }, count) {
    if (log) {
      const powers = [];
      for (let power = Math.floor(low); power <= high + 1e-9; power += 1) {
        for (const digit of high - low < 3.5 ? [1, 2, 5] : [1]) {
          const at = power + Math.log10(digit);
          if (at >= low - 1e-9 && at <= high + 1e-9) powers.push({ at, label: short(digit * 10 ** power) });
        }
      }
      if (powers.length > 1) return powers;
    }
    const minStep = (high - low) / count || 1;
    const power = 10 ** Math.floor(Math.log10(minStep));
    const step = [1, 2, 5, 10].map((digit) => digit * power).find((size) => size >= minStep) ?? minStep;
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step && found.length < 50; k += 1) {
      found.push({ at: k * step, label: short(log ? 10 ** (k * step) : k * step) });
    }
    return found;
  }

  /** Returns the ticks of a whole axis, from its description. */
  const placed = (axis) => axis.ticks.map(([at, label]) => ({ at, label }));

  /** Draws the ticks and labels of axes around an area; `toX` and `toY` convert positions to pixels. */
  function axes(context, { left, top, width, height }, x, y, toX, toY) {
    const line = (fromX, fromY, endX, endY) => {
      context.beginPath();
      context.moveTo(fromX, fromY);
      context.lineTo(endX, endY);
      context.stroke();
    };
    const bottom = top + height;
    context.setLineDash([]);
    context.font = FONT;
    context.lineWidth = 1;
    context.strokeStyle = colour("line");
    context.fillStyle = colour("ink");
    line(left, top, left, bottom);
    line(left, bottom, left + width, bottom);
    context.textAlign = "center";
    let free = -Infinity;
    for (const { at, label } of x.ticks) {
      line(toX(at), bottom, toX(at), bottom + 4);
      const half = context.measureText(label).width / 2;
      if (toX(at) - half < free) continue;
      context.fillText(label, toX(at), bottom + 16);
      free = toX(at) + half + 8;
    }
    context.fillText(x.caption, left + width / 2, bottom + 31, width);
    context.textAlign = "right";
    free = Infinity;
    for (const { at, label } of y.ticks) {
      line(left - 4, toY(at), left, toY(at));
      if (toY(at) > free) continue;
      context.fillText(label, left - 7, toY(at) + 4);
      free = toY(at) - 14;
    }
  }

  function html(name, attributes = {}, text = "") {
    const node = document.createElement(name);
    for (const [attribute, value] of Object.entries(attributes)) node.setAttribute(attribute, value);
    node.textContent = text;
    return node;
  }

  /** Returns the sample of a legend's entry. */
  function sample({ kind, style }) {
    const [color, width] = [style?.color ?? "var(--black)", Math.min(6, PER_POINT * (style?.width ?? 1))];
    const dashes = (style?.dashes ?? []).map((length) => PER_POINT * length).join();
    const shapes = {
      line: `<path d="M0 6h24" stroke="${color}" stroke-width="${width}" stroke-dasharray="${dashes}"/>`,
      dot: `<circle cx="12" cy="6" r="${width / 2 + 1}" fill="${color}"/>`,
      shade: `<path d="M0 0h24v12h-24z" fill="${color}"/>`,
      rupture: '<path d="M12 0v12" stroke="var(--grey)" stroke-width="1.5" stroke-dasharray="3 3"/>',
      alarm: '<path d="M12 0v12M8 0h8l-4 5z" stroke="var(--black)" fill="var(--black)"/>',
    };
    const node = html("span", { class: "sample", "aria-hidden": "true" });
    node.innerHTML = shapes[kind] ? `<svg width="24" height="12">${shapes[kind]}</svg>` : "";
    return node;
  }

  /** Returns an item of a legend. */
  function entry(one) {
    const item = html("li");
    item.append(sample(one), one.text);
    return item;
  }

  /** Splits a caption such as "Force (N)" into the name and the unit. */
  function named(caption) {
    const [, name, unit] = caption.match(/^(.*?)(?: \(([^()]*)\))?$/);
    return { name, unit: unit ?? "" };
  }

  /** Returns the index of the last point at or before x, at least 0. */
  function before(xs, x) {
    let [low, high] = [0, xs.length];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (xs[middle] <= x) low = middle;
      else high = middle;
    }
    return low;
  }

  const value = (axis, place) => (axis.log ? 10 ** place : place);

  /** True if the positions increase. A boundary can go back and has gaps. */
  const isAscending = (xs) => xs.every((x, index) => index === 0 || x >= xs[index - 1]);

  /** Returns the unique values of a drawn line at x: one for a signal, any number for a boundary. */
  function crossings([xs, ys], x) {
    const between = (i) => (xs[i + 1] === xs[i] ? ys[i] : ys[i] + ((x - xs[i]) / (xs[i + 1] - xs[i])) * (ys[i + 1] - ys[i]));
    if (isAscending(xs)) {
      if (xs.length === 0 || x < xs[0] || x > xs[xs.length - 1]) return [];
      const i = before(xs, x);
      return [i + 1 === xs.length || xs[i] === x ? ys[i] : between(i)];
    }
    const found = [];
    for (let i = 0; i + 1 < xs.length; i += 1) {
      const isOver = Math.min(xs[i], xs[i + 1]) <= x && x <= Math.max(xs[i], xs[i + 1]);
      if (isOver && Number.isFinite(ys[i]) && Number.isFinite(ys[i + 1])) found.push(between(i));
    }
    // Two segments that meet at x give one value.
    return found.sort((a, b) => a - b).filter((y, index) => index === 0 || y - found[index - 1] > 1e-9 * Math.abs(y));
  }

  /** One panel of a figure. */
  class Chart {
    /** `options`: `{ title, group, height, whole }`; `whole` is the full range of x if the panel shows only a part. */
    constructor(parent, panel, { title = null, group = null, height = 200, whole = null } = {}) {
      this.figure = html("figure", { class: "chart", ...(panel.id ? { id: `chart-${panel.id}` } : {}) });
      const caption = html("figcaption", {}, [title, panel.y.caption || panel.x.caption].filter(Boolean).join(": "));
      this.reading = html("span", { class: "quiet" });
      caption.append(" ", this.reading);
      const plot = html("div", { class: "plot" });
      // With the role of a slider, a chart reports its cursor and values to screen readers.
      this.canvas = html("canvas", { tabindex: 0, role: "slider", "aria-valuenow": 0, "aria-valuetext": "no cursor" });
      [this.mark, this.selected] = ["cursor", "selected"].map((name) => html("div", { class: name }));
      plot.append(this.canvas, this.mark, this.selected);
      this.legend = html("ul", { class: "legend" });
      this.figure.append(caption, plot, this.legend);
      parent.append(this.figure);
      this.hidden = new Set();
      this.height = height;
      this.width = Math.max(this.figure.clientWidth, 200);
      this.isVisible = true;
      this.cursor = null;
      const key = `${group} ${panel.x.caption}`;
      this.group = (group && groups.get(key)) || new Set();
      if (group) groups.set(key, this.group);
      this.group.add(this);
      this.name = group;
      this.update(panel, whole);
      this.listen();
    }

    /** Draws another panel in the same chart: at once if it is visible, otherwise when it becomes visible. */
    update(panel, whole = null) {
      this.panel = panel;
      this.whole = whole;
      this.zoomed = null;
      const names = JSON.stringify([panel.legend, panel.lines.map((line) => line.name)]);
      if (names !== this.names) this.nameLines();
      this.names = names;
      this.isDrawn = false;
      if (this.isVisible) this.draw();
    }

    /** Builds the legend. The names of the lines are switches. */
    nameLines() {
      const { panel } = this;
      const { name, unit } = named(panel.x.caption);
      const [low, high] = [panel.x.low, panel.x.high].map((end) => number(value(panel.x, end)));
      const names = [...new Set(panel.lines.map((line) => line.name).filter((name) => name !== ""))];
      this.canvas.setAttribute("aria-label", `${panel.y.caption || "Intervals"} against ${name} from ${low} to ${high} ${unit}: ${names.join(", ")}. The arrow keys move a cursor.`);
      this.canvas.setAttribute("aria-valuemin", low);
      this.canvas.setAttribute("aria-valuemax", high);
      this.values = [];
      const lines = names.map((text) => {
        const one = panel.lines.find((line) => line.name === text);
        const item = html("li");
        const button = html("button", { type: "button", role: "switch", "aria-checked": String(!this.hidden.has(text)) });
        button.append(sample({ kind: one.points[0].length === 1 ? "dot" : "line", style: one.style }), text);
        button.addEventListener("click", () => {
          if (!this.hidden.delete(text)) this.hidden.add(text);
          button.setAttribute("aria-checked", String(!this.hidden.has(text)));
          this.draw();
        });
        const shown = html("span", { class: "value" });
        this.values.push([text, shown]);
        item.append(button, shown);
        return item;
      });
      const others = panel.legend.filter((one) => one.kind !== "line" || !names.includes(one.text));
      this.legend.replaceChildren(...lines, ...others.map(entry));
    }

    /** Returns the displayed ranges of x and y. With a zoom, y covers the visible points within the panel. */
    limits() {
      const { x, y } = this.panel;
      if (!this.zoomed && y.low !== null) return [x, y];
      const { low, high } = this.zoomed ?? x;
      let [min, max] = [Infinity, -Infinity];
      for (const { points: [xs, ys], name } of this.panel.lines) {
        if (this.hidden.has(name)) continue;
        for (let i = 0; i < xs.length; i += 1) {
          if (xs[i] < low || xs[i] > high || !Number.isFinite(ys[i])) continue;
          if (ys[i] < min) min = ys[i];
          if (ys[i] > max) max = ys[i];
        }
      }
      const margin = 0.05 * (max - min) || 0.05 * Math.abs(max) || 0.5;
      const isEmpty = !(min <= max);
      const within = { low: isEmpty ? (y.low ?? 0) : Math.max(y.low ?? -Infinity, min - margin), high: isEmpty ? (y.high ?? 1) : Math.min(y.high ?? Infinity, max + 2 * margin) };
      return [{ ...x, low, high }, within.low < within.high ? { ...y, ...within } : y];
    }

    /** Draws the panel. Returns the canvas. */
    draw() {
      const { canvas, panel } = this;
      this.isDrawn = true;
      const ratio = window.devicePixelRatio || 1;
      const [pixelWidth, pixelHeight] = [this.width * ratio, this.height * ratio].map(Math.round);
      if (canvas.width !== pixelWidth || canvas.height !== pixelHeight) {
        [canvas.width, canvas.height] = [pixelWidth, pixelHeight];
        [canvas.style.width, canvas.style.height] = [`${this.width}px`, `${this.height}px`];
      }
      const context = (this.context ??= canvas.getContext("2d"));
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, this.width, this.height);
      const [x, y] = (this.shown = this.limits());
      const area = { left: MARGIN.left, top: MARGIN.top, width: this.width - MARGIN.left - MARGIN.right, height: this.height - MARGIN.top - MARGIN.bottom };
      const { left, top, width, height } = (this.area = area);
      const [perX, perY] = [width / (x.high - x.low), height / (y.high - y.low)];
      const toX = (place) => left + (place - x.low) * perX;
      const toY = (place) => top + Math.min(1e5, Math.max(-1e5, (y.high - place) * perY));
      // Whole axes use the ticks of the description, if there are any.
      const shown = (axis, whole, count) => (whole.ticks && (axis === whole || whole.ticks.length === 0) ? placed(whole) : ticks(axis, Math.max(2, count)));
      const [xTicks, yTicks] = [shown(x, panel.x, width / 80), shown(y, panel.y, height / 32)];
      context.save();
      context.beginPath();
      context.rect(left, top, width, height);
      context.clip();
      for (const [from, to, color] of panel.shades) {
        context.fillStyle = colour(color);
        context.fillRect(toX(from), top, toX(to) - toX(from), height);
      }
      context.beginPath();
      for (const { at } of xTicks) {
        context.moveTo(toX(at), top);
        context.lineTo(toX(at), top + height);
      }
      for (const { at } of yTicks) {
        context.moveTo(left, toY(at));
        context.lineTo(left + width, toY(at));
      }
      context.lineWidth = 1;
      context.strokeStyle = colour("grid");
      context.stroke();
      this.fills = panel.fills.map(({ points: [xs, ys], color }) => {
        const path = new Path2D();
        for (let i = 0; i < xs.length; i += 1) path.lineTo(toX(xs[i]), toY(ys[i]));
        context.fillStyle = colour(color);
        context.fill(path);
        return path;
      });
      const stroke = ({ color, width, dashes }) => {
        context.strokeStyle = colour(color);
        context.lineWidth = PER_POINT * width;
        context.setLineDash(dashes.map((length) => PER_POINT * length));
        context.stroke();
      };
      const upright = (times, style) => {
        context.beginPath();
        for (const at of times) {
          context.moveTo(toX(at), top);
          context.lineTo(toX(at), top + height);
        }
        stroke(style);
      };
      upright(panel.ruptures, { color: "grey", width: 1, dashes: [3, 3] });
      context.lineJoin = "round";
      for (const { points: [xs, ys], style, name } of panel.lines) {
        if (this.hidden.has(name)) continue;
        const dots = new Path2D();
        context.beginPath();
        let isDown = false;
        for (let i = 0; i < xs.length; i += 1) {
          const at = ys[i];
          if (!Number.isFinite(at)) isDown = false;
          else if (isDown) context.lineTo(toX(xs[i]), toY(at));
          else if (i + 1 < xs.length && Number.isFinite(ys[i + 1])) {
            context.moveTo(toX(xs[i]), toY(at));
            isDown = true;
          } else {
            // A point between gaps.
            dots.moveTo(toX(xs[i]), toY(at));
            dots.arc(toX(xs[i]), toY(at), (PER_POINT * style.width) / 2 + 0.5, 0, 2 * Math.PI);
          }
        }
        stroke(style);
        context.fillStyle = colour(style.color);
        context.fill(dots);
      }
      for (const { at, style } of panel.levels) {
        context.beginPath();
        context.moveTo(left, toY(at));
        context.lineTo(left + width, toY(at));
        stroke(style);
      }
      upright(panel.alarms, { color: "black", width: 0.8, dashes: [] });
      context.fillStyle = colour("black");
      context.beginPath();
      for (const at of panel.alarms) {
        context.moveTo(toX(at) - 4, top);
        context.lineTo(toX(at) + 4, top);
        context.lineTo(toX(at), top + 6);
      }
      context.fill();
      context.restore();
      context.font = FONT;
      context.fillStyle = colour("ink");
      context.textAlign = "center";
      for (const [atX, atY, text] of panel.notes) context.fillText(text, toX(atX), toY(atY) + 4);
      if (!panel.is_bare) axes(context, area, { ticks: xTicks, caption: panel.x.caption }, { ticks: yTicks }, toX, toY);
      this.point(this.cursor, false);
    }

    /** Moves the cursor in all charts of the group, or removes it (`null`), and notifies the animation. */
    point(place, isShared = true) {
      if (isShared) {
        this.group.forEach((chart) => (chart.isVisible || chart === this) && chart.point(place && { ...place, y: chart === this ? place.y : null }, false));
        if (this.panel.x.caption === TIME) window.dispatchEvent(new CustomEvent("charttime", { detail: { time: place && place.x, isKept: place?.isKept === true } }));
      }
      if (isShared || (place === null && this.cursor === null)) return;
      this.cursor = place;
      const [x, y] = this.shown;
      const isInside = place !== null && place.x >= x.low && place.x <= x.high;
      this.mark.hidden = !isInside;
      const { name, unit } = named(this.panel.x.caption);
      const at = isInside ? this.area.left + ((place.x - x.low) / (x.high - x.low)) * this.area.width : 0;
      this.mark.style.transform = `translate(${at}px, ${this.area.top}px)`;
      this.mark.style.height = `${this.area.height}px`;
      const isRead = isInside && !place.isQuiet;
      if (!isRead && !this.isRead) return;
      this.isRead = isRead;
      this.reading.textContent = isRead ? `${name} ${number(value(x, place.x))} ${unit}` : "";
      const of = named(this.panel.y.caption).unit;
      for (const [text, shown] of this.values) {
        const line = this.panel.lines.find((one) => one.name === text && one.points[0].length > 2);
        const at = line && isRead ? crossings(line.points, place.x).slice(0, MOST_CROSSINGS) : [];
        shown.textContent = line && isRead ? `${at.map((one) => number(value(y, one))).join(" and ") || "—"} ${of}` : "";
      }
      if (!isRead || place.y === null || this.panel.fills.every((fill) => fill.text === "")) return;
      // For a map: the value of the cell.
      const ratio = window.devicePixelRatio || 1;
      const down = this.area.top + ((y.high - place.y) / (y.high - y.low)) * this.area.height;
      const index = this.fills.findLastIndex((path) => this.context.isPointInPath(path, at * ratio, down * ratio));
      const cell = index < 0 ? (this.panel.outside ?? "—") : this.panel.fills[index].text;
      this.reading.textContent += `, ${named(this.panel.y.caption).name} ${number(value(y, place.y))}: ${cell}`;
    }

    /** Displays a range of x in every chart of the group, or everything if it is null. */
    zoom(range) {
      for (const chart of this.group) {
        chart.zoomed = range;
        chart.isDrawn = false;
        if (chart.isVisible) chart.draw();
      }
      window.dispatchEvent(new CustomEvent("chartzoom", { detail: { group: this.name, range } }));
    }

    /** Returns the position of a pointer event in the coordinates of the axes, limited to them. */
    place({ clientX, clientY }) {
      const box = this.canvas.getBoundingClientRect();
      const [x, y] = this.shown;
      const share = (at, of) => Math.min(1, Math.max(0, at / of));
      return {
        x: x.low + share(clientX - box.left - this.area.left, this.area.width) * (x.high - x.low),
        y: y.high - share(clientY - box.top - this.area.top, this.area.height) * (y.high - y.low),
      };
    }

    /** Handles pointer, keys, size, visibility and theme. Horizontal touch selects; vertical touch scrolls the page. */
    listen() {
      const { canvas, selected } = this;
      let from = null;
      let pressed = { at: -Infinity, x: 0 };
      const select = (event) => {
        const [left, right] = [from, event.clientX].sort((a, b) => a - b);
        selected.hidden = event.type !== "pointermove" || right - left < 4;
        const start = left - canvas.getBoundingClientRect().left;
        selected.style.cssText = `left: ${start}px; width: ${right - left}px; top: ${this.area.top}px; height: ${this.area.height}px`;
        return [left, right];
      };
      selected.hidden = true;
      this.mark.hidden = true;
      canvas.addEventListener("pointerdown", (event) => {
        if (event.button !== 0) return;
        from = event.clientX;
        canvas.setPointerCapture(event.pointerId);
        const isSecond = event.timeStamp - pressed.at < 350 && Math.abs(event.clientX - pressed.x) < 20;
        pressed = { at: isSecond ? -Infinity : event.timeStamp, x: event.clientX };
        if (isSecond) this.zoom(null);
      });
      canvas.addEventListener("pointermove", (event) => {
        this.point(this.place(event));
        if (from !== null) select(event);
      });
      canvas.addEventListener("pointerup", (event) => {
        if (from === null) return;
        const [left, right] = select(event);
        from = null;
        const [low, high] = [left, right].map((clientX) => this.place({ clientX, clientY: 0 }).x);
        if (right - left >= 8 && low < high) this.zoom({ low, high });
      });
      canvas.addEventListener("pointercancel", () => {
        from = null;
        selected.hidden = true;
      });
      canvas.addEventListener("pointerleave", () => this.point(null));
      canvas.addEventListener("blur", () => this.point(null));
      canvas.addEventListener("keydown", (event) => this.key(event));
      new ResizeObserver(([{ contentRect }]) => {
        if (contentRect.width > 0 && contentRect.width !== this.width) this.resize(contentRect.width, this.height);
      }).observe(this.figure);
      // A chart outside the window is drawn when it becomes visible.
      new IntersectionObserver((entries) => {
        this.isVisible = entries[entries.length - 1].isIntersecting;
        if (this.isVisible && !this.isDrawn) this.draw();
      }).observe(this.figure);
      dark.addEventListener("change", () => this.draw());
      window.addEventListener("themechange", () => this.draw());
      window.addEventListener("beforeprint", () => this.isDrawn || this.draw());
    }

    resize(width, height) {
      [this.width, this.height] = [width, height];
      this.draw();
    }

    remove() {
      this.group.delete(this);
      this.figure.remove();
    }

    /** Handles a key: moves the cursor, or zooms around it. */
    key(event) {
      // The key may have just made the chart visible.
      if (!this.isDrawn) this.draw();
      const [x, y] = this.shown;
      const { x: about, y: level } = this.cursor ?? { x: (x.low + x.high) / 2, y: null };
      const pixels = event.shiftKey ? 40 : 4;
      const [across, up] = [(pixels * (x.high - x.low)) / this.area.width, (pixels * (y.high - y.low)) / this.area.height];
      const move = (by, raise) => {
        const within = (at, axis) => Math.min(axis.high, Math.max(axis.low, at));
        this.point({ x: within(about + by, x), y: within((level ?? (y.low + y.high) / 2) + raise, y), isKept: true });
        this.speak();
      };
      const toEvent = () => {
        const events = [...this.panel.ruptures, ...this.panel.alarms].filter((at) => at >= x.low && at <= x.high).sort((a, b) => a - b);
        const next = events.find((at) => at > about + 1e-6) ?? events[0];
        if (next !== undefined) move(next - about, 0);
      };
      const scaled = (factor) => {
        const [first, last] = this.whole ?? [this.panel.x.low, this.panel.x.high];
        const [low, high] = [Math.max(about + (x.low - about) * factor, first), Math.min(about + (x.high - about) * factor, last)];
        this.zoom(low <= first && high >= last ? null : { low, high });
      };
      const actions = {
        ArrowLeft: () => move(-across, 0),
        ArrowRight: () => move(across, 0),
        ...(this.panel.fills.some((fill) => fill.text) ? { ArrowUp: () => move(0, up), ArrowDown: () => move(0, -up) } : {}),
        "+": () => scaled(0.6),
        "=": () => scaled(0.6),
        "-": () => scaled(1 / 0.6),
        0: () => this.zoom(null),
        e: toEvent,
      };
      const action = actions[event.key];
      if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      action();
    }

    /** Reports the cursor and its values to screen readers. */
    speak() {
      const values = this.values.filter(([, shown]) => shown.textContent !== "").map(([text, shown]) => `${text} ${shown.textContent}`);
      this.canvas.setAttribute("aria-valuenow", number(value(this.shown[0], this.cursor.x)));
      this.canvas.setAttribute("aria-valuetext", [this.reading.textContent, ...values].join(", "));
    }
  }

  /** Lists the legend of all panels except the names of lines. Returns the number of entries. */
  function key(list, { legend, rows }) {
    const lines = new Set(rows.flatMap(({ panels }) => panels.flatMap((panel) => panel.lines.map((line) => line.name))));
    const others = legend.filter((one) => one.kind !== "title" && !lines.has(one.text));
    const names = JSON.stringify(others);
    if (list.names !== names) list.replaceChildren(...others.map(entry));
    list.names = names;
    return others.length;
  }

  /** Draws all panels of a figure into `parent`, with their common legend, and returns the charts. */
  function figure(parent, description, group) {
    const isOfMany = description.rows.length > 1;
    // A row of events has no vertical quantity and needs less height.
    const least = ({ lines, fills }) => (lines.length > 0 || fills.length > 0 ? 120 : 76);
    const panels = description.rows.flatMap(({ title, height, panels }) =>
      panels.map((panel) => ({ panel, title: isOfMany && title, height: Math.max(least(panel), Math.round(1.6 * height)) })),
    );
    const list = html("ul", { class: "legend key" });
    if (key(list, description)) parent.append(list);
    return panels.map(({ panel, title, height }) => new Chart(parent, panel, { title, group, height }));
  }

  /** Moves the cursor of all visible charts over time; a quiet cursor has no values. */
  function time(x, isQuiet) {
    for (const [key, group] of groups) {
      if (key.endsWith(TIME)) group.forEach((chart) => chart.isVisible && chart.isDrawn && chart.point({ x, y: null, isQuiet }, false));
    }
  }

  return { Chart, figure, axes, placed, colour, number, short, time, key };
})();
