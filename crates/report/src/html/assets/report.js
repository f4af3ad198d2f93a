// A report: draws the figures from the page's data, and handles its buttons.
"use strict";

(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const byName = new Map();
  const status = document.getElementById("status");

  function drawFigures(place) {
    const { name } = place.dataset;
    // The charts of a sweep have different axes.
    const group = ["axes", "maps"].includes(name) ? null : name;
    byName.set(name, data.figures[name].flatMap((figure) => trocarCharts.figure(place, figure, group)));
  }

  function windows(bar) {
    const buttons = [...bar.querySelectorAll("button")];
    const show = (button) => {
      const [first] = byName.get(bar.dataset.of) || [];
      if (!first) return;
      first.zoom("all" in button.dataset ? null : { low: Number(button.dataset.from), high: Number(button.dataset.to) });
      buttons.forEach((other) => other.setAttribute("aria-pressed", String(other === button)));
    };
    buttons.forEach((button) => button.addEventListener("click", () => show(button)));
    bar.hidden = false;
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
  const recoloured = () => window.dispatchEvent(new Event("themechange"));
  function theme() {
    const button = document.getElementById("theme");
    button.hidden = false;
    button.addEventListener("click", () => {
      const next = THEMES[(THEMES.indexOf(root.dataset.theme ?? "system") + 1) % THEMES.length];
      if (next === "system") delete root.dataset.theme;
      else root.dataset.theme = next;
      button.textContent = `Theme: ${next}`;
      recoloured();
    });
  }

  /** Prepares printing: light theme, width of half a page, all details open. */
  function printing() {
    const CHART = [325, 170];
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
      before.charts = [...byName.values()].flat().map((chart) => ({ chart, size: [chart.width, chart.height] }));
      before.charts.forEach(({ chart }) => chart.resize(...CHART));
    });
    window.addEventListener("afterprint", () => {
      if (!before) return;
      before.folded.forEach((details) => {
        details.open = false;
      });
      if (before.theme) root.dataset.theme = before.theme;
      else delete root.dataset.theme;
      before.charts.forEach(({ chart, size }) => chart.resize(...size));
      before = null;
      recoloured();
    });
  }

  if (data.animation) new trocarAnimation.Player(document.getElementById("animation")).setData(data.animation);
  document.querySelectorAll(".charts").forEach(drawFigures);
  document.querySelectorAll(".windows").forEach(windows);
  buttons();
  theme();
  printing();
})();
