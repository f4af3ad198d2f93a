// The stability map: where the loop is stable over two parameters, and the point where the page is.
"use strict";

const trocarMap = (() => {
  const MARGIN = { left: 68, right: 14, top: 12, bottom: 46 };
  let told = null;
  let now = { x: null, y: null };
  let move = () => {};
  let seen = false;

  /** The ways between values of an axis and shares of its length. */
  function scale(axis) {
    if (axis.log) {
      const ratio = Math.log(axis.high / axis.low);
      return { share: (v) => Math.log(v / axis.low) / ratio, value: (s) => axis.low * Math.exp(s * ratio) };
    }
    const width = axis.high - axis.low;
    return { share: (v) => (v - axis.low) / width, value: (s) => axis.low + s * width };
  }

  /** Round values along an axis. */
  function ticks(axis) {
    const found = [];
    if (axis.log) {
      for (let power = Math.floor(Math.log10(axis.low)); power <= Math.ceil(Math.log10(axis.high)); power += 1) {
        for (const digit of [1, 2, 5]) {
          const value = digit * 10 ** power;
          if (value >= axis.low * 0.999 && value <= axis.high * 1.001) found.push(value);
        }
      }
      return found;
    }
    const rough = (axis.high - axis.low) / 5;
    const unit = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((digit) => digit * unit).find((size) => size >= rough) || rough;
    for (let value = Math.ceil(axis.low / step) * step; value <= axis.high * 1.0001; value += step) found.push(value);
    return found;
  }

  const written = (value) => String(Number(value.toPrecision(3)));

  function place(canvas) {
    const box = canvas.getBoundingClientRect();
    return { left: MARGIN.left, top: MARGIN.top, width: box.width - MARGIN.left - MARGIN.right, height: box.height - MARGIN.top - MARGIN.bottom };
  }

  function draw(canvas) {
    const ratio = window.devicePixelRatio || 1;
    const box = canvas.getBoundingClientRect();
    canvas.width = Math.round(box.width * ratio);
    canvas.height = Math.round(box.height * ratio);
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, box.width, box.height);
    if (!told) return;
    const { left, top, width, height } = place(canvas);
    const [across, upwards] = [scale(told.x), scale(told.y)];
    const [columns, rows] = [told.x.count, told.y.count];
    // The verdict of a point fills what is nearer to it than to its neighbours.
    const edge = (index, count) => Math.min(1, Math.max(0, (index - 0.5) / (count - 1)));
    for (let row = 0; row < rows; row += 1) {
      for (let column = 0; column < columns; column += 1) {
        const stable = told.stable[row * columns + column] === "1";
        context.fillStyle = trocarCharts.colour(stable ? "sky" : "page");
        const [x0, x1] = [edge(column, columns), edge(column + 1, columns)];
        const [y0, y1] = [edge(row, rows), edge(row + 1, rows)];
        context.globalAlpha = stable ? 0.45 : 1;
        // On whole pixels: what is half transparent must not overlap.
        const [from, to] = [Math.round(left + x0 * width), Math.round(left + x1 * width)];
        const [above, below] = [Math.round(top + (1 - y1) * height), Math.round(top + (1 - y0) * height)];
        context.fillRect(from, above, to - from, below - above);
      }
    }
    context.globalAlpha = 1;
    context.strokeStyle = trocarCharts.colour("ink");
    context.lineWidth = 2;
    context.beginPath();
    for (const [[x0, y0], [x1, y1]] of told.boundary) {
      context.moveTo(left + across.share(x0) * width, top + (1 - upwards.share(y0)) * height);
      context.lineTo(left + across.share(x1) * width, top + (1 - upwards.share(y1)) * height);
    }
    context.stroke();
    context.lineWidth = 1;
    context.strokeStyle = trocarCharts.colour("line");
    context.strokeRect(left, top, width, height);
    context.fillStyle = trocarCharts.colour("ink");
    context.font = '12px system-ui, "DejaVu Sans", sans-serif';
    context.textAlign = "center";
    let free = -Infinity;
    for (const value of ticks(told.x)) {
      const x = left + across.share(value) * width;
      context.strokeRect(x, top + height, 0, 4);
      const half = context.measureText(written(value)).width / 2;
      if (x - half < free) continue;
      free = x + half + 8;
      context.fillText(written(value), x, top + height + 17);
    }
    context.fillText(told.x.name, left + width / 2, top + height + 38);
    context.textAlign = "right";
    free = Infinity;
    for (const value of ticks(told.y)) {
      const y = top + (1 - upwards.share(value)) * height;
      context.strokeRect(left - 4, y, 4, 0);
      if (y > free) continue;
      free = y - 16;
      context.fillText(written(value), left - 7, y + 4);
    }
    context.save();
    context.translate(14, top + height / 2);
    context.rotate(-Math.PI / 2);
    context.textAlign = "center";
    context.fillText(told.y.name, 0, 0);
    context.restore();
    context.textAlign = "left";
    const sx = across.share(now.x);
    const sy = upwards.share(now.y);
    if (sx >= 0 && sx <= 1 && sy >= 0 && sy <= 1) {
      const [x, y] = [left + sx * width, top + (1 - sy) * height];
      context.lineWidth = 5;
      context.strokeStyle = trocarCharts.colour("page");
      context.beginPath();
      context.arc(x, y, 8, 0, 7);
      context.stroke();
      context.lineWidth = 3;
      context.strokeStyle = trocarCharts.colour("vermilion");
      context.stroke();
    }
  }

  function tell(canvas, line) {
    const where = `${told.x.name} ${written(now.x)}, ${told.y.name} ${written(now.y)}`;
    const radius = told.spectral_radius;
    const word = radius !== null && radius < 1 ? "stable" : "unstable";
    const unmodelled = told.unmodelled.length ? ` Not in the linear model: ${told.unmodelled.join("; ")}.` : "";
    line.textContent = `${where}: ${word}, spectral radius ${radius === null ? "—" : radius.toFixed(6)}, dominant mode at ${trocarCharts.number(told.frequency_hz)} Hz with damping ratio ${trocarCharts.number(told.damping_ratio)}. Blue is stable.${unmodelled}`;
    canvas.setAttribute("aria-label", `Stability map. ${line.textContent}`);
  }

  return {
    /** Lets the pointer and the arrow keys move the point: `onMove(x, y)` in values. */
    begin(canvas, onMove) {
      move = onMove;
      const at = (event) => {
        if (!told) return;
        const box = canvas.getBoundingClientRect();
        const { left, top, width, height } = place(canvas);
        const share = (v) => Math.min(1, Math.max(0, v));
        const x = scale(told.x).value(share((event.clientX - box.left - left) / width));
        const y = scale(told.y).value(1 - share((event.clientY - box.top - top) / height));
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
        if (!by || !told) return;
        event.preventDefault();
        const step = event.shiftKey ? 0.1 : 0.02;
        const stepped = (axis, value, direction) => {
          const along = scale(axis);
          return Number(along.value(Math.min(1, Math.max(0, along.share(value) + direction * step))).toPrecision(4));
        };
        move(stepped(told.x, now.x, by[0]), stepped(told.y, now.y, by[1]), performance.now());
      });
      new ResizeObserver(() => draw(canvas)).observe(canvas);
      // Asking where a canvas is makes the browser lay out everything: what nobody sees waits.
      new IntersectionObserver((entries) => {
        seen = entries[entries.length - 1].isIntersecting;
        if (seen) draw(canvas);
      }).observe(canvas);
      window.addEventListener("themechange", () => draw(canvas));
      window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw(canvas));
    },
    show(canvas, line, message) {
      told = message;
      now = { x: message.x.now, y: message.y.now };
      draw(canvas);
      tell(canvas, line);
    },
    /** The page has moved to another point of the same map. */
    at(canvas, x, y) {
      if (!told || (now.x === x && now.y === y)) return;
      now = { x, y };
      if (seen) draw(canvas);
    },
    is: (x, y) => told !== null && told.x.key === x && told.y.key === y,
    /** Where on the screen a pair of values is: for tests. */
    spot(canvas, x, y) {
      const { left, top, width, height } = place(canvas);
      return [left + scale(told.x).share(x) * width, top + (1 - scale(told.y).share(y)) * height];
    },
    told: () => told,
  };
})();
