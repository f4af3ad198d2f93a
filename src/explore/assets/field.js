// The page of a link: its pointer moves the operator's hand on the master.
"use strict";

const trocarField = (() => {
  const part = (id) => document.getElementById(id);
  trocarPush.begin({
    button: part("push"), field: part("field"), strips: part("pushed"), text: part("push-text"), lamp: part("lamp"), sound: part("push-sound"),
    // The command line sets the scenario.
    scheme: { value: "0" }, state: () => null,
  });
  trocarLink.begin(
    (message) => {
      if (message.type === "refused") {
        trocarPush.refused(message.id);
        part("push-text").textContent = message.message;
      } else trocarPush.receive(message);
    },
    (text) => {
      part("status").textContent = text;
      if (text !== "connected") trocarPush.leave("the link has ended");
    },
  );
  return { state: trocarPush.state };
})();
