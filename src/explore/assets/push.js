// Insertion by hand: the pointer is the desired position of the hand on the master, in real time.
"use strict";

const trocarPush = (() => {
  /** Displayed time of the charts, in s. */
  const SHOWN_S = 8;
  const MODES = ["teleoperation", "the slave is frozen", "re-engaging"];
  let parts = null;
  let state = null;
  let charts = null;

  const mm = (value) => `${value.toFixed(1)} mm`;

  function newState(id, augmented) {
    return { id, augmented, range: null, aim: null, rows: [], events: [], maxForce: 1, pressed: false, sent: 0, ended: false };
  }

  /** Converts a height in the field to a position. A deeper position is lower in the field. */
  const position = (y, height) => {
    const [from, to] = state.range;
    return from + (to - from) * Math.min(1, Math.max(0, (y - 14) / (height - 28)));
  };
  const depth = (value, height) => 14 + ((value - state.range[0]) / (state.range[1] - state.range[0])) * (height - 28);

  function aim(value) {
    const [from, to] = state.range;
    state.aim = Math.min(to, Math.max(from, value));
    parts.field.setAttribute("aria-valuenow", state.aim.toFixed(1));
    parts.field.setAttribute("aria-valuetext", mm(state.aim));
    if (performance.now() - state.sent > 8) send();
  }

  function send() {
    state.sent = performance.now();
    trocarLink.tell({ type: "aim", m: state.aim / 1000 });
  }

  function draw() {
    const { field } = parts;
    const ratio = window.devicePixelRatio || 1;
    const box = field.getBoundingClientRect();
    if (field.width !== Math.round(box.width * ratio) || field.height !== Math.round(box.height * ratio)) {
      field.width = Math.round(box.width * ratio);
      field.height = Math.round(box.height * ratio);
    }
    const context = field.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, box.width, box.height);
    context.font = '12px system-ui, "DejaVu Sans", sans-serif';
    context.fillStyle = trocarCharts.colour("quiet");
    if (!state || !state.range || state.rows.length === 0) {
      context.fillText("press Begin", 12, 24);
      return;
    }
    const row = state.rows[state.rows.length - 1];
    const [, , master, slave, , , mode] = row;
    const [left, right] = [box.width * 0.32, box.width * 0.72];
    context.fillText("master", left - 22, 11);
    context.fillText("needle", right - 20, 11);
    context.lineWidth = 1;
    context.strokeStyle = trocarCharts.colour("grid");
    const minUnit = (state.range[1] - state.range[0]) / 10;
    const unit = [1, 2, 5, 10, 20, 50, 100, 200].find((size) => size >= minUnit) ?? 500;
    for (let value = Math.ceil(state.range[0] / unit) * unit; value <= state.range[1]; value += unit) {
      const y = depth(value, box.height);
      context.beginPath();
      context.moveTo(0, y);
      context.lineTo(box.width, y);
      context.stroke();
      context.fillText(String(value), 3, y - 2);
    }
    context.strokeStyle = trocarCharts.colour("sky");
    context.lineWidth = 7;
    context.beginPath();
    context.moveTo(left, 16);
    context.lineTo(left, depth(master, box.height));
    context.stroke();
    context.fillStyle = trocarCharts.colour("blue");
    context.beginPath();
    context.arc(left, depth(master, box.height), 9, 0, 7);
    context.fill();
    if (state.aim !== null) {
      context.strokeStyle = trocarCharts.colour("quiet");
      context.lineWidth = 1.5;
      context.setLineDash([4, 4]);
      context.beginPath();
      context.moveTo(left - 22, depth(state.aim, box.height));
      context.lineTo(left + 22, depth(state.aim, box.height));
      context.stroke();
      context.setLineDash([]);
    }
    const tip = depth(slave, box.height);
    context.strokeStyle = trocarCharts.colour(mode === 1 ? "orange" : "vermilion");
    context.lineWidth = mode === 1 ? 6 : 3;
    context.beginPath();
    context.moveTo(right, 16);
    context.lineTo(right, tip);
    context.stroke();
    context.fillStyle = context.strokeStyle;
    context.beginPath();
    context.moveTo(right - 5, tip - 8);
    context.lineTo(right + 5, tip - 8);
    context.lineTo(right, tip + 2);
    context.fill();
    if (mode === 1) context.fillText("frozen", right - 18, Math.min(box.height - 6, tip + 16));
  }

  function showForce() {
    const row = state.rows[state.rows.length - 1];
    const force = row[5];
    state.maxForce = Math.max(state.maxForce, Math.abs(force));
    parts.felt.style.height = `${(100 * Math.max(0, force)) / state.maxForce}%`;
    parts.felt.classList.toggle("frozen", row[6] === 1);
    parts.feltText.textContent = `${force.toFixed(2)} N`;
    if (parts.mode.textContent !== MODES[row[6]]) parts.mode.textContent = MODES[row[6]];
    for (const pad of navigator.getGamepads ? navigator.getGamepads() : []) {
      const share = Math.min(1, Math.max(0, force / state.maxForce));
      if (pad && pad.vibrationActuator) {
        pad.vibrationActuator.playEffect("dual-rumble", { duration: 60, strongMagnitude: share, weakMagnitude: 0 }).catch(() => {});
      }
    }
  }

  function strips() {
    const last = state.rows[state.rows.length - 1][0];
    while (state.rows.length > 2 && state.rows[0][0] < last - SHOWN_S) state.rows.shift();
    const every = Math.max(1, Math.round(state.rows.length / 1500));
    const rows = state.rows.filter((_, index) => index % every === 0 || index === state.rows.length - 1);
    const column = (index) => rows.map((row) => row[index]);
    const shades = [];
    for (const row of rows) {
      const open = shades[shades.length - 1];
      const name = row[6] === 1 ? "augmented" : "reengaging";
      if (row[6] === 0) continue;
      if (open && open.name === name && row[0] - open.to < 0.05) open.to = row[0];
      else shades.push({ from: row[0], to: row[0], name });
    }
    const from = rows[0][0];
    const marks = state.events.filter(([at]) => at >= from).map(([at, kind]) => ({ at, kind }));
    const extras = { shades, marks, thresholds: [] };
    const positions = [column(0), column(2), column(3)];
    const forces = [column(0), column(4), column(5)];
    if (charts === null) {
      const x = { label: "time", unit: "s" };
      charts = [
        trocarCharts.chart(parts.strips, {
          id: "push-position", title: "Position", height: 170, x, y: { label: "position", unit: "mm" },
          series: [{ label: "master", colour: "sky", width: 4 }, { label: "slave", colour: "vermilion", width: 2 }],
        }, positions, extras),
        trocarCharts.chart(parts.strips, {
          id: "push-force", title: "Force", height: 150, x, y: { label: "force", unit: "N" },
          series: [{ label: "tissue", colour: "sky", width: 4 }, { label: "feedback", colour: "vermilion", width: 2 }],
        }, forces, extras),
      ];
      return;
    }
    charts[0].update(positions, extras);
    charts[1].update(forces, extras);
  }

  function end(text) {
    parts.button.textContent = "Begin";
    parts.mode.textContent = "";
    parts.text.textContent = text;
    parts.felt.style.height = "0";
    parts.felt.classList.remove("frozen");
    if (state) state.ended = true;
  }

  function begin() {
    const id = trocarLink.ask({ type: "push", state: parts.state(), augmented: parts.scheme.value === "1" });
    if (!id) {
      parts.text.textContent = "no connection to the server";
      return;
    }
    state = newState(id, parts.scheme.value === "1");
    parts.button.textContent = "End";
    parts.text.textContent = "";
    parts.field.focus();
  }

  return {
    begin(given) {
      parts = given;
      const { field, button } = parts;
      button.addEventListener("click", () => {
        if (state && !state.ended) {
          // The result follows.
          trocarLink.tell({ type: "stop" });
          end("ended");
        } else begin();
      });
      const at = (event) => {
        const box = field.getBoundingClientRect();
        aim(position(event.clientY - box.top, box.height));
      };
      const ready = () => state && state.range && !state.ended;
      field.addEventListener("pointerdown", (event) => {
        if (!ready() || event.button !== 0) return;
        state.pressed = true;
        field.setPointerCapture(event.pointerId);
        at(event);
      });
      field.addEventListener("pointermove", (event) => ready() && state.pressed && at(event));
      const up = () => {
        if (!ready()) return;
        state.pressed = false;
        send();
      };
      field.addEventListener("pointerup", up);
      field.addEventListener("pointercancel", up);
      field.addEventListener("keydown", (event) => {
        const by = { ArrowDown: 0.25, ArrowUp: -0.25, PageDown: 2, PageUp: -2 }[event.key];
        if (!ready() || event.ctrlKey || event.metaKey || event.altKey) return;
        const to = by ? (state.aim ?? state.range[0]) + by : { Home: state.range[0], End: state.range[1] }[event.key];
        if (to === undefined) return;
        event.preventDefault();
        aim(to);
      });
      new ResizeObserver(draw).observe(field);
      window.addEventListener("themechange", draw);
    },
    /** Handles a message about the insertion. */
    receive(message) {
      // Ignores messages of an earlier insertion.
      if (!state || message.id !== state.id) return;
      if (message.type === "pushing" && !state.ended) {
        state.range = message.range_mm;
        state.aim = message.range_mm[0];
        parts.field.setAttribute("aria-valuemin", message.range_mm[0].toFixed(1));
        parts.field.setAttribute("aria-valuemax", message.range_mm[1].toFixed(1));
        parts.mode.textContent = MODES[0];
      } else if (message.type === "moved" && !state.ended && state.range) {
        if (state.pressed) send();
        state.rows.push(...message.rows);
        for (const [at, kind] of message.events) {
          state.events.push([at, kind]);
          if (kind === "alarm") trocarListen.cue(parts.lamp);
        }
        if (state.rows.length === 0) return;
        showForce();
        draw();
        strips();
      } else if (message.type === "pushed") {
        const overshoot = message.overshoot_mm.map((value) => (value === null ? "—" : mm(value))).join(", ");
        const diverged = message.diverged_s === null ? "" : `diverged at ${message.diverged_s} s; `;
        end(`${diverged}ruptures: ${message.ruptures}, missed: ${message.missed}, false alarms: ${message.false_alarms}; overshoot: ${overshoot || "—"}`);
      }
    },
    /** Ends the insertion because the scenario changes or the connection is lost. */
    leave(text) {
      if (!state || state.ended) return;
      trocarLink.tell({ type: "stop" });
      end(text);
    },
    /** Handles a refusal of the insertion. */
    refused: (id) => state && state.id === id && end(""),
    state: () => state,
  };
})();
