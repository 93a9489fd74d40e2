// The browser's own voice, for the agent: it speaks what it is told, once somebody has allowed it with the button.
"use strict";

if (document.body.dataset.kind === "agent" && "speechSynthesis" in window) {
  const button = document.getElementById("speak");
  const view = document.getElementById("terminal").dataset.view;
  const origin = window.location.origin.replace(/^http/, "ws");

  // Only voices of this device: others would send the words to whoever makes the browser.
  const voiceOf = (language) => {
    const own = speechSynthesis.getVoices().filter((voice) => voice.localService);
    const named = (voice) => voice.lang.toLowerCase().replace("_", "-");
    const wanted = language.toLowerCase();
    return own.find((voice) => named(voice) === wanted) ??
      own.find((voice) => named(voice).split("-")[0] === wanted.split("-")[0]);
  };

  const tell = (words) => {
    button.textContent = words;
    button.hidden = false;
  };

  const speak = (told) => {
    if (told.hush) {
      speechSynthesis.cancel();
      return;
    }
    const voice = voiceOf(told.language);
    if (voice === undefined) {
      tell("This device has no voice for " + told.language);
      return;
    }
    const utterance = new SpeechSynthesisUtterance(told.say);
    utterance.voice = voice;
    utterance.lang = voice.lang;
    speechSynthesis.speak(utterance);
  };

  button.addEventListener("click", () => {
    button.hidden = true;
    speechSynthesis.speak(new SpeechSynthesisUtterance(""));
    const socket = new WebSocket(origin + "/voice/" + view);
    socket.addEventListener("message", (event) => speak(JSON.parse(event.data)));
    socket.addEventListener("close", () => {
      speechSynthesis.cancel();
      tell("Let it speak");
    });
  });
  speechSynthesis.getVoices();
  button.hidden = false;
}
