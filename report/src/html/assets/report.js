// A report: draws the charts and maps from the page's data, and handles its buttons.
"use strict";

(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const byName = new Map();
  const status = document.getElementById("status");

  /** Returns the range function of the vertical axis. */
  function yRange(chart) {
    if (chart.range) return () => chart.range;
    if (!chart.includes.length && !chart.y.log) return undefined;
    return (low, high) => {
      const ends = [low, high, ...chart.includes].filter((value) => value !== null && Number.isFinite(value));
      if (!ends.length) return chart.y.log ? [0.1, 1] : [0, 1];
      const [min, max] = [Math.min(...ends), Math.max(...ends)];
      // A logarithmic axis shows at most ten powers of ten.
      if (chart.y.log) return uPlot.rangeLog(Math.max(min, 1e-10 * max), max, 10, true);
      const margin = 0.03 * (max - min || 1);
      return [min === 0 ? 0 : min - margin, max + margin];
    };
  }

  /** Returns a chart's columns over one common x. */
  function columns(chart) {
    let next = 0;
    const tables = chart.columns.map(({ x, y }) => {
      const spanned = y.map((column) => {
        const { span } = chart.series[next++];
        return span ? column.map((value) => (value === null ? undefined : value)) : column;
      });
      return [x, ...spanned];
    });
    return tables.length === 1 ? tables[0] : uPlot.join(tables);
  }

  function drawCharts(place) {
    const { name } = place.dataset;
    const drawn = [];
    for (const chart of data.charts[name] || []) {
      if (!chart.columns.some(({ x }) => x.length > 0)) continue;
      const spec = {
        title: chart.title,
        alt: chart.alt,
        height: chart.height,
        group: name === "axes" ? undefined : name,
        markLabels: chart.markLabels,
        x: chart.x,
        y: { ...chart.y, range: yRange(chart) },
        series: chart.series.map((one) => ({ ...one, dash: one.dash.length ? one.dash : undefined, points: one.scatter })),
      };
      drawn.push(trocarCharts.chart(place, spec, columns(chart), chart.extras));
    }
    byName.set(name, drawn);
  }

  function windows(bar) {
    const buttons = [...bar.querySelectorAll("button")];
    const show = (button) => {
      const [first] = byName.get(bar.dataset.of) || [];
      if (!first) return;
      if ("all" in button.dataset) first.zoom(null, null);
      else first.zoom(Number(button.dataset.from), Number(button.dataset.to));
      buttons.forEach((other) => other.setAttribute("aria-pressed", String(other === button)));
    };
    buttons.forEach((button) => button.addEventListener("click", () => show(button)));
    bar.hidden = false;
  }

  // Five colours of viridis (van der Walt and Smith 2015).
  const SCALE = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
  const rgb = (share) => {
    const at = Math.min(Math.max(share, 0), 1) * (SCALE.length - 1);
    const low = Math.min(Math.floor(at), SCALE.length - 2);
    return SCALE[low].map((part, index) => Math.round(part + (at - low) * (SCALE[low + 1][index] - part)));
  };

  /** Returns about `count` round ticks of an axis, in the coordinate of the axis. */
  function ticks(low, high, log, count) {
    if (log) {
      const powers = [];
      for (let power = Math.floor(low); power <= high + 1e-9; power += 1) {
        for (const digit of high - low < 3.5 ? [1, 2, 5] : [1]) {
          const at = power + Math.log10(digit);
          if (at >= low - 1e-9 && at <= high + 1e-9) powers.push({ at, label: trocarCharts.short(digit * 10 ** power) });
        }
      }
      if (powers.length > 1) return powers;
    }
    const minStep = (high - low) / count || 1;
    const power = 10 ** Math.floor(Math.log10(minStep));
    const step = [1, 2, 5, 10].map((digit) => digit * power).find((size) => size >= minStep);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) {
      const at = k * step;
      found.push({ at, label: trocarCharts.short(log ? 10 ** at : at) });
    }
    return found;
  }

  /** A map: cells with a colour or a verdict, a boundary, the point of the scenario. */
  class PlaneMap {
    constructor(place, map) {
      this.map = map;
      this.scaleX = map.x.log ? Math.log10 : (value) => value;
      this.scaleY = map.y.log ? Math.log10 : (value) => value;
      this.xEdges = this.edges(map.x, this.scaleX);
      this.yEdges = this.edges(map.y, this.scaleY);
      const defined = (map.cells || []).filter((value) => value !== null);
      this.min = Math.min(...defined);
      this.max = Math.max(...defined);
      const figure = document.createElement("figure");
      const caption = document.createElement("figcaption");
      caption.textContent = map.unit ? `${map.title}, ${map.unit}` : map.title;
      this.canvas = document.createElement("canvas");
      this.canvas.tabIndex = 0;
      this.canvas.setAttribute("role", "img");
      this.canvas.setAttribute("aria-label", `${map.alt} The arrow keys move a cursor.`);
      this.output = document.createElement("output");
      figure.append(caption, this.canvas, this.output, this.legend());
      place.append(figure);
      this.canvas.addEventListener("pointermove", (event) => this.point(event));
      this.canvas.addEventListener("pointerleave", () => this.move(null));
      this.canvas.addEventListener("keydown", (event) => this.key(event));
      new ResizeObserver(() => this.draw()).observe(place);
      this.place = place;
      this.draw();
    }

    /** Returns the edges of the cells, halfway between their centres, in the coordinate of the axis. */
    edges({ values }, scale) {
      const centres = values.map(scale);
      const last = centres.length - 1;
      const inner = centres.slice(1).map((centre, index) => 0.5 * (centre + centres[index]));
      if (last < 1) return [centres[0] - 0.5, centres[0] + 0.5];
      return [centres[0] - (inner[0] - centres[0]), ...inner, centres[last] + (centres[last] - inner[last - 1])];
    }

    legend() {
      const { map } = this;
      const entry = (kind, text) => {
        const item = document.createElement("li");
        const swatch = document.createElement("span");
        swatch.className = `swatch ${kind}`;
        item.append(swatch, text);
        return item;
      };
      if (!map.cells) {
        const list = document.createElement("ul");
        list.className = "key";
        list.append(entry("stable", "stable"), entry("boundary", "boundary"), entry("here", "scenario"));
        if (map.differing.length) list.append(entry("differing", "simulation disagrees"));
        return list;
      }
      const row = document.createElement("div");
      row.className = "scale";
      const colours = document.createElement("span");
      colours.className = "colours";
      const stops = [0, 0.25, 0.5, 0.75, 1].map((share) => `rgb(${rgb(share).join()})`);
      colours.style.background = `linear-gradient(to right, ${stops.join()})`;
      const { number } = trocarCharts;
      row.append(this.min <= this.max ? number(this.min) : "—", colours, this.min <= this.max ? `${number(this.max)} ${map.unit}` : "");
      return row;
    }

    draw(width = this.place.clientWidth) {
      const { map, canvas } = this;
      const ratio = window.devicePixelRatio || 1;
      const height = Math.round(Math.min(0.72 * width, 480)) + 52;
      this.area = { left: 66, top: 8, width: Math.max(width - 66 - 12, 40), height: height - 8 - 44 };
      const { area } = this;
      canvas.width = width * ratio;
      canvas.height = height * ratio;
      canvas.style.height = `${height}px`;
      const context = canvas.getContext("2d");
      context.scale(ratio, ratio);
      const { colour } = trocarCharts;
      const [left, right] = [this.xEdges[0], this.xEdges[this.xEdges.length - 1]];
      const [low, high] = [this.yEdges[0], this.yEdges[this.yEdges.length - 1]];
      this.x = (value) => area.left + ((value - left) / (right - left)) * area.width;
      this.y = (value) => area.top + ((high - value) / (high - low)) * area.height;
      context.save();
      context.beginPath();
      context.rect(area.left, area.top, area.width, area.height);
      context.clip();
      this.shade = this.stable();
      map.y.values.forEach((_, row) => {
        const top = this.y(this.yEdges[row + 1]);
        const tall = this.y(this.yEdges[row]) - top;
        let column = 0;
        while (column < map.x.values.length) {
          const fill = this.fill(column, row);
          let end = column + 1;
          while (end < map.x.values.length && this.fill(end, row) === fill) end += 1;
          if (fill) {
            const from = this.x(this.xEdges[column]);
            context.fillStyle = fill;
            context.fillRect(from, top, this.x(this.xEdges[end]) - from + 0.4, tall + 0.4);
          }
          column = end;
        }
      });
      context.strokeStyle = colour("blue");
      context.lineWidth = 2.5;
      context.beginPath();
      for (const [fromX, fromY, toX, toY] of map.boundary) {
        context.moveTo(this.x(this.scaleX(fromX)), this.y(this.scaleY(fromY)));
        context.lineTo(this.x(this.scaleX(toX)), this.y(this.scaleY(toY)));
      }
      context.stroke();
      const dot = ([x, y], name, size) => {
        context.beginPath();
        context.arc(this.x(this.scaleX(x)), this.y(this.scaleY(y)), size, 0, 2 * Math.PI);
        context.fillStyle = colour(name);
        context.fill();
        context.strokeStyle = colour("page");
        context.lineWidth = 1.5;
        context.stroke();
      };
      map.differing.forEach((point) => dot(point, "vermilion", 3.5));
      if (map.here) dot(map.here, "green", 6);
      if (this.cursor) this.ring(context);
      context.restore();
      context.strokeStyle = colour("line");
      context.lineWidth = 1;
      context.strokeRect(area.left + 0.5, area.top + 0.5, area.width, area.height);
      this.axes(context, [left, right], [low, high]);
    }

    axes(context, [left, right], [low, high]) {
      const { map, area } = this;
      const { colour } = trocarCharts;
      context.fillStyle = colour("ink");
      context.strokeStyle = colour("line");
      context.font = '13px system-ui, "DejaVu Sans", Arial, sans-serif';
      context.textAlign = "center";
      const line = (fromX, fromY, toX, toY) => {
        context.beginPath();
        context.moveTo(fromX, fromY);
        context.lineTo(toX, toY);
        context.stroke();
      };
      let free = -Infinity;
      for (const { at, label } of ticks(left, right, map.x.log, Math.max(2, area.width / 90))) {
        const x = this.x(at);
        line(x, area.top + area.height, x, area.top + area.height + 5);
        const half = 0.5 * context.measureText(label).width;
        if (x - half < free) continue;
        context.fillText(label, x, area.top + area.height + 18);
        free = x + half + 8;
      }
      context.fillText(map.x.label, area.left + 0.5 * area.width, area.top + area.height + 37, area.width);
      context.textAlign = "right";
      for (const { at, label } of ticks(low, high, map.y.log, Math.max(2, area.height / 60))) {
        const y = this.y(at);
        line(area.left - 5, y, area.left, y);
        context.fillText(label, area.left - 8, y + 4);
      }
      context.save();
      context.translate(14, area.top + 0.5 * area.height);
      context.rotate(-0.5 * Math.PI);
      context.textAlign = "center";
      context.fillText(map.y.label, 0, 0, area.height);
      context.restore();
    }

    ring(context) {
      const { column, row } = this.cursor;
      const [left, top] = [this.x(this.xEdges[column]), this.y(this.yEdges[row + 1])];
      context.strokeStyle = trocarCharts.colour("ink");
      context.lineWidth = 2;
      context.strokeRect(left, top, this.x(this.xEdges[column + 1]) - left, this.y(this.yEdges[row]) - top);
    }

    value(column, row) {
      return this.map.cells[row * this.map.x.values.length + column];
    }

    fill(column, row) {
      const { map } = this;
      if (!map.cells) return map.verdicts[row][column] === "1" ? this.shade : null;
      const value = this.value(column, row);
      if (value === null) return null;
      return `rgb(${rgb(this.max > this.min ? (value - this.min) / (this.max - this.min) : 0.5).join()})`;
    }

    /** Returns the opaque colour of stable cells. It is opaque because cells overlap slightly. */
    stable() {
      const parts = (name) => trocarCharts.colour(name).match(/\d+/g).map(Number);
      const page = parts("page");
      return `rgb(${parts("sky").map((part, index) => Math.round(page[index] + 0.38 * (part - page[index]))).join()})`;
    }

    point(event) {
      const box = this.canvas.getBoundingClientRect();
      const { area } = this;
      const [x, y] = [event.clientX - box.left, event.clientY - box.top];
      const inside = x >= area.left && x < area.left + area.width && y >= area.top && y < area.top + area.height;
      if (!inside) return this.move(null);
      const column = this.xEdges.findIndex((edge) => this.x(edge) > x) - 1;
      const row = this.yEdges.findIndex((edge) => this.y(edge) < y) - 1;
      return this.move(column >= 0 && row >= 0 ? { column, row } : null);
    }

    key(event) {
      const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
      const step = steps[event.key];
      if (!step || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      const far = event.shiftKey ? 10 : 1;
      const [columns, rows] = [this.map.x.values.length, this.map.y.values.length];
      const from = this.cursor || { column: Math.floor(columns / 2), row: Math.floor(rows / 2) };
      const within = (value, count) => Math.min(Math.max(value, 0), count - 1);
      this.move({ column: within(from.column + far * step[0], columns), row: within(from.row + far * step[1], rows) });
    }

    move(cursor) {
      const same = cursor && this.cursor && cursor.column === this.cursor.column && cursor.row === this.cursor.row;
      if (same || (!cursor && !this.cursor)) return;
      this.cursor = cursor;
      if (cursor) {
        const { map } = this;
        const { number } = trocarCharts;
        const { column, row } = cursor;
        const stable = () => (map.verdicts[row][column] === "1" ? "stable" : "not stable");
        const what = map.cells ? `${number(this.value(column, row))} ${map.unit}` : stable();
        this.output.textContent = `${map.x.label} ${number(map.x.values[column])}, ${map.y.label} ${number(map.y.values[row])}: ${what}`;
      } else {
        this.output.textContent = "";
      }
      this.draw();
    }
  }

  const maps = [];
  function drawMap(place) {
    const map = data.maps[place.dataset.name];
    if (map) maps.push(new PlaneMap(place, map));
  }

  async function copy(text) {
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      const area = document.createElement("textarea");
      area.value = text;
      document.body.append(area);
      area.select();
      document.execCommand("copy");
      area.remove();
    }
  }

  function save(name, text) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  function buttons() {
    for (const button of document.querySelectorAll("[data-copy], [data-save]")) {
      const { copy: copied, save: saved, file } = button.dataset;
      button.addEventListener("click", async () => {
        const text = document.getElementById(copied || saved).textContent;
        if (copied) await copy(text);
        else save(file, text);
        status.textContent = copied ? "Copied." : `${file} is saved.`;
        const label = button.textContent;
        button.textContent = copied ? "Copied" : "Saved";
        setTimeout(() => {
          button.textContent = label;
        }, 1200);
      });
    }
    document.querySelectorAll(".actions").forEach((actions) => {
      actions.hidden = false;
    });
  }

  const root = document.documentElement;
  const THEMES = ["system", "light", "dark"];
  const recoloured = () => {
    window.dispatchEvent(new Event("themechange"));
    maps.forEach((map) => map.draw());
  };
  function theme() {
    const button = document.getElementById("theme");
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    button.hidden = false;
    button.addEventListener("click", () => {
      const next = THEMES[(THEMES.indexOf(root.dataset.theme ?? "system") + 1) % THEMES.length];
      if (next === "system") delete root.dataset.theme;
      else root.dataset.theme = next;
      button.textContent = `Theme: ${next}`;
      recoloured();
    });
    dark.addEventListener("change", recoloured);
  }

  /** Prepares printing: light theme, width of half a page, all details open. */
  function printing() {
    const [PAPER, CHART] = [660, { width: 325, height: 180 }];
    let before = null;
    window.addEventListener("beforeprint", () => {
      if (before) return;
      const folded = [...document.querySelectorAll("details:not([open])")];
      before = { theme: root.dataset.theme, folded };
      folded.forEach((details) => {
        details.open = true;
      });
      root.dataset.theme = "light";
      recoloured();
      for (const chart of [...byName.values()].flat()) {
        chart.height = chart.plot.height;
        chart.plot.setSize(CHART);
      }
      maps.forEach((map) => map.draw(PAPER));
    });
    window.addEventListener("afterprint", () => {
      if (!before) return;
      before.folded.forEach((details) => {
        details.open = false;
      });
      if (before.theme) root.dataset.theme = before.theme;
      else delete root.dataset.theme;
      before = null;
      recoloured();
      for (const chart of [...byName.values()].flat()) {
        chart.plot.setSize({ width: Math.max(chart.figure.clientWidth, 280), height: chart.height });
      }
    });
  }

  if (data.animation) new trocarAnimation.Player(document.getElementById("animation")).setData(data.animation);
  document.querySelectorAll(".charts").forEach(drawCharts);
  document.querySelectorAll(".map").forEach(drawMap);
  document.querySelectorAll(".windows").forEach(windows);
  buttons();
  theme();
  printing();
})();
