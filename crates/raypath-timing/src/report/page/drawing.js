"use strict";
// Draws a view of the window. A view is { left, top, cycle, row }: the cycle and row at the left and upper edges, and
// the width of a cycle and the height of a row in pixels.
const drawing = (() => {
  const RULER = 22, LANE = 9, MARGIN = 132;
  const HEAD = RULER + 2 * LANE + 4;
  const operations = ["op0", "op1", "op2", "op3", "op4", "op5", "op6", "op7"];
  let colours = {};

  function readColours() {
    const style = getComputedStyle(document.documentElement);
    for (const name of ["ink", "quiet", "line", "card", "row", "stall", "refused", "unsunk", "accent", "on", "on-bright", ...operations])
      colours[name] = style.getPropertyValue("--" + name).trim();
  }
  const colourOf = (job) => colours[operations[job.operation % operations.length]];
  // The text colour on a job. Three operation colours are too bright for white text.
  const inkOn = (job) => colours[[4, 5, 6].includes(job.operation % operations.length) ? "on-bright" : "on"];

  function prepare(canvas) {
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    return [context, width, height];
  }

  function hatch(context, x, y, width, height) {
    context.fillStyle = colours.stall;
    context.fillRect(x, y, width, height);
    if (width < 4 || height < 4) return;
    context.save();
    context.beginPath();
    context.rect(x, y, width, height);
    context.clip();
    context.strokeStyle = colours.on;
    context.globalAlpha = 0.45;
    context.lineWidth = 1;
    context.beginPath();
    for (let at = x - height; at < x + width; at += 5) {
      context.moveTo(at, y + height);
      context.lineTo(at + height, y);
    }
    context.stroke();
    context.restore();
  }

  // Draws the cycles of a job in a stage: stalled in all but the last cycle, or in all if no exit was recorded.
  function stay(context, job, stage, x, y, width, height, cycle) {
    const colour = colourOf(job);
    context.globalAlpha = stage === 0 ? 0.45 : stage % 2 ? 1 : 0.82;
    context.fillStyle = colour;
    const gap = cycle > 5 ? 1 : 0;
    context.fillRect(x, y, Math.max(width - gap, 0.5), height);
    context.globalAlpha = 1;
    const moves = stage < job.enters.length - 1 || job.left;
    const stalled = stage === 0 ? 0 : width - (moves ? cycle : 0);
    if (stalled > 0.01) hatch(context, x, y, Math.max(stalled - gap, 0.5), height);
    return colour;
  }

  function byJob(context, view, width, height, hovered) {
    const per = Math.max(1, Math.ceil(1 / view.row));
    const from = Math.max(0, Math.floor(view.top)), until = Math.min(model.jobs.length, view.top + (height - HEAD) / view.row + 1);
    const tall = Math.max(view.row - (view.row > 5 ? 1 : 0), 0.8);
    context.font = "11px system-ui, sans-serif";
    for (let index = from; index < until; index += per) {
      const job = model.jobs[index], y = HEAD + (index - view.top) * view.row;
      const x = (cycle) => MARGIN + (cycle - view.left) * view.cycle;
      if (job === hovered) {
        context.fillStyle = colours.row;
        context.fillRect(0, y, width, view.row);
      }
      if (x(job.gone) < MARGIN || x(job.accepted) > width) continue;
      if (view.cycle < 1.5) {
        context.fillStyle = colourOf(job);
        context.fillRect(x(job.accepted), y, Math.max(x(job.gone) - x(job.accepted), 1), tall);
        if (job.stalls > 0) for (let i = 0; i + 1 < job.enters.length; i++) {
          const stalled = job.enters[i + 1] - job.enters[i] - 1;
          if (stalled > 0) hatch(context, x(job.enters[i]), y, Math.max(stalled * view.cycle, 0.5), tall);
        }
        continue;
      }
      stay(context, job, 0, x(job.accepted), y, view.cycle, tall, view.cycle);
      for (let i = 0; i + 1 < job.enters.length; i++) {
        const at = x(job.enters[i]), wide = x(job.enters[i + 1]) - at;
        if (at > width || at + wide < MARGIN) continue;
        stay(context, job, i + 1, at, y, wide, tall, view.cycle);
        if (view.cycle >= 15 && view.row >= 12) {
          context.fillStyle = inkOn(job);
          context.fillText(String(i + 1), x(job.enters[i + 1] - 1) + view.cycle / 2 - (i < 9 ? 3.5 : 6.5), y + view.row / 2 + 4);
        }
      }
    }
    // Labels, drawn last because jobs may extend below them.
    context.fillStyle = colours.card;
    context.fillRect(0, HEAD, MARGIN - 4, height);
    const every = Math.max(1, Math.ceil(13 / view.row));
    for (let index = Math.ceil(from / every) * every; index < until; index += every) {
      const job = model.jobs[index], y = HEAD + (index - view.top) * view.row + Math.min(view.row, 14) / 2 + 4;
      if (y < HEAD + 6) continue;
      context.fillStyle = colourOf(job);
      context.fillRect(4, y - 9, 4, 10);
      context.fillStyle = job === hovered ? colours.ink : colours.quiet;
      context.fillText(`${model.name(job)} ${model.owner} ${job.owner}`, 12, y, MARGIN - 20);
    }
  }

  function byStage(context, view, width, height, hovered) {
    const rows = model.stages + 1, row = (height - HEAD) / rows;
    const x = (cycle) => MARGIN + (cycle - view.left) * view.cycle;
    const end = view.left + (width - MARGIN) / view.cycle;
    context.font = "11px system-ui, sans-serif";
    if (view.cycle >= 5) {
      // Draw bubbles everywhere; jobs cover them.
      context.strokeStyle = colours.line;
      context.setLineDash([2, 2]);
      context.beginPath();
      const [from, until] = [Math.max(Math.floor(view.left), model.first), Math.min(end, model.end)];
      for (let cycle = from; cycle < until; cycle++)
        for (let stage = 0; stage < rows; stage++) context.rect(x(cycle) + 1.5, HEAD + stage * row + 3.5, view.cycle - 4, row - 7);
      context.stroke();
      context.setLineDash([]);
    }
    const drawn = new Array(rows).fill(-Infinity);
    for (let index = model.firstInside(Math.floor(view.left)); index < model.jobs.length; index++) {
      const job = model.jobs[index];
      if (job.accepted > end) break;
      for (let stage = 0; stage < job.enters.length; stage++) {
        const from = stage === 0 ? job.accepted : job.fronts[stage - 1];
        const until = stage === 0 ? job.accepted + 1 : job.enters[stage];
        const [at, over] = [x(from), x(until)];
        const y = HEAD + stage * row + 2, tall = row - 4;
        // Skip jobs that fall on a pixel already drawn.
        if (over <= drawn[stage] + 0.5 && view.cycle < 1) continue;
        drawn[stage] = over;
        context.fillStyle = colours.card;
        context.fillRect(at, y, over - at, tall);
        stay(context, job, stage, at, y, Math.max(over - at, 0.6), tall, view.cycle);
        if (stage > 0 && from > job.enters[stage - 1]) {
          const waits = x(job.enters[stage - 1]);
          context.fillStyle = colourOf(job);
          context.fillRect(waits, y + tall * 0.62, Math.max(at - waits - 1, 0.6), tall * 0.38);
          hatch(context, waits, y + tall * 0.62, Math.max(at - waits - 1, 0.6), tall * 0.38);
        }
        if (job === hovered) {
          context.strokeStyle = colours.ink;
          context.lineWidth = 2;
          context.strokeRect(at + 1, y + 1, Math.max(over - at - 3, 1), tall - 2);
          context.lineWidth = 1;
        }
        if (view.cycle >= 34 && stage > 0) {
          context.fillStyle = inkOn(job);
          context.fillText(String(job.owner), x(until - 1) + 4, y + 12, view.cycle - 8);
        }
      }
    }
    context.fillStyle = colours.card;
    context.fillRect(0, HEAD, MARGIN - 4, height);
    for (let stage = 0; stage < rows; stage++) {
      context.fillStyle = colours.quiet;
      context.fillText(stage === 0 ? "input" : "stage " + stage + (stage === model.stages ? " (output)" : ""), 12, HEAD + stage * row + row / 2 + 4);
    }
  }

  function head(context, view, width, height) {
    const x = (cycle) => MARGIN + (cycle - view.left) * view.cycle;
    const end = view.left + (width - MARGIN) / view.cycle;
    context.fillStyle = colours.card;
    context.fillRect(0, 0, width, HEAD - 2);
    // Port activity: the input lane, and below it the output lane.
    context.fillStyle = colours.row;
    context.fillRect(MARGIN, RULER, width, LANE);
    context.fillRect(MARGIN, RULER + LANE + 1, width, LANE);
    for (let index = model.firstAccepted(Math.floor(view.left)); index < model.jobs.length; index++) {
      const job = model.jobs[index];
      if (job.accepted > end) break;
      context.fillStyle = colourOf(job);
      context.fillRect(x(job.accepted), RULER, Math.max(view.cycle - (view.cycle > 5 ? 1 : 0), 0.6), LANE);
    }
    const lanes = [[model.refused, RULER, colours.refused], [model.stalled, RULER + LANE + 1, colours.unsunk]];
    for (const [spans, y, colour] of lanes) {
      context.fillStyle = colour;
      for (const [from, cycles] of spans)
        if (from + cycles >= view.left && from <= end) context.fillRect(x(from), y, Math.max(cycles * view.cycle, 0.6), LANE);
    }
    context.font = "11px system-ui, sans-serif";
    context.fillStyle = colours.card;
    context.fillRect(0, 0, MARGIN - 4, HEAD);
    context.fillStyle = colours.quiet;
    context.fillText("cycle", 12, 14);
    context.fillText("in", 12, RULER + 8);
    context.fillText("out", 36, RULER + LANE + 9);
    let step = 1;
    while (step * view.cycle < 70) step *= String(step)[0] === "2" ? 2.5 : 2;
    step = Math.max(1, Math.round(step));
    context.strokeStyle = colours.line;
    context.beginPath();
    for (let cycle = Math.max(0, Math.ceil(view.left / step) * step); cycle < end; cycle += step) {
      context.fillText(cycle.toLocaleString("en"), x(cycle) + 3, 14);
      context.moveTo(x(cycle) + 0.5, 0);
      context.lineTo(x(cycle) + 0.5, RULER);
      context.moveTo(x(cycle) + 0.5, HEAD);
      context.lineTo(x(cycle) + 0.5, height);
    }
    context.globalAlpha = 0.7;
    context.stroke();
    context.globalAlpha = 1;
  }

  function overview(canvas, view, width) {
    const [context, wide, tall] = prepare(canvas), refused = operations.length;
    const cycles = Math.max(1, model.end - model.first);
    // A bar covers several cycles, so that its height shows a rate.
    const bar = Math.max(1, Math.ceil((8 * wide) / cycles)), bins = Math.max(1, Math.ceil(wide / bar));
    const per = (cycles * bar) / wide, counts = Array.from({ length: bins }, () => new Array(refused + 1).fill(0));
    for (const job of model.jobs) counts[Math.min(bins - 1, Math.floor((job.accepted - model.first) / per))][job.operation % refused]++;
    for (const [from, length] of model.refused) {
      for (let bin = Math.floor((from - model.first) / per); bin <= Math.min(bins - 1, (from + length - 1 - model.first) / per); bin++) {
        const [begin, over] = [model.first + bin * per, model.first + (bin + 1) * per];
        counts[bin][refused] += Math.max(0, Math.min(over, from + length) - Math.max(begin, from));
      }
    }
    counts.forEach((count, bin) => {
      let y = tall;
      for (let kind = 0; kind <= refused; kind++) {
        const part = Math.min(1, count[kind] / per) * tall;
        context.fillStyle = kind === refused ? colours.refused : colours[operations[kind]];
        context.fillRect(bin * bar, y - part, bar, part);
        y -= part;
      }
    });
    const x = (cycle) => ((cycle - model.first) / cycles) * wide;
    const [from, until] = [x(view.left), x(view.left + (width - MARGIN) / view.cycle)];
    context.strokeStyle = colours.ink;
    context.lineWidth = 2;
    context.strokeRect(Math.max(1, from), 1, Math.max(4, Math.min(wide - 1, until) - Math.max(1, from)), tall - 2);
  }

  return {
    HEAD, MARGIN, readColours,
    draw(canvas, small, view, rows, hovered) {
      const [context, width, height] = prepare(canvas);
      (rows === "job" ? byJob : byStage)(context, view, width, height, hovered);
      head(context, view, width, height);
      overview(small, view, width);
    },
  };
})();
