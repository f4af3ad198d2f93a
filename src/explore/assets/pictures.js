// The signals of both runs, drawn from the description of their figure, and the table of metrics.
"use strict";

const trocarPictures = (() => {
  const GROUP = "signals";
  let charts = null;
  let last = null;
  /** The element with the legend of the marks. */
  const key = document.getElementById("key");

  /** Draws a frame. The first frame creates the charts, one per parent with the remaining charts in the last parent;
   *  later frames update them. */
  function draw(parents, frame) {
    last = frame;
    trocarCharts.key(key, frame.figure);
    const panels = frame.figure.rows.flatMap((row) => row.panels);
    if (charts?.length === panels.length) {
      charts.forEach((chart, index) => chart.update(panels[index], frame.whole_s));
      return;
    }
    charts?.forEach((chart) => chart.remove());
    charts = panels.map((panel, index) => {
      const parent = parents[Math.min(index, parents.length - 1)];
      return new trocarCharts.Chart(parent, panel, { group: GROUP, whole: frame.whole_s });
    });
  }

  /** Draws the table of `compare`. It sets only changed cells, to reduce layout. */
  function table(body, { rows }) {
    while (body.rows.length > rows.length) body.lastElementChild.remove();
    rows.forEach((row, at) => {
      const line = body.rows[at] ?? body.insertRow();
      row.cells.forEach((cell, index) => {
        let node = line.children[index];
        if (!node) {
          node = document.createElement(index === 0 ? "th" : "td");
          if (index === 0) node.scope = "row";
          line.append(node);
        }
        if (node.textContent !== cell) node.textContent = cell;
      });
    });
  }

  return {
    GROUP,
    draw,
    table,
    frame: () => last,
    /** Returns the panel with an id, such as "feedback-force". */
    panel: (id) => last.figure.rows.flatMap((row) => row.panels).find((panel) => panel.id === id),
    point: (x) => charts?.[0].point({ x, y: null }),
  };
})();
