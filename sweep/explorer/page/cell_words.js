/** The text about a cell where no server explains it. */

import { printedUnits, readable } from "eulerdisk/ticks";

/** @import { Line, Parameter, PointAnswer } from "eulerdisk/types" */

/**
 * A cell: its numbers, and the parameters and lines of its plane.
 * @typedef {object} Cell
 * @property {{x: Parameter, y: Parameter}} sides
 * @property {PointAnswer} numbers
 * @property {Line[]} lines
 * @property {string} criterion
 */

/** Widths of the columns of names and of values. */
const NAME = 12;
const VALUE = 22;

/** Digits of a value on a line. */
const LINE_DIGITS = 6;

/**
 * @param {Cell} cell
 * @returns {string}
 */
export function wordsOfCell(cell) {
  const { sides, numbers, criterion } = cell;
  const { start } = numbers;
  const told = (/** @type {string} */ name) => printedUnits(start[name].text);
  const place = /** @type {const} */ (["x", "y"]).map((side) => {
    const { name, label } = sides[side];
    return `${label} ${told(name)}`;
  });
  const others = Object.keys(start).filter((name) => name !== sides.x.name && name !== sides.y.name);
  const held = numbers.numbers.map(
    ({ name, text, description }) =>
      `  ${name.replaceAll("_", " ").padEnd(NAME + 6)}${printedUnits(text).padEnd(VALUE)}${description}`,
  );
  return [
    row("cell", place.join(", ")),
    row("start", others.map((name) => `${name.replaceAll("_", " ")} ${told(name)}`).join(", ")),
    "",
    ...held,
    "",
    ...boundaryRows(cell),
    row("verdict", criterion ? `${numbers.verdict} by ${criterion}` : numbers.verdict),
  ].join("\n");
}

/**
 * @param {string} name
 * @param {string} text
 */
function row(name, text) {
  return name.padEnd(NAME) + text;
}

/**
 * @param {string} place
 * @param {string} label
 */
function onLine(place, label) {
  return `${printedUnits(place).padEnd(VALUE + 6)} ${label}`;
}

/**
 * Return where the lines of the map cross the row of a cell, along the parameter of the boundary.
 * @param {Cell} cell
 */
function boundaryRows({ sides, numbers, lines }) {
  const along = sides.x.control ? "x" : "y";
  const across = along === "x" ? "y" : "x";
  const { name, label, factor, unit } = sides[along];
  if (!sides[along].control) return [];
  const wanted = numbers.start[sides[across].name].value;
  const order = along === "x" ? [0, 1] : [1, 0];
  const found = lines.flatMap((line) =>
    crossings(line.points, wanted, order).map((value) =>
      onLine(`${label} ${readable(value * factor, LINE_DIGITS)} ${unit}`, line.label),
    ),
  );
  const here = row("", onLine(`${label} ${numbers.start[name].text}`, "this cell"));
  return found.length === 0 ? [] : [...found.map((text, i) => row(i ? "" : "lines", text)), here, ""];
}

/**
 * Return the values along one side at which polylines have a given value along the other.
 * @param {number[][][]} lines
 * @param {number} wanted  the given value along the other side
 * @param {number[]} order  indices of both sides in a point
 */
export function crossings(lines, wanted, [along, across]) {
  return lines.flatMap((points) => {
    if (points.length === 1) return points[0][across] === wanted ? [points[0][along]] : [];
    const isClosed = points[0].every((value, side) => value === points[points.length - 1][side]);
    return points.slice(1).flatMap((end, i) => {
      const begin = points[i];
      const [before, after] = [begin[across] - wanted, end[across] - wanted];
      const isLast = i === points.length - 2 && !isClosed;
      // a segment includes its first end only, so that a point of the line is met once; the last segment includes both
      if (before === after || before * after > 0 || (after === 0 && !isLast)) return [];
      return [begin[along] + (before / (before - after)) * (end[along] - begin[along])];
    });
  });
}
