// The signals of both runs, and the table of metrics.
"use strict";

const trocarPictures = (() => {
  const GROUP = "signals";
  /** The lines of each chart: the run (0 classical, 1 augmented), its column, and its style. */
  const CHARTS = [
    {
      id: "chart-position", title: "Position, mm", height: 200, y: { label: "", unit: "mm" },
      lines: [
        [1, "master_position_mm", { label: "hand, augmented", colour: "green", width: 1.5, dash: [2, 4] }],
        [0, "slave_position_mm", { label: "needle, classical", colour: "blue", width: 2, dash: [9, 6] }],
        [1, "slave_position_mm", { label: "needle, augmented", colour: "vermilion", width: 2.25 }],
      ],
    },
    {
      id: "chart-force", title: "Force on the hand, N", height: 200, y: { label: "", unit: "N" },
      lines: [
        [0, "operator_force_n", { label: "classical", colour: "blue", width: 2, dash: [9, 6] }],
        [1, "operator_force_n", { label: "augmented", colour: "vermilion", width: 2.25 }],
        [1, "tissue_force_n", { label: "tissue", colour: "sky", width: 3, show: false }],
        [1, "feedback_force_n", { label: "feedback", colour: "purple", width: 1.25, show: false }],
      ],
    },
    {
      id: "chart-decision", title: "Decision function and its threshold", height: 200, y: { label: "g", unit: "", named: true },
      lines: [
        [0, "decision", { label: "g, classical", colour: "blue", width: 1.75, dash: [9, 6] }],
        [1, "decision", { label: "g, augmented", colour: "vermilion", width: 2 }],
      ],
    },
    {
      id: "chart-stiffness", title: "Estimated stiffness", height: 200, y: { label: "K", unit: "N/m", named: true },
      lines: [
        [0, "stiffness_n_per_m", { label: "K, classical", colour: "blue", width: 1.75, dash: [9, 6] }],
        [1, "stiffness_n_per_m", { label: "K, augmented", colour: "vermilion", width: 2 }],
      ],
    },
    {
      id: "chart-mode", title: "Mode of the augmented run", height: 150,
      y: {
        label: "mode", unit: "", range: () => [-0.3, 2.3],
        ticks: [{ at: 0, label: "teleoperation" }, { at: 1, label: "frozen" }, { at: 2, label: "re-engaging" }],
      },
      lines: [[1, "mode", { label: "mode", colour: "vermilion", width: 2, stepped: true }]],
    },
  ];
  let charts = null;
  let last = null;

  function extras(frame, chart) {
    const [classical, augmented] = frame.runs;
    const shades = augmented.modes.map(([from, to, mode]) => ({ from, to, name: mode === 1 ? "augmented" : "reengaging" }));
    const ruptures = new Set([...classical.ruptures_s, ...augmented.ruptures_s]);
    const marks = [...ruptures].map((at) => ({ at, kind: "rupture" }));
    marks.push(...augmented.alarms.map(([at]) => ({ at, kind: "alarm" })));
    const zoomed = frame.window_s && { min: frame.window_s[0], max: frame.window_s[1] };
    return { shades, marks, whole: frame.whole_s, zoomed, thresholds: chart.id === "chart-decision" ? [{ value: augmented.threshold }] : [] };
  }

  function columns(frame, chart) {
    return [frame.time_s, ...chart.lines.map(([run, column]) => frame.runs[run].lines[column])];
  }

  /** Draws a frame. The first frame creates the charts, one in each parent and the others in the last; later frames update them. */
  function draw(parents, frame) {
    last = frame;
    if (charts === null) {
      charts = CHARTS.map((chart, index) => {
        const parent = parents[Math.min(index, parents.length - 1)];
        const spec = { ...chart, group: GROUP, x: { label: "time", unit: "s" }, series: chart.lines.map((line) => line[2]) };
        return trocarCharts.chart(parent, spec, columns(frame, chart), extras(frame, chart));
      });
      return;
    }
    charts.forEach((chart, index) => chart.update(columns(frame, CHARTS[index]), extras(frame, CHARTS[index])));
  }

  /** Draws the table of `compare`. Only changed cells are set, to reduce layout. */
  function table(body, { rows }) {
    while (body.rows.length > rows.length) body.lastElementChild.remove();
    rows.forEach((row, at) => {
      const line = body.rows[at] ?? body.insertRow();
      row.cells.forEach((cell, index) => {
        let made = line.children[index];
        if (!made) {
          made = document.createElement(index === 0 ? "th" : "td");
          if (index === 0) made.scope = "row";
          line.append(made);
        }
        if (made.textContent !== cell) made.textContent = cell;
      });
    });
  }

  /** Returns the charts of one run (0 classical, 1 augmented) in one image with a width in pixels, or 0 for that of the page. */
  async function png(title, run, width) {
    const ratio = window.devicePixelRatio || 1;
    const before = charts.map(({ plot }) => ({ width: plot.width, height: plot.height, shown: plot.series.map((one) => one.show) }));
    charts.forEach((chart, index) => {
      chart.flush();
      CHARTS[index].lines.forEach(([of], line) => of !== run && chart.plot.setSeries(line + 1, { show: false }));
      if (width > 0) chart.plot.setSize({ width: width / ratio, height: (0.45 * width) / ratio });
    });
    try {
      return await image(title, charts.filter((_, index) => CHARTS[index].lines.some(([of]) => of === run)));
    } finally {
      charts.forEach(({ plot }, index) => {
        before[index].shown.forEach((show, line) => line > 0 && plot.setSeries(line, { show }));
        plot.setSize(before[index]);
      });
    }
  }

  async function image(title, drawn) {
    // uPlot draws at the end of the task that gave it data.
    await Promise.resolve();
    const ratio = window.devicePixelRatio || 1;
    const sources = drawn.map((chart) => chart.plot.ctx.canvas);
    const head = 34 * ratio;
    const canvas = document.createElement("canvas");
    canvas.width = Math.max(...sources.map((source) => source.width));
    canvas.height = sources.reduce((sum, source) => sum + source.height + head, head);
    const context = canvas.getContext("2d");
    context.fillStyle = trocarCharts.colour("page");
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.fillStyle = trocarCharts.colour("ink");
    context.font = `bold ${15 * ratio}px system-ui, "DejaVu Sans", sans-serif`;
    context.fillText(title, 10 * ratio, 22 * ratio);
    let top = head;
    drawn.forEach((chart, index) => {
      const spec = CHARTS[charts.indexOf(chart)];
      context.font = `bold ${13 * ratio}px system-ui, "DejaVu Sans", sans-serif`;
      context.fillStyle = trocarCharts.colour("ink");
      context.fillText(spec.title, 10 * ratio, top + 20 * ratio);
      let left = (30 + 9 * spec.title.length) * ratio;
      context.font = `${12 * ratio}px system-ui, "DejaVu Sans", sans-serif`;
      chart.plot.series.slice(1).forEach((series, line) => {
        if (!series.show) return;
        const { label, colour } = spec.lines[line][2];
        context.fillStyle = trocarCharts.colour(colour);
        context.fillRect(left, top + 14 * ratio, 18 * ratio, 4 * ratio);
        context.fillStyle = trocarCharts.colour("ink");
        context.fillText(label, left + 24 * ratio, top + 20 * ratio);
        left += 34 * ratio + context.measureText(label).width;
      });
      context.drawImage(sources[index], 0, top + head);
      top += sources[index].height + head;
    });
    const blob = await new Promise((done) => canvas.toBlob(done, "image/png"));
    return { blob, width: canvas.width };
  }

  return {
    GROUP,
    draw,
    table,
    png,
    frame: () => last,
    /** Moves the cursor of the charts to a time. */
    point(time_s) {
      if (charts === null) return;
      const { plot } = charts[0];
      plot.setCursor({ left: plot.valToPos(time_s, "x"), top: 10 }, true, true);
    },
  };
})();
