/** Drawing bodies: their meridians, their orientation, and the squares of the table. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { bodyOf } from "eulerdisk/compute/shapes";
import { Arrow, attitude, middleHeight, poseAt } from "eulerdisk/motion/disk_scene";
import { niceLength } from "eulerdisk/motion/furniture";
import { Samples } from "eulerdisk/motion/samples";
import { meridianOf, reachOf } from "eulerdisk/motion/solid";
import { Vector3 } from "three";

const near = (found, expected, off = 1e-12) =>
  assert.ok(Math.abs(found - expected) < off, `${found} ${expected}`);

/** A body with these words, as of a cell. */
const body = (name, cell) =>
  bodyOf({ name, called: name }, { axial_moment: 0.5, transverse_moment: 0.25, ...cell });

const BODIES = [
  body("torus", { tube: 0.3 }),
  body("rounded", { thickness: 0.4 }),
  body("arc", { fillet: 0.2, offset: 0.1 }),
  body("rim", { thickness: 0.5, fillet: 0.1, tilt: 0.2 }),
  body("rim", { thickness: 0.5, fillet: 0.1, tilt: -0.2 }),
  body("rim", { thickness: 0.5, fillet: 0, tilt: 0.2 }),
  body("ball", { offset: 0.2 }),
  body("spheroid", { offset: 0, flattening: 0.4 }),
];

test("the camera looks at the mean height of the center: low for a flat disk, the radius for an upright one", () => {
  const samplesOf = (tilt) => ({
    arrays: { time: [0, 2] },
    head: { radius: 0.04 },
    at: (name, time) => (name === "tilt" ? tilt + 0.01 * Math.sin(40 * time) : NaN),
  });
  near(middleHeight(samplesOf(0)), 0.04, 1e-5);
  near(middleHeight(samplesOf(1.5)), 0.04 * Math.cos(1.5), 1e-4);
});

test("the force is along the path, across it towards positive tilt, and up, for a disk and a body", () => {
  const two = (value) => Float64Array.of(value, value);
  const heading = 0.4;
  for (const body of [null, BODIES[0]]) {
    const push = (normal, across, along) => {
      const arrays = {
        time: Float64Array.of(0, 1), tilt: two(0.2), heading: two(heading), roll_angle: two(0.1),
        contact_x: two(0), contact_y: two(0), centre_x: two(0), centre_y: two(0), centre_z: two(1),
        normal_force: two(normal), friction_across: two(across), friction_along: two(along),
      }; // prettier-ignore
      return poseAt(new Samples({ head: { radius: 1, body, lossy: true }, arrays }), 0.5).push.toArray();
    };
    const [sine, cosine] = [Math.sin(heading), Math.cos(heading)];
    const expected = [[0, 0, 1], [cosine, sine, 0], [-sine, cosine, 0]]; // prettier-ignore
    [push(1, 0, 0), push(0, 1, 0), push(0, 0, 1)].forEach((found, i) =>
      found.forEach((value, k) => near(value, expected[i][k])),
    );
  }
});

test("the parts of a meridian join and go from axis to axis; a torus has no end on the axis", () => {
  for (const each of BODIES) {
    const stretches = meridianOf(each);
    stretches.slice(1).forEach(({ points }, i) => {
      const [a, b] = stretches[i].points.at(-1);
      near(points[0][0], a);
      near(points[0][1], b);
    });
    const [first, last] = [stretches[0].points[0], stretches.at(-1).points.at(-1)];
    if (each.name === "torus") {
      near(first[0], last[0]);
      near(first[1], last[1]);
    } else {
      near(first[0], 0);
      near(last[0], 0);
    }
    // the axis points to its start
    assert.ok(first[1] >= last[1] - 1e-12);
    // no point is beyond the outer radius, and one reaches it
    const widest = Math.max(...stretches.flatMap(({ points }) => points.map(([a]) => a)));
    near(widest, 1, 2e-3);
  }
});

test("a meridian is on its circle or ellipse, shifted by the center of mass", () => {
  const [torus, rounded, arc, , , , ball, spheroid] = BODIES.map(meridianOf);
  torus.flatMap(({ points }) => points).forEach(([a, b]) => near(Math.hypot(a - 0.7, b), 0.3));
  rounded[1].points.forEach(([a, b]) => near(Math.hypot(a - 0.8, b), 0.2));
  arc[1].points.forEach(([a, b]) => near(Math.hypot(a - 0.8, b + 0.1), 0.2));
  ball.flatMap(({ points }) => points).forEach(([a, b]) => near(Math.hypot(a, b + 0.2), 1));
  spheroid.flatMap(({ points }) => points).forEach(([a, b]) => near(Math.hypot(a, b / 0.6), 1));
});

test("a rim has both edges at half its thickness, whichever it stands on", () => {
  for (const rim of BODIES.slice(3, 6).map(meridianOf)) {
    const heights = rim.flatMap(({ points }) => points.map(([, b]) => b));
    near(Math.max(...heights), 0.25);
    near(Math.min(...heights), -0.25);
  }
});

test("the farthest point is measured from the center of mass", () => {
  near(reachOf(BODIES[0]), 1);
  near(reachOf(BODIES[6]), 1.2);
  near(reachOf(body("spheroid", { offset: 0, flattening: -0.5 })), 1.5);
  near(reachOf(BODIES[5]), Math.hypot(1, 0.25));
});

test("a disk tilts to the side of its heading, and its painted radius turns with it", () => {
  const across = (heading) => new Vector3(Math.cos(heading), Math.sin(heading), 0);
  for (const [tilt, heading, angle] of [
    [0, 0, 0],
    [0.3, 0.7, 0],
    [-0.4, 2, 1.1],
    [1.2, -3, 9],
  ]) {
    const { turned, down } = attitude(tilt, heading, angle);
    near(down.z, -Math.cos(tilt));
    near(down.dot(across(heading)), -Math.sin(tilt));
    near(down.dot(across(heading + Math.PI / 2)), 0);
    const painted = new Vector3(1, 0, 0).applyQuaternion(turned);
    near(painted.dot(down), Math.cos(angle));
    near(painted.dot(across(heading + Math.PI / 2)), -Math.sin(angle));
    // the painted radius is in the plane of the disk
    near(new Vector3(0, 0, 1).applyQuaternion(turned).dot(down), 0);
  }
});

test("a length is 1, 2 or 5 times a power of ten", () => {
  const lengths = [1, 1.9, 2, 4.9, 5, 9.9, 10, 0.03, 0.5].map(niceLength);
  [1, 1, 2, 2, 5, 5, 10, 0.02, 0.5].forEach((each, i) => near(lengths[i], each));
});

test("an arrow starts at its place, points along its vector and has its length", () => {
  const from = new Vector3(0.3, -0.2, 0.1);
  for (const along of [new Vector3(0.4, -0.7, 1.2), new Vector3(0, 0, -0.05), new Vector3(1, 0, 0)]) {
    const arrow = new Arrow(1, "#123456");
    arrow.point(from, along);
    arrow.updateMatrixWorld(true);
    // a cone points along y and is centered at half its height
    const { height } = arrow.head.geometry.parameters;
    const tip = new Vector3(0, height / 2, 0).applyMatrix4(arrow.head.matrixWorld);
    near(tip.distanceTo(from.clone().add(along)), 0);
  }
});
