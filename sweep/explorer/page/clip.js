/** Polylines cut at a rectangle, so that nothing far outside is drawn: screens count in single precision. */

/** @typedef {[number, number]} Pixel */

/**
 * Pieces of a polyline inside a rectangle. A place that is not finite ends a piece.
 * @param {Pixel[]} points
 * @param {{left: number, top: number, right: number, bottom: number}} box
 * @returns {Pixel[][]}
 */
export function clipped(points, box) {
  /** @type {Pixel[][]} */
  const pieces = [];
  /** @type {Pixel[]} */
  let piece = [];
  for (let each = 1; each < points.length; each += 1) {
    const part = segment(points[each - 1], points[each], box);
    if (part === null) continue;
    const last = piece.at(-1);
    if (!last || last[0] !== part[0][0] || last[1] !== part[0][1]) {
      piece = [part[0]];
      pieces.push(piece);
    }
    piece.push(part[1]);
  }
  return pieces;
}

/**
 * Part of a segment inside a rectangle (Liang and Barsky 1984); null if there is none.
 * @param {Pixel} from
 * @param {Pixel} to
 * @param {{left: number, top: number, right: number, bottom: number}} box
 * @returns {[Pixel, Pixel]|null}
 */
function segment(from, to, box) {
  if (![...from, ...to].every(Number.isFinite)) return null;
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
  let [enter, leave] = [0, 1];
  const sides = [
    [-dx, from[0] - box.left],
    [dx, box.right - from[0]],
    [-dy, from[1] - box.top],
    [dy, box.bottom - from[1]],
  ];
  for (const [slope, distance] of sides) {
    if (slope === 0 && distance < 0) return null;
    if (slope < 0) enter = Math.max(enter, distance / slope);
    if (slope > 0) leave = Math.min(leave, distance / slope);
  }
  if (enter > leave) return null;
  /** @param {number} share @returns {Pixel} */
  const at = (share) =>
    share === 0 ? from : share === 1 ? to : [from[0] + share * dx, from[1] + share * dy];
  return [at(enter), at(leave)];
}
