// The page of umax tune: all variants in step. Pictures are decoded as they are needed and drawn to canvases together, so
// that no pane is ever at another frame than its neighbours.
"use strict";
(() => {
const data = JSON.parse(document.getElementById("data").textContent);
const at = id => document.getElementById(id);
const variants = data.variants;
const shown = variants.filter(variant => variant.frames.length > 0);
const palette = ["#4cc2ff", "#ffb454", "#7ee081", "#ff7b9c", "#c89bff", "#5fe0cf", "#f2e05c", "#ff9268", "#9fb4d8", "#d3b38a"];
const dashes = [[], [6, 3], [2, 3], [9, 3, 2, 3]];

variants.forEach((variant, i) => {
  variant.index = i;
  variant.color = palette[i % palette.length];
  variant.dash = dashes[Math.floor(i / palette.length) % dashes.length];
});

const state = {
  frame: data.worst, playing: false, mode: "all", edge: 0.5,
  first: shown.length ? shown[0].index : 0,
  second: shown.length ? shown[shown.length - 1].index : 0,
};

// ---- pictures: decoded when wanted, the least recently used are let go ------------------------------------------------

const mostDecoded = Math.max(4 * variants.length, Math.floor(3e8 / (4 * data.width * data.height)));
const decoded = new Map();  // "variant/frame" to a promise of a bitmap, the oldest first

function decode(variant, frame) {
  const text = atob(variant.frames[frame - 1]);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return createImageBitmap(new Blob([bytes], { type: "image/webp" }));
}

function bitmap(variant, frame) {
  const key = variant.index + "/" + frame;
  const found = decoded.get(key) || decode(variant, frame);
  decoded.delete(key);
  decoded.set(key, found);
  while (decoded.size > mostDecoded) {
    const [oldest, promise] = decoded.entries().next().value;
    decoded.delete(oldest);
    promise.then(image => image.close());
  }
  return found;
}

// ---- drawing ----------------------------------------------------------------------------------------------------------

function paint(canvas, frame, draw) {
  if (canvas.width !== data.width) [canvas.width, canvas.height] = [data.width, data.height];
  const context = canvas.getContext("2d");
  context.globalCompositeOperation = "source-over";
  draw(context);
  canvas.dataset.frame = frame;
}

function drawWipe(context, a, b) {
  const edge = Math.round(state.edge * data.width);
  context.drawImage(a, 0, 0);
  if (edge < data.width)
    context.drawImage(b, edge, 0, data.width - edge, data.height, edge, 0, data.width - edge, data.height);
  if (edge <= 0 || edge >= data.width) return;
  context.fillStyle = "#fff";
  context.fillRect(edge - 1, 0, 2, data.height);
}

function drawDifference(context, a, b) {
  context.drawImage(a, 0, 0);
  context.globalCompositeOperation = "difference";
  context.drawImage(b, 0, 0);
  context.globalCompositeOperation = "lighter";
  // the picture on itself: twice as bright
  for (let gain = Number(at("gain").value); gain > 1; gain /= 2) context.drawImage(context.canvas, 0, 0);
}

function wantedVariants() {
  return state.mode === "all" ? shown : [variants[state.first], variants[state.second]];
}

function draw(frame, images) {
  if (state.mode === "all") {
    shown.forEach((variant, i) => paint(variant.canvas, frame, context => context.drawImage(images[i], 0, 0)));
    return;
  }
  const [a, b] = images;
  if (state.mode === "pair") {
    paint(at("view-a"), frame, context => context.drawImage(a, 0, 0));
    paint(at("view-b"), frame, context => context.drawImage(b, 0, 0));
  } else {
    paint(at("view-a"), frame, context => (state.mode === "wipe" ? drawWipe : drawDifference)(context, a, b));
  }
}

let drawing = false, redraw = false;

// Draws the wanted frame as soon as all its pictures are there; frames that were passed over meanwhile are left out.
async function show() {
  redraw = true;
  if (drawing || shown.length === 0) return;
  drawing = true;
  while (redraw) {
    redraw = false;
    const frame = state.frame, mode = state.mode, pair = state.first + "/" + state.second;
    const images = await Promise.all(wantedVariants().map(variant => bitmap(variant, frame)));
    if (mode !== state.mode || pair !== state.first + "/" + state.second) { redraw = true; continue; }
    draw(frame, images);
    document.body.dataset.drawn = frame;
    if (state.playing) for (const variant of wantedVariants()) bitmap(variant, frame % data.frames + 1);
  }
  drawing = false;
}

// ---- time -------------------------------------------------------------------------------------------------------------

const timeOf = frame => (frame - 1) / data.fps;

function goTo(frame) {
  state.frame = Math.min(Math.max(Math.round(frame), 1), data.frames);
  at("scrubber").value = state.frame;
  at("scrubber").setAttribute("aria-valuetext", `frame ${state.frame} of ${data.frames}`);
  at("readout").textContent = `frame ${state.frame} of ${data.frames} · ${timeOf(state.frame).toFixed(2)} s`;
  moveCursors();
  showAim();
  show();
}

let started = 0, startFrame = 1;

function tick(now) {
  if (!state.playing) return;
  const passed = (now - started) / 1000 * data.fps * Number(at("speed").value);
  const frame = (startFrame - 1 + Math.floor(passed)) % data.frames + 1;
  if (frame !== state.frame) goTo(frame);
  requestAnimationFrame(tick);
}

function play(on) {
  state.playing = on;
  at("play").firstElementChild.textContent = on ? "❚❚" : "▶";
  at("play").setAttribute("aria-label", on ? "Pause" : "Play");
  if (!on) return;
  started = performance.now();
  startFrame = state.frame;
  requestAnimationFrame(tick);
}

// ---- which variants ---------------------------------------------------------------------------------------------------

function choose(index) {
  if (!variants[index]) return;
  if (index === state.second && variants[index].frames.length && variants[state.first].frames.length)
    state.second = state.first;
  state.first = index;
  if (!variants[index].frames.length) setMode("all");
  reflectChoice();
}

function compareWith(index) {
  if (!variants[index] || !variants[index].frames.length) return;
  state.second = index;
  if (state.mode === "all") setMode("wipe");
  reflectChoice();
}

function reflectChoice() {
  for (const variant of variants) variant.pane.setAttribute("aria-pressed", variant.index === state.first);
  for (const row of at("table").tBodies[0].rows) row.setAttribute("aria-selected", Number(row.dataset.index) === state.first);
  const chosen = variants[state.first];
  at("first").value = state.first;
  at("second").value = state.second;
  at("chosen").textContent = chosen.label;
  at("snippet").textContent = chosen.snippet;
  at("copied").textContent = "";
  showAim();
  const [a, b] = [chosen.label, variants[state.second].label];
  at("stage-a").lastElementChild.textContent =
    state.mode === "wipe" ? `${a}  |  ${b}` : state.mode === "difference" ? `difference of ${a} and ${b}` : a;
  at("stage-b").lastElementChild.textContent = b;
  emphasise();
  show();
}

// The command that looks for a value beside the chosen variant's, with the height that it has now.
function showAim() {
  const chosen = variants[state.first];
  at("aiming").hidden = !chosen.aim || !chosen.frames.length;
  if (at("aiming").hidden) return;
  const percent = 100 * chosen.series.shares[state.frame - 1];
  at("aim").textContent = `${chosen.aim} --want 'height(${chosen.lowest_body}) at frame ${state.frame} = ${percent.toFixed(1)} %'`;
  at("aim-copied").textContent = "";
}

function setMode(mode) {
  if (mode !== "all" && (shown.length === 0 || !variants[state.first].frames.length)) return;
  state.mode = mode;
  for (const button of at("modes").children) button.setAttribute("aria-pressed", button.dataset.mode === mode);
  at("grid").hidden = mode !== "all";
  at("stage").hidden = at("pairing").hidden = mode === "all";
  at("stage-b").hidden = mode !== "pair";
  at("wipe-control").hidden = mode !== "wipe";
  at("gain-control").hidden = mode !== "difference";
  at("view-a").classList.toggle("wiping", mode === "wipe");
  reflectChoice();
}

// ---- plots ------------------------------------------------------------------------------------------------------------

const plots = [];

function makePlot(id, series) {
  const quiet = "#a3abb8", grid = "#2c3038";
  const axis = more => Object.assign({ grid: { color: grid, borderColor: grid }, ticks: { color: quiet, maxTicksLimit: 7 } }, more);
  const chart = new Chart(at(id), {
    type: "line",
    data: {
      datasets: shown.map(variant => ({
        label: variant.label, data: series(variant), borderColor: variant.color, backgroundColor: variant.color,
        borderDash: variant.dash, borderWidth: 1.5, pointRadius: 0, pointHitRadius: 6,
      })),
    },
    options: {
      animation: false, parsing: false, normalized: true, responsive: true, maintainAspectRatio: false,
      interaction: { mode: "nearest", axis: "x", intersect: false },
      onClick: event => goTo(chart.scales.x.getValueForPixel(event.x) * data.fps + 1),
      onResize: () => requestAnimationFrame(moveCursors),
      scales: {
        x: axis({ type: "linear", min: 0, max: Math.max(timeOf(data.frames), 1e-9), title: { display: true, text: "time [s]", color: quiet } }),
        y: axis({ beginAtZero: true }),
      },
      plugins: {
        legend: { display: false },
        tooltip: { displayColors: true, callbacks: { title: items => items[0].parsed.x.toFixed(3) + " s" } },
      },
    },
  });
  plots.push({ chart, series });
}

const points = values => values.map((y, i) => ({ x: timeOf(i + 1), y }));

function energyOf(variant) {
  const kind = at("energy").value;
  if (kind !== "total") return points(variant.series[kind]);
  return points(variant.series.elastic.map((e, i) => e + variant.series.kinetic[i] + variant.series.potential[i]));
}

function emphasise() {
  for (const { chart } of plots) {
    chart.data.datasets.forEach((set, i) => {
      const chosen = shown[i].index === state.first;
      set.borderWidth = chosen ? 3 : 1.5;
      set.order = chosen ? 0 : 1;
    });
    chart.update("none");
  }
}

function moveCursors() {
  for (const { chart } of plots) {
    const cursor = chart.canvas.parentElement.querySelector(".cursor"), area = chart.chartArea;
    if (!area) continue;
    cursor.style.left = chart.scales.x.getPixelForValue(timeOf(state.frame)) + "px";
    cursor.style.top = area.top + "px";
    cursor.style.height = area.bottom - area.top + "px";
    cursor.dataset.time = timeOf(state.frame);
  }
}

// ---- table ------------------------------------------------------------------------------------------------------------

const number = (value, digits) => value === null || value === undefined ? "–" : Number(value).toFixed(digits);
const columns = [
  { name: "", value: v => v.index + 1, text: v => v.index + 1 },
  ...data.keys.map((key, i) => ({ name: key, words: true, value: v => v.values[i], text: v => v.values[i] })),
  { name: "largest U/Umax", value: v => v.largest_ratio, text: v => number(v.largest_ratio, 4) },
  { name: "largest stretch [%]", value: v => v.largest_stretch, text: v => number(v.largest_stretch, 1) },
  { name: "least height [m]", value: v => v.least_height, text: v => number(v.least_height, 3) },
  { name: "of its height [%]", value: v => v.least_share, text: v => number(v.least_share === undefined ? undefined : 100 * v.least_share, 1) },
  { name: "most limits at once", value: v => v.most_limits, text: v => number(v.most_limits, 0) },
  { name: "steps not converged", value: v => v.steps_not_converged, text: v => number(v.steps_not_converged, 0), bad: v => v.steps_not_converged > 0 },
  { name: "computing [s]", value: v => v.wall_seconds, text: v => number(v.wall_seconds, 1) },
  { name: "ended", words: true, value: v => v.exit_code, text: v => v.exit_code === 0 ? "whole" : `exit code ${v.exit_code}`, bad: v => v.exit_code !== 0 },
];
const sorting = { column: 0, up: true };

// "5%" before "10%", "100 kPa" before "1 MPa": by the numbers that the program read where there are, else as words
function compare(a, b, column) {
  const x = column.value(a), y = column.value(b);
  if (x === undefined || x === null) return y === undefined || y === null ? 0 : 1;
  if (y === undefined || y === null) return -1;
  if (typeof x === "number" && typeof y === "number") return x - y;
  return String(x).localeCompare(String(y), "en", { numeric: true });
}

function fillTable() {
  const rows = [...variants].sort((a, b) => (sorting.up ? 1 : -1) * compare(a, b, columns[sorting.column]) || a.index - b.index);
  at("table").tBodies[0].replaceChildren(...rows.map(variant => {
    const row = document.createElement("tr");
    row.dataset.index = variant.index;
    row.onclick = () => choose(variant.index);
    for (const column of columns) {
      const cell = row.insertCell();
      cell.textContent = column.text(variant);
      cell.className = (column.words ? "words " : "") + (column.bad && column.bad(variant) ? "bad" : "");
    }
    return row;
  }));
  [...at("table").tHead.rows[0].cells].forEach((cell, i) => {
    if (i === sorting.column) cell.setAttribute("aria-sort", sorting.up ? "ascending" : "descending");
    else cell.removeAttribute("aria-sort");
  });
}

function makeTable() {
  const head = at("table").tHead.insertRow();
  columns.forEach((column, i) => {
    const cell = document.createElement("th"), button = document.createElement("button");
    cell.scope = "col";
    if (column.words) cell.className = "words";
    button.textContent = column.name || "#";
    button.onclick = () => {
      sorting.up = sorting.column === i ? !sorting.up : true;
      sorting.column = i;
      fillTable();
      reflectChoice();
    };
    cell.append(button);
    head.append(cell);
  });
  fillTable();
}

// ---- setting up -------------------------------------------------------------------------------------------------------

function makePane(variant) {
  const pane = document.createElement("button");
  pane.className = "pane";
  pane.style.setProperty("--own", variant.color);
  if (variant.frames.length) {
    variant.canvas = document.createElement("canvas");
    variant.canvas.dataset.variant = variant.index + 1;
    [variant.canvas.width, variant.canvas.height] = [data.width, data.height];
    pane.append(variant.canvas);
  } else {
    const words = document.createElement("div");
    words.className = "failed";
    words.textContent = `exit code ${variant.exit_code}: ${variant.failure}`;
    pane.append(words);
  }
  const words = document.createElement("span"), swatch = document.createElement("span"),
        label = document.createElement("span"), figures = document.createElement("span");
  [words.className, swatch.className, label.className, figures.className] = ["words", "swatch", "label", "figures"];
  label.textContent = variant.label;
  figures.textContent = variant.frames.length ? `U/Umax ≤ ${number(variant.largest_ratio, 3)}` : "";
  words.append(swatch, label, figures);
  pane.append(words);
  pane.onclick = event => event.shiftKey ? compareWith(variant.index) : choose(variant.index);
  variant.pane = pane;
  return pane;
}

async function copy(from, said) {
  try {
    await navigator.clipboard.writeText(at(from).textContent);
    at(said).textContent = "Copied.";
  } catch {
    getSelection().selectAllChildren(at(from));
    at(said).textContent = document.execCommand("copy") ? "Copied." : "Selected: copy it with Ctrl+C.";
  }
}

function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "SELECT") return;
  const digit = /^(?:Digit|Numpad)([1-9])$/.exec(event.code);
  const on_button = event.target.tagName === "BUTTON" && event.target.id !== "play" && !event.target.classList.contains("pane");
  if (event.target.id === "edge" && event.key.startsWith("Arrow")) return;
  if (event.key === "ArrowRight" || event.key === "ArrowLeft") {
    play(false);
    goTo(state.frame + (event.key === "ArrowRight" ? 1 : -1) * (event.shiftKey ? 10 : 1));
  } else if (event.key === " " && !on_button) {
    play(!state.playing);
  } else if (digit) {
    (event.shiftKey ? compareWith : choose)(Number(digit[1]) - 1);
  } else if (event.key === "w" || event.key === "W") {
    goTo(data.worst);
  } else {
    return;
  }
  event.preventDefault();
}

function dragEdge(event) {
  if (state.mode !== "wipe" || !(event.buttons & 1)) return;
  const box = at("view-a").getBoundingClientRect();
  state.edge = Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1);
  at("edge").value = 100 * state.edge;
  show();
}

function listen() {
  at("scrubber").max = data.frames;
  at("scrubber").oninput = event => { play(false); goTo(Number(event.target.value)); };
  at("play").onclick = () => play(!state.playing);
  at("speed").onchange = () => { if (state.playing) play(true); };
  at("worst").onclick = () => { play(false); goTo(data.worst); };
  at("modes").onclick = event => { if (event.target.dataset.mode) setMode(event.target.dataset.mode); };
  at("first").onchange = event => { state.first = Number(event.target.value); reflectChoice(); };
  at("second").onchange = event => { state.second = Number(event.target.value); reflectChoice(); };
  at("swap").onclick = () => { [state.first, state.second] = [state.second, state.first]; reflectChoice(); };
  at("edge").oninput = event => { state.edge = Number(event.target.value) / 100; show(); };
  at("gain").onchange = show;
  at("view-a").onpointerdown = event => { at("view-a").setPointerCapture(event.pointerId); dragEdge(event); };
  at("view-a").onpointermove = dragEdge;
  at("copy").onclick = () => copy("snippet", "copied");
  at("copy-aim").onclick = () => copy("aim", "aim-copied");
  at("energy").onchange = () => {
    const { chart, series } = plots[2];
    chart.data.datasets.forEach((set, i) => { set.data = series(shown[i]); });
    chart.update("none");
    moveCursors();
  };
  document.addEventListener("keydown", onKey);
}

at("title").textContent = data.title;
at("summary").textContent = data.summary;
at("footer").textContent = data.made_by;
at("grid").style.setProperty("--columns", data.columns);
at("grid").append(...variants.map(makePane));
for (const select of [at("first"), at("second")])
  select.append(...shown.map(variant => new Option(variant.label, variant.index)));
for (const button of at("modes").children) button.disabled = shown.length < 2 && button.dataset.mode !== "all";
makeTable();
makePlot("plot-ratio", variant => points(variant.series.ratio));
makePlot("plot-limits", variant => points(variant.series.limits));
makePlot("plot-energy", energyOf);
listen();
reflectChoice();
goTo(state.frame);
requestAnimationFrame(moveCursors);
document.body.dataset.ready = "yes";
})();
