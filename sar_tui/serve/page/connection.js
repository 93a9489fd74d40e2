// Keeps the view connected: covers it when it is out of date, says why, and connects again by itself.
"use strict";

{
  const SILENT_MS = 2000;      // the app shows signs of life twice a second
  const STARTING_MS = 30000;   // before its first one it has to start
  const GIVEN_UP_MS = 10000;   // a connection that has been silent for longer is replaced
  const RETRY_MS = 2000;
  const LONGEST_RETRY_MS = 30000;
  const ANSWER = /^\x1b\[\d+;\d+R$/;  // the terminal's answer to the app's question whether it is there
  const RESET = new Uint8Array([0x1b, 0x63]);

  const AGENT = {  // in the language of the participant's browser
    en: { lost: "One moment…", ended: "This view is closed.", waiting: "One moment…", again: "Open it again" },
    de: { lost: "Einen Moment…", ended: "Diese Ansicht ist geschlossen.", waiting: "Einen Moment…", again: "Wieder öffnen" },
    es: { lost: "Un momento…", ended: "La vista se ha cerrado.", waiting: "Un momento…", again: "Abrir de nuevo" },
  };
  const OPERATOR = {
    lost: "The connection is lost. What was shown here is out of date.\nConnecting again …",
    ended: "You have left the session.",
    waiting: "This view has ended.\nIt opens again by itself as soon as it can.",
    again: "Open it again",
  };
  const isAgent = document.body.dataset.kind === "agent";
  const TEXTS = isAgent ? AGENT[navigator.language.slice(0, 2)] ?? AGENT.en : OPERATOR;
  const REFUSED = "The server was started again with another token.\nOpen the address that it has printed now.";

  document.getElementById("again").textContent = TEXTS.again;

  const cover = (text) => {
    document.getElementById("why").textContent = text;
    document.body.classList.add("-covered");
  };
  const uncover = () => document.body.classList.remove("-covered");

  const Socket = window.WebSocket;

  // What textual.js takes for its websocket. It outlives the connections to the server, one after another.
  class ViewSocket extends EventTarget {
    constructor(url) {
      super();
      this.base = new URL(url);
      this.size = null;
      this.count = 0;
      this.failures = 0;
      this.connect();
      window.setInterval(() => this.check(), SILENT_MS / 4);
    }

    // Keys are not sent while the view is covered: nobody should act on what they cannot see.
    send(text) {
      const [kind, content] = JSON.parse(text);
      if (kind === "resize") this.size = content;
      const isAllowed = kind !== "stdin" || ANSWER.test(content) || !document.body.classList.contains("-covered");
      if (isAllowed && this.socket.readyState === Socket.OPEN) this.socket.send(text);
    }

    connect() {
      const url = new URL(this.base);
      const view = this.count === 0 ? url.pathname.split("/").pop() : url.pathname.split("/").pop() + "-" + this.count;
      url.pathname = "/ws/" + view;
      if (this.size !== null) {
        url.searchParams.set("width", this.size.width);
        url.searchParams.set("height", this.size.height);
      }
      this.ended = null;
      this.isAlive = false;
      this.isFresh = this.count > 0;
      this.count += 1;
      this.heardAt = performance.now();
      const socket = new Socket(url);
      this.socket = socket;
      socket.binaryType = "arraybuffer";
      socket.addEventListener("open", () => {
        if (socket === this.socket) this.dispatchEvent(new Event("open"));
      });
      socket.addEventListener("message", (event) => {
        if (socket === this.socket) this.receive(event.data, view);
      });
      socket.addEventListener("close", () => {
        if (socket === this.socket) this.closed();
      });
    }

    receive(data, view) {
      this.heardAt = performance.now();
      if (typeof data === "string") {
        const [kind, content] = JSON.parse(data);
        if (kind === "ended") this.ended = content;
        if (kind === "alive") this.alive(view);
        if (kind === "ended" || kind === "alive") return;
      } else if (this.isFresh) {
        this.isFresh = false;
        this.dispatchEvent(new MessageEvent("message", { data: RESET.buffer }));
      }
      this.dispatchEvent(new MessageEvent("message", { data }));
    }

    alive(view) {
      this.isAlive = true;
      this.failures = 0;
      document.body.classList.add("-alive");
      uncover();
      if (this.view !== view) {
        this.view = view;
        window.dispatchEvent(new CustomEvent("view", { detail: view }));
      }
    }

    check() {
      const silence = performance.now() - this.heardAt;
      if (this.socket === null || silence < (this.isAlive ? SILENT_MS : STARTING_MS)) return;
      cover(TEXTS.lost);
      if (silence > GIVEN_UP_MS) {
        const socket = this.socket;
        this.socket = null;
        socket.close();
        this.retry();
      }
    }

    closed() {
      this.socket = null;
      if (this.ended !== null && !this.ended.failed) {
        cover(TEXTS.ended);
        return;
      }
      if (this.ended !== null && this.ended.why) cover(this.ended.why + "\n\n" + TEXTS.waiting);
      else cover(this.ended !== null ? TEXTS.waiting : TEXTS.lost);
      this.retry();
    }

    retry() {
      const delay = Math.min(LONGEST_RETRY_MS, RETRY_MS * 2 ** Math.min(this.failures, 4));
      window.setTimeout(() => this.retryIfReady(), delay);
    }

    // Starting a view takes the machine a moment, so the server is asked first whether there is something to show.
    async retryIfReady() {
      let status = 0;
      try {
        status = (await fetch("/ready", { cache: "no-store" })).status;
      } catch {
        // the server is not there yet
      }
      if (status === 403) {
        cover(REFUSED);
      } else if (status === 200) {
        this.failures += 1;
        this.connect();
      } else {
        window.setTimeout(() => this.retryIfReady(), RETRY_MS);
      }
    }
  }
  ViewSocket.prototype.socket = null;

  window.WebSocket = new Proxy(Socket, {
    construct: (_, [url]) => (new URL(url).pathname.startsWith("/ws/") ? new ViewSocket(url) : new Socket(url)),
  });
}
