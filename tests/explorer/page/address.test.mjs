/** The address: a state is read back as written, and unreadable parts have their initial values. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { fragmentOf, stateOf, themeOf } from "eulerdisk/address";
import { firstState, UNSET } from "eulerdisk/state";
import { ABOUT, RATE, TILT } from "./about.mjs";

const FIRST = firstState(ABOUT);

const FULL = {
  view: {
    base: "spinning",
    words: { alpha: 0.8, criterion: "peak_tilt > 1e+1deg & x" },
    x: { name: "gravity", centre: 2.5, half: 0.7000000000000001, scale: "log" },
    y: { name: "tilt", centre: -0.3, half: 1e-10, scale: "linear" },
  },
  quantity: "period",
  stored: false,
  hidden: ["analytic", "measured"],
  range: [-0.5, 50],
  points: [
    { x: 2.4, y: -0.31 },
    { x: 1e-300, y: 5e12 },
  ],
  compare: true,
  motions: [
    { losses: { friction: 0.002, air_law: "bildsten" }, camera: [0.5, -0.9, 8], open: ["laws", "words"] },
    { losses: { mass: 2 }, camera: null, open: ["words"] },
  ],
  time: 1.25,
  speed: 0.2,
  theme: "dark",
};

test("a complete state is read back, with and without a hash", () => {
  assert.deepEqual(stateOf(fragmentOf(FULL), ABOUT), FULL);
  assert.deepEqual(stateOf(`#${fragmentOf(FULL)}`, ABOUT), FULL);
});

test("the initial state has a short address and is read back", () => {
  const fragment = "base=rolling&x=roll_rate,3,1,linear&y=tilt,-4,2,log&quantity=peak_tilt";
  assert.equal(fragmentOf(FIRST), fragment);
  assert.deepEqual(stateOf(fragment, ABOUT), FIRST);
  assert.deepEqual(stateOf("", ABOUT), FIRST);
});

test("the entries of an address have the documented names", () => {
  const entries = Object.fromEntries(new URLSearchParams(fragmentOf(FULL)));
  assert.deepEqual(entries, {
    base: "spinning",
    x: "gravity,2.5,0.7000000000000001,log",
    y: "tilt,-0.3,1e-10,linear",
    "with.alpha": "0.8",
    "with.criterion": "peak_tilt > 1e+1deg & x",
    quantity: "period",
    a: "2.4,-0.31",
    "a.loss.friction": "0.002",
    "a.loss.air_law": "bildsten",
    "a.camera": "0.5,-0.9,8",
    "a.open": "laws,words",
    b: "1e-300,5000000000000",
    "b.loss.mass": "2",
    "b.open": "words",
    time: "1.25",
    speed: "0.2",
    compare: "yes",
    stored: "no",
    hide: "analytic,measured",
    range: "-0.5,50",
    theme: "dark",
  });
  assert.match(fragmentOf(FIRST), /x=roll_rate,3,1/);
});

test("times and cameras have six digits; all other numbers have all digits", () => {
  const third = { ...FULL, time: 1 / 3, points: [{ x: 1 / 3, y: 2 / 3 }, null] };
  third.motions = [{ losses: {}, camera: [1 / 3, 2 / 3, 100 / 3], open: [] }, UNSET];
  const { time, points, motions } = stateOf(fragmentOf(third), ABOUT);
  assert.equal(time, 0.333333);
  assert.deepEqual(points[0], { x: 1 / 3, y: 2 / 3 });
  assert.deepEqual(motions[0].camera, [0.333333, 0.666667, 33.3333]);
});

test("settings of a motion without a start are not written", () => {
  const fragment = fragmentOf({ ...FIRST, motions: [FULL.motions[0], UNSET] });
  assert.equal(fragment, fragmentOf(FIRST));
});

test("encoded and plain special characters are read correctly", () => {
  const { view } = stateOf(
    "x=roll_rate%2C%2B2.5%2C5e-1%2Clinear&y=tilt,-4.5e+0,1.5,log&with.criterion=departure%3A7deg&theme=dark)",
    ABOUT,
  );
  assert.deepEqual(view.x, { ...RATE, centre: 2.5, half: 0.5 });
  assert.deepEqual(view.y, { ...TILT, centre: -4.5, half: 1.5 });
  assert.deepEqual(view.words, { criterion: "departure:7deg" });
  assert.equal(
    stateOf("with.criterion=peak_tilt > 1e+1deg", ABOUT).view.words.criterion,
    "peak_tilt > 1e+1deg",
  );
});

test("two numbers are a point even if their sum overflows", () => {
  assert.deepEqual(stateOf("a=1e308,1.5e308", ABOUT).points[0], { x: 1e308, y: 1.5e308 });
});

/** Addresses with nothing that can be read. */
const SENSELESS = [
  "x=tilt,1,1&y=tilt,1,1",
  "x=roll_rate,2,-1,linear&y=tilt,-4,0,log",
  "base=x&quantity=y&a=1&range=&with.alpha=&with.nothing=1",
  "a=1&hide=<b>,x&theme=pink",
  "time=-1&speed=3",
  "range=50,1",
  "a= , &b=1, &range= ,1&with.alpha= &x=roll_rate, ,1,linear",
  "x=roll_rate,3,1e308,linear",
  "x=roll_rate,-1e13,1,linear",
  "x=roll_rate,nan,1,linear",
  "range=5,5&a=,5&b=1,",
  "range=1,50,7&a=2.4,0.02,1",
  "time=NaN&speed=Infinity",
  "&&==&%zz=%",
  `with.alpha=1&junk=${"x".repeat(20_000)}`,
  `with.criterion=${"9".repeat(201)}`,
  "stored=yes&compare=no&quantity=period",
];

for (const fragment of SENSELESS) {
  test(`nothing is read from ${fragment.slice(0, 60)}`, () => {
    assert.deepEqual(stateOf(fragment, ABOUT), FIRST);
  });
}

/** Unreadable settings of a motion. */
const SENSELESS_OF_A_MOTION = [
  "camera= , ,4",
  "loss.air_law=%20",
  "camera=nan,0,4",
  "camera=0,0,-1",
  "camera=0,0,0",
  "camera=0,0",
  "open=all",
  "loss.nothing=1",
  `loss.friction=${"9".repeat(50)}`,
];

for (const entry of SENSELESS_OF_A_MOTION) {
  test(`${entry.slice(0, 40)} does not set anything of a motion`, () => {
    const { points, motions } = stateOf(`a=2,0.1&a.${entry}`, ABOUT);
    assert.deepEqual(points[0], { x: 2, y: 0.1 });
    assert.deepEqual(motions, [UNSET, UNSET]);
  });
}

test("the theme of an address is known without the rest", () => {
  assert.deepEqual(["theme=dark", "#x=1&theme=light", "theme=pink", ""].map(themeOf), [
    "dark",
    "light",
    "",
    "",
  ]);
});
