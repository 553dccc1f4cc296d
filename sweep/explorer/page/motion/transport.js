/** Play, pause, the place in time and the speed: the controls of the clock, which all panels share. */

import { html } from "eulerdisk/html";
import { SPEEDS } from "eulerdisk/motion/clock";
import { svg } from "eulerdisk/svg";

/** @typedef {import("eulerdisk/motion/clock").Clock} Clock */

/** What the button does, drawn: not every font has signs for it. */
const SIGNS = { pause: "M3 2h4v12H3zM9 2h4v12H9z", play: "M4 2l10 6-10 6z" };

/** Steps of the slider of time. */
const STEPS = 1000;

export class Transport {
  /**
   * @param {HTMLElement} element
   * @param {Clock} clock
   */
  constructor(element, clock) {
    this.clock = clock;
    this.button = html("button", { type: "button", class: "play" });
    this.button.addEventListener("click", () => (clock.playing ? clock.pause() : clock.play()));
    this.slide = html("input", {
      type: "range",
      min: "0",
      max: String(STEPS),
      class: "time",
      "aria-label": "time",
    });
    this.slide.addEventListener("input", () => clock.seek((Number(this.slide.value) / STEPS) * clock.length));
    this.said = html("output", { class: "now" });
    const options = SPEEDS.map((speed) => html("option", { value: String(speed) }, `${speed}\u00d7`));
    this.speed = html(
      "select",
      { "aria-label": "speed", title: "seconds of the motion in a second" },
      ...options,
    );
    this.speed.addEventListener("change", () => clock.setSpeed(Number(this.speed.value)));
    element.append(this.button, this.slide, this.said, this.speed);
    this.follow();
  }

  /** Show where the clock is. */
  follow() {
    const { playing, time, length, speed } = this.clock;
    const word = playing ? "pause" : "play";
    if (this.button.dataset.does !== word) {
      this.button.dataset.does = word;
      this.button.setAttribute("aria-label", word);
      const sign = svg("path", { d: SIGNS[word], fill: "currentColor" });
      const size = { viewBox: "0 0 16 16", width: 14, height: 14, "aria-hidden": "true" };
      this.button.replaceChildren(svg("svg", size, sign));
    }
    this.slide.value = String(length > 0 ? Math.round((time / length) * STEPS) : 0);
    const digits = Math.max(0, 2 - Math.floor(Math.log10(Math.max(length, 1e-6))));
    const text = `${time.toFixed(digits)} s`;
    this.said.textContent = text;
    this.slide.setAttribute("aria-valuetext", text);
    this.speed.value = String(speed);
  }
}
