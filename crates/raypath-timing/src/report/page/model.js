"use strict";
// The recorded window: jobs with the cycles of their stages, and the stalls at the ports.
const model = (() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const flowing = new Array(data.stages).fill(1);
  const jobs = data.jobs.map(([operation, owner, accepted, stays, left], index) => {
    // enters[i] is the first cycle in stage i + 1; the last entry is the first cycle outside the pipeline.
    const enters = [accepted + 1];
    for (const cycles of stays === null ? flowing : stays) enters.push(enters[enters.length - 1] + cycles);
    const gone = enters[enters.length - 1];
    let stalls = 0;
    for (let i = 0; i + 1 < enters.length; i++) stalls += enters[i + 1] - enters[i] - 1;
    return { index, operation, owner, accepted, enters, gone, left, stalls };
  });
  // A stage holds the oldest job in its output register; a younger one waits in the skid buffer until that has left.
  const last = new Array(data.stages).fill(0);
  for (const job of jobs) {
    job.fronts = [];
    for (let i = 0; i + 1 < job.enters.length; i++) {
      job.fronts.push(Math.min(job.enters[i + 1], Math.max(job.enters[i], last[i])));
      last[i] = job.enters[i + 1];
    }
  }

  // The index of the first job with of(job) >= value, by binary search: of(job) ascends with the index.
  function find(value, of) {
    let low = 0, high = jobs.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (of(jobs[middle]) < value) low = middle + 1; else high = middle;
    }
    return low;
  }
  // The stage of a job in a cycle: 0 is the input, -1 outside.
  function stageOf(job, cycle) {
    if (cycle === job.accepted) return 0;
    for (let i = 0; i + 1 < job.enters.length; i++) if (cycle >= job.enters[i] && cycle < job.enters[i + 1]) return i + 1;
    return -1;
  }
  const within = (spans, cycle) => spans.some(([from, cycles]) => cycle >= from && cycle < from + cycles);

  return {
    ...data, jobs, stageOf, within,
    firstInside: (cycle) => find(cycle + 1, (job) => job.gone),
    firstAccepted: (cycle) => find(cycle, (job) => job.accepted),
    name: (job) => data.operations[job.operation] ?? "operation " + job.operation,
  };
})();
