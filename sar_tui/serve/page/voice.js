// Speaks for the agent with the browser's own voice, once the button has been pressed.
"use strict";

if (document.body.dataset.kind === "agent" && "speechSynthesis" in window) {
  const button = document.getElementById("speak");
  const origin = window.location.origin.replace(/^http/, "ws");

  // Only local voices: others send the text to the browser's maker.
  const voiceOf = (language) => {
    const local = speechSynthesis.getVoices().filter((voice) => voice.localService);
    const tag = (voice) => voice.lang.toLowerCase().replace("_", "-");
    const wanted = language.toLowerCase();
    return local.find((voice) => tag(voice) === wanted) ??
      local.find((voice) => tag(voice).split("-")[0] === wanted.split("-")[0]);
  };

  const show = (text) => {
    button.textContent = text;
    button.hidden = false;
  };

  const speak = (message) => {
    if (message.hush) {
      speechSynthesis.cancel();
      return;
    }
    const voice = voiceOf(message.language);
    if (voice === undefined) {
      show("This device has no voice for " + message.language);
      return;
    }
    const utterance = new SpeechSynthesisUtterance(message.say);
    utterance.voice = voice;
    utterance.lang = voice.lang;
    speechSynthesis.speak(utterance);
  };

  let view = document.getElementById("terminal").dataset.view;
  let isAllowed = false;
  let socket = null;

  // A browser speaks only after a touch, which counts for as long as the page is open.
  const listen = () => {
    const listening = new WebSocket(origin + "/voice/" + view);
    socket = listening;
    listening.addEventListener("message", (event) => speak(JSON.parse(event.data)));
    listening.addEventListener("close", () => {
      speechSynthesis.cancel();
      if (listening === socket) {
        socket = null;
        show("Let it speak");
      }
    });
  };

  const allow = () => {
    button.hidden = true;
    isAllowed = true;
    speechSynthesis.speak(new SpeechSynthesisUtterance(""));
    listen();
  };

  button.addEventListener("click", allow);
  window.addEventListener("view", (event) => {
    const isOther = view !== event.detail;
    view = event.detail;
    if (isOther && isAllowed) {
      button.hidden = true;
      listen();
    }
  });
  speechSynthesis.getVoices();
  button.hidden = false;
}
