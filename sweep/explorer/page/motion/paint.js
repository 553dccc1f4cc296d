/** Pictures on moving bodies: colours, sectors that make the rotation visible, and a painted radius or meridian. */

import { CanvasTexture, MeshStandardMaterial, SRGBColorSpace } from "three";

/** Colours of the faces, as in films and figures, safe for the colour-blind. */
export const FACES = ["#f4c95d", "#5a86b8"];

/** Colour of the edge of a thick body. */
export const EDGE_COLOUR = "#c9c3b8";

const PAINT = "#c8380a";

/** Side of the picture on a face in pixels, and number of sectors that make the rotation visible. */
const FACE_PIXELS = 512;
const SECTORS = 12;

/** @param {string} colour */
export function painted(colour) {
  return new MeshStandardMaterial({ map: facePicture(colour), roughness: 0.75, metalness: 0.0 });
}

/**
 * Return a picture of one colour to draw on.
 * @param {number} width  in pixels
 * @param {string} colour
 * @param {number} [height]
 */
export function filled(width, colour, height = width) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.fillStyle = colour;
  context.fillRect(0, 0, width, height);
  return context;
}

/** @param {CanvasRenderingContext2D} context */
export function textureOf({ canvas }) {
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  texture.anisotropy = 4;
  return texture;
}

/**
 * Return the picture of a face: alternating darker sectors, a ring near the rim, and the painted radius to the right.
 * @param {string} colour
 */
function facePicture(colour) {
  const context = filled(FACE_PIXELS, colour);
  const middle = FACE_PIXELS / 2;
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
  return textureOf(context);
}

/** Width and height of the picture of a surface of revolution, in pixels. */
const AROUND_PIXELS = 1024;
const ALONG_PIXELS = 8;

/** Width of the painted meridian and of its outline, as shares of the circumference. */
const CASING = 0.012;
const MERIDIAN = 0.007;

/**
 * Return the picture of a surface of revolution, wrapped once around it: alternating darker sectors, and the painted
 * meridian at the seam.
 * @param {string} colour
 */
export function surfacePicture(colour) {
  const context = filled(AROUND_PIXELS, colour, ALONG_PIXELS);
  const bar = (/** @type {number} */ from, /** @type {number} */ share, /** @type {string} */ style) => {
    context.fillStyle = style;
    context.fillRect(from * AROUND_PIXELS, 0, share * AROUND_PIXELS, ALONG_PIXELS);
  };
  for (let sector = 1; sector < SECTORS; sector += 2) {
    bar(sector / SECTORS, 1 / SECTORS, "rgb(0 0 0 / 10%)");
  }
  for (const [share, style] of /** @type {[number, string][]} */ ([
    [CASING, "#ffffff"],
    [MERIDIAN, PAINT],
  ])) {
    bar(0, share, style);
    bar(1 - share, share, style);
  }
  return textureOf(context);
}
