// Charts of trocar's pages, on uPlot: several lines over a shared axis, shaded modes, marked events, thresholds. Dragging
// zooms and a double click shows everything again; a click on a name in the legend hides its line; and the keyboard does as
// much: the arrows move the cursor, + and - zoom about it, 0 shows everything. Charts of one group zoom and point together.
"use strict";

const trocarCharts = (() => {
  const groups = new Map();
  /** How wide an axis is whose values have names, and its label where it has one. */
  const NAMED_SIZE = 110;
  const LABEL_SIZE = 22;
  const font = (size) => `${size}px system-ui, "DejaVu Sans", Arial, sans-serif`;

  /** The theme's colours, as they were looked up: asking the browser makes it compute every style anew. */
  let colours = new Map();
  const forget = () => {
    colours = new Map();
  };
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", forget);
  window.addEventListener("themechange", forget);

  /** What a name such as "blue" is in the theme that is shown now. */
  function colour(name) {
    if (!colours.has(name)) {
      colours.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim() || name);
    }
    return colours.get(name);
  }

  /** A number in four significant digits; a dash where there is none. */
  function number(value) {
    if (value === null || value === undefined || !Number.isFinite(value)) return "—";
    const size = Math.abs(value);
    if (value === 0) return "0";
    if (size < 5e-5 || size >= 1e6) return value.toExponential(1);
    return value.toFixed(Math.min(4, Math.max(0, 3 - Math.floor(Math.log10(size)))));
  }

  /** A number without digits that say nothing. */
  function short(value) {
    const size = Math.abs(value);
    if (size !== 0 && (size < 1e-4 || size >= 1e6)) return value.toExponential(1).replace(".0e", "e");
    return String(Number(value.toPrecision(6)));
  }

  /** Draws the intervals of the modes, the events and the thresholds, beneath and above the lines. */
  function decorations(state) {
    const across = (plot, value) => plot.valToPos(value, "x", true);
    return {
      drawClear: (plot) => {
        const { ctx, bbox } = plot;
        ctx.save();
        for (const { from, to, name } of state.shades) {
          const left = Math.max(across(plot, from), bbox.left);
          const right = Math.min(across(plot, to), bbox.left + bbox.width);
          if (right <= left) continue;
          ctx.fillStyle = colour(`shade-${name}`);
          ctx.fillRect(left, bbox.top, right - left, bbox.height);
        }
        ctx.restore();
      },
      draw: (plot) => {
        const { ctx, bbox } = plot;
        const ratio = window.devicePixelRatio || 1;
        ctx.save();
        ctx.beginPath();
        ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
        ctx.clip();
        for (const { at, kind, label } of state.marks) {
          const x = Math.round(across(plot, at)) + 0.5;
          ctx.strokeStyle = colour(kind === "alarm" ? "black" : "grey");
          ctx.setLineDash(kind === "alarm" ? [] : [4 * ratio, 4 * ratio]);
          ctx.lineWidth = 1.25 * ratio;
          ctx.beginPath();
          ctx.moveTo(x, bbox.top);
          ctx.lineTo(x, bbox.top + bbox.height);
          ctx.stroke();
          if (label && state.spec.markLabels) {
            ctx.font = font(12 * ratio);
            ctx.textAlign = "left";
            ctx.fillStyle = colour("quiet");
            ctx.fillText(label, x + 4 * ratio, bbox.top + 13 * ratio);
          }
        }
        ctx.setLineDash([10 * ratio, 4 * ratio, 2 * ratio, 4 * ratio]);
        for (const { value, scale } of state.thresholds) {
          const y = plot.valToPos(value, scale || "y", true);
          ctx.strokeStyle = colour("vermilion");
          ctx.lineWidth = 1.5 * ratio;
          ctx.beginPath();
          ctx.moveTo(bbox.left, y);
          ctx.lineTo(bbox.left + bbox.width, y);
          ctx.stroke();
        }
        ctx.restore();
      },
    };
  }

  /** From where to where there is something to see: told where the columns are only a part of it. */
  function whole(state) {
    const [xs] = state.plot.data;
    return state.whole ?? [xs[0] ?? 0, xs[xs.length - 1] ?? 1];
  }

  /** The same stretch of x in every chart of the group. */
  function zoom(state, min, max) {
    for (const other of state.group) {
      other.zoomed = min === null ? null : { min, max };
      const [first, last] = whole(other);
      other.plot.setScale("x", min === null ? { min: first, max: last } : { min, max });
    }
    window.dispatchEvent(new CustomEvent("chartzoom", { detail: { group: state.spec.group, min, max } }));
  }

  /** The keys that do what the mouse does. */
  function keys(state, event) {
    const { plot } = state;
    const { min, max } = plot.scales.x;
    const width = plot.over.clientWidth;
    const left = plot.cursor.left >= 0 ? plot.cursor.left : width / 2;
    const top = plot.over.clientHeight / 2;
    // Told to the group, as a motion of the mouse is.
    const move = (by) => plot.setCursor({ left: Math.min(width, Math.max(0, left + by)), top }, true, true);
    const about = plot.posToVal(left, "x");
    // On a logarithmic axis by ratios; never beyond what there is.
    const [to, from] = state.spec.x.log ? [Math.log, Math.exp] : [(x) => x, (x) => x];
    const scaled = (factor) => {
      const [first, last] = whole(state);
      const end = (x) => from(to(about) + (to(x) - to(about)) * factor);
      const [low, high] = [Math.max(end(min), first), Math.min(end(max), last)];
      if (low <= first && high >= last) zoom(state, null, null);
      else if (low < high) zoom(state, low, high);
    };
    const step = event.shiftKey ? 40 : 4;
    const doings = {
      ArrowLeft: () => move(-step),
      ArrowRight: () => move(step),
      "+": () => scaled(0.6),
      "=": () => scaled(0.6),
      "-": () => scaled(1 / 0.6),
      0: () => zoom(state, null, null),
    };
    const doing = doings[event.key];
    if (!doing || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    doing();
  }

  /** The legend's names as switches that the keyboard reaches. */
  function legend(state) {
    const rows = state.plot.root.querySelectorAll(".u-legend .u-series");
    rows.forEach((row, index) => {
      if (index === 0) return;
      const name = row.querySelector("th");
      name.tabIndex = 0;
      name.setAttribute("role", "switch");
      const told = () => name.setAttribute("aria-checked", String(state.plot.series[index].show));
      told();
      name.addEventListener("click", () => setTimeout(told));
      name.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        state.plot.setSeries(index, { show: !state.plot.series[index].show });
        told();
      });
    });
  }

  function axes(spec) {
    const named = spec.y.ticks && {
      splits: () => spec.y.ticks.map((tick) => tick.at),
      values: () => spec.y.ticks.map((tick) => tick.label),
      label: undefined,
      size: NAMED_SIZE,
    };
    const common = {
      stroke: () => colour("ink"),
      grid: { stroke: () => colour("grid"), width: 1 },
      ticks: { stroke: () => colour("line"), width: 1 },
      font: font(13),
      labelFont: font(13),
    };
    return [
      { ...common, label: spec.x.unit ? `${spec.x.label}, ${spec.x.unit}` : spec.x.label, labelSize: 22, size: 36 },
      { ...common, label: spec.y.unit ? `${spec.y.label}, ${spec.y.unit}` : spec.y.label, labelSize: LABEL_SIZE, size: spec.y.named ? NAMED_SIZE - LABEL_SIZE : 62, ...named },
    ];
  }

  function series(spec) {
    const x = { label: spec.x.label, value: (_, v) => (v === null || v === undefined ? "—" : `${number(v)} ${spec.x.unit || ""}`) };
    const lines = spec.series.map((one) => ({
      label: one.label,
      stroke: () => colour(one.colour),
      width: one.width || 2,
      dash: one.dash,
      show: one.show !== false,
      paths: one.scatter ? () => null : one.stepped ? uPlot.paths.stepped({ align: 1 }) : undefined,
      points: one.points || one.scatter ? { show: true, size: one.scatter ? 6 : 5 } : { show: false },
      value: (_, v) => (v === null || v === undefined ? "—" : `${number(v)} ${spec.y.unit || ""}`),
    }));
    return [x, ...lines];
  }

  /**
   * Draws a chart into `parent`. A series that has `scatter` is points without a line; what is given back also has
   * `zoom(min, max)`, which shows a stretch of x in the whole group, or all of it where both are null.
   *
   * `spec`: `{ id, title, alt, height, group, markLabels, x: { label, unit, log }, y: { label, unit, log, range, ticks, named },
   * ticks as `[{ at, label }]` where the values have names, named where the axis stands above one whose values have,
   * series: [{ label, colour, width, dash, stepped, points, show }] }`, colours by the theme's names.
   * `columns`: x, then one array a series, all of a length; what is not a number leaves a gap.
   * `extras`: `{ shades: [{ from, to, name: "augmented" | "reengaging" }], marks: [{ at, kind: "rupture" | "alarm", label }],
   * thresholds: [{ value }], whole: [from, to] where the columns are only a part of what there is }`.
   * Gives `{ plot, figure, update(columns, extras), flush(), unzoom(), destroy() }`. A zoom is told to the window as "chartzoom", with the
   * group and the stretch of x, none for all of it.
   */
  function chart(parent, spec, columns, extras = {}) {
    const figure = document.createElement("figure");
    figure.className = "chart";
    if (spec.id) figure.id = spec.id;
    const caption = document.createElement("figcaption");
    caption.textContent = spec.title;
    figure.append(caption);
    parent.append(figure);
    const group = spec.group ? groups.get(spec.group) || new Set() : new Set();
    if (spec.group) groups.set(spec.group, group);
    const state = { spec, group, zoomed: null, pending: null, shades: [], marks: [], thresholds: [], ...extras };
    const range = spec.y.range && ((_, low, high) => spec.y.range(low, high));
    const hooks = decorations(state);
    state.plot = new uPlot(
      {
        width: Math.max(figure.clientWidth, 280),
        height: spec.height || 240,
        scales: {
          // A logarithmic axis too ends where it is told to, and not at the next power of ten.
          x: { time: false, distr: spec.x.log ? 3 : 1, ...(spec.x.log ? { range: (_, low, high) => [low, high] } : {}) },
          y: { distr: spec.y.log ? 3 : 1, ...(range ? { range } : {}) },
        },
        axes: axes(spec),
        series: series(spec),
        legend: { live: true },
        cursor: {
          ...(spec.group ? { sync: { key: spec.group, scales: ["x", null] } } : {}),
          drag: { x: true, y: false, setScale: false },
          bind: {
            dblclick: () => () => {
              zoom(state, null, null);
              return null;
            },
          },
        },
        hooks: {
          drawClear: [hooks.drawClear],
          draw: [hooks.draw],
          setSelect: [
            (plot) => {
              const { left, width } = plot.select;
              if (width < 4) return;
              const [min, max] = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
              plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
              zoom(state, min, max);
            },
          ],
        },
      },
      columns,
      figure,
    );
    group.add(state);
    const over = state.plot.over;
    over.tabIndex = 0;
    over.setAttribute("role", "img");
    over.setAttribute("aria-label", spec.alt || spec.title);
    over.addEventListener("keydown", (event) => keys(state, event));
    legend(state);
    const resized = new ResizeObserver(() => {
      const width = Math.max(figure.clientWidth, 280);
      if (width !== state.plot.width) state.plot.setSize({ width, height: spec.height || 240 });
    });
    resized.observe(figure);
    const apply = () => {
      if (!state.pending) return;
      const columns = state.pending;
      state.pending = null;
      state.plot.setData(columns, state.zoomed === null);
      if (state.zoomed !== null) state.plot.setScale("x", state.zoomed);
    };
    // What nobody sees is drawn when somebody does.
    state.seen = true;
    const watch = new IntersectionObserver((entries) => {
      state.seen = entries[entries.length - 1].isIntersecting;
      if (state.seen) apply();
    });
    watch.observe(figure);
    window.addEventListener("beforeprint", apply);
    const redraw = () => state.plot.redraw(false, true);
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", redraw);
    window.addEventListener("themechange", redraw);
    return {
      plot: state.plot,
      figure,
      update(newColumns, newExtras = {}) {
        Object.assign(state, newExtras);
        state.pending = newColumns;
        if (state.seen) apply();
      },
      /** Draws what waits to be seen. */
      flush: apply,
      zoom: (min, max) => zoom(state, min, max),
      /** Lets the next columns be seen whole, in all of the group. */
      unzoom() {
        for (const other of group) other.zoomed = null;
      },
      destroy() {
        resized.disconnect();
        watch.disconnect();
        window.removeEventListener("beforeprint", apply);
        dark.removeEventListener("change", redraw);
        window.removeEventListener("themechange", redraw);
        group.delete(state);
        state.plot.destroy();
        figure.remove();
      },
    };
  }

  return { chart, colour, number, short };
})();
