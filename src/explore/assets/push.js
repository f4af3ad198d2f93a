// Insertion by hand: the pointer is the desired position of the hand on the master, in real time.
"use strict";

const trocarPush = (() => {
  /** Displayed time of the charts, in s. */
  const SHOWN_S = 8;
  let parts = null;
  let state = null;
  let charts = null;

  const mm = (value) => `${value.toFixed(1)} mm`;

  function newState(id, augmented) {
    return { id, augmented, range: null, aim: null, rows: [], events: [], maxForce: 1, pressed: false, sent: 0, ended: false };
  }

  /** Converts a height in the drawing to a position of the hand. */
  const position = (y) => {
    const [[top, from], [bottom, to]] = state.heights;
    return from + ((y - top) / (bottom - top)) * (to - from);
  };

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

  /** Draws the last row in the field. */
  function draw(drawing) {
    const [, , , , , feedback, , felt] = state.rows[state.rows.length - 1];
    state.maxForce = Math.max(state.maxForce, Math.abs(felt));
    parts.panel.setDrawings([drawing]);
    parts.panel.tell(drawing.state);
    vibrate(feedback);
  }

  function vibrate(force) {
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
      const color = state.shades[row[6] - 1];
      if (row[6] === 0) continue;
      if (open && open[2] === color && row[0] - open[1] < 0.05) open[1] = row[0];
      else shades.push([row[0], row[0], color]);
    }
    const [from, time] = [rows[0][0], column(0)];
    const marks = (kind) => state.events.filter((event) => event[0] >= from && event[1] === kind).map(([at]) => at);
    const panels = state.figure.rows[0].panels.map((panel, index) => ({
      ...panel, shades, ruptures: marks("rupture"), alarms: marks("alarm"),
      x: { ...panel.x, low: from, high: Math.max(last, from + 1) },
      y: { ...panel.y, low: null, high: null },
      lines: panel.lines.map((line, at) => ({ ...line, points: [time, column(state.lines[index][at])] })),
    }));
    charts ??= panels.map((panel) => new trocarCharts.Chart(parts.strips, panel, { height: 160 }));
    charts.forEach((chart, index) => chart.update(panels[index]));
  }

  function end(text) {
    parts.button.textContent = "Begin";
    parts.text.textContent = text;
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
      parts.panel = new trocarAnimation.Panel(field, "", "augmented");
      parts.panel.state.setAttribute("role", "status");
      parts.panel.describe("Needle, tissue and hand");
      button.addEventListener("click", () => {
        if (state && !state.ended) {
          // The result follows.
          trocarLink.tell({ type: "stop" });
          end("ended");
        } else begin();
      });
      const at = (event) => {
        aim(position(parts.panel.height(event)));
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
    },
    /** Handles a message about the insertion. */
    receive(message) {
      // Ignores messages of an earlier insertion.
      if (!state || message.id !== state.id) return;
      if (message.type === "pushing" && !state.ended) {
        state.range = message.range_mm;
        [state.figure, state.lines, state.shades] = [message.figure, message.lines, message.shades];
        state.augmented = message.augmented;
        state.aim = message.range_mm[0];
        state.heights = message.heights;
        parts.panel.name.textContent = state.augmented ? "augmented" : "classical";
        parts.panel.figure.className = `needle-panel ${state.augmented ? "augmented" : "classical"}`;
        parts.panel.setDrawings([message.drawing]);
        parts.field.setAttribute("aria-valuemin", message.range_mm[0].toFixed(1));
        parts.field.setAttribute("aria-valuemax", message.range_mm[1].toFixed(1));
      } else if (message.type === "moved" && !state.ended && state.range) {
        if (state.pressed) send();
        state.rows.push(...message.rows);
        for (const [at, kind] of message.events) {
          state.events.push([at, kind]);
          if (kind === "alarm") trocarListen.cue(parts.lamp);
        }
        if (!message.drawing) return;
        draw(message.drawing);
        strips();
      } else if (message.type === "pushed" && message.text !== undefined) {
        end(message.text);
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
