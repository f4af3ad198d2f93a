// The stability map over two parameters, with the point of the current state.
"use strict";

const trocarMap = (() => {
  const MARGIN = { left: 68, right: 14, top: 12, bottom: 46 };
  let map = null;
  let now = { x: null, y: null };
  let move = () => {};
  let visible = false;

  /** Converts the ends of an axis to its coordinate: a logarithmic axis has exponents of ten. */
  function placed({ low, high, log }) {
    return log ? { low: Math.log10(low), high: Math.log10(high), log } : { low, high, log };
  }

  /** Returns the conversions between the values of an axis and fractions of its length. */
  function scale(axis) {
    const { low, high, log } = placed(axis);
    const share = (place) => (place - low) / (high - low);
    const value = (s) => low + s * (high - low);
    return { share: (v) => share(log ? Math.log10(v) : v), value: (s) => (log ? 10 ** value(s) : value(s)) };
  }

  const written = (value) => String(Number(value.toPrecision(3)));

  function place(canvas) {
    const box = canvas.getBoundingClientRect();
    return { left: MARGIN.left, top: MARGIN.top, width: box.width - MARGIN.left - MARGIN.right, height: box.height - MARGIN.top - MARGIN.bottom };
  }

  /** Returns the outline of the stable region, up to its boundary. `at` converts a column and a row of the grid to
   *  pixels. */
  function stablePath(at, xScale, yScale) {
    const [columns, rows] = [map.x.count, map.y.count];
    const ends = new Map();
    for (const segment of map.boundary) {
      const points = segment.map(([x, y]) => [xScale.share(x) * (columns - 1), yScale.share(y) * (rows - 1)]);
      const cell = [0, 1].map((axis) => Math.floor((points[0][axis] + points[1][axis]) / 2));
      ends.set(cell.join(), [...(ends.get(cell.join()) ?? []), ...points]);
    }
    const path = new Path2D();
    for (let row = 0; row + 1 < rows; row += 1) {
      for (let column = 0; column + 1 < columns; column += 1) {
        const corners = [[column, row], [column + 1, row], [column + 1, row + 1], [column, row + 1]];
        const stable = corners.filter(([x, y]) => map.stable[y * columns + x] === "1");
        if (stable.length === 0) continue;
        // The boundary cuts a cell along a line. Order the stable corners and the ends of the line around the cell.
        const cut = stable.length === 4 ? [] : ends.get([column, row].join()) ?? [];
        const all = [...stable, ...cut];
        const middle = [0, 1].map((axis) => all.reduce((sum, point) => sum + point[axis], 0) / all.length);
        const angle = ([x, y]) => Math.atan2(y - middle[1], x - middle[0]);
        all.sort((a, b) => angle(a) - angle(b)).forEach(([x, y], index) => path[index ? "lineTo" : "moveTo"](...at(x, y)));
        path.closePath();
      }
    }
    return path;
  }

  function draw(canvas) {
    const ratio = window.devicePixelRatio || 1;
    const box = canvas.getBoundingClientRect();
    canvas.width = Math.round(box.width * ratio);
    canvas.height = Math.round(box.height * ratio);
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, box.width, box.height);
    if (!map) return;
    const { left, top, width, height } = place(canvas);
    const [xScale, yScale] = [scale(map.x), scale(map.y)];
    const [columns, rows] = [map.x.count, map.y.count];
    context.fillStyle = trocarCharts.colour("sky");
    context.globalAlpha = 0.45;
    context.fill(stablePath((column, row) => [left + (column / (columns - 1)) * width, top + (1 - row / (rows - 1)) * height], xScale, yScale));
    context.globalAlpha = 1;
    context.strokeStyle = trocarCharts.colour("ink");
    context.lineWidth = 2;
    context.beginPath();
    for (const [[x0, y0], [x1, y1]] of map.boundary) {
      context.moveTo(left + xScale.share(x0) * width, top + (1 - yScale.share(y0)) * height);
      context.lineTo(left + xScale.share(x1) * width, top + (1 - yScale.share(y1)) * height);
    }
    context.stroke();
    const [x, y] = [placed(map.x), placed(map.y)];
    const axis = (of, caption) => ({ ticks: trocarCharts.placed(of), caption });
    const toX = (at) => left + ((at - x.low) / (x.high - x.low)) * width;
    const toY = (at) => top + ((y.high - at) / (y.high - y.low)) * height;
    trocarCharts.axes(context, { left, top, width, height }, axis(map.x, map.x.name), axis(map.y), toX, toY);
    context.save();
    context.translate(14, top + height / 2);
    context.rotate(-Math.PI / 2);
    context.textAlign = "center";
    context.fillText(map.y.name, 0, 0);
    context.restore();
    context.textAlign = "left";
    const sx = xScale.share(now.x);
    const sy = yScale.share(now.y);
    if (sx >= 0 && sx <= 1 && sy >= 0 && sy <= 1) {
      const [atX, atY] = [left + sx * width, top + (1 - sy) * height];
      context.lineWidth = 5;
      context.strokeStyle = trocarCharts.colour("page");
      context.beginPath();
      context.arc(atX, atY, 8, 0, 7);
      context.stroke();
      context.lineWidth = 3;
      context.strokeStyle = trocarCharts.colour("vermilion");
      context.stroke();
    }
  }

  function describe(canvas, line) {
    const where = `${map.x.name} ${written(map.x.per * now.x)}, ${map.y.name} ${written(map.y.per * now.y)}`;
    const { spectral_radius: radius, frequency_hz: frequency, damping_ratio: damping } = map.mode;
    const margin = map.margins.gain === null ? "none" : `${trocarCharts.number(map.margins.gain)} times`;
    line.textContent = `${where}: ${map.verdict}. Gain margin ${margin}, spectral radius ${radius === null ? "—" : radius.toFixed(6)}, dominant mode at ${trocarCharts.number(frequency)} Hz with damping ratio ${trocarCharts.number(damping)}. Blue is stable.`;
    canvas.setAttribute("aria-label", `Stability map. ${line.textContent}`);
  }

  return {
    /** Handles the pointer and the arrow keys, which move the point and call `onMove(x, y)` with values. */
    begin(canvas, onMove) {
      move = onMove;
      const at = (event) => {
        if (!map) return;
        const box = canvas.getBoundingClientRect();
        const { left, top, width, height } = place(canvas);
        const share = (v) => Math.min(1, Math.max(0, v));
        const x = scale(map.x).value(share((event.clientX - box.left - left) / width));
        const y = scale(map.y).value(1 - share((event.clientY - box.top - top) / height));
        move(Number(x.toPrecision(4)), Number(y.toPrecision(4)), performance.now());
      };
      let dragging = false;
      canvas.addEventListener("pointerdown", (event) => {
        if (event.button !== 0) return;
        dragging = true;
        canvas.setPointerCapture(event.pointerId);
        at(event);
      });
      canvas.addEventListener("pointermove", (event) => dragging && at(event));
      canvas.addEventListener("pointerup", () => { dragging = false; });
      canvas.addEventListener("pointercancel", () => { dragging = false; });
      canvas.addEventListener("keydown", (event) => {
        const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] }[event.key];
        if (!by || !map) return;
        event.preventDefault();
        const step = event.shiftKey ? 0.1 : 0.02;
        const stepped = (axis, value, direction) => {
          const along = scale(axis);
          return Number(along.value(Math.min(1, Math.max(0, along.share(value) + direction * step))).toPrecision(4));
        };
        move(stepped(map.x, now.x, by[0]), stepped(map.y, now.y, by[1]), performance.now());
      });
      new ResizeObserver(() => draw(canvas)).observe(canvas);
      // Finding the position of a canvas causes a layout of the page, so do not draw an invisible map.
      new IntersectionObserver((entries) => {
        visible = entries[entries.length - 1].isIntersecting;
        if (visible) draw(canvas);
      }).observe(canvas);
      window.addEventListener("themechange", () => draw(canvas));
      window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw(canvas));
    },
    show(canvas, line, message) {
      map = message;
      now = { x: message.x.now, y: message.y.now };
      draw(canvas);
      describe(canvas, line);
    },
    /** Moves the point on the same map. */
    at(canvas, x, y) {
      if (!map || (now.x === x && now.y === y)) return;
      now = { x, y };
      if (visible) draw(canvas);
    },
    /** Discards the map, so that the next map is drawn around the present values. */
    forget() {
      map = null;
    },
    /** Returns the ranges of the drawn map if it has the same axes and contains the values, so that the map stays;
     *  otherwise returns no ranges. */
    ranges(axes, value) {
      if (!map || map.x.key !== axes.x || map.y.key !== axes.y) return {};
      const isInside = ({ key, low, high }) => value(key) >= low && value(key) <= high;
      if (!isInside(map.x) || !isInside(map.y)) return {};
      return { x_range: [map.x.low, map.x.high], y_range: [map.y.low, map.y.high] };
    },
    is: (x, y) => map !== null && map.x.key === x && map.y.key === y,
    /** Returns the screen position of a pair of values, for tests. */
    spot(canvas, x, y) {
      const { left, top, width, height } = place(canvas);
      return [left + scale(map.x).share(x) * width, top + (1 - scale(map.y).share(y)) * height];
    },
    current: () => map,
  };
})();
