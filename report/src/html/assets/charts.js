// Charts of trocar's pages, drawn with uPlot: several lines over one axis, shaded modes, marked events, thresholds. Dragging
// zooms, a double click shows everything, and a click on a name in the legend hides its line. Keyboard: the arrow keys move the
// cursor, + and - zoom about it, 0 shows everything. Charts of one group share zoom and cursor.
"use strict";

const trocarCharts = (() => {
  const groups = new Map();
  /** Width of an axis whose values have names, and of the label of an axis. */
  const NAMED_SIZE = 110;
  const LABEL_SIZE = 22;
  const font = (size) => `${size}px system-ui, "DejaVu Sans", Arial, sans-serif`;

  /** Cache of the theme's colours, because each look-up in the browser recomputes all styles. */
  let colours = new Map();
  const clearColours = () => {
    colours = new Map();
  };
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", clearColours);
  window.addEventListener("themechange", clearColours);

  /** Returns a colour name such as "blue" as rgb() in the current theme. */
  function colour(name) {
    if (!colours.has(name)) {
      // Only a colour that an element has is resolved for light or dark.
      const probe = document.body.appendChild(document.createElement("i"));
      probe.style.color = `var(--${name}, ${name})`;
      colours.set(name, getComputedStyle(probe).color);
      probe.remove();
    }
    return colours.get(name);
  }

  /** Returns a number with four significant digits, or a dash if it is undefined. */
  function number(value) {
    if (value === null || value === undefined || !Number.isFinite(value)) return "—";
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

  /** Returns the hooks that draw the shades below the lines, and the events and thresholds above them. */
  function decorations(state) {
    const xPixel = (plot, value) => plot.valToPos(value, "x", true);
    return {
      drawClear: (plot) => {
        const { ctx, bbox } = plot;
        ctx.save();
        for (const { from, to, name } of state.shades) {
          const left = Math.max(xPixel(plot, from), bbox.left);
          const right = Math.min(xPixel(plot, to), bbox.left + bbox.width);
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
          const x = Math.round(xPixel(plot, at)) + 0.5;
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

  /** Returns the full range of x: that of the columns, or the given one if the columns are only a part of it. */
  function fullRange(state) {
    const [xs] = state.plot.data;
    return state.whole ?? [xs[0] ?? 0, xs[xs.length - 1] ?? 1];
  }

  /** Shows the same range of x in every chart of the group, or everything if both are null. */
  function zoom(state, min, max) {
    for (const other of state.group) {
      other.zoomed = min === null ? null : { min, max };
      const [first, last] = fullRange(other);
      other.plot.setScale("x", min === null ? { min: first, max: last } : { min, max });
    }
    window.dispatchEvent(new CustomEvent("chartzoom", { detail: { group: state.spec.group, min, max } }));
  }

  /** Zooms by a finger: dragging across selects a range, a double tap shows everything. Dragging down scrolls the page. */
  function touch(state) {
    const { over } = state.plot;
    let from = null;
    let tapped = 0;
    over.style.touchAction = "pan-y";
    const at = (event) => Math.min(Math.max(event.clientX - over.getBoundingClientRect().left, 0), over.clientWidth);
    const select = (left, width) => state.plot.setSelect({ left, width, top: 0, height: width ? over.clientHeight : 0 }, false);
    over.addEventListener("pointerdown", (event) => {
      if (event.pointerType !== "touch") return;
      from = at(event);
      if (event.timeStamp - tapped < 350) zoom(state, null, null);
      tapped = event.timeStamp;
    });
    over.addEventListener("pointermove", (event) => {
      if (from !== null && event.pointerType === "touch") select(Math.min(from, at(event)), Math.abs(at(event) - from));
    });
    over.addEventListener("pointercancel", () => {
      from = null;
      select(0, 0);
    });
    over.addEventListener("pointerup", (event) => {
      if (from === null || event.pointerType !== "touch") return;
      const [left, right] = [from, at(event)].sort((a, b) => a - b);
      from = null;
      select(0, 0);
      if (right - left >= 12) zoom(state, state.plot.posToVal(left, "x"), state.plot.posToVal(right, "x"));
    });
  }

  /** Handles a key: moves the cursor or zooms. */
  function keys(state, event) {
    const { plot } = state;
    const { min, max } = plot.scales.x;
    const width = plot.over.clientWidth;
    const left = plot.cursor.left >= 0 ? plot.cursor.left : width / 2;
    const top = plot.over.clientHeight / 2;
    // Moves the cursor of the whole group, as a motion of the mouse does.
    const move = (by) => plot.setCursor({ left: Math.min(width, Math.max(0, left + by)), top }, true, true);
    const about = plot.posToVal(left, "x");
    // A logarithmic axis zooms by ratios. The range never exceeds the data.
    const [to, from] = state.spec.x.log ? [Math.log, Math.exp] : [(x) => x, (x) => x];
    const scaled = (factor) => {
      const [first, last] = fullRange(state);
      const end = (x) => from(to(about) + (to(x) - to(about)) * factor);
      const [low, high] = [Math.max(end(min), first), Math.min(end(max), last)];
      if (low <= first && high >= last) zoom(state, null, null);
      else if (low < high) zoom(state, low, high);
    };
    const step = event.shiftKey ? 40 : 4;
    const actions = {
      ArrowLeft: () => move(-step),
      ArrowRight: () => move(step),
      "+": () => scaled(0.6),
      "=": () => scaled(0.6),
      "-": () => scaled(1 / 0.6),
      0: () => zoom(state, null, null),
    };
    const action = actions[event.key];
    if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    action();
  }

  /** Makes the names of the legend switches with keyboard focus. */
  function legend(state) {
    const rows = state.plot.root.querySelectorAll(".u-legend .u-series");
    rows.forEach((row, index) => {
      if (index === 0) return;
      const name = row.querySelector("th");
      name.tabIndex = 0;
      name.setAttribute("role", "switch");
      const updateChecked = () => name.setAttribute("aria-checked", String(state.plot.series[index].show));
      updateChecked();
      name.addEventListener("click", () => setTimeout(updateChecked));
      name.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        state.plot.setSeries(index, { show: !state.plot.series[index].show });
        updateChecked();
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
    // A chart whose title names the quantity has no label beside its axis.
    const yLabel = spec.y.label ? { label: spec.y.unit ? `${spec.y.label}, ${spec.y.unit}` : spec.y.label, labelSize: LABEL_SIZE } : {};
    return [
      { ...common, label: spec.x.unit ? `${spec.x.label}, ${spec.x.unit}` : spec.x.label, labelSize: 22, size: 36 },
      { ...common, ...yLabel, size: spec.y.named ? NAMED_SIZE - LABEL_SIZE : spec.y.label ? 62 : 46, ...named },
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

  /** Returns the bands between the upper and the lower edges. */
  function bands(spec) {
    const uppers = spec.series.map((one, k) => (one.edge && spec.series[k + 1]?.edge ? k + 1 : 0)).filter((k) => k > 0);
    return uppers.map((k) => ({
      series: [k, k + 1],
      fill: () => colour(spec.series[k - 1].colour).replace(/^rgb\((.*)\)$/, "rgba($1, 0.15)"),
    }));
  }

  /**
   * Draws a chart into `parent`.
   *
   * `spec`: `{ id, title, alt, height, group, markLabels, x: { label, unit, log }, y: { label, unit, log, range, ticks, named },
   * series: [{ label, colour, width, dash, stepped, scatter, points, show, edge }] }`. An upper and a lower `edge` bound a band. Colours are names of the theme. `ticks` is
   * `[{ at, label }]` for values with names; `named` aligns an axis with one below whose values have names. A series with `scatter`
   * has points without a line.
   * `columns`: x, then one array per series, all of the same length. A value that is not a number leaves a gap.
   * `extras`: `{ shades: [{ from, to, name: "augmented" | "reengaging" }], marks: [{ at, kind: "rupture" | "alarm", label }],
   * thresholds: [{ value }], whole: [from, to], zoomed: { min, max } }`. `whole` is the full range of x if the columns are only a part
   * of it, and `zoomed` the displayed range, or null for everything.
   * Returns `{ plot, figure, update(columns, extras), flush(), zoom(min, max), destroy() }`. `zoom` shows a range of x in
   * the whole group, or everything if both are null. A zoom dispatches the event "chartzoom" on the window, with the group and the
   * range of x, which is null for everything.
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
    // uPlot draws up to the first of several points at the end of its range. A range a little wider than the points has them all.
    const isScattered = spec.series.some((one) => one.scatter);
    const widened = (low, high) =>
      spec.x.log ? [low / 1.001, high * 1.001] : [low - 1e-3 * (high - low || 1), high + 1e-3 * (high - low || 1)];
    const xRange = isScattered ? (_, low, high) => widened(low, high) : spec.x.log ? (_, low, high) => [low, high] : null;
    const hooks = decorations(state);
    state.plot = new uPlot(
      {
        width: Math.max(figure.clientWidth, 280),
        height: spec.height || 240,
        scales: {
          // A logarithmic axis has these limits too, and not the next powers of ten.
          x: { time: false, distr: spec.x.log ? 3 : 1, ...(xRange ? { range: xRange } : {}) },
          y: { distr: spec.y.log ? 3 : 1, ...(range ? { range } : {}) },
        },
        axes: axes(spec),
        series: series(spec),
        bands: bands(spec),
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
    touch(state);
    if (state.zoomed) state.plot.setScale("x", state.zoomed);
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
    // A chart outside the viewport is drawn when it becomes visible.
    state.visible = true;
    const watch = new IntersectionObserver((entries) => {
      state.visible = entries[entries.length - 1].isIntersecting;
      if (state.visible) apply();
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
        if (state.visible) apply();
      },
      /** Draws pending columns now. */
      flush: apply,
      zoom: (min, max) => zoom(state, min, max),
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
