// The controls: a slider, a switch or a list for every key that the page can set. Frequently used keys come first.
"use strict";

const trocarControls = (() => {
  const FIRST = {
    "Scales": ["scaling.force", "scaling.position"],
    "Tissue": ["tissue.kind", "tissue.index", "tissue.stiffness_n_per_m", "tissue.damping_n_s_per_m", "tissue.mu", "tissue.lambda", "tissue.power", "tissue.contact_m"],
    "Hand": ["arm.k_h_n_per_m", "arm.b_h_n_s_per_m", "arm.m_h_kg", "operator.speed_m_per_s", "operator.movement_s", "operator.tremor_amplitude_m", "operator.reflex"],
    "Detection": ["detector.threshold", "detector.drift", "estimator.contact_m"],
    "Hold and force": ["augmentation.min_hold_s", "augmentation.max_hold_s", "augmentation.freeze", "augmentation.force_law", "augmentation.decay_ratio", "augmentation.amplification"],
    "Re-engagement": ["augmentation.reengage", "augmentation.catch_up_speed_m_per_s", "augmentation.blend_s"],
    "Delay and noise": ["channel.forward_delay_s", "channel.backward_delay_s", "channel.jitter_s", "channel.loss", "sensor.force_noise_std_n", "simulation.seed"],
  };
  /** Fixed ranges of sliders: from, to. */
  const RANGES = {
    "scaling.force": [0, 5],
    "scaling.position": [0.1, 4],
    "channel.forward_delay_s": [0, 0.1],
    "channel.backward_delay_s": [0, 0.1],
    "channel.jitter_s": [0, 0.02],
    "channel.loss": [0, 0.5],
    "sensor.force_noise_std_n": [0, 0.2],
    "augmentation.min_hold_s": [0, 2],
    "augmentation.max_hold_s": [0, 5],
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
  let changed = () => {};

  /** Returns the conversions between position and value of a slider, or null without a range. */
  function scale(key, value) {
    const known = RANGES[key.path];
    if (known) {
      const [low, high] = [Math.min(known[0], value), Math.max(known[1], value)];
      return { at: (v) => ((v - low) / (high - low)) * STEPS, value: (at) => low + ((high - low) * at) / STEPS };
    }
    if (!(value > 0)) return null;
    const low = Math.max(value / 10, key.kind.low > 0 ? key.kind.low : 0);
    const high = Math.min(value * 10, key.kind.high ?? Infinity);
    if (!(high > low)) return null;
    const ratio = Math.log(high / low);
    return { at: (v) => (Math.log(v / low) / ratio) * STEPS, value: (at) => low * Math.exp((ratio * at) / STEPS) };
  }

  const rounded = (value) => Number(value.toPrecision(3));

  function element(name, attributes = {}, text = "") {
    const made = document.createElement(name);
    for (const [attribute, value] of Object.entries(attributes)) made.setAttribute(attribute, value);
    if (text) made.textContent = text;
    return made;
  }

  /** Returns the control of a key. */
  function control(key, base) {
    const box = element("div", { class: "control", "data-key": key.path });
    const id = `key-${key.path.replaceAll(".", "-")}`;
    const name = element("div", { class: "name" });
    name.append(element("label", { for: id }, key.path));
    const back = element("button", { type: "button", title: `reset to ${JSON.stringify(base ?? null)}`, "aria-label": `Reset ${key.path}` }, "reset");
    name.append(back);
    const inputs = element("div", { class: "inputs" });
    const meaning = element("p", { class: "meaning", id: `${id}-meaning` }, key.meaning);
    const made = { key, base, value: base, box, show: () => {} };
    const give = (value, input) => {
      made.value = value;
      mark(made);
      changed(key.path, input);
    };
    back.addEventListener("click", () => {
      made.show(made.base);
      give(made.base);
      // The button becomes hidden, so the focus moves to the control of this key.
      inputs.firstElementChild.focus();
    });
    if (key.kind.type === "flag") {
      const input = element("input", { type: "checkbox", id, "aria-describedby": meaning.id });
      input.addEventListener("input", () => give(input.checked, performance.now()));
      made.show = (value) => { input.checked = value === true; };
      inputs.append(input);
    } else if (key.kind.type === "choice") {
      const input = element("select", { id, "aria-describedby": meaning.id });
      for (const choice of key.kind.choices) input.append(element("option", { value: JSON.stringify(choice) }, String(choice)));
      input.addEventListener("input", () => give(JSON.parse(input.value), performance.now()));
      made.show = (value) => { input.value = JSON.stringify(value); };
      inputs.append(input);
    } else if (key.kind.type === "numbers") {
      const input = element("input", { type: "text", id, "aria-describedby": meaning.id, placeholder: "1, 2.5, 4" });
      input.addEventListener("change", () => {
        const numbers = input.value.split(/[,;\s]+/).filter(Boolean).map(Number);
        box.classList.toggle("wrong", numbers.some((number) => !Number.isFinite(number)));
        if (numbers.some((number) => !Number.isFinite(number))) return;
        if (numbers.length === 0) made.show(made.base);
        give(numbers.length ? numbers : made.base, performance.now());
      });
      made.show = (value) => { input.value = Array.isArray(value) ? value.join(", ") : ""; };
      inputs.append(input);
    } else {
      const whole = key.kind.type === "whole";
      const sliding = scale(key, typeof base === "number" ? base : NaN);
      const number = element("input", { type: "number", step: "any", id: sliding ? `${id}-number` : id, "aria-label": `${key.path}, as a number`, "aria-describedby": meaning.id });
      const slider = sliding && element("input", { type: "range", id, min: "0", max: String(STEPS), step: "any", "aria-describedby": meaning.id });
      const shape = (value) => (whole ? Math.max(0, Math.round(value)) : rounded(value));
      if (slider) {
        slider.addEventListener("input", () => {
          const value = shape(sliding.value(Number(slider.value)));
          number.value = value;
          slider.setAttribute("aria-valuetext", String(value));
          give(value, performance.now());
        });
        slider.addEventListener("keydown", (event) => {
          // An arrow key moves by 1 % of the range, Page Up and Page Down by 10 %.
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
        const given = Number(number.value);
        // A browser empties what is no number: it is wrong, and not the default.
        const isWrong = number.validity.badInput || !Number.isFinite(given);
        box.classList.toggle("wrong", isWrong);
        number.setCustomValidity(isWrong ? "not a number" : "");
        if (isWrong) {
          number.reportValidity();
          return;
        }
        const value = number.value === "" ? made.base : whole ? Math.round(given) : given;
        made.show(value);
        give(value, performance.now());
      });
      made.show = (value) => {
        number.value = value ?? "";
        if (slider && typeof value === "number") {
          // A value beyond the range, such as 0 on a logarithmic slider, is at the end of the slider.
          slider.value = Math.min(STEPS, Math.max(0, sliding.at(value) || 0));
          slider.setAttribute("aria-valuetext", String(value));
        }
      };
      inputs.append(number);
    }
    made.show(base);
    box.append(name, inputs, meaning);
    controls.set(key.path, made);
    return box;
  }

  function mark(made) {
    made.box.classList.toggle("changed", JSON.stringify(made.value) !== JSON.stringify(made.base));
    made.box.classList.remove("wrong");
  }

  return {
    /** Draws every control with the values of a scenario. Changes call `onChange(path, time of the input)`. */
    draw(form, keys, values, onChange) {
      const open = new Set([...form.querySelectorAll("details[open]")].map((group) => group.dataset.group));
      const first = form.children.length === 0;
      // In a narrow window the signals are below the controls, so fewer groups are open.
      const narrow = window.matchMedia("(max-width: 60rem)").matches;
      form.replaceChildren();
      controls.clear();
      changed = onChange;
      const byPath = new Map(keys.map((key) => [key.path, key]));
      const placed = new Set();
      const group = (title, paths, isOpen) => {
        const keysHere = paths.filter((path) => byPath.has(path) && !placed.has(path));
        if (keysHere.length === 0) return;
        const details = element("details", { "data-group": title });
        details.open = first ? isOpen && (title === "Scales" || !narrow) : open.has(title);
        details.append(element("summary", {}, title));
        for (const path of keysHere) {
          placed.add(path);
          details.append(control(byPath.get(path), values[path]));
        }
        form.append(details);
      };
      // Keys without a value in this scenario are in the sections below.
      for (const [title, paths] of Object.entries(FIRST)) {
        group(title, paths.filter((path) => path in values), ["Scales", "Hold and force", "Delay and noise"].includes(title));
      }
      const sections = new Map();
      for (const key of keys) {
        const section = key.path.includes(".") ? key.path.split(".")[0] : "scenario";
        sections.set(section, [...(sections.get(section) || []), key.path]);
      }
      for (const [section, paths] of sections) group(`[${section}]`, paths, false);
    },
    /** Returns the changed keys and their values. */
    changes() {
      const set = {};
      for (const [path, made] of controls) {
        if (made.value !== undefined && JSON.stringify(made.value) !== JSON.stringify(made.base)) set[path] = made.value;
      }
      return set;
    },
    /** Sets keys to these values, and all others to the values of the scenario. */
    give(set) {
      for (const [path, made] of controls) {
        made.value = path in set ? set[path] : made.base;
        made.show(made.value);
        mark(made);
      }
    },
    /** Sets the value of a key. */
    put(path, value) {
      const made = controls.get(path);
      if (!made) return;
      made.value = value;
      made.show(value);
      mark(made);
    },
    value: (path) => controls.get(path)?.value,
    /** Marks the controls that an error message names. */
    blame(message) {
      for (const [path, made] of controls) made.box.classList.toggle("wrong", message.includes(path));
    },
    /** Shows only the controls whose key or meaning contains all words. */
    find(form, words) {
      const required = words.toLowerCase().split(/\s+/).filter(Boolean);
      for (const group of form.querySelectorAll("details")) {
        let shown = 0;
        for (const box of group.querySelectorAll(".control")) {
          const text = box.textContent.toLowerCase();
          const fits = required.every((word) => text.includes(word));
          box.hidden = !fits;
          shown += fits ? 1 : 0;
        }
        group.hidden = shown === 0;
        if (required.length > 0) group.open = shown > 0;
      }
    },
  };
})();
