// The connection to the server: one WebSocket with JSON messages in both directions and binary frames.
"use strict";

const trocarLink = (() => {
  let socket = null;
  let next = 1;
  let receive = () => {};
  let changed = () => {};

  /** Unpacks a binary message: JSON with a file's content, or with a figure whose lines get their points. */
  function unpacked(buffer) {
    const length = new DataView(buffer).getUint32(0, true);
    const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
    if (head.type === "file") return { ...head, content: new Uint8Array(buffer, 4 + length) };
    const numbers = new Float32Array(buffer, 4 + length);
    for (const { panels } of head.figure.rows) {
      for (const { lines, fills } of panels) {
        for (const one of [...lines, ...fills]) {
          const [from, count] = one.points;
          one.points = [numbers.subarray(from, from + count), numbers.subarray(from + count, from + 2 * count)];
        }
      }
    }
    return head;
  }

  function connect() {
    socket = new WebSocket(`ws://${location.host}/link${location.search}`);
    socket.binaryType = "arraybuffer";
    socket.addEventListener("open", () => changed("connected"));
    socket.addEventListener("message", (event) => {
      const message = typeof event.data === "string" ? JSON.parse(event.data) : unpacked(event.data);
      if (message) receive(message);
    });
    socket.addEventListener("close", () => {
      changed("no connection to the server; reconnecting", true);
      setTimeout(connect, 1500);
    });
  }

  return {
    /** Connects, and reconnects after a loss of the connection. */
    begin(onMessage, onChange) {
      receive = onMessage;
      changed = onChange;
      connect();
    },
    /** Sends a request. Returns its id, or 0 without a connection. */
    ask(request) {
      if (!socket || socket.readyState !== WebSocket.OPEN) return 0;
      const id = next++;
      socket.send(JSON.stringify({ ...request, id }));
      return id;
    },
    /** Sends a message with the id of an earlier request. */
    tell(message) {
      if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
    },
  };
})();
