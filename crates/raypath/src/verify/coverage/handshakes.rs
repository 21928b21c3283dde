use super::Atlas;
use raypath_model::Control;
use raypath_ops::JobKind;

const KINDS: usize = JobKind::ALL.len();

/// What happened at the ports, in numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Handshakes {
    /// Cycles by what the source met, what the sink met, and how full it was.
    cycles: [[[u64; 3]; 4]; 3],
    /// Resets by how many jobs were inside.
    resets: Vec<u64>,
    /// Jobs accepted, by the kind before, the kind, and whether it came in the very next cycle.
    pairs: [[[u64; 2]; KINDS]; KINDS],
    /// Jobs withdrawn, by kind, and whether they had been refused.
    withdrawn: [[u64; 2]; KINDS],
}

const SOURCES: [&str; 3] = ["accepted", "refused", "idle"];
const SINKS: [&str; 4] = ["taken", "held", "ready for nothing", "idle"];
const FILLS: [&str; 3] = ["empty", "between", "full"];

impl Handshakes {
    pub(super) fn new(capacity: usize) -> Self {
        Self {
            cycles: Default::default(),
            resets: vec![0; capacity + 1],
            pairs: Default::default(),
            withdrawn: Default::default(),
        }
    }

    /// Counts a cycle: whether the source offered and was accepted, whether the sink took and there was something, and
    /// how many jobs of how many were inside.
    pub(super) fn cycle(&mut self, source: (bool, bool), sink: (bool, bool), inside: usize) {
        let source = match source {
            (true, true) => 0,
            (true, false) => 1,
            (false, _) => 2,
        };
        let sink = match sink {
            (true, true) => 0,
            (false, true) => 1,
            (true, false) => 2,
            (false, false) => 3,
        };
        let full = self.resets.len() - 1;
        let fill = if inside == 0 { 0 } else { 1 + usize::from(inside >= full) };
        self.cycles[source][sink][fill] += 1;
    }

    pub(super) fn reset(&mut self, inside: usize) {
        let most = self.resets.len() - 1;
        self.resets[inside.min(most)] += 1;
    }

    pub(super) fn pair(&mut self, before: JobKind, kind: JobKind, is_next_cycle: bool) {
        self.pairs[before as usize][kind as usize][usize::from(is_next_cycle)] += 1;
    }

    pub(super) fn withdrawn(&mut self, kind: JobKind, was_refused: bool) {
        self.withdrawn[kind as usize][usize::from(was_refused)] += 1;
    }

    pub(super) fn add(&mut self, other: &Self) {
        let sum = |mine: &mut u64, others: &u64| *mine += others;
        let cycles = self.cycles.as_flattened_mut().as_flattened_mut().iter_mut();
        cycles.zip(other.cycles.as_flattened().as_flattened()).for_each(|(mine, others)| sum(mine, others));
        self.resets.iter_mut().zip(&other.resets).for_each(|(mine, others)| sum(mine, others));
        let pairs = self.pairs.as_flattened_mut().as_flattened_mut().iter_mut();
        pairs.zip(other.pairs.as_flattened().as_flattened()).for_each(|(mine, others)| sum(mine, others));
        let withdrawn = self.withdrawn.as_flattened_mut().iter_mut();
        withdrawn.zip(other.withdrawn.as_flattened()).for_each(|(mine, others)| sum(mine, others));
    }

    /// All places that can be reached, with their counts.
    pub(super) fn places(&self, atlas: &Atlas) -> Vec<(String, u64)> {
        let mut places = Vec::new();
        for (source, of_source) in SOURCES.iter().zip(&self.cycles) {
            for (sink, of_sink) in SINKS.iter().zip(of_source) {
                for (fill, &count) in FILLS.iter().zip(of_sink) {
                    if is_reachable(atlas, source, sink, fill) {
                        places.push((format!("cycle: source {source}, sink {sink}, {fill}"), count));
                    }
                }
            }
        }
        places.extend(
            self.resets.iter().enumerate().map(|(inside, &count)| (format!("reset with {inside} inside"), count)),
        );
        for &before in atlas.kinds {
            for &kind in atlas.kinds {
                let [later, next] = self.pairs[before as usize][kind as usize];
                places.push((format!("{kind} after {before}, with a gap"), later));
                if !keeps_apart(atlas, before, kind) {
                    places.push((format!("{kind} after {before}, in the next cycle"), next));
                }
            }
        }
        for &kind in atlas.kinds {
            let [unoffered, refused] = self.withdrawn[kind as usize];
            places.push((format!("{kind} withdrawn before it was refused"), unoffered));
            places.push((format!("{kind} withdrawn after it was refused"), refused));
        }
        places
    }
}

/// With credits a gate at the entrance keeps beats of a sum that takes several steps apart.
fn keeps_apart(atlas: &Atlas, before: JobKind, kind: JobKind) -> bool {
    let is_loop = |kind: JobKind| {
        atlas.shape.loops.iter().any(|a_loop| a_loop.opcode == kind.opcode() && a_loop.last > a_loop.first)
    };
    atlas.shape.control == Control::Credit && before == kind && is_loop(kind)
}

/// What contradicts itself: an empty datapath shows nothing and accepts; a full one shows something and refuses. Where
/// no sum takes several steps, only a sink that refused can make the datapath refuse: with credits it then is full, and
/// with skid buffers all places up to the output hold something, so that the output shows something until the entrance
/// is ready again.
fn is_reachable(atlas: &Atlas, source: &str, sink: &str, fill: &str) -> bool {
    let shows = ["taken", "held"].contains(&sink);
    let has_loops = !atlas.shape.loops.is_empty();
    match fill {
        "empty" => !shows && source != "refused",
        "full" => shows && source != "accepted",
        _ if source == "refused" && !has_loops => shows && atlas.shape.control == Control::Skid,
        _ => true,
    }
}
