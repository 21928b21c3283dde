//! What each search fetches next.

use super::fetch::Blocks;
use super::{Fifo, Visited};
use crate::hardware::{Burst, Phase, TURNS_WAITING};
use crate::search::{BRANCHES, Branch, NODE_BLOCKS, NODE_BYTES, Place, SEARCH_BLOCK, SearchJob, SearchParameters};
use raypath_model::{StateWords, state};

/// Vectors or indices of a turn.
const PER_TURN: u32 = 16;

/// Indices in a word of the memory of those that were compared.
const WAYS: usize = 8;

#[derive(Debug, Clone)]
pub struct Turns {
    parameters: SearchParameters,
    searches: Vec<Search>,
    /// A bit for each search: it is in the unit, it can go on, it has had no turn.
    in_use: u32,
    waits: u32,
    is_new: u32,
    /// A bit for each search with indices of the one before, as all have after a reset.
    remembered: u32,
    /// The searches behind the one that had the last turn.
    after: u32,
    /// The search whose compared indices are forgotten, and the number of the next set.
    sweep: Option<(u8, usize)>,
    turn: Option<Turn>,
    burst: Option<Pending>,
    /// The bursts that wait, and their number with that on the way to the output.
    queue: Fifo<Blocks>,
    count: u32,
}

#[derive(Debug, Clone)]
struct Search {
    base: u32,
    address: u32,
    /// None if the job was refused.
    job: Option<SearchJob>,
    state: State,
    candidate: u32,
    /// The blocks of lists that have arrived last, by the lowest bit of their numbers.
    lists: [[u32; 16]; 2],
    half: usize,
    compared: Vec<[u32; WAYS]>,
    /// The branches of a tree that are visited, the last one first.
    branches: Vec<Branch>,
}

#[derive(Debug, Clone, Copy, Default)]
struct State {
    phase: Phase,
    number: u32,
    left: u32,
    spent: u32,
}

#[derive(Debug, Clone, Copy, Default)]
struct Turn {
    context: u8,
    step: u32,
    state: State,
    /// The list that has arrived last, when the turn began.
    half: usize,
    candidate: u32,
    branch: Option<Branch>,
}

/// A burst whose address is computed. One of an index that was compared before, or has no vector, is dropped.
#[derive(Debug, Clone, Copy, Default)]
struct Pending {
    blocks: Blocks,
    /// The set of the index, and the indices in it.
    compared: Option<(usize, [u32; WAYS])>,
    is_outside: bool,
}

state! {
    Turns { searches, in_use, waits, is_new, remembered, after, sweep, turn, burst, queue, count }
    State { phase, number, left, spent }
    Turn { context, step, state, half, candidate, branch }
    Branch { first, children, is_leaf }
    Pending { blocks, compared, is_outside }
}

impl raypath_model::State for Search {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        let Self { base, address, job, state, candidate, lists, half, compared, branches } = self;
        let mut of_job = job.map(|job| job.words());
        of_job.pass(words);
        *job = of_job.and_then(|words| SearchJob::from_words(words, &SearchParameters::MOST).ok());
        base.pass(words);
        address.pass(words);
        state.pass(words);
        candidate.pass(words);
        lists.pass(words);
        half.pass(words);
        compared.pass(words);
        words.many(branches);
    }
}

impl raypath_model::State for Phase {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        use Phase::{Begin, Enter, Expand, List, Neighbours, Scan, Visit};
        words.one_of(self, &[Enter, Begin, Scan, List, Neighbours, Expand, Visit]);
    }
}

/// What happens in a cycle.
pub struct Events {
    /// A job that is offered: its number, base and address.
    pub enters: Option<(u64, u32, u32)>,
    pub release: Option<u8>,
    /// A job whose words have come.
    pub load: Option<(u8, [u32; 16])>,
    pub list: Option<(u8, u32, [u32; 16])>,
    pub expands: Option<(u8, u32)>,
    /// The outcome of a node.
    pub visited: Option<Visited>,
    /// A block of the search whose turn it is has failed.
    pub has_failed: bool,
    pub burst_ready: bool,
}

/// What leaves at a clock edge.
pub struct TurnsEdge {
    pub burst: Option<Blocks>,
    /// The number of the search that has entered.
    pub entered: Option<u8>,
    /// A search with more branches than there are places.
    pub overflowed: Option<u8>,
}

impl Turns {
    pub fn new(parameters: SearchParameters) -> Self {
        let state = State { phase: Phase::Enter, number: 0, left: 0, spent: 0 };
        let search = Search {
            base: 0,
            address: 0,
            job: None,
            state,
            candidate: 0,
            lists: [[0; 16]; 2],
            half: 0,
            compared: vec![[u32::MAX; WAYS]; parameters.remembered as usize / WAYS],
            branches: Vec::new(),
        };
        Self {
            parameters,
            searches: vec![search; parameters.contexts as usize],
            in_use: 0,
            waits: 0,
            is_new: 0,
            remembered: (1 << parameters.contexts) - 1,
            after: 0,
            sweep: None,
            turn: None,
            burst: None,
            queue: Fifo::new(),
            count: 0,
        }
    }

    pub fn is_idle(&self) -> bool {
        self.in_use == 0
    }

    pub fn can_enter(&self) -> bool {
        self.in_use != (1 << self.parameters.contexts) - 1 && self.sweep.is_none()
    }

    /// The search whose turn it is.
    pub fn running(&self) -> Option<u8> {
        self.turn.map(|turn| turn.context)
    }

    /// Whether the job that was loaded last in a search was refused.
    pub fn is_refused(&self, context: u8) -> bool {
        self.searches[usize::from(context)].job.is_none()
    }

    /// The clock edge.
    pub fn edge(&mut self, events: &Events) -> TurnsEdge {
        let entered = events.enters.filter(|_| self.can_enter()).map(|_| (!self.in_use).trailing_zeros() as u8);
        let skips = self.burst.is_some_and(Pending::is_skipped);
        let burst = self.burst.filter(|_| !skips && self.count < TURNS_WAITING);
        let taken = self.queue.first().copied().filter(|_| events.burst_ready);
        self.count = self.count + u32::from(burst.is_some()) - u32::from(taken.is_some());
        self.queue.edge(burst.map(|pending| pending.blocks), taken.is_some());
        let moves = self.burst.is_none() || skips || burst.is_some();
        let remembers = burst.and_then(|pending| Some((pending.blocks, pending.compared?)));

        let (mut came, mut ended) = (0_u32, None);
        let (mut next, mut pops) = (None, None);
        if let Some(turn) = self.turn.filter(|_| moves) {
            let step = self.step(turn, events.has_failed);
            next = step.asks;
            pops = step.pops.then_some(turn.context);
            if step.ends {
                ended = Some((turn.context, step.state));
                came |= u32::from(step.again) << turn.context;
            } else {
                self.turn = Some(Turn { step: turn.step + 1, state: step.state, ..turn });
            }
        }
        let picked = self.pick(ended.is_some());

        // The memories: what is written is read from the next cycle on.
        if let Some((context, state)) = ended {
            self.searches[usize::from(context)].state = state;
            self.turn = None;
        }
        if let Some(turn) = picked {
            self.turn = Some(turn);
        }
        self.remember(remembers);
        if let Some(context) = pops {
            self.searches[usize::from(context)].branches.pop();
        }
        let mut overflowed = None;
        if let Some(Visited { context, branch, is_last }) = events.visited {
            let branches = &mut self.searches[usize::from(context)].branches;
            match branch.children {
                0 => {}
                _ if branches.len() == BRANCHES => overflowed = Some(context),
                _ => branches.push(branch),
            }
            came |= u32::from(is_last) << context;
        }
        if let (Some(context), Some((_, base, address))) = (entered, events.enters) {
            let search = &mut self.searches[usize::from(context)];
            (search.base, search.address) = (base, address);
            search.branches.clear();
            if self.remembered >> context & 1 == 1 {
                self.sweep = Some((context, 0));
            }
            self.remembered &= !(1 << context);
            came |= 1 << context;
            self.in_use |= 1 << context;
            self.is_new |= 1 << context;
        }
        if let Some(context) = events.release {
            self.in_use &= !(1 << context);
        }
        if let Some((context, words)) = &events.load {
            let job = SearchJob::from_words(*words, &self.parameters).ok();
            self.searches[usize::from(*context)].job = job;
            came |= 1 << context;
        }
        if let Some((context, number, words)) = &events.list {
            let search = &mut self.searches[usize::from(*context)];
            search.half = *number as usize % 2;
            search.lists[search.half] = *words;
            came |= 1 << context;
        }
        if let Some((context, index)) = events.expands {
            self.searches[usize::from(context)].candidate = index;
            came |= 1 << context;
        }
        let picked = picked.map_or(0, |turn| 1 << turn.context);
        self.waits = (self.waits | came) & !picked;
        self.is_new &= !picked;
        if moves {
            self.burst = next;
        }
        TurnsEdge { burst: taken, entered, overflowed }
    }

    /// The turn that begins in the next cycle, if there is none or one ends.
    fn pick(&mut self, ends: bool) -> Option<Turn> {
        let own = self.turn.map_or(0, |turn| 1 << turn.context);
        let swept = self.sweep.map_or(0, |(context, _)| 1 << context) & !self.is_new;
        let can = self.waits & !own & !swept;
        if can == 0 || (self.turn.is_some() && !ends) {
            return None;
        }
        let later = can & self.after;
        let context = if later != 0 { later } else { can }.trailing_zeros();
        self.after = !0 << context << 1;
        let Search { state, half, candidate, branches, .. } = &self.searches[context as usize];
        let is_new = self.is_new >> context & 1 == 1;
        let state = State { phase: if is_new { Phase::Enter } else { state.phase }, ..*state };
        let (half, branch) = (*half, branches.last().copied());
        Some(Turn { context: context as u8, step: 0, state, half, candidate: *candidate, branch })
    }

    /// An index is remembered, or a set of indices is forgotten.
    fn remember(&mut self, remembers: Option<(Blocks, (usize, [u32; WAYS]))>) {
        if let Some((Blocks { context, index, .. }, (set, mut known))) = remembers {
            known.rotate_right(1);
            known[0] = index;
            self.searches[usize::from(context)].compared[set] = known;
            self.remembered |= 1 << context;
        } else if let Some((context, set)) = self.sweep {
            let compared = &mut self.searches[usize::from(context)].compared;
            compared[set] = [u32::MAX; WAYS];
            self.sweep = (set + 1 < compared.len()).then_some((context, set + 1));
        }
    }

    /// A step of a turn.
    fn step(&self, turn: Turn, block_failed: bool) -> Step {
        let Turn { context, step, state, .. } = turn;
        let search = &self.searches[usize::from(context)];
        let address = |address: u32| u64::from(search.base) << 32 | u64::from(address);
        let ask = |burst, index, to: u32, count| {
            Some(Pending {
                blocks: Blocks { burst, context, index, address: address(to), count },
                compared: None,
                is_outside: false,
            })
        };
        let drain = || Step::last(ask(Burst::Drain, state.number, 0, 0), state);
        if state.phase == Phase::Enter {
            let asks = ask(Burst::Job, state.number, search.address, 1);
            return Step::last(asks, State { phase: Phase::Begin, ..state });
        }
        let stops = match state.phase {
            Phase::Begin | Phase::List | Phase::Neighbours | Phase::Visit => step == 0,
            Phase::Scan => true,
            Phase::Enter | Phase::Expand => false,
        };
        // The step is that of a job, also if its blocks fail meanwhile.
        search.job.as_ref().filter(|_| !(block_failed && stops)).map_or_else(drain, |job| self.step_of(turn, job, ask))
    }

    fn step_of(&self, turn: Turn, job: &SearchJob, ask: impl Fn(Burst, u32, u32, u32) -> Option<Pending>) -> Step {
        let Turn { step, state, context, .. } = turn;
        let blocks = job.layout().bytes() / SEARCH_BLOCK;
        let (places, expansions) = match job.place {
            Place::Scan => ((0, 0), 0),
            Place::Gather { list, len } => ((list, len), 0),
            Place::Graph { entries, entry_count, expansions, .. } => ((entries, entry_count), expansions),
            Place::Keys { nodes, len, expansions } => ((nodes, len), expansions),
            Place::Boxes { nodes, expansions } => ((nodes, 0), expansions),
        };
        let is_tree = matches!(job.place, Place::Keys { .. } | Place::Boxes { .. });
        let spent = if state.phase == Phase::Begin { 0 } else { state.spent };
        let mark = |state: State| {
            if spent < expansions {
                Step::last(
                    ask(Burst::Expand, state.number, 0, 0),
                    State { phase: Phase::Expand, spent: spent + 1, ..state },
                )
            } else {
                Step::last(ask(Burst::Drain, state.number, 0, 0), state)
            }
        };
        let list =
            |base: u32, number: u32| ask(Burst::List, number, base.wrapping_add(number.wrapping_mul(SEARCH_BLOCK)), 1);
        // A vector that may be none.
        let check = |index: u32| {
            let to = job.vectors.wrapping_add(index.wrapping_mul(job.stride));
            ask(Burst::Vector, index, to, blocks).map(|pending| Pending { is_outside: index >= job.count, ..pending })
        };
        // One that may have been compared before.
        let compare = |index: u32| {
            let sets = self.searches[0].compared.len();
            let set = (index ^ index >> sets.trailing_zeros()) as usize % sets;
            let compared = Some((set, self.searches[usize::from(context)].compared[set]));
            check(index).map(|pending| Pending { compared, ..pending })
        };
        let node = |index: u32, is_last: bool| {
            let to = places.0.wrapping_add(index.wrapping_mul(NODE_BYTES));
            ask(Burst::Node, is_last.into(), to, NODE_BLOCKS)
        };
        let neighbours = || match job.place {
            Place::Graph { neighbours, degree, .. } => {
                let stride = (4 * degree).next_multiple_of(SEARCH_BLOCK);
                (neighbours.wrapping_add(turn.candidate.wrapping_mul(stride)), degree)
            }
            _ => (0, 0),
        };
        match state.phase {
            Phase::Enter => Step::last(None, state),
            Phase::Begin => match (step, job.place) {
                (0, _) => Step::inner(ask(Burst::Query, state.number, job.query, blocks), state),
                (1, _) => {
                    let is_cosine = job.metric == crate::search::SearchMetric::Cosine;
                    let asks = ask(Burst::Norm, state.number, job.query, blocks).filter(|_| is_cosine);
                    Step::inner(asks, state)
                }
                (_, Place::Scan) if job.count == 0 => Step::last(ask(Burst::Drain, state.number, 0, 0), state),
                (_, Place::Scan) => {
                    let next = State { phase: Phase::Scan, number: 0, left: job.count, spent };
                    Step { again: true, ..Step::last(None, next) }
                }
                _ if is_tree => Step::last(node(0, true), State { phase: Phase::Visit, number: 0, left: 0, spent }),
                _ if places.1 == 0 => mark(state),
                _ => Step::last(list(places.0, 0), State { phase: Phase::List, number: 0, left: places.1, spent }),
            },
            Phase::Scan if state.left == 0 => Step::last(ask(Burst::Drain, state.number, 0, 0), state),
            Phase::Scan => {
                let asks = check(state.number);
                let next = State { number: state.number.wrapping_add(1), left: state.left - 1, ..state };
                if step + 1 == PER_TURN {
                    Step { again: true, ..Step::last(asks, next) }
                } else {
                    Step::inner(asks, next)
                }
            }
            Phase::List | Phase::Neighbours => {
                let (base, _) = if state.phase == Phase::List { places } else { neighbours() };
                if step == 0 {
                    return Step::inner(
                        list(base, state.number.wrapping_add(1)).filter(|_| state.left > PER_TURN),
                        state,
                    );
                }
                let place = step - 1;
                if place == state.left {
                    return mark(state);
                }
                let asks = compare(self.searches[usize::from(context)].lists[turn.half][place as usize % 16]);
                if step == PER_TURN && state.left > PER_TURN {
                    Step::last(
                        asks,
                        State { number: state.number.wrapping_add(1), left: state.left - PER_TURN, ..state },
                    )
                } else {
                    Step::inner(asks, state)
                }
            }
            Phase::Expand => {
                let (base, degree) = neighbours();
                if degree == 0 {
                    return mark(state);
                }
                Step::last(list(base, 0), State { phase: Phase::Neighbours, number: 0, left: degree, ..state })
            }
            Phase::Visit => {
                let cannot = turn.branch.is_none_or(|branch| !branch.is_leaf && spent >= expansions);
                if step == 0 && cannot {
                    return Step::last(ask(Burst::Drain, state.number, 0, 0), state);
                }
                let Branch { first, children, is_leaf } = turn.branch.unwrap_or_default();
                let pops = step == 0;
                if is_leaf && matches!(job.place, Place::Keys { .. }) {
                    let next = State { phase: Phase::Scan, number: first, left: places.1, ..state };
                    return Step { again: true, pops, ..Step::last(None, next) };
                }
                let (place, vector) = if is_leaf { (step / 4, step % 4) } else { (step, 3) };
                let rest = (0..place).fold(children, |rest, _| rest & rest.wrapping_sub(1));
                let (child, is_last_child) = (rest.trailing_zeros(), rest.count_ones() <= 1);
                let index = first.wrapping_add(if is_leaf { 4 * child + vector } else { child });
                let asks = if is_leaf { check(index) } else { node(index, is_last_child) };
                if is_last_child && vector == 3 {
                    let next = State { spent: spent + u32::from(!is_leaf), ..state };
                    Step { again: is_leaf, pops, ..Step::last(asks, next) }
                } else {
                    Step { pops, ..Step::inner(asks, state) }
                }
            }
        }
    }
}

/// What a step does.
struct Step {
    asks: Option<Pending>,
    state: State,
    /// The turn ends.
    ends: bool,
    /// The search can go on at once.
    again: bool,
    /// The branch is taken.
    pops: bool,
}

impl Step {
    /// One after which the turn goes on.
    fn inner(asks: Option<Pending>, state: State) -> Self {
        Self { asks, state, ends: false, again: false, pops: false }
    }

    /// One after which it ends.
    fn last(asks: Option<Pending>, state: State) -> Self {
        Self { ends: true, ..Self::inner(asks, state) }
    }
}

impl Pending {
    fn is_skipped(self) -> bool {
        self.is_outside || self.compared.is_some_and(|(_, known)| known.contains(&self.blocks.index))
    }
}
