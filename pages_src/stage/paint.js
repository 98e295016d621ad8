/** @typedef {import("./types.js").Drawing} Drawing */
/** @typedef {{ images: (CanvasImageSource & { width: number, height: number } | undefined)[], colors: string[] }} Looks */

/**
 * Draws a facade with its lower left corner at a place. Sides of leaves are on whole pixels, so that no seams are visible.
 *
 * @param {CanvasRenderingContext2D} context whose unit is a pixel of the screen
 * @param {Drawing} drawing
 * @param {Looks} looks
 * @param {{ left: number, bottom: number, scale: number }} view pixels, and pixels per metre
 */
export function paint(context, drawing, { images, colors }, { left, bottom, scale }) {
  const { columns, label, picture } = drawing;
  const outlines = new Map(drawing.outlines.map(({ leaf, corners }) => [leaf, corners]));
  const colorOf = (/** @type {number} */ leaf) => colors[label[leaf] < 0 ? colors.length - 1 : label[leaf]];
  context.imageSmoothingQuality = "high";
  for (let leaf = 0; leaf < label.length; leaf += 1) {
    const [x, y, width, height, u, v, right, top] = columns.subarray(8 * leaf, 8 * leaf + 8);
    const [x0, x1] = [Math.round(left + x * scale), Math.round(left + (x + width) * scale)];
    const [y0, y1] = [Math.round(bottom - (y + height) * scale), Math.round(bottom - y * scale)];
    const image = images[picture[leaf]];
    const corners = outlines.get(leaf);
    if (image && right > u && top > v) {
      const { width: w, height: h } = image;
      context.drawImage(image, u * w, (1 - top) * h, (right - u) * w, (top - v) * h, x0, y0, x1 - x0, y1 - y0);
    } else if (corners && !image) {
      context.fillStyle = colors[colors.length - 1];
      context.fillRect(x0, y0, x1 - x0, y1 - y0);
      context.fillStyle = colorOf(leaf);
      context.beginPath();
      for (const [across, up] of corners) context.lineTo(x0 + across * (x1 - x0), y1 - up * (y1 - y0));
      context.fill();
    } else {
      context.fillStyle = colorOf(leaf);
      context.fillRect(x0, y0, x1 - x0, y1 - y0);
    }
  }
}

/**
 * Small pictures of facades, all to one scale, so that a wider one looks wider.
 * @param {{ canvas: HTMLCanvasElement, drawing: Drawing, looks: Looks }[]} pictures
 * @param {{ width: number, height: number }} room pixels of the largest
 */
export function paintSmall(pictures, room) {
  const scale = Math.min(
    room.width / Math.max(...pictures.map(({ drawing }) => drawing.width)),
    room.height / Math.max(...pictures.map(({ drawing }) => drawing.height)),
  );
  for (const { canvas, drawing, looks } of pictures) {
    const [width, height] = [drawing.width * scale, drawing.height * scale];
    Object.assign(canvas.style, { width: `${width}px`, height: `${height}px` });
    const { context, ratio } = sharp(canvas, width, height);
    paint(context, drawing, looks, { left: 0, bottom: canvas.height, scale: scale * ratio });
  }
}

/**
 * A canvas of a size in CSS pixels, as sharp as the screen.
 * @param {HTMLCanvasElement} canvas
 * @param {number} width
 * @param {number} height
 * @returns {{ context: CanvasRenderingContext2D, ratio: number }} whose unit is a pixel of the screen
 */
export function sharp(canvas, width, height) {
  const ratio = Math.min(globalThis.devicePixelRatio || 1, 3);
  const [w, h] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
  if (canvas.width !== w) canvas.width = w;
  if (canvas.height !== h) canvas.height = h;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.clearRect(0, 0, w, h);
  return { context, ratio };
}
