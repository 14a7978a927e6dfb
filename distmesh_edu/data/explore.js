// The controls of a figure on the page. A picture for every combination of values came with the page.
(function () {
  "use strict";

  const SHORTEST_STEP = 100, LONGEST_STEP = 600; // milliseconds
  const LENGTH_OF_PLAY = 6000;
  const CALM_STEP = 1200; // for readers who asked for less motion
  const calm = window.matchMedia("(prefers-reduced-motion: reduce)");

  function wake(root) {
    const { frames, order, texts } = JSON.parse(root.querySelector(".explore-data").textContent);
    const picture = root.querySelector(".explore-picture");
    const rows = Array.from(root.querySelectorAll(".explore-row"));
    const controls = rows.map((row) => row.querySelector("input, select"));

    // The start frame is in the page already. Held here it stays decoded, so that paper gets it at once.
    const start = new Image();
    start.src = picture.src;
    let playing = null; // { button, timer }

    function show() {
      let number = 0; // of the combination: the last control runs fastest
      controls.forEach((control, i) => {
        number = number * texts[i].length + Number(control.value);
        const output = rows[i].querySelector("output");
        if (output) {
          output.textContent = texts[i][control.value];
          control.setAttribute("aria-valuetext", texts[i][control.value]);
        }
      });
      const frame = frames[order[number]];
      const source = frame === null ? start.src : "data:image/webp;base64," + frame;
      if (picture.src !== source) picture.src = source;
    }

    function say(button, verb) {
      button.classList.toggle("explore-playing", verb === "Pause");
      button.setAttribute("aria-label", verb + " " + button.dataset.label);
    }

    function stop() {
      if (!playing) return;
      window.clearInterval(playing.timer);
      say(playing.button, "Play");
      playing = null;
    }

    function play(button, range) {
      stop(); // one at a time
      const last = Number(range.max);
      if (Number(range.value) === last) {
        range.value = 0;
        show();
      }
      const wish = Math.min(LONGEST_STEP, Math.max(SHORTEST_STEP, LENGTH_OF_PLAY / (last + 1)));
      const timer = window.setInterval(() => {
        range.value = Number(range.value) + 1;
        show();
        if (Number(range.value) >= last) stop();
      }, calm.matches ? CALM_STEP : wish);
      playing = { button, timer };
      say(button, "Pause");
    }

    function paper(printing) {
      stop();
      if (printing) picture.src = start.src;
      else show();
    }

    rows.forEach((row, i) => {
      controls[i].addEventListener("input", () => { stop(); show(); });
      const button = row.querySelector("button");
      if (!button) return;
      button.addEventListener("click", () => {
        if (playing && playing.button === button) stop();
        else play(button, controls[i]);
      });
    });
    window.addEventListener("beforeprint", () => paper(true));
    window.addEventListener("afterprint", () => paper(false));
    window.matchMedia("print").addEventListener("change", (event) => paper(event.matches));

    root.classList.add("explore-awake");
    root.querySelector(".explore-controls").hidden = false;
  }

  // Every figure brings this script. Each copy wakes what sleeps, and leaves the rest alone.
  document.querySelectorAll(".explore:not(.explore-awake)").forEach((root) => {
    if (root.querySelector(".explore-data")) wake(root);
  });
})();
