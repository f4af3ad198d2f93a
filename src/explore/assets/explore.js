// The page: its state, its requests to the server, and the handling of the answers.
"use strict";

const trocar = (() => {
  const part = (id) => document.getElementById(id);
  /** Sets the text of an element. Skips an unchanged text to avoid a layout. */
  const setText = (id, text) => {
    if (part(id).textContent !== text) part(id).textContent = text;
  };
  /** The last hundred latencies, in ms: from the input event to the drawn frame, and in the server. */
  const timings = [];
  const AXES = { x: "scaling.force", y: "channel.delay_s" };
  /** Changes within this time, in ms, form one step of undo and Back. */
  const STEP_MS = 700;
  const state = { scenario: "", set: {}, map: { ...AXES } };
  let hello = null;
  let base = {};
  /** The displayed time: "rupture", "all", or { between: [from, to] } in s. */
  let shownTime = "rupture";
  let animation = null;
  let request = { id: 0, at: null, busy: false, again: false };
  /** The timer of the checks in noise, which begin after this time without changes, in ms. */
  let noiseTimer = 0;
  const IDLE_MS = 600;
  let opened = 0;
  /** True until the values of the opened scenario arrive. */
  let isOpening = false;
  /** The time of the cursor and of the paused animation, in s, or `null`. `isSought` is true if the next frame must
   *  move them there. */
  let shownAt = null;
  let isSought = false;
  /** The last change written into the address and its time; `what` is the change to be written. */
  let written = { timer: 0, at: -Infinity, last: null, what: null };
  /** The error of the address, displayed until the next change. */
  let notice = "";
  /** The answer to be drawn, with the time of the first input that it shows; `null` if all are drawn. */
  let pending = null;
  /** True if an answer was drawn since the last frame of the screen. */
  let isDrawn = false;
  let mapped = { id: 0, timer: 0 };
  let files = { id: 0, waiting: false, last: null };
  /** Width of a chart in pixels, stored because reading it at each request would cause a layout of the whole page. */
  let chartWidth = 0;

  /** Returns the state in the address of the page. */
  function address() {
    const given = new URLSearchParams(location.hash.slice(1));
    const set = {};
    for (const [key, value] of given) {
      if (["scenario", "x", "y", "time", "at"].includes(key)) continue;
      try {
        set[key] = JSON.parse(value);
      } catch {
        set[key] = value;
      }
    }
    const [from, to] = (given.get("time") ?? "").split("-").map(Number);
    const time = from < to ? { between: [from, to] } : given.get("time") === "all" ? "all" : "rupture";
    const at = Number(given.get("at") ?? NaN);
    return { scenario: given.get("scenario"), set, x: given.get("x"), y: given.get("y"), time, at: Number.isFinite(at) ? at : null };
  }

  /** Writes the state into the address, after a short delay because browsers limit the rate of changes. `what` names
   *  the change, which becomes a step of undo and Back; without it, the last step is only completed. */
  function toAddress(what = null) {
    written.what = what ?? written.what;
    clearTimeout(written.timer);
    written.timer = setTimeout(writeAddress, 120);
  }

  /** Returns the number of steps that Back can undo on this page. */
  const depth = () => history.state?.depth ?? 0;

  const rounded = (time) => Number(time.toFixed(4));

  function writeAddress() {
    const given = new URLSearchParams({ scenario: state.scenario });
    for (const [key, value] of Object.entries(state.set)) given.set(key, JSON.stringify(value));
    for (const axis of ["x", "y"]) if (state.map[axis] !== AXES[axis]) given.set(axis, state.map[axis]);
    if (shownTime !== "rupture") given.set("time", shownTime === "all" ? "all" : shownTime.between.map(rounded).join("-"));
    if (shownAt !== null) given.set("at", rounded(shownAt));
    const now = performance.now();
    // All changes of one drag form one step.
    const { what, last } = written;
    const isStep = what !== null && (what !== last || now - written.at > STEP_MS) && location.hash !== `#${given}`;
    if (isStep) history.pushState({ depth: depth() + 1 }, "", `#${given}`);
    else history.replaceState({ depth: depth() }, "", `#${given}`);
    if (what !== null) [written.last, written.at] = [what, now];
    written.what = null;
    part("undo").disabled = depth() === 0;
    const sets = Object.entries(state.set).map(([key, value]) => ` --set '${key}=${JSON.stringify(value)}'`);
    // The keys of events have an effect with augmentation only.
    const augments = Object.keys(state.set).some((key) => key.startsWith("augmentation."));
    setText("command", `trocar run ${state.scenario}${augments ? " --set augmentation.enabled=true" : ""}${sets.join("")}`);
  }

  const current = () => ({ scenario: state.scenario, set: state.set });

  /** Requests both runs of the state. Only one request is active at a time; afterwards the latest state is requested.
   *  */
  function show(at = null) {
    if (request.busy) {
      request.again = true;
      request.at = request.at ?? at;
      return;
    }
    const points = Math.min(1600, Math.max(400, Math.round(chartWidth * 1.5)));
    const id = trocarLink.ask({ type: "show", state: current(), points, window: shownTime });
    if (id) request = { id, at, busy: true, again: false };
  }

  function map(delay = 500) {
    clearTimeout(mapped.timer);
    mapped.timer = setTimeout(() => {
      const ranges = trocarMap.ranges(state.map, (key) => mapValue(key));
      mapped.id = trocarLink.ask({ type: "map", state: current(), x: state.map.x, y: state.map.y, ...ranges });
    }, delay);
  }

  /** Returns the value of a map's axis. The axis channel.delay_s sets both delays, and its value is the forward
   *  delay. */
  const mapValue = (key) => trocarControls.value(key === "channel.delay_s" ? "channel.forward_delay_s" : key);

  function changed(path, at) {
    notice = "";
    state.set = trocarControls.changes();
    toAddress(path);
    show(at ?? null);
    map();
  }

  function open(scenario, set = {}, time = "rupture") {
    state.scenario = scenario;
    state.set = set;
    shownTime = time;
    trocarMap.forget();
    trocarPush.leave("");
    part("scenario").value = scenario;
    const { question = "", title = "" } = hello.scenarios.find((one) => one.name === scenario) ?? {};
    part("question").textContent = question.replace(title, "").replace(/^[:?]/, "");
    part("question").title = question;
    document.title = `${title || scenario} · trocar explore`;
    opened = trocarLink.ask({ type: "open", scenario });
    isOpening = opened !== 0;
  }

  /** Loads the state of the address, as far as it is valid. */
  function follow(given, otherwise) {
    const known = hello.scenarios.some((one) => one.name === given.scenario);
    const isAxis = (key) => hello.axes.some((axis) => axis.key === key);
    if (isAxis(given.x)) state.map.x = given.x;
    if (isAxis(given.y)) state.map.y = given.y;
    part("map-x").value = state.map.x;
    part("map-y").value = state.map.y;
    const missing = given.scenario && !known;
    notice = missing ? `scenario ${given.scenario.slice(0, 80)} does not exist; showing ${otherwise}` : "";
    [shownAt, isSought] = [given.at, given.at !== null];
    const scenario = known ? given.scenario : otherwise;
    if (scenario !== state.scenario || opened === 0) {
      open(scenario, missing ? {} : given.set, given.time);
      return;
    }
    // The scenario is the same, so keep its controls and the focus.
    shownTime = given.time;
    state.set = given.set;
    trocarControls.give(given.set);
    toAddress();
    show();
    map(0);
  }

  /** Lists the warnings of the runs. Each warning appears once, with the runs that it concerns. */
  function warned(runs) {
    const texts = new Map();
    runs.forEach((run, index) => {
      run.warnings.forEach(({ code, message, remedy }) => {
        const text = `${message} (${code})${remedy === null ? "" : `: ${remedy}`}`;
        texts.set(text, [...(texts.get(text) ?? []), ["classical", "augmented"][index]]);
      });
    });
    const items = [...texts].map(([text, schemes]) => {
      const item = document.createElement("li");
      item.textContent = `${schemes.join(" and ")}: ${text}`;
      return item;
    });
    part("warnings").hidden = items.length === 0;
    part("warnings").replaceChildren(...items);
  }

  /** Shows the errors of a control at the control, and the others above the result, which is then out of date. */
  function trouble(errors) {
    const others = trocarControls.blame(errors);
    part("trouble").hidden = others.length === 0;
    part("trouble").textContent = others.join(" ");
    part("main").classList.toggle("outdated", errors.length > 0);
  }

  function timed(frame, at) {
    setText("timing", `both runs: ${frame.server_ms.toFixed(1)} ms`);
    requestAnimationFrame(() => {
      // A message posted within a frame arrives after the frame is drawn.
      const channel = new MessageChannel();
      channel.port1.onmessage = () => {
        timings.push({ server_ms: frame.server_ms, total_ms: at === null ? null : performance.now() - at });
        if (timings.length > 100) timings.shift();
      };
      channel.port2.postMessage(0);
    });
  }

  /**
   * Draws the last answer, at most once per frame of the screen, while the server computes the next one. It draws at once
   * instead of in the next frame, so that the next frame has less to do.
   */
  function draw() {
    if (pending === null || isDrawn) return;
    const { frame, at } = pending;
    pending = null;
    isDrawn = true;
    requestAnimationFrame(() => {
      isDrawn = false;
      draw();
    });
    trouble(notice ? [notice] : []);
    const diverged = frame.runs.filter((run) => run.diverged_s !== null);
    setText("status", diverged.map((run) => `${run.name} diverges at ${run.diverged_s} s`).join("; ") || "up to date");
    warned(frame.runs);
    setText("answer", frame.answer);
    animation ??= new trocarAnimation.Player(part("animation"));
    animation.setData(frame.animation);
    trocarPictures.draw([part("chart-1"), part("chart-2"), part("signals")], frame);
    trocarPictures.table(part("metrics").tBodies[0], frame.table);
    if (isSought) animation.seek(shownAt);
    isSought = false;
    timed(frame, at);
    const [x, y] = [state.map.x, state.map.y].map(mapValue);
    if (typeof x === "number" && typeof y === "number" && trocarMap.is(state.map.x, state.map.y)) trocarMap.at(part("map"), x, y);
  }

  const places = () => ({ front: part("front"), sections: part("sections") });

  function next() {
    request.busy = false;
    if (request.again) show(request.at);
  }

  const handlers = {
    hello(message) {
      const isNew = hello === null;
      hello = message;
      part("version").textContent = message.version;
      if (isNew) {
        const groups = new Map();
        for (const { name, title, group } of message.scenarios) {
          if (!groups.has(group)) groups.set(group, part("scenario").appendChild(document.createElement("optgroup")));
          groups.get(group).label = group;
          groups.get(group).append(new Option(title, name));
        }
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
      isOpening = false;
      base = message.values;
      trocarControls.draw(places(), [...hello.keys, ...message.layers], base, changed);
      trocarControls.give(state.set);
      // Also send unknown keys of the address, which the server refuses.
      state.set = { ...state.set, ...trocarControls.changes() };
      toAddress();
      if (part("find").value) trocarControls.find(places(), part("find").value);
      request.busy = false;
      show();
      map(0);
    },
    shown(frame) {
      if (frame.id !== request.id) return;
      if (typeof shownTime === "object" && shownTime.between[0] >= frame.whole_s[1]) {
        // The run has become shorter than the zoomed window.
        shownTime = "rupture";
        request.again = true;
        next();
        return;
      }
      pending = { frame, at: pending?.at ?? request.at };
      next();
      clearTimeout(noiseTimer);
      noiseTimer = setTimeout(() => trocarLink.tell({ type: "noise", id: request.id }), IDLE_MS);
      draw();
    },
    table(message) {
      if (message.id !== request.id) return;
      if (pending) pending.frame.table = message.table;
      else trocarPictures.table(part("metrics").tBodies[0], message.table);
    },
    mapped(message) {
      if (message.id === mapped.id) trocarMap.show(part("map"), part("map-text"), message);
    },
    file(message) {
      if (message.id === files.id) save(message.name, message.content);
    },
    refused(message) {
      if (message.id === mapped.id) {
        part("map-text").textContent = message.all.join(" ");
        return;
      }
      // Earlier results are not drawn any more.
      if (message.id === request.id) pending = null;
      if (message.id === opened) isOpening = false;
      trouble(message.all);
      trocarPush.refused(message.id);
      if (message.id === request.id) {
        const shown = trocarPictures.frame() ? "the pale curves are those of the last valid values" : "correct the marked values";
        part("status").textContent = `refused; ${shown}`;
        next();
      }
    },
  };

  function save(name, content) {
    const blob = new Blob([content], { type: typeof content === "string" ? "text/plain" : "image/png" });
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    files.last = { name, content, size: blob.size };
    part("status").textContent = `saved ${name}`;
  }

  /** Sets the controls to a point of the map. The axis channel.delay_s sets both delays. */
  function moved(x, y, at) {
    // Use the axes of the drawn map, because the map of newly selected axes may not have arrived yet.
    const { x: xAxis, y: yAxis } = trocarMap.current();
    for (const [key, value] of [[xAxis.key, x], [yAxis.key, y]]) {
      const keys = key === "channel.delay_s" ? ["channel.forward_delay_s", "channel.backward_delay_s"] : [key];
      for (const one of keys) trocarControls.put(one, value);
    }
    trocarMap.at(part("map"), x, y);
    changed(xAxis.key, at);
  }

  function theme(name) {
    if (name) document.documentElement.dataset.theme = name;
    else delete document.documentElement.dataset.theme;
    try {
      localStorage.setItem("trocar-theme", name);
    } catch {
      // Without local storage the theme is not saved.
    }
    window.dispatchEvent(new Event("themechange"));
  }

  function begin() {
    chartWidth = part("chart-1").clientWidth;
    new ResizeObserver(([{ contentRect }]) => {
      chartWidth = contentRect.width;
    }).observe(part("chart-1"));
    let saved = "";
    try {
      saved = localStorage.getItem("trocar-theme") ?? "";
    } catch {
      // Without local storage no theme is loaded.
    }
    part("theme").value = saved;
    theme(part("theme").value);
    part("theme").addEventListener("change", () => theme(part("theme").value));
    part("scenario").addEventListener("change", () => {
      notice = "";
      shownAt = null;
      open(part("scenario").value);
      toAddress("scenario");
    });
    part("undo").addEventListener("click", () => history.back());
    window.addEventListener("keydown", (event) => {
      const isText = event.target.matches("input[type=text], input[type=search]");
      if (!(event.ctrlKey || event.metaKey) || event.altKey || isText || !["z", "y"].includes(event.key.toLowerCase())) return;
      event.preventDefault();
      if (event.key.toLowerCase() === "y" || event.shiftKey) history.forward();
      else if (depth() > 0) history.back();
    });
    part("reset").addEventListener("click", () => {
      trocarControls.give({});
      changed("", performance.now());
    });
    part("find").addEventListener("input", () => trocarControls.find(places(), part("find").value));
    part("controls").addEventListener("submit", (event) => event.preventDefault());
    for (const axis of ["x", "y"]) {
      part(`map-${axis}`).addEventListener("change", () => {
        state.map[axis] = part(`map-${axis}`).value;
        toAddress(axis);
        map(0);
      });
    }
    trocarMap.begin(part("map"), moved);
    trocarListen.begin({ button: part("listen"), output: part("listen-at"), lamp: part("lamp"), volume: part("volume"), scheme: part("listen-scheme") });
    trocarPush.begin({
      button: part("push"), field: part("field"), strips: part("pushed"), text: part("push-text"), scheme: part("push-scheme"),
      lamp: part("push-lamp"), sound: part("push-sound"), volume: part("volume"), state: current,
      live: part("push-live"), result: part("push-result"), animation: part("push-animation"), charts: part("push-charts"),
    });
    // The field replaces the animation and the curves, so that it is in view.
    const pushing = (isOpen) => {
      part("push-section").hidden = !isOpen;
      part("main").classList.toggle("pushing", isOpen);
      part("push-open").setAttribute("aria-expanded", String(isOpen));
      if (isOpen) trocarPush.open();
      else trocarPush.leave("");
      window.scrollTo(0, 0);
    };
    part("push-open").addEventListener("click", () => pushing(true));
    part("push-close").addEventListener("click", () => {
      pushing(false);
      part("push-open").focus();
    });
    // Keep focused elements visible below the sticky picture.
    new ResizeObserver(([{ contentRect }]) => {
      const isSticky = getComputedStyle(document.querySelector(".stage")).position === "sticky";
      document.documentElement.style.scrollPaddingTop = isSticky ? `${contentRect.height + 8}px` : "";
    }).observe(document.querySelector(".stage"));
    for (const file of ["toml", "csv", "png"]) {
      part(`export-${file}`).addEventListener("click", () => {
        const picture = file === "png" ? { window: shownTime, width: part("export-width").value } : {};
        files.id = trocarLink.ask({ type: "export", state: current(), augmented: part("export-scheme").value === "1", file, ...picture });
        if (!files.id) part("status").textContent = "no connection to the server: nothing is saved";
      });
    }
    part("copy-link").addEventListener("click", async () => {
      try {
        await navigator.clipboard.writeText(location.href);
        part("status").textContent = "link copied";
      } catch {
        part("status").textContent = "the browser does not allow copying: copy the address of the page";
      }
    });
    window.addEventListener("chartzoom", ({ detail }) => {
      if (detail.group !== trocarPictures.GROUP) return;
      shownTime = detail.range === null ? "all" : { between: [detail.range.low, detail.range.high].map((at) => Math.max(0, at)) };
      toAddress("time");
      show();
    });
    const at = (time) => {
      shownAt = time;
      toAddress();
    };
    window.addEventListener("charttime", ({ detail }) => detail.isKept && at(detail.time));
    part("animation").addEventListener("input", () => at(animation.data.time_s[animation.at]));
    part("animation").addEventListener("click", () => animation.isPlaying && at(null));
    for (const time of ["rupture", "all"]) {
      part(`show-${time}`).addEventListener("click", () => {
        shownTime = time;
        toAddress("time");
        show();
      });
    }
    window.addEventListener("hashchange", () => {
      clearTimeout(written.timer);
      written.what = null;
      if (hello) follow(address(), state.scenario);
    });
    trocarLink.begin(
      (message) => {
        const handle = handlers[message.type];
        if (handle) handle(message);
        else trocarPush.receive(message);
      },
      (text, isLost) => {
        part("status").textContent = text;
        request.busy = false;
        isOpening = false;
        trocarPush.leave("connection lost");
        part("offline").hidden = !isLost;
        part("main").classList.toggle("offline", isLost === true);
        part("controls").inert = isLost === true;
        part("offline").textContent = isLost ? "The server has ended, so nothing on this page changes any more. Start trocar explore again with the same --port; the page then goes on by itself." : "";
        if (isLost) animation?.pause();
      },
    );
  }

  begin();
  return { state, timings, file: () => files.last, busy: () => isOpening || request.busy || request.again || pending !== null, animation: () => animation };
})();
