// The controls: the front controls with plain names and units, and a control for every other key under "All
// settings". A control without effect is disabled and says why. A value that the server refuses is marked at its
// control.
"use strict";

const trocarControls = (() => {
  /** The front controls: their keys, and the number of displayed units per SI unit. A limit can be the value of
   *  another key. */
  const FRONT = [
    { keys: ["scaling.force"], name: "Force feedback", unit: "×", range: [0, 3] },
    { keys: ["scaling.position"], name: "Needle motion per hand motion", unit: "×", range: [0.2, 2] },
    { keys: ["channel.forward_delay_s", "channel.backward_delay_s"], name: "Delay of the link, each way", unit: "ms", per: 1000, range: [0, 0.05] },
    { keys: ["sensor.force_noise_std_n"], name: "Noise of the force sensor", unit: "mN", per: 1000, range: [0, 0.1] },
    { keys: ["detector.threshold"], name: "Alarm threshold", unit: "" },
    { keys: ["augmentation.min_hold_s"], name: "Shortest freeze", unit: "s", range: [0, "augmentation.max_hold_s"] },
    { keys: ["augmentation.catch_up_speed_m_per_s"], name: "Speed of catching up", unit: "mm/s", per: 1000, range: [0.002, 0.2], log: true },
    { keys: ["operator.speed_m_per_s"], name: "Speed of the hand", unit: "mm/s", per: 1000, range: [0.001, 0.1], log: true },
  ];
  /** Fixed ranges of other sliders, in SI units. */
  const RANGES = {
    "channel.jitter_s": [0, 0.02],
    "channel.loss": [0, 0.5],
    "augmentation.max_hold_s": ["augmentation.min_hold_s", 5],
    "augmentation.decay_ratio": [0, 1],
    "augmentation.exit_ratio": [0, 1],
    "augmentation.blend_s": [0, 1],
    "augmentation.amplification": [1, 10],
    "operator.tremor_amplitude_m": [0, 0.002],
    "estimator.contact_m": [-0.01, 0.03],
    "simulation.seed": [0, 50],
  };
  const STEPS = 400;
  const controls = new Map();
  /** The front controls that set several keys. Each key also has its own control. */
  let combined = [];
  let byPath = new Map();
  let changed = () => {};

  /** Returns the conversions between the position and the value of a slider, or null without a range. */
  function scale(key, value, front) {
    const known = front?.range ?? RANGES[key.path];
    if (known && !front?.log) {
      const limit = (end) => (typeof end === "string" ? controls.get(end)?.value ?? value : end);
      const [low, high] = [Math.min(limit(known[0]), value), Math.max(limit(known[1]), value)];
      return { at: (v) => ((v - low) / (high - low)) * STEPS, value: (at) => low + ((high - low) * at) / STEPS };
    }
    if (!(value > 0)) return null;
    const low = known ? Math.min(known[0], value) : Math.max(value / 10, key.kind.low > 0 ? key.kind.low : 0);
    const high = known ? Math.max(known[1], value) : Math.min(value * 10, key.kind.high ?? Infinity);
    if (!(high > low)) return null;
    const ratio = Math.log(high / low);
    return { at: (v) => (Math.log(v / low) / ratio) * STEPS, value: (at) => low * Math.exp((ratio * at) / STEPS) };
  }

  /** Parses a number with a decimal point or comma. Returns NaN for ambiguous texts such as 1,000. */
  function parsed(text) {
    const plain = text.trim().replace("−", "-");
    const isAmbiguous = /^-?[1-9]\d{0,2},\d{3}$/.test(plain) || (plain.includes(",") && plain.includes("."));
    return plain === "" || isAmbiguous ? NaN : Number(plain.replace(",", "."));
  }

  const rounded = (value) => Number(value.toPrecision(3));

  function element(name, attributes = {}, text = "") {
    const node = document.createElement(name);
    for (const [attribute, value] of Object.entries(attributes)) node.setAttribute(attribute, value);
    if (text) node.textContent = text;
    return node;
  }

  /** Returns why a key has no effect with the present values, or an empty text. */
  function inactive(key) {
    for (const acts of key.acts) {
      // The page always runs both schemes.
      if (acts.key === "augmentation.enabled") continue;
      const now = controls.get(acts.key)?.value;
      if (!acts.words.includes(String(now))) return `Acts only for ${acts.key} = ${acts.words.join(" or ")}; here it is ${now}.`;
      const choice = byPath.get(acts.key);
      const reason = choice ? inactive(choice) : "";
      if (reason) return reason;
    }
    return "";
  }

  function updateActive() {
    for (const { key, box } of [...controls.values(), ...combined]) {
      const reason = inactive(key);
      if (box.reason.textContent === reason) continue;
      box.reason.textContent = reason;
      box.reason.hidden = reason === "";
      box.classList.toggle("inactive", reason !== "");
      for (const input of box.querySelectorAll("input, select")) input.disabled = reason !== "";
    }
  }

  /** Returns the control of a key. A front control can set several keys and has its own unit. */
  function control(key, base, front = null) {
    const box = element("div", { class: "control", "data-key": key.path });
    const id = `key-${(front?.keys.length > 1 ? "both." : "") + key.path}`.replaceAll(".", "-");
    const name = element("div", { class: "name" });
    name.append(element("label", { for: id }, front?.name ?? key.name));
    const back = element("button", { type: "button", title: `reset to ${JSON.stringify(base ?? null)}`, "aria-label": `Reset ${front?.name ?? key.path}` }, "reset");
    name.append(back);
    const inputs = element("div", { class: "inputs" });
    const meaning = element("p", { class: "meaning", id: `${id}-meaning` }, front ? "" : key.meaning);
    if (front) {
      box.title = `${front.keys.join(", ")}: ${key.meaning}`;
      meaning.hidden = true;
    } else {
      meaning.prepend(element("code", {}, key.path), " ");
    }
    box.reason = element("p", { class: "reason", hidden: "" });
    box.error = element("p", { class: "error", role: "alert", hidden: "" });
    const control = { key, base, value: base, box, keys: front?.keys ?? [key.path], show: () => {} };
    const give = (value, input) => {
      control.value = value;
      mark(control);
      if (control.keys.length > 1) control.keys.forEach((path) => put(path, value));
      followCombined(key.path);
      if (key.kind.type === "choice" || key.kind.type === "flag") updateActive();
      for (const other of controls.values()) if (other.limits?.includes(key.path)) other.show(other.value);
      changed(key.path, input);
    };
    back.addEventListener("click", () => {
      control.show(control.base);
      give(control.base);
      // The button becomes hidden, so move the focus to the control of this key.
      inputs.firstElementChild.focus();
    });
    if (key.kind.type === "flag") {
      const input = element("input", { type: "checkbox", id, "aria-describedby": meaning.id });
      input.addEventListener("input", () => give(input.checked, performance.now()));
      control.show = (value) => { input.checked = value === true; };
      inputs.append(input);
    } else if (key.kind.type === "choice") {
      const input = element("select", { id, "aria-describedby": meaning.id });
      for (const choice of key.kind.choices) input.append(element("option", { value: JSON.stringify(choice) }, String(choice)));
      input.addEventListener("input", () => give(JSON.parse(input.value), performance.now()));
      control.show = (value) => { input.value = JSON.stringify(value); };
      inputs.append(input);
    } else if (key.kind.type === "numbers") {
      const input = element("input", { type: "text", id, "aria-describedby": meaning.id, placeholder: "1, 2.5, 4" });
      input.addEventListener("change", () => {
        // If semicolons separate the numbers, commas are decimal commas.
        const numbers = input.value.split(input.value.includes(";") ? /[;\s]+/ : /[,\s]+/).filter(Boolean).map(parsed);
        const isWrong = numbers.some((number) => !Number.isFinite(number));
        fail(control, isWrong ? "These are not numbers, separated by commas or semicolons." : "");
        if (isWrong) return;
        if (numbers.length === 0) control.show(control.base);
        give(numbers.length ? numbers : control.base, performance.now());
      });
      control.show = (value) => { input.value = Array.isArray(value) ? value.join(", ") : ""; };
      inputs.append(input);
    } else {
      const whole = key.kind.type === "whole";
      const per = front?.per ?? 1;
      const unit = front?.unit ?? key.unit ?? "";
      control.limits = (front?.range ?? RANGES[key.path])?.filter((end) => typeof end === "string");
      let sliding = scale(key, typeof base === "number" ? base : NaN, front);
      const shown = (value) => Number((value * per).toPrecision(12));
      const spoken = (value) => `${rounded(value * per)} ${unit}`;
      const label = `${front?.name ?? key.name}, as a number${unit ? ` in ${unit}` : ""}`;
      const number = element("input", { type: "text", inputmode: "decimal", id: sliding ? `${id}-number` : id, "aria-label": label, "aria-describedby": meaning.id });
      const slider = sliding && element("input", { type: "range", id, min: "0", max: String(STEPS), step: "any", "aria-describedby": meaning.id });
      const shape = (value) => (whole ? Math.max(0, Math.round(value)) : rounded(value));
      if (slider) {
        slider.addEventListener("input", () => {
          const value = shape(sliding.value(Number(slider.value)));
          number.value = shown(value);
          slider.setAttribute("aria-valuetext", spoken(value));
          give(value, performance.now());
        });
        slider.addEventListener("keydown", (event) => {
          // Arrow keys move by 1 % of the range, Page Up and Page Down by 10 %.
          const by = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 10, PageDown: -10 }[event.key];
          if (!by) return;
          event.preventDefault();
          const step = whole ? STEPS / 50 : STEPS / 100;
          slider.value = Number(slider.value) + by * step;
          slider.dispatchEvent(new Event("input", { bubbles: true }));
        });
        inputs.append(slider);
      }
      number.addEventListener("change", () => {
        const isEmpty = number.value.trim() === "";
        const given = parsed(number.value) / per;
        const isWrong = !isEmpty && !Number.isFinite(given);
        fail(control, isWrong ? `${number.value} is not a number. Write thousands without a comma, and decimals as 0.05 or 0,05.` : "");
        if (isWrong) return;
        const value = isEmpty ? control.base : whole ? Math.round(given) : Number(given.toPrecision(12));
        control.show(value);
        give(value, performance.now());
      });
      control.show = (value) => {
        number.value = typeof value === "number" ? shown(value) : "";
        if (slider && typeof value === "number") {
          sliding = scale(key, control.limits?.length ? value : control.base, front) ?? sliding;
          // A value outside the range, such as 0 on a logarithmic slider, is shown at the end of the slider.
          slider.value = Math.min(STEPS, Math.max(0, sliding.at(value) || 0));
          slider.setAttribute("aria-valuetext", spoken(value));
        }
      };
      inputs.append(number);
      if (unit || front) inputs.append(element("span", { class: "unit", "aria-hidden": "true" }, unit));
    }
    control.show(base);
    box.append(name, inputs, meaning, box.reason, box.error);
    if (control.keys.length > 1) combined.push(control);
    else controls.set(key.path, control);
    return box;
  }

  /** Shows the value of a key, or of all keys, in the combined control that sets it. */
  function followCombined(path = null) {
    for (const control of combined) {
      if (path !== null && !control.keys.includes(path)) continue;
      const { value } = controls.get(control.keys[0]) ?? control;
      if (value !== control.value) control.show(value);
      control.value = value;
      mark(control);
    }
  }

  function put(path, value) {
    const control = controls.get(path);
    if (!control) return;
    control.value = value;
    control.show(value);
    mark(control);
  }

  function mark(control) {
    control.box.classList.toggle("changed", JSON.stringify(control.value) !== JSON.stringify(control.base));
    fail(control, "");
  }

  /** Shows an error at a control; an empty text removes the error. */
  function fail({ box }, text) {
    box.classList.toggle("wrong", text !== "");
    if (box.error.textContent === text) return;
    box.error.textContent = text;
    box.error.hidden = text === "";
    if (text) for (let at = box.parentElement; at; at = at.parentElement) if (at.tagName === "DETAILS") at.open = true;
  }

  return {
    /** Draws every control with the values of a scenario. Each change calls `onChange(path, time of the input)`. */
    draw({ front, sections }, keys, values, onChange) {
      const open = new Set([...sections.querySelectorAll("details[open]")].map((group) => group.dataset.group));
      front.replaceChildren();
      sections.replaceChildren();
      controls.clear();
      combined = [];
      changed = onChange;
      byPath = new Map(keys.map((key) => [key.path, key]));
      // The limit of a slider can be the value of another control, which must be drawn first.
      const limits = new Set(FRONT.flatMap((one) => one.range ?? []).filter((end) => typeof end === "string"));
      for (const path of limits) if (byPath.has(path)) control(byPath.get(path), values[path]);
      const placed = new Set();
      for (const one of FRONT) {
        const key = byPath.get(one.keys[0]);
        if (!key) continue;
        if (one.keys.length === 1) placed.add(key.path);
        front.append(control(key, values[key.path], one));
      }
      const groups = new Map();
      for (const key of keys) {
        if (placed.has(key.path)) continue;
        const section = key.path.includes(".") ? key.path.split(".")[0] : "scenario";
        groups.set(section, [...(groups.get(section) || []), key]);
      }
      for (const [section, group] of groups) {
        const details = element("details", { "data-group": section });
        details.open = open.has(section);
        details.append(element("summary", {}, section), ...group.map((key) => control(key, values[key.path])));
        sections.append(details);
      }
      updateActive();
    },
    /** Returns the changed keys and their values. */
    changes() {
      const set = {};
      for (const [path, control] of controls) {
        if (control.value !== undefined && JSON.stringify(control.value) !== JSON.stringify(control.base)) set[path] = control.value;
      }
      return set;
    },
    /** Sets these keys to these values, and all other keys to the values of the scenario. */
    give(set) {
      for (const [path, control] of controls) {
        control.value = path in set ? set[path] : control.base;
        control.show(control.value);
        mark(control);
      }
      followCombined();
      updateActive();
    },
    put(path, value) {
      put(path, value);
      followCombined(path);
    },
    value: (path) => controls.get(path)?.value,
    /** Shows each error at the control that it names. Returns the other errors. */
    blame(errors) {
      const isOf = (path) => (error) => error.split(/[^\w.-]+/).some((word) => word.replace(/\.$/, "") === path);
      const others = new Set(errors);
      const messages = new Map();
      for (const [path, control] of controls) {
        const ofControl = errors.filter(isOf(path));
        ofControl.forEach((error) => others.delete(error));
        messages.set(control, [...(messages.get(control) ?? []), ...ofControl]);
      }
      for (const [control, ofControl] of messages) fail(control, [...new Set(ofControl)].join(" "));
      return [...others];
    },
    /** Shows only the settings that contain all words in their name, key or meaning. */
    find({ front, sections }, words) {
      const required = words.toLowerCase().split(/\s+/).filter(Boolean);
      const search = (box) => {
        const text = `${box.textContent} ${box.title}`.toLowerCase();
        box.hidden = !required.every((word) => text.includes(word));
        return !box.hidden;
      };
      [...front.children].forEach(search);
      for (const group of sections.children) {
        const shown = [...group.querySelectorAll(".control")].filter(search).length;
        group.hidden = shown === 0;
        if (required.length > 0) group.open = shown > 0;
      }
    },
  };
})();
