"use strict";
// The view of the timeline and its controls.
(() => {
  const canvas = document.getElementById("canvas");
  if (!canvas) return;
  const small = document.getElementById("overview"), tip = document.getElementById("tip"), range = document.getElementById("range");
  const { HEAD, MARGIN } = drawing;
  let rows = "job", hovered = null, drag = null, asked = false;
  let view = { left: 0, top: 0, cycle: 18, row: 18 };

  const wide = () => Math.max(1, canvas.clientWidth - MARGIN), tall = () => Math.max(1, canvas.clientHeight - HEAD);
  const cycles = () => Math.max(1, model.end - model.first);

  function clamp() {
    view.cycle = Math.min(80, Math.max(Math.min(18, wide() / cycles()), view.cycle));
    view.row = Math.min(36, Math.max(Math.min(18, tall() / model.jobs.length), view.row));
    const shown = wide() / view.cycle, fits = shown >= cycles() - 1e-6;
    const [lowest, highest] = fits ? [model.end - shown, model.first] : [model.first - 2, model.end + 2 - shown];
    view.left = Math.min(Math.max(view.left, lowest), highest);
    view.top = Math.min(Math.max(view.top, 0), Math.max(0, model.jobs.length + 1 - tall() / view.row));
  }
  function show() {
    clamp();
    const end = Math.min(model.end, view.left + wide() / view.cycle);
    const [from, until] = [Math.max(model.first, Math.floor(view.left)), Math.ceil(end)];
    range.textContent = `cycles ${from} to ${until} of ${model.first} to ${model.end}`;
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; drawing.draw(canvas, small, view, rows, hovered); });
  }
  // Scrolls the rows so that the oldest job inside in the leftmost cycle is at the top.
  function follow() {
    view.top = model.firstInside(Math.max(model.first, Math.ceil(view.left))) - 1;
  }
  function reset() {
    Object.assign(view, { left: model.jobs[0].accepted - 1, top: 0, cycle: 18, row: 18 });
    show();
  }
  function all() {
    Object.assign(view, { left: model.first, top: 0, cycle: wide() / cycles(), row: tall() / model.jobs.length });
    show();
  }
  function zoom(factor, x, y) {
    const cycle = view.left + (x - MARGIN) / view.cycle, row = view.top + (y - HEAD) / view.row;
    view.cycle *= factor;
    view.row *= factor;
    clamp();
    // Rounded, so that zooming in and out restores the view exactly.
    view.left = Math.round((cycle - (x - MARGIN) / view.cycle) * 1e6) / 1e6;
    view.top = Math.round((row - (y - HEAD) / view.row) * 1e6) / 1e6;
    show();
  }
  function zoomCentre(factor) { zoom(factor, MARGIN + wide() / 2, HEAD + tall() / 2); }
  function move(part) {
    view.left += (part * wide()) / view.cycle;
    clamp();
    follow();
    show();
  }
  function choose(which) {
    rows = which;
    document.getElementById("by-job").setAttribute("aria-pressed", String(which === "job"));
    document.getElementById("by-stage").setAttribute("aria-pressed", String(which === "stage"));
    if (which === "job") follow();
    show();
  }
  function nextStall() {
    const after = Math.floor(view.left + wide() / view.cycle / 3);
    const ahead = (spans) => spans.map(([from]) => from).find((from) => from > after + 1);
    const found = [ahead(model.refused), ahead(model.stalled)].filter((cycle) => cycle !== undefined);
    if (found.length === 0) return;
    view.left = Math.min(...found) - wide() / view.cycle / 3;
    clamp();
    follow();
    show();
  }

  function at(event) {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }
  function jobAt(x, y) {
    if (x < 0 || y < HEAD) return null;
    const cycle = Math.floor(view.left + (x - MARGIN) / view.cycle);
    if (rows === "job") return model.jobs[Math.floor(view.top + (y - HEAD) / view.row)] ?? null;
    const height = tall() / (model.stages + 1), stage = Math.floor((y - HEAD) / height);
    const there = [];
    for (let index = model.firstInside(cycle); index < model.jobs.length && model.jobs[index].accepted <= cycle; index++)
      if (model.stageOf(model.jobs[index], cycle) === stage) there.push(model.jobs[index]);
    const waits = (y - HEAD) / height - stage > 0.6 && there.length > 1;
    return there[waits ? 1 : 0] ?? null;
  }
  function describe(job, cycle) {
    const lines = [`${model.name(job)}, ${model.owner} ${job.owner}`, `job ${job.index} of the window`, `accepted in cycle ${job.accepted}`];
    for (let i = 0; i + 1 < job.enters.length; i++) {
      const stay = job.enters[i + 1] - job.enters[i], here = cycle >= job.enters[i] && cycle < job.enters[i + 1];
      const stalled = stay > 1 ? `, ${stay - 1} stalled` : "";
      lines.push(`${here ? "▸" : "  "} stage ${i + 1}: cycle ${job.enters[i]}${stalled}`);
    }
    lines.push(job.left ? `left in cycle ${job.gone - 1}` : "exit not recorded");
    if (job.left) lines.push(`${job.gone - 1 - job.accepted} cycles in total, ${job.stalls} stalled`);
    return lines.join("\n");
  }
  function hover(event) {
    const [x, y] = at(event), job = jobAt(x, y);
    if (job !== hovered) {
      hovered = job;
      show();
    }
    const cycle = Math.floor(view.left + (x - MARGIN) / view.cycle);
    tip.hidden = job === null && !(y < HEAD && x > MARGIN);
    if (tip.hidden) return;
    const ends = [`cycle ${cycle}`];
    if (model.within(model.refused, cycle)) ends.push("offered job not accepted");
    if (model.within(model.stalled, cycle)) ends.push("sink not ready");
    tip.textContent = job ? describe(job, cycle) : ends.join("\n");
    tip.style.left = (x + tip.offsetWidth + 24 > canvas.clientWidth ? Math.max(0, x - tip.offsetWidth - 12) : x + 16) + "px";
    tip.style.top = Math.max(0, Math.min(y + 12, canvas.clientHeight - tip.offsetHeight)) + "px";
  }

  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const amount = event.deltaMode === 1 ? 16 * event.deltaY : event.deltaY;
    if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) return move((event.deltaX || amount) / 1000);
    zoom(Math.exp(-Math.max(-300, Math.min(300, amount)) / 500), ...at(event));
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    drag = { x: event.clientX, y: event.clientY, left: view.left, top: view.top };
    canvas.setPointerCapture(event.pointerId);
    canvas.classList.add("dragged");
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!drag) return hover(event);
    view.left = drag.left - (event.clientX - drag.x) / view.cycle;
    view.top = drag.top - (event.clientY - drag.y) / view.row;
    tip.hidden = true;
    show();
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => {
    drag = null;
    canvas.classList.remove("dragged");
  });
  canvas.addEventListener("pointerleave", () => {
    tip.hidden = true;
    hovered = null;
    show();
  });
  canvas.addEventListener("dblclick", reset);

  const keys = {
    ArrowLeft: () => move(-0.1), ArrowRight: () => move(0.1), PageUp: () => move(-0.8), PageDown: () => move(0.8),
    ArrowUp: () => { view.top -= 0.1 * tall() / view.row; show(); },
    ArrowDown: () => { view.top += 0.1 * tall() / view.row; show(); },
    "+": () => zoomCentre(1.25), "=": () => zoomCentre(1.25), "-": () => zoomCentre(0.8), "0": reset, s: nextStall,
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  const buttons = {
    "by-job": () => choose("job"), "by-stage": () => choose("stage"), "zoom-in": () => zoomCentre(1.5), "zoom-out": () => zoomCentre(1 / 1.5),
    earlier: () => move(-0.5), later: () => move(0.5), stall: nextStall, all, reset,
  };
  for (const [id, act] of Object.entries(buttons)) document.getElementById(id).addEventListener("click", act);

  function jump(event) {
    const box = small.getBoundingClientRect();
    view.left = model.first + ((event.clientX - box.left) / box.width) * cycles() - wide() / view.cycle / 2;
    clamp();
    follow();
    show();
  }
  small.addEventListener("pointerdown", (event) => { small.setPointerCapture(event.pointerId); jump(event); });
  small.addEventListener("pointermove", (event) => { if (event.buttons) jump(event); });

  const colours = () => { drawing.readColours(); show(); };
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", colours);
  new ResizeObserver(show).observe(canvas);
  drawing.readColours();
  reset();
})();
