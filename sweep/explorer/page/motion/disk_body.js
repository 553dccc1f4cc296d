/** The disk as a body of three.js: two faces with a painted radius, and a rim. Its axis is z, the painted radius x. */

import {
  CanvasTexture,
  Group,
  LatheGeometry,
  Mesh,
  MeshStandardMaterial,
  RingGeometry,
  SRGBColorSpace,
  Vector2,
} from "three";

/** Colours of the faces, the same as in films and figures: the colour-blind can tell them apart. */
const FACES = ["#f4c95d", "#5a86b8"];
const PAINT = "#c8380a";

/** Half the thickness over the radius, of a disk and of a ring, which has no face; those of the equations have none. */
const THICKNESS = { disk: 0.012, ring: 0.03 };

/** Side of the picture on a face, in pixels, and sectors that show that the disk turns. */
const PIXELS = 512;
const SECTORS = 12;

/** Inner radius of the widest ring that is drawn, over the radius: a hoop has no width. */
const WIDEST = 0.9;

/**
 * Inner radius over the radius of the ring that has this moment of inertia; 0 for a full disk.
 * @param {number} alpha
 */
function innerRadius(alpha) {
  // a ring from a R to R has (1 + a^2) / 2
  return Math.min(Math.sqrt(Math.max(2 * alpha - 1, 0)), WIDEST);
}

/**
 * @param {number} radius
 * @param {number} alpha  moment of inertia over m R^2
 * @param {string} rimColour
 * @returns {Group}
 */
export function diskBody(radius, alpha, rimColour) {
  const body = new Group();
  const inner = innerRadius(alpha) * radius;
  const half = (inner > 0 ? THICKNESS.ring : THICKNESS.disk) * radius;
  for (const [side, colour] of FACES.entries()) {
    const face = new Mesh(new RingGeometry(inner, radius, 128), painted(colour));
    // the second face looks the other way; its painted radius stays where that of the first one is
    if (side === 1) face.rotation.x = Math.PI;
    face.position.z = side === 0 ? half : -half;
    face.castShadow = true;
    body.add(face);
  }
  const profile = [new Vector2(radius, -half), new Vector2(radius, half)];
  if (inner > 0) {
    profile.push(new Vector2(inner, half), new Vector2(inner, -half), new Vector2(radius, -half));
  }
  const rim = new Mesh(
    new LatheGeometry(profile, 128),
    new MeshStandardMaterial({ color: rimColour, roughness: 0.5, side: 2 }),
  );
  rim.rotation.x = Math.PI / 2;
  rim.castShadow = true;
  body.add(rim);
  return body;
}

/** @param {string} colour */
function painted(colour) {
  const texture = new CanvasTexture(facePicture(colour));
  texture.colorSpace = SRGBColorSpace;
  texture.anisotropy = 4;
  return new MeshStandardMaterial({ map: texture, roughness: 0.75, metalness: 0.0 });
}

/**
 * Picture of a face: sectors by turns a little darker, a ring near the rim, and the painted radius to the right.
 * @param {string} colour
 */
function facePicture(colour) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = PIXELS;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const middle = PIXELS / 2;
  context.fillStyle = colour;
  context.fillRect(0, 0, PIXELS, PIXELS);
  context.translate(middle, middle);
  context.fillStyle = "rgb(0 0 0 / 7%)";
  for (let sector = 0; sector < SECTORS; sector += 2) {
    const from = ((sector - 0.5) / SECTORS) * 2 * Math.PI;
    context.beginPath();
    context.moveTo(0, 0);
    context.arc(0, 0, middle, from, from + (2 * Math.PI) / SECTORS);
    context.fill();
  }
  context.lineWidth = 0.02 * middle;
  context.strokeStyle = "rgb(0 0 0 / 35%)";
  context.beginPath();
  context.arc(0, 0, 0.985 * middle, 0, 2 * Math.PI);
  context.stroke();
  for (const [width, style] of /** @type {[number, string][]} */ ([
    [0.1, "#ffffff"],
    [0.06, PAINT],
  ])) {
    context.lineWidth = width * middle;
    context.strokeStyle = style;
    context.beginPath();
    context.moveTo(0, 0);
    context.lineTo(middle, 0);
    context.stroke();
  }
  return canvas;
}
