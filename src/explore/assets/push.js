// Insertion by hand: the pointer is the desired position of the hand on the master, in real time.
"use strict";

const trocarPush = (() => {
  const SHOWN_S = 8;
  /** Time that the charts of the result show before and after the animation, in s. */
  const [BEFORE_S, AFTER_S] = [0.2, 1];
  let parts = null;
  let state = null;
  let charts = null;
  let player = null;
  let resultCharts = [];
  let shownResult = null;
  /** The requested frame of the screen; 0 if there is none. */
  let frame = 0;

  const mm = (value) => `${value.toFixed(1)} mm`;

  function newState(id, augmented) {
    return { id, augmented, range: null, aim: null, rows: [], events: [], full: null, pressed: false, drawing: null, ended: false };
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
  }

  /** Asks for the next ticks and draws the last ones, once per frame of the screen. */
  function redraw() {
    frame ||= requestAnimationFrame(() => {
      frame = 0;
      if (!state.range || state.ended) return;
      trocarLink.tell({ type: "aim", id: state.id, m: state.aim / 1000 });
      if (!state.drawing) return;
      parts.panel.setDrawings([state.drawing]);
      parts.panel.tell(state.drawing.state);
      strips();
    });
  }

  /** Plays the felt force. */
  function sound() {
    const felt = state.rows[state.rows.length - 1][7];
    if (parts.sound.checked) trocarListen.force(felt, state.full);
    else trocarListen.quiet();
  }

  /** Signals an event by sound, vibration and light. */
  function feel(kind) {
    if (kind === "alarm") trocarListen.light(parts.lamp);
    if (kind !== "rupture" || !parts.sound.checked) return;
    trocarListen.click();
    trocarListen.vibrate();
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
    // Use fixed axes, because autoscaling would magnify micrometres before contact. Force is on the left, position on
    // the right.
    const places = state.range.flatMap((at) => [at, state.scale * at]);
    const ends = [[-0.2 * state.full, state.full], [Math.min(...places), Math.max(...places)]];
    const panels = state.figure.rows[0].panels.map((panel, index) => ({
      ...panel, shades, ruptures: marks("rupture"), alarms: marks("alarm"),
      x: { ...panel.x, low: from, high: Math.max(last, from + 1), ticks: null },
      y: { ...panel.y, low: ends[index][0], high: ends[index][1], ticks: null },
      lines: panel.lines.map((line, at) => ({ ...line, points: [time, column(state.lines[index][at])] })),
    }));
    charts ??= panels.map((panel) => new trocarCharts.Chart(parts.strips, panel, { height: 160 }));
    charts.forEach((chart, index) => chart.update(panels[index]));
  }

  function end(text) {
    parts.button.textContent = "Begin";
    parts.text.textContent = text;
    if (state) state.ended = true;
    trocarListen.quiet();
  }

  /** Shows the results of both schemes with the same motion of the hand. */
  function result(message) {
    const { answer, animation, figure } = message;
    shownResult = message;
    end(`The same motion of your hand with both schemes: ${answer}`);
    parts.button.textContent = "Push again";
    show("result");
    player ??= new trocarAnimation.Player(parts.animation);
    player.setData(animation);
    resultCharts.forEach((chart) => chart.remove());
    const panels = figure.rows.flatMap((row) => row.panels).slice(0, 2);
    resultCharts = panels.map((panel) => new trocarCharts.Chart(parts.charts, panel, { group: "pushed" }));
    const times = animation.time_s;
    const [low, high] = [Math.max(panels[0].x.low, times[0] - BEFORE_S), Math.min(panels[0].x.high, times[times.length - 1] + AFTER_S)];
    resultCharts[0].zoom({ low, high });
  }

  /** Shows the field ("live") or the result. */
  function show(which) {
    parts.live.hidden = which === "result";
    parts.result.hidden = which !== "result";
  }

  function begin() {
    const id = trocarLink.ask({ type: "push", state: parts.state(), augmented: parts.scheme.value === "1" });
    if (!id) {
      parts.text.textContent = "no connection to the server";
      return;
    }
    state = newState(id, parts.scheme.value === "1");
    show("live");
    // This is a user gesture, after which a browser allows sound.
    trocarListen.start(Number(parts.volume.value));
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
      // A hidden page draws no frames, so the insertion pauses.
      document.addEventListener("visibilitychange", () => trocarListen.quiet());
      button.addEventListener("click", () => {
        if (state && !state.ended) {
          // The result follows.
          trocarLink.tell({ type: "stop", id: state.id });
          end("ended");
        } else begin();
      });
      const at = (event) => {
        aim(position(parts.panel.height(event)));
      };
      const ready = () => state && state.range && !state.ended;
      field.addEventListener("pointerdown", (event) => {
        if (!ready() || event.button !== 0) return;
        // Keep a drag from selecting text.
        event.preventDefault();
        field.focus();
        trocarListen.start(Number(parts.volume.value));
        state.pressed = true;
        field.setPointerCapture(event.pointerId);
        at(event);
      });
      field.addEventListener("pointermove", (event) => ready() && state.pressed && at(event));
      const up = () => {
        if (!ready()) return;
        state.pressed = false;
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
    receive(message) {
      // Ignore messages of an earlier insertion.
      if (!state || message.id !== state.id) return;
      if (message.type === "pushing" && !state.ended) {
        [state.range, state.scale] = [message.range_mm, message.position_scale];
        [state.figure, state.lines, state.shades] = [message.figure, message.lines, message.shades];
        state.augmented = message.augmented;
        state.aim = message.range_mm[0];
        state.heights = message.heights;
        parts.panel.name.textContent = state.augmented ? "augmented" : "classical";
        parts.panel.figure.className = `needle-panel ${state.augmented ? "augmented" : "classical"}`;
        parts.panel.setDrawings([message.drawing]);
        parts.field.setAttribute("aria-valuemin", message.range_mm[0].toFixed(1));
        parts.field.setAttribute("aria-valuemax", message.range_mm[1].toFixed(1));
        redraw();
      } else if (message.type === "moved" && !state.ended && state.range) {
        state.rows.push(...message.rows);
        for (const [at, kind] of message.events) {
          state.events.push([at, kind]);
          feel(kind);
        }
        redraw();
        if (!message.drawing) return;
        // The force axis and the tone reach their maximum at the end of the drawn bar, in N.
        [state.drawing, state.full] = [message.drawing, message.drawing.full_n];
        sound();
      } else if (message.type === "pushed") result(message);
    },
    /** Begins an insertion unless one is running. */
    open: () => (!state || state.ended) && begin(),
    /** Ends the insertion because the scenario changed or the connection was lost. */
    leave(text) {
      if (!state || state.ended) return;
      trocarLink.tell({ type: "stop", id: state.id });
      end(text);
    },
    refused: (id) => state && state.id === id && end(""),
    state: () => state,
    result: () => shownResult,
  };
})();
