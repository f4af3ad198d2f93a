// The link to the program: one WebSocket, JSON both ways, and frames of numbers.
"use strict";

const trocarLink = (() => {
  let socket = null;
  let next = 1;
  let hear = () => {};
  let changed = () => {};

  /** A frame's head and its lines by name: times_s, then for each run an object of columns. */
  function unpacked(buffer) {
    const length = new DataView(buffer).getUint32(0, true);
    const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
    const numbers = new Float32Array(buffer, 4 + length);
    // Where a run has diverged there are gaps, which charts want as null; else the numbers are taken as they are.
    const gaps = head.runs.some((run) => run.diverged_s !== null);
    const line = (index) => {
      const raw = numbers.subarray(index * head.points, (index + 1) * head.points);
      return gaps ? Array.from(raw, (value) => (Number.isFinite(value) ? value : null)) : raw;
    };
    const width = head.columns.length;
    head.time_s = line(0);
    head.runs.forEach((run, which) => {
      run.lines = {};
      head.columns.forEach((name, column) => {
        run.lines[name] = line(1 + which * width + column);
      });
    });
    return head;
  }

  function connect() {
    let opened = false;
    socket = new WebSocket(`ws://${location.host}/link`);
    socket.binaryType = "arraybuffer";
    socket.addEventListener("open", () => {
      opened = true;
      changed("connected");
    });
    socket.addEventListener("message", (event) => {
      const told = typeof event.data === "string" ? JSON.parse(event.data) : unpacked(event.data);
      if (told) hear(told);
    });
    socket.addEventListener("close", (event) => {
      changed(event.reason ? `ended: ${event.reason}` : "the program is not there; trying again");
      if (!opened) {
        // It answers, and takes no further page.
        const full = (answer) => answer.ok && changed("the program takes no more pages: close another one; trying again");
        fetch("/icon.svg").then(full, () => {});
      }
      setTimeout(connect, 1500);
    });
  }

  return {
    /** Connects, and again whenever the connection is lost. */
    begin(onMessage, onChange) {
      hear = onMessage;
      changed = onChange;
      connect();
    },
    /** Sends a wish; gives its number, 0 where nobody hears it. */
    ask(wish) {
      if (!socket || socket.readyState !== WebSocket.OPEN) return 0;
      const id = next++;
      socket.send(JSON.stringify({ ...wish, id }));
      return id;
    },
    /** Sends what has no answer. */
    tell(wish) {
      if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(wish));
    },
  };
})();
