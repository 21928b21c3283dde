//! The cycle-exact model of searches: in every cycle its ports are those of `raypath_search`.
//!
//! Each part is as the module of the same name in `hardware/search` has it. What a search finds is computed when its
//! blocks are taken, by the functions of the functional model.

mod beats;
mod fetch;
mod list;
mod ranks;
mod results;
mod turns;

use crate::engine::{SearchInputs, SearchOutputs};
use crate::hardware::{Burst, SearchPorts};
use crate::search::{BOXES_OPCODE, Branch, KEYS_OPCODE, SearchParameters};
use beats::Beats;
use fetch::Fetch;
use list::{List, ListEdge};
use ranks::{Filter, Ranks};
use raypath_model::{State, StateWords, state};
use raypath_ops::JobKind;
use results::Results;
use std::collections::VecDeque;
use turns::{Events, Turns, TurnsEdge};

/// The searches of a unit.
#[derive(Debug, Clone)]
pub struct Searches {
    turns: Turns,
    fetch: Fetch,
    beats: Beats,
    ranks: Ranks,
    filter: Filter,
    list: List,
    results: Results,
    /// The nodes of trees in the datapath.
    nodes: VecDeque<Visited>,
    /// Beats before the job of a ray that waits, of so many.
    before: u32,
    per_job: u32,
    /// The bits of a job's number and of its base.
    id_mask: u64,
    base_mask: u32,
}

/// A beat that is offered to the datapath.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Beat {
    /// A node of a tree in place of a beat, and whether it is one of keys.
    pub node: Option<bool>,
    pub is_angular: bool,
    pub is_last: bool,
}

impl Beat {
    pub fn opcode(self) -> u64 {
        match self.node {
            Some(true) => KEYS_OPCODE,
            Some(false) => BOXES_OPCODE,
            None if self.is_angular => JobKind::Angular.opcode(),
            None => JobKind::Euclidean.opcode(),
        }
    }
}

state! {
    Searches { turns, fetch, beats, ranks, filter, list, results, nodes, before }
    Item { burst, context, index, key, failed }
    Visited { context, branch, is_last }
}

impl State for Burst {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        use Burst::{Drain, Expand, Job, List, Node, Norm, Query, Vector};
        words.one_of(self, &[Job, Query, Norm, List, Vector, Expand, Drain, Node]);
    }
}

/// A vector or a marker, with the key of its rank.
#[derive(Debug, Clone, Copy, Default)]
struct Item {
    burst: Burst,
    context: u8,
    index: u32,
    key: u32,
    failed: bool,
}

/// Where a search goes from a node, and whether that is the last of its branch.
#[derive(Debug, Clone, Copy, Default)]
struct Visited {
    context: u8,
    branch: Branch,
    is_last: bool,
}

impl Searches {
    pub fn new(parameters: SearchParameters, ports: SearchPorts) -> Self {
        Self {
            turns: Turns::new(parameters),
            fetch: Fetch::new(parameters, ports.memory_width),
            beats: Beats::new(parameters),
            ranks: Ranks::new(ports.divider_latency),
            filter: Filter::new(parameters),
            list: List::new(parameters),
            results: Results::new(parameters),
            nodes: VecDeque::new(),
            before: 0,
            per_job: parameters.turns,
            id_mask: u64::MAX >> (64 - ports.id_width),
            base_mask: u32::MAX.checked_shr(64 - ports.address_width).unwrap_or(0),
        }
    }

    pub fn is_idle(&self) -> bool {
        self.turns.is_idle()
    }

    pub fn outputs(&self) -> SearchOutputs {
        let (result, request) = (self.results.shown(), self.fetch.request());
        SearchOutputs { is_idle: self.is_idle(), ready: self.turns.can_enter(), result, request }
    }

    /// The beat that is next at the datapath, if a job of a ray is offered or not.
    pub fn next_beat(&self, is_ray_offered: bool) -> Option<Beat> {
        let has_turn = !(is_ray_offered && self.before == self.per_job);
        if has_turn { self.beats.offer(self.ranks.can_send()) } else { None }
    }

    /// The clock edge. The datapath takes what is next, if `takes`, which is a beat if `is_beat`. The outcome of the last
    /// beat of a vector leaves it, if `has_outcome`, or that of a node, if `is_tested`.
    pub fn cycle(
        &mut self,
        inputs: &SearchInputs<'_>,
        is_ray_offered: bool,
        takes: bool,
        is_beat: bool,
        [has_outcome, is_tested]: [bool; 2],
    ) {
        let leaves = is_beat && takes;
        if takes && (is_beat || is_ray_offered) {
            self.before = if is_beat && is_ray_offered { self.before + 1 } else { 0 };
        }
        // What each part had in registers.
        let visited = if is_tested { self.nodes.pop_front() } else { None };
        let node = if leaves { self.beats.node() } else { None };
        let has_failed = self.turns.running().is_some_and(|context| self.beats.has_failed(context));
        let (can_send, ranked, kept) = (self.ranks.can_send(), self.ranks.first(), self.filter.next());
        let (job, list) = (self.beats.job(), self.beats.list());
        let ListEdge { is_free, found, expands, limit } = self.list.edge(self.results.can_push());
        let load = job.filter(|_| is_free);
        let kept = kept.filter(|_| is_free && job.is_none());
        let ranked = ranked.filter(|_| self.filter.can_take());
        let (sent, ended) = self.beats.ends(leaves, load.is_some(), can_send);
        let take = self.fetch.has_head() && self.beats.is_free(ended) && !self.beats.keeps_query();

        let release = self.results.edge(found, inputs.result_ready);
        let enters = inputs.job.map(|(id, base, address)| (id & self.id_mask, base & self.base_mask, address));
        let burst_ready = self.fetch.is_ready(inputs.request_ready);
        let events = Events { enters, release, load, list, expands, visited, has_failed, burst_ready };
        let TurnsEdge { burst, entered, overflowed } = self.turns.edge(&events);
        if let (Some(context), Some((id, ..))) = (entered, enters) {
            self.results.enter(context, id);
        }
        if let Some((context, norm)) = self.ranks.edge(sent, has_outcome, ranked.is_some()) {
            self.results.norm(context, norm);
        }
        self.filter.edge(ranked, kept.is_some());
        if let Some((context, limit)) = limit {
            self.filter.limit(context, limit);
        }
        if let Some((context, words)) = load {
            let is_refused = self.turns.is_refused(context);
            self.filter.limit(context, self.list.clear(context, &words, is_refused));
            self.results.load(context, &words);
        }
        if let Some(item) = kept {
            self.list.take(item);
        }
        self.nodes.extend(node);
        let head = self.fetch.edge(burst, inputs.request_ready, inputs.response.as_ref(), take);
        self.beats.edge(head, leaves, ended);
        if let Some(context) = overflowed {
            self.beats.fail(context);
        }
    }
}

/// A queue in a memory with a word at the output, as the module `raypath_queue`.
#[derive(Debug, Clone)]
struct Fifo<T> {
    words: VecDeque<T>,
    /// The first word is at the output.
    has_output: bool,
}

impl<T: State + Default> State for Fifo<T> {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        self.words.pass(words);
        self.has_output.pass(words);
    }
}

impl<T> Fifo<T> {
    fn new() -> Self {
        Self { words: VecDeque::new(), has_output: false }
    }

    #[inline]
    fn first(&self) -> Option<&T> {
        if self.has_output { self.words.front() } else { None }
    }

    #[inline]
    fn edge(&mut self, push: Option<T>, pop: bool) {
        if pop {
            self.words.pop_front();
        }
        self.has_output = !self.words.is_empty();
        if let Some(word) = push {
            self.words.push_back(word);
        }
    }
}
