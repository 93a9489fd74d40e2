// Sets the terminal's websocket, font size and focus.
"use strict";

{
  const terminal = document.getElementById("terminal");
  const origin = window.location.origin.replace(/^http/, "ws");
  terminal.dataset.sessionWebsocketUrl = origin + "/ws/" + terminal.dataset.view;

  // The agent is seen from across a table: about 42 columns and 15 lines fill the screen.
  if (document.body.dataset.kind === "agent") {
    const size = Math.min(window.innerWidth / (42 * 0.6), window.innerHeight / (15 * 1.35));
    terminal.dataset.fontSize = String(Math.max(16, Math.floor(size)));
  }

  const focus = () => terminal.querySelector("textarea")?.focus();
  window.addEventListener("load", focus);
  window.addEventListener("focus", focus);
  document.getElementById("again").addEventListener("click", () => window.location.reload());
}
