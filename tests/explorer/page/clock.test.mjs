/** The clock of motions: it plays, pauses, is held, and has a speed that suits the length. */

import assert from "node:assert/strict";
import { afterEach, test } from "node:test";
import { Clock, SPEEDS } from "eulerdisk/motion/clock";

let frames = [];
globalThis.requestAnimationFrame = (deed) => frames.push(deed);
globalThis.cancelAnimationFrame = () => (frames = []);
const frame = (now) => frames.shift()(now);
afterEach(() => (frames = []));

/** A clock with a motion of this length [s]. */
function clockOf(length) {
  const clock = new Clock();
  clock.enter("A", length);
  return clock;
}

test("a motion continues where it was paused, and no frame lasts more than a tenth of a second", () => {
  const clock = clockOf(9);
  clock.play();
  const times = [1000, 1050, 1090].map((now) => (frame(now), clock.time));
  clock.pause();
  assert.equal(frames.length, 0);
  clock.play();
  times.push(...[60_000, 60_040, 70_000].map((now) => (frame(now), clock.time)));
  [0, 0.05, 0.09, 0.09, 0.13, 0.23].forEach((time, i) => assert.ok(Math.abs(times[i] - time) < 1e-12));
});

test("it stops with the longest motion and restarts after its end", () => {
  const clock = clockOf(1);
  clock.enter("B", 2);
  clock.setSpeed(50);
  assert.equal(clock.length, 2);
  clock.play();
  frame(1000);
  frame(1100);
  assert.deepEqual([clock.time, clock.playing, frames.length], [2, false, 0]);
  clock.play();
  assert.deepEqual([clock.time, clock.playing], [0, true]);
});

test("a motion takes about nine seconds, unless a speed is chosen", () => {
  const speed = (length) => clockOf(length).speed;
  assert.deepEqual([9, 0.09, 120, 4.5, 1e6, 1e-6].map(speed), [1, 0.02, 10, 0.5, 50, 0.02]);
  const clock = clockOf(9);
  clock.setSpeed(0.2);
  assert.equal(clock.speed, 0.2);
  clock.setSpeed(null);
  assert.equal(clock.speed, 1);
  assert.deepEqual(
    SPEEDS.toSorted((a, b) => a - b),
    SPEEDS,
  );
});

test("a time is kept within the motion; if the motion leaves, the clock is reset", () => {
  const clock = clockOf(5);
  const times = [-1, 3, 9].map((time) => (clock.seek(time), clock.time));
  assert.deepEqual(times, [0, 3, 5]);
  clock.enter("A", 4);
  assert.equal(clock.time, 4);
  clock.leave("A");
  assert.deepEqual([clock.time, clock.length, clock.playing], [0, 0, false]);
  clock.play();
  assert.equal(clock.playing, false);
});

test("a held clock stands although motions start, until it is moved or plays", () => {
  const clock = clockOf(5);
  clock.play();
  clock.hold(1.25);
  assert.deepEqual([clock.playing, clock.time, clock.standing], [false, 1.25, 1.25]);
  clock.begin(true);
  assert.deepEqual([clock.playing, clock.time], [false, 1.25]);
  clock.seek(2);
  clock.begin(true);
  assert.deepEqual([clock.playing, clock.time], [true, 0]);
  clock.hold(3);
  clock.hold(null);
  clock.begin(false);
  assert.deepEqual([clock.playing, clock.time], [false, 0]);
});

test("an address gets a time only if the clock stands between start and end", () => {
  const clock = clockOf(5);
  assert.equal(clock.standing, null);
  clock.seek(2);
  assert.equal(clock.standing, 2);
  clock.play();
  assert.equal(clock.standing, null);
  clock.pause();
  clock.seek(5);
  assert.equal(clock.standing, null);
  // held before its motion arrives
  const early = new Clock();
  early.hold(7);
  assert.equal(early.standing, 7);
});

test("listeners are called after every change", () => {
  const clock = new Clock();
  let calls = 0;
  clock.listen(() => (calls += 1));
  for (const deed of [
    () => clock.enter("A", 5),
    () => clock.seek(1),
    () => clock.play(),
    () => frame(1),
    () => clock.pause(),
  ]) {
    const before = calls;
    deed();
    assert.equal(calls, before + 1);
  }
});
