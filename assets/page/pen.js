// A canvas to scale, and the shapes that are drawn on it.
"use strict";

/** A canvas with a scale: y points up, lengths in the view's unit. */
class Pen {
  constructor(canvas, box, [[x0, y0], [x1, y1]], theme) {
    Object.assign(this, { canvas, box, theme, g: canvas.getContext("2d"), texts: [] });
    const [width, height] = [x1 - x0 || 1, y1 - y0 || 1];
    this.scale = Math.min(box.width / width, box.height / height);
    this.left = box.x + (box.width - width * this.scale) / 2 - x0 * this.scale;
    this.base = box.y + (box.height + height * this.scale) / 2 + y0 * this.scale;
  }

  at([x, y]) {
    return [this.left + x * this.scale, this.base - y * this.scale];
  }

  /** The place of the scene under a point of the canvas. */
  under([px, py]) {
    return [(px - this.left) / this.scale, (this.base - py) / this.scale];
  }

  path(points, isClosed = false) {
    const { g } = this;
    g.beginPath();
    points.forEach((point, index) => (index ? g.lineTo(...this.at(point)) : g.moveTo(...this.at(point))));
    if (isClosed) g.closePath();
  }

  line(points, color, width = 1.5, dash = []) {
    if (points.length < 2) return;
    const { g } = this;
    this.path(points);
    Object.assign(g, { strokeStyle: color, lineWidth: width, lineJoin: "round", lineCap: "round" });
    g.setLineDash(dash);
    g.stroke();
    g.setLineDash([]);
  }

  shape(points, { fill, stroke, width = 1, dash = [] }) {
    this.path(points, true);
    this.paint({ fill, stroke, width, dash });
  }

  disc(place, radius, { fill, stroke, width = 1, dash = [], least = 0 }) {
    const { g } = this;
    g.beginPath();
    g.arc(...this.at(place), Math.max(least, radius * this.scale), 0, 2 * Math.PI);
    this.paint({ fill, stroke, width, dash });
  }

  paint({ fill, stroke, width, dash }) {
    const { g } = this;
    if (fill) {
      g.fillStyle = fill;
      g.fill();
    }
    if (stroke) {
      Object.assign(g, { strokeStyle: stroke, lineWidth: width });
      g.setLineDash(dash);
      g.stroke();
      g.setLineDash([]);
    }
  }

  /** Whether a box of the canvas is between the sides of the drawing, and meets no other. */
  isFree([left, top, right, bottom], taken) {
    const isInside = left >= this.box.x && right <= this.box.x + this.box.width;
    return isInside && !taken.some(([a, b, c, d]) => left < c && a < right && top < d && b < bottom);
  }

  text(place, words, color, { dx = 0, dy = 0, align = "left", size = 12, weight = "" } = {}) {
    const { g } = this;
    const [x, y] = this.at(place);
    Object.assign(g, { font: `${weight} ${size}px system-ui, sans-serif`, textAlign: align, textBaseline: "middle" });
    Object.assign(g, { lineWidth: 3, strokeStyle: this.theme.paper, lineJoin: "round" });
    this.texts.push({ words, x: x + dx, y: y + dy, align, size });
    g.strokeText(words, x + dx, y + dy);
    g.fillStyle = color;
    g.fillText(words, x + dx, y + dy);
  }
}

/** The box of a text on a canvas: its corners. */
function boxOfText(g, { words, x, y, align, size }) {
  g.font = `600 ${size}px system-ui, sans-serif`;
  const width = g.measureText(words).width;
  const left = align === "right" ? x - width : align === "center" ? x - width / 2 : x;
  return [left, y - size / 2, left + width, y + size / 2];
}

/** Where the name of a shape stands: between its corners, which may lie far from its pose. */
function shapeMiddle(shape, pose) {
  const { points } = shapePoints(shape, pose);
  return [0, 1].map((axis) => points.reduce((sum, point) => sum + point[axis], 0) / points.length);
}

/** Corners of a shape at its pose, grown by a length; round parts as many short sides. */
function shapePoints(shape, pose, growth_um = 0) {
  const name = typeof shape === "string" ? shape : Object.keys(shape)[0];
  const figures = shape[name] || {};
  let [core, radius_um] = [[[0, 0]], growth_um];
  if (name === "disc") radius_um += figures.radius_um;
  if (name === "capsule") {
    core = [[-figures.length_um / 2, 0], [figures.length_um / 2, 0]];
    radius_um += figures.radius_um;
  }
  if (name === "box") {
    const [a, b] = figures.size_um.map((size) => size / 2);
    core = [[-a, -b], [a, -b], [a, b], [-a, b]];
  }
  if (name === "polygon") core = figures.points_um;
  const [cos, sin] = [Math.cos(pose.heading_rad), Math.sin(pose.heading_rad)];
  const placed = core.map(([x, y]) => [pose.x_um + x * cos - y * sin, pose.y_um + x * sin + y * cos]);
  return { points: placed, radius_um };
}

/** Draws a rounded shape: its core, stroked by twice its radius. */
function drawShape(pen, { points, radius_um }, color) {
  const { g } = pen;
  pen.path(points, points.length > 2);
  Object.assign(g, { fillStyle: color, strokeStyle: color, lineJoin: "round", lineCap: "round" });
  g.lineWidth = 2 * radius_um * pen.scale;
  if (points.length === 1) return pen.disc(points[0], radius_um, { fill: color, least: 2 });
  if (points.length > 2) g.fill();
  if (radius_um > 0) g.stroke();
  return undefined;
}

/** The smallest box about points, grown by a share of its size. */
function boxAbout(points, share = 0.06) {
  const low = [0, 1].map((axis) => Math.min(...points.map((point) => point[axis])));
  const high = [0, 1].map((axis) => Math.max(...points.map((point) => point[axis])));
  const more = share * Math.max(high[0] - low[0], high[1] - low[1], 1e-6);
  return [low.map((value) => value - more), high.map((value) => value + more)];
}
