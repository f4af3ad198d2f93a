// The page: its state, what it asks the program, and where the answers go.
"use strict";

const trocar = (() => {
  const part = (id) => document.getElementById(id);
  /** Text for a part of the page; the same again costs nothing. */
  const say = (id, text) => {
    if (part(id).textContent !== text) part(id).textContent = text;
  };
  /** From the input event to the drawn frame, and the program's own time, in ms: the last hundred. */
  const timings = [];
  const state = { scenario: "", set: {}, map: { x: "scaling.force", y: "tissue.stiffness_n_per_m" } };
  let hello = null;
  let base = {};
  let window_s = null;
  let asked = { id: 0, at: null, busy: false, again: false };
  let opened = 0;
  let addressed = 0;
  /** What was wrong with the address: said until something changes. */
  let notice = "";
  let mapped = { id: 0, timer: 0 };
  let files = { id: 0, waiting: false, last: null };

  /** What the address of the page says. */
  function address() {
    const given = new URLSearchParams(location.hash.slice(1));
    const set = {};
    for (const [key, value] of given) {
      if (["scenario", "x", "y"].includes(key)) continue;
      try {
        set[key] = JSON.parse(value);
      } catch {
        set[key] = value;
      }
    }
    return { scenario: given.get("scenario"), set, x: given.get("x"), y: given.get("y") };
  }

  /** Puts the state into the address, soon: browsers count how often that is done. */
  function toAddress() {
    clearTimeout(addressed);
    addressed = setTimeout(writeAddress, 120);
  }

  function writeAddress() {
    const given = new URLSearchParams({ scenario: state.scenario });
    for (const [key, value] of Object.entries(state.set)) given.set(key, JSON.stringify(value));
    if (state.map.x !== "scaling.force") given.set("x", state.map.x);
    if (state.map.y !== "tissue.stiffness_n_per_m") given.set("y", state.map.y);
    history.replaceState(null, "", `#${given}`);
    const sets = Object.entries(state.set).map(([key, value]) => ` --set '${key}=${JSON.stringify(value)}'`);
    say("command", `trocar run ${state.scenario}${sets.join("")}`);
  }

  const wish = () => ({ scenario: state.scenario, set: state.set });

  /** Asks for both runs of the state: one question at a time, the last one counts. */
  function show(at = null) {
    if (asked.busy) {
      asked.again = true;
      asked.at = asked.at ?? at;
      return;
    }
    const points = Math.min(1600, Math.max(400, Math.round(part("signals").clientWidth * 1.2)));
    const id = trocarLink.ask({ type: "show", state: wish(), points, window_s });
    if (id) asked = { id, at, busy: true, again: false };
  }

  function map(delay = 500) {
    clearTimeout(mapped.timer);
    mapped.timer = setTimeout(() => {
      mapped.id = trocarLink.ask({ type: "map", state: wish(), x: state.map.x, y: state.map.y });
    }, delay);
  }

  function changed(path, at) {
    notice = "";
    state.set = trocarControls.changes();
    toAddress();
    show(at ?? null);
    map();
  }

  function open(scenario, set = {}) {
    state.scenario = scenario;
    state.set = set;
    window_s = null;
    trocarPictures.unzoom();
    trocarPush.leave("");
    part("scenario").value = scenario;
    part("question").textContent = hello.scenarios.find((one) => one.name === scenario)?.question ?? "";
    opened = trocarLink.ask({ type: "open", scenario });
  }

  /** Goes where the address says, as far as there is such a place. */
  function follow(given, otherwise) {
    const known = hello.scenarios.some((one) => one.name === given.scenario);
    const isAxis = (key) => hello.axes.some((axis) => axis.key === key);
    if (isAxis(given.x)) state.map.x = given.x;
    if (isAxis(given.y)) state.map.y = given.y;
    part("map-x").value = state.map.x;
    part("map-y").value = state.map.y;
    const missing = given.scenario && !known;
    notice = missing ? `there is no scenario ${given.scenario.slice(0, 80)} here: this is ${otherwise}` : "";
    open(known ? given.scenario : otherwise, missing ? {} : given.set);
  }

  function trouble(text) {
    part("trouble").hidden = text === "";
    part("trouble").textContent = text;
  }

  function timed(frame) {
    say("timing", `both runs: ${frame.server_ms.toFixed(1)} ms`);
    const { at } = asked;
    requestAnimationFrame(() => {
      // A message that is posted within a frame is heard when the frame is drawn.
      const channel = new MessageChannel();
      channel.port1.onmessage = () => {
        timings.push({ server_ms: frame.server_ms, total_ms: at === null ? null : performance.now() - at });
        if (timings.length > 100) timings.shift();
      };
      channel.port2.postMessage(0);
    });
  }

  function next() {
    asked.busy = false;
    if (asked.again) show(asked.at);
  }

  const hear = {
    hello(message) {
      const isNew = hello === null;
      hello = message;
      part("version").textContent = message.version;
      if (isNew) {
        for (const { name } of message.scenarios) part("scenario").append(new Option(name.replace("builtin:", ""), name));
        for (const axis of ["x", "y"]) {
          for (const { key, name } of message.axes) part(`map-${axis}`).append(new Option(name, key));
        }
      }
      const known = message.scenarios.some((one) => one.name === state.scenario);
      if (isNew || !known) follow(address(), message.first);
      else open(state.scenario, state.set);
    },
    values(message) {
      if (message.id !== opened) return;
      base = message.values;
      trocarControls.draw(part("controls"), hello.keys, base, changed);
      trocarControls.give(state.set);
      // What the address says beyond the keys there are is the program's to refuse.
      state.set = { ...state.set, ...trocarControls.changes() };
      toAddress();
      if (part("find").value) trocarControls.find(part("controls"), part("find").value);
      asked.busy = false;
      show();
      map(0);
    },
    shown(frame) {
      if (frame.id !== asked.id) return;
      if (window_s !== null && window_s[0] >= frame.whole_s[1]) {
        // The run has become shorter than what was looked at.
        window_s = null;
        trocarPictures.unzoom();
        asked.again = true;
        next();
        return;
      }
      trouble(notice);
      trocarControls.blame("");
      const diverged = frame.runs.filter((run) => run.diverged_s !== null);
      say("status", diverged.map((run) => `${run.name} diverges at ${run.diverged_s} s`).join("; ") || "up to date");
      trocarPictures.draw(part("signals"), frame);
      trocarPictures.table(part("metrics").tBodies[0], frame.table);
      timed(frame);
      const [x, y] = [state.map.x, state.map.y].map((key) => trocarControls.value(key));
      if (typeof x === "number" && typeof y === "number" && trocarMap.is(state.map.x, state.map.y)) trocarMap.at(part("map"), x, y);
      next();
    },
    table(message) {
      if (message.id === asked.id) trocarPictures.table(part("metrics").tBodies[0], message.table);
    },
    mapped(message) {
      if (message.id === mapped.id) trocarMap.show(part("map"), part("map-told"), message);
    },
    file(message) {
      if (message.id === files.id) save(message.name, new Blob([message.content], { type: "text/plain" }), message.content);
    },
    refused(message) {
      // Where a key was set here, there is no line of a file to be named.
      const reason = message.message.replace(/^the page:\d+:\d+: /, "");
      if (message.id === mapped.id) {
        part("map-told").textContent = reason;
        return;
      }
      trouble(reason);
      trocarControls.blame(reason);
      trocarPush.refused(message.id);
      if (message.id === asked.id) {
        part("status").textContent = "refused";
        next();
      }
    },
  };

  function save(name, blob, content) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    files.last = { name, content, size: blob.size };
    part("status").textContent = `saved ${name}`;
  }

  /** From a point of the map to the controls; both delays are one axis. */
  function moved(x, y, at) {
    // The axes of the map that is drawn: others may have been chosen, and not have come yet.
    const { x: across, y: upwards } = trocarMap.told();
    for (const [key, value] of [[across.key, x], [upwards.key, y]]) {
      const keys = key === "channel.delay_s" ? ["channel.forward_delay_s", "channel.backward_delay_s"] : [key];
      for (const one of keys) trocarControls.put(one, value);
    }
    trocarMap.at(part("map"), x, y);
    changed(across.key, at);
  }

  function theme(name) {
    if (name) document.documentElement.dataset.theme = name;
    else delete document.documentElement.dataset.theme;
    try {
      localStorage.setItem("trocar-theme", name);
    } catch {
      // A browser that keeps nothing forgets the theme.
    }
    window.dispatchEvent(new Event("themechange"));
  }

  function begin() {
    let kept = "";
    try {
      kept = localStorage.getItem("trocar-theme") ?? "";
    } catch {
      // As above.
    }
    part("theme").value = kept;
    theme(part("theme").value);
    part("theme").addEventListener("change", () => theme(part("theme").value));
    part("scenario").addEventListener("change", () => {
      notice = "";
      open(part("scenario").value);
    });
    part("reset").addEventListener("click", () => {
      trocarControls.give({});
      changed("", performance.now());
    });
    part("find").addEventListener("input", () => trocarControls.find(part("controls"), part("find").value));
    part("controls").addEventListener("submit", (event) => event.preventDefault());
    for (const axis of ["x", "y"]) {
      part(`map-${axis}`).addEventListener("change", () => {
        state.map[axis] = part(`map-${axis}`).value;
        toAddress();
        map(0);
      });
    }
    trocarMap.begin(part("map"), moved);
    trocarListen.begin({ button: part("listen"), output: part("listen-at"), lamp: part("lamp"), volume: part("volume"), scheme: part("listen-scheme") });
    trocarPush.begin({
      button: part("push"), field: part("field"), felt: part("felt"), feltTold: part("felt-told"), mode: part("push-mode"),
      strips: part("pushed"), told: part("push-told"), scheme: part("push-scheme"), lamp: part("lamp"), state: wish,
    });
    for (const file of ["toml", "csv"]) {
      part(`export-${file}`).addEventListener("click", () => {
        files.id = trocarLink.ask({ type: "export", state: wish(), augmented: part("export-scheme").value === "1", file });
        if (!files.id) part("status").textContent = "the program is not there: nothing is saved";
      });
    }
    part("export-png").addEventListener("click", async () => {
      if (trocarPictures.frame() === null) return;
      save(`${state.scenario.replace(/^builtin:|\.toml$/g, "")}.png`, await trocarPictures.png(part("command").textContent), null);
    });
    part("copy-link").addEventListener("click", async () => {
      try {
        await navigator.clipboard.writeText(location.href);
        part("status").textContent = "link copied";
      } catch {
        part("status").textContent = "the browser does not let the page copy: take the address above";
      }
    });
    window.addEventListener("chartzoom", ({ detail }) => {
      if (detail.group !== trocarPictures.GROUP) return;
      window_s = detail.min === null ? null : [Math.max(0, detail.min), Math.max(0, detail.max)];
      show();
    });
    window.addEventListener("hashchange", () => {
      if (hello) follow(address(), state.scenario);
    });
    trocarLink.begin(
      (message) => {
        const heard = hear[message.type];
        if (heard) heard(message);
        else trocarPush.hear(message);
      },
      (text) => {
        part("status").textContent = text;
        asked.busy = false;
        trocarPush.leave("the program has gone");
      },
    );
  }

  begin();
  return { state, timings, file: () => files.last, busy: () => asked.busy || asked.again };
})();
