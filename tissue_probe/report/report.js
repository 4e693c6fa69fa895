// The report's plots, by uPlot, of the data that stand in the page: drag to magnify, double click
// to go back.

const COLOURS = { measured: "--measured", "base model": "--base", "last model": "--last", model: "--last" };

/** A colour of the page by its name. @param {string} name */
function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Numbers in single precision, as base64 has them. @param {string} text */
function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

function axis(label, more = {}) {
  return {
    label, labelSize: 20, labelFont: "13px system-ui, sans-serif", font: "12px system-ui, sans-serif",
    stroke: colour("--soft"), grid: { stroke: colour("--line"), width: 1 }, ticks: { show: false }, ...more,
  };
}

/** The background of the curves. */
function band(low, high, across, name, strength) {
  return (plot) => {
    const { ctx, bbox } = plot, scale = across ? "y" : "x";
    const at = [low, high].map((value) => plot.valToPos(value, scale, true));
    ctx.save();
    ctx.globalAlpha = strength;
    ctx.fillStyle = colour(name);
    if (across) ctx.fillRect(bbox.left, Math.min(...at), bbox.width, Math.abs(at[1] - at[0]));
    else ctx.fillRect(Math.min(...at), bbox.top, Math.max(Math.abs(at[1] - at[0]), 1), bbox.height);
    ctx.restore();
  };
}

/** One of several plots in a place; it is as wide as that. */
function draw(place, height, options, data) {
  const box = document.createElement("div");
  place.append(box);
  const plot = new uPlot({ width: box.clientWidth || 600, height, ...options }, data, box);
  new ResizeObserver(() => plot.setSize({ width: box.clientWidth, height })).observe(box);
}

function drawSignals(place, data) {
  const time = unpacked(data.time), measured = unpacked(data.measured);
  const models = Object.entries(data.models).map(([name, values]) => [name, unpacked(values)]);
  const error = (values) => values.map((value, n) => data.per * (measured[n] - value));
  const line = (name, width) => ({ label: name, stroke: colour(COLOURS[name]), width, points: { show: false } });
  const shared = { cursor: { sync: { key: place.id } }, scales: { x: { time: false } } };
  draw(place, 260, {
    ...shared, axes: [axis(""), axis(`${data.name} [${data.unit}]`, { size: 62 })],
    series: [{ label: "time [s]" }, line("measured", 3), ...models.map(([name]) => line(name, 1.3))],
  }, [time, measured, ...models.map(([, values]) => values)]);
  draw(place, 220, {
    ...shared, axes: [axis("time [s]"), axis(`error [${data.error_unit}]`, { size: 62 })],
    series: [{ label: "time [s]" }, ...models.map(([name]) => line(name, 1))],
    hooks: { drawClear: [band(-2 * data.noise, 2 * data.noise, true, "--soft", 0.25)] },
  }, [time, ...models.map(([, values]) => error(values))]);
}

function drawProfile(place, data) {
  const x = [], steps = Object.entries(data.models).map(([name, values]) => [name, values, []]);
  data.edges.slice(0, -1).forEach((edge, n) => {
    x.push(edge, data.edges[n + 1]);
    for (const [, values, drawn] of steps) drawn.push(values[n], values[n]);
  });
  const every = steps.flatMap(([, values]) => values).filter((value) => value !== null);
  const most = Math.max(1, ...every), wide = most > 10;
  const hooks = [band(1, 1.0001, true, "--ink", 0.6)];
  if (data.here) {
    const [begin, end] = data.here, [first, last] = [data.edges[0], data.edges.at(-1)];
    const pieces = begin <= end ? [[begin, end]] : [[begin, last], [first, end]];
    hooks.push(...pieces.map(([low, high]) => band(low, high, false, "--region", 0.25)));
  }
  const middles = data.edges.slice(0, -1).map((edge, n) => (edge + data.edges[n + 1]) / 2);
  const named = data.labels.length ? { splits: middles, values: data.labels } : {};
  const unit = data.unit ? ` [${data.unit}]` : "";
  draw(place, 190, {
    legend: { show: false },
    scales: {
      x: { time: false, distr: data.logarithmic ? 3 : 1 },
      y: { distr: wide ? 3 : 1, range: wide ? [0.5, 1.5 * most] : [0, 1.1 * most] },
    },
    axes: [axis(`${data.quantity}${unit}`, named), axis("error / noise", { size: 50 })],
    series: [{}, ...steps.map(([name]) => ({ label: name, stroke: colour(COLOURS[name]), width: 2, points: { show: false } }))],
    hooks: { drawClear: hooks },
  }, [x, ...steps.map(([, , drawn]) => drawn)]);
}

for (const place of document.querySelectorAll("[data-plots]")) {
  for (const data of JSON.parse(document.getElementById(place.dataset.plots).textContent)) {
    (data.kind === "signals" ? drawSignals : drawProfile)(place, data);
  }
}
