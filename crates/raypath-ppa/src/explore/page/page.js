"use strict";
// Draws the configurations of a search. All text is set as text, never as markup.
const data = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);

function element(name, attributes = {}, text = "") {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  return made;
}

function shape(name, attributes, text = "") {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  return made;
}

const label = (metric) => `${metric.name}, ${metric.unit}`;
const isMeasured = (point) => ["front", "dominated", "missed"].includes(point.status);

// The value of a metric, and the error of a prediction in its place; null if neither is known.
function known(point, metric) {
  if (metric.name in point.values) return [point.values[metric.name], 0];
  const predicted = point.predicted[metric.name];
  return predicted && predicted.error !== null ? [predicted.value, predicted.error] : null;
}

function grid(head, rows) {
  const table = element("table", { class: "grid" });
  const line = table.createTHead().insertRow();
  for (const cell of head) line.append(element("th", { scope: "col" }, cell));
  const body = table.createTBody();
  for (const row of rows) {
    const line = body.insertRow();
    for (const cell of row) line.append(element("td", /^[\d.,]+( %)?$/.test(cell) ? { class: "number" } : {}, cell));
  }
  return table;
}

function choose(point) {
  const chosen = byId("chosen");
  chosen.replaceChildren(element("h2", {}, point.name));
  chosen.append(element("p", { class: "quiet" }, point.options || "the default configuration"));
  const values = data.metrics.map((metric) => {
    const found = known(point, metric);
    if (found === null) return `${label(metric)}: not known`;
    const text = point.texts[metric.name] ?? found[0].toPrecision(3);
    return `${label(metric)}: ${text}${found[1] > 0 ? ` ± ${found[1].toPrecision(2)}, predicted` : ""}`;
  });
  chosen.append(element("p", {}, values.join("; ")));
  if (point.summary) for (const line of point.summary.split("\n")) chosen.append(element("p", {}, line));
  for (const table of point.tables ?? []) {
    const scroll = element("div", { class: "scroll" });
    scroll.append(grid(table.head, table.rows));
    chosen.append(element("h3", {}, table.title), scroll);
  }
  chosen.hidden = false;
  for (const circle of document.querySelectorAll("circle"))
    circle.classList.toggle("is-chosen", circle.getAttribute("aria-label") === point.name);
}

// Makes an element show a configuration's stages.
function chooses(made, point) {
  made.setAttribute("tabindex", "0");
  made.addEventListener("click", () => choose(point));
  made.addEventListener("keydown", (event) => { if (event.key === "Enter") choose(point); });
}

function showTip(point, x, y) {
  const lines = data.metrics.filter((metric) => metric.name in point.values).map((metric) => `${point.texts[metric.name]} ${metric.unit}`);
  const tip = byId("tip");
  tip.textContent = [point.name, ...lines, isMeasured(point) ? "" : "not measured"].filter((line) => line).join("\n");
  tip.hidden = false;
  const box = byId("plot").getBoundingClientRect();
  tip.style.left = `${Math.min(x - box.left + 14, box.width - tip.offsetWidth)}px`;
  tip.style.top = `${y - box.top + 14}px`;
}

const PLOT = { left: 70, right: 880, top: 14, bottom: 470 };

// The scale of an axis: a little more than the range of its values.
function scale(values, from, to) {
  const least = Math.min(...values), most = Math.max(...values);
  const margin = (most - least || Math.abs(most) || 1) * 0.06;
  const begin = least >= 0 ? Math.max(0, least - margin) : least - margin, end = most + margin;
  const at = (value) => from + (value - begin) / (end - begin) * (to - from);
  const rough = (end - begin) / 6, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((digit) => digit * power).find((step) => step >= rough);
  const marks = [];
  for (let mark = Math.ceil(begin / step); mark * step <= end; mark++) marks.push(Number((mark * step).toPrecision(6)));
  return { at, marks };
}

function draw() {
  const plot = byId("plot");
  const [across, up] = ["across", "up"].map((id) => data.metrics[byId(id).value]);
  const wanted = data.points.filter((point) => isMeasured(point) || byId("unmeasured").checked);
  const points = wanted.map((point) => ({ point, x: known(point, across), y: known(point, up) })).filter(({ x, y }) => x && y);
  plot.replaceChildren();
  byId("tip").hidden = true;
  if (points.length === 0) {
    plot.append(shape("text", { x: PLOT.left, y: 40 }, "No configuration has both metrics."));
    return;
  }
  const horizontal = scale(points.map(({ x }) => x[0]), PLOT.left, PLOT.right);
  const vertical = scale(points.map(({ y }) => y[0]), PLOT.bottom, PLOT.top);
  for (const mark of horizontal.marks) {
    const x = horizontal.at(mark);
    plot.append(shape("line", { class: "mark", x1: x, x2: x, y1: PLOT.top, y2: PLOT.bottom }));
    plot.append(shape("text", { x, y: PLOT.bottom + 18, "text-anchor": "middle" }, String(mark)));
  }
  for (const mark of vertical.marks) {
    const y = vertical.at(mark);
    plot.append(shape("line", { class: "mark", x1: PLOT.left, x2: PLOT.right, y1: y, y2: y }));
    plot.append(shape("text", { x: PLOT.left - 8, y: y + 4, "text-anchor": "end" }, String(mark)));
  }
  plot.append(shape("line", { class: "axis", x1: PLOT.left, x2: PLOT.right, y1: PLOT.bottom, y2: PLOT.bottom }));
  plot.append(shape("line", { class: "axis", x1: PLOT.left, x2: PLOT.left, y1: PLOT.top, y2: PLOT.bottom }));
  plot.append(shape("text", { x: PLOT.right, y: PLOT.bottom + 40, "text-anchor": "end", id: "label-across" }, label(across)));
  plot.append(shape("text", { x: 8, y: 12, id: "label-up" }, label(up)));
  for (const goal of data.goals) {
    if (goal.metric === across.name) {
      const x = horizontal.at(goal.limit);
      if (x >= PLOT.left && x <= PLOT.right) plot.append(shape("line", { class: "goal", x1: x, x2: x, y1: PLOT.top, y2: PLOT.bottom }));
    }
    if (goal.metric === up.name) {
      const y = vertical.at(goal.limit);
      if (y >= PLOT.top && y <= PLOT.bottom) plot.append(shape("line", { class: "goal", x1: PLOT.left, x2: PLOT.right, y1: y, y2: y }));
    }
  }
  staircase(plot, points, across, up, horizontal, vertical);
  // The front is drawn last, over the others.
  points.sort((a, b) => (a.point.status === "front") - (b.point.status === "front"));
  for (const { point, x, y } of points) {
    const at = [horizontal.at(x[0]), vertical.at(y[0])];
    const clamp = (value, low, high) => Math.max(low, Math.min(high, value));
    if (x[1] > 0) {
      const ends = [-1, 1].map((sign) => clamp(horizontal.at(x[0] + sign * x[1]), PLOT.left, PLOT.right));
      plot.append(shape("line", { class: "error", x1: ends[0], x2: ends[1], y1: at[1], y2: at[1] }));
    }
    if (y[1] > 0) {
      const ends = [-1, 1].map((sign) => clamp(vertical.at(y[0] + sign * y[1]), PLOT.top, PLOT.bottom));
      plot.append(shape("line", { class: "error", x1: at[0], x2: at[0], y1: ends[0], y2: ends[1] }));
    }
    const circle = shape("circle", { class: point.status, cx: at[0], cy: at[1], r: 6, role: "button", "aria-label": point.name });
    chooses(circle, point);
    circle.addEventListener("pointerenter", (event) => showTip(point, event.clientX, event.clientY));
    circle.addEventListener("focus", () => {
      const box = circle.getBoundingClientRect();
      showTip(point, box.right, box.bottom);
    });
    for (const end of ["pointerleave", "blur"]) circle.addEventListener(end, () => { byId("tip").hidden = true; });
    plot.append(circle);
  }
}

// The line below which no configuration that meets the goals is, in these two metrics alone.
function staircase(plot, points, across, up, horizontal, vertical) {
  const cost = (metric, value) => metric.isMaximised ? -value : value;
  const front = points.filter(({ point }) => point.status === "front");
  front.sort((a, b) => cost(across, a.x[0]) - cost(across, b.x[0]) || cost(up, a.y[0]) - cost(up, b.y[0]));
  let path = "", best = Infinity;
  for (const { x, y } of front) {
    if (cost(up, y[0]) >= best) continue;
    best = cost(up, y[0]);
    const [px, py] = [horizontal.at(x[0]), vertical.at(y[0])];
    path += path === "" ? `M ${px} ${py}` : ` H ${px} V ${py}`;
  }
  if (path !== "") plot.append(shape("path", { class: "staircase", d: path }));
}

function begin() {
  byId("summary").append(...data.summary.map((line) => element("p", {}, line)), element("p", { class: "quiet" }, data.setting));
  const wanted = { across: "period", up: "area" };
  for (const [id, name] of Object.entries(wanted)) {
    const select = byId(id);
    data.metrics.forEach((metric, place) => select.append(element("option", { value: place }, label(metric))));
    select.value = Math.max(0, data.metrics.findIndex((metric) => metric.name === name));
    select.addEventListener("change", draw);
  }
  byId("unmeasured").addEventListener("change", draw);
  const front = data.points.filter((point) => point.status === "front");
  const area = (point) => point.values.area ?? 0;
  front.sort((a, b) => area(a) - area(b));
  const rows = front.map((point) => [point.name, ...data.metrics.map((metric) => point.texts[metric.name] ?? "")]);
  const table = grid(["configuration", ...data.metrics.map(label)], rows);
  [...table.tBodies[0].rows].forEach((row, place) => chooses(row, front[place]));
  byId("front").querySelector("table").replaceWith(table);
  draw();
}

begin();
