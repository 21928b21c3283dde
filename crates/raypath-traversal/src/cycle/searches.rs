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
use crate::hardware::SearchPorts;
use crate::search::SearchParameters;
use beats::Beats;
use fetch::{Burst, Fetch};
use list::{List, ListEdge};
use ranks::{Filter, Ranks};
use results::Results;
use std::collections::VecDeque;
use turns::Turns;

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
    /// Beats before the job of a ray that waits, of so many.
    before: u32,
    per_job: u32,
}

/// A beat that is offered to the datapath.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Beat {
    pub is_angular: bool,
    pub is_last: bool,
}

/// A vector or a marker, with the key of its rank.
#[derive(Debug, Clone, Copy)]
struct Item {
    burst: Burst,
    context: u8,
    index: u32,
    key: u32,
    failed: bool,
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
            before: 0,
            per_job: parameters.turns,
        }
    }

    pub fn is_idle(&self) -> bool {
        self.turns.is_idle()
    }

    pub fn outputs(&self) -> SearchOutputs {
        SearchOutputs { ready: self.turns.can_enter(), result: self.results.shown(), request: self.fetch.request() }
    }

    /// The beat that is next at the datapath, if a job of a ray is offered or not.
    pub fn next_beat(&self, is_ray_offered: bool) -> Option<Beat> {
        self.beat().filter(|_| !(is_ray_offered && self.before == self.per_job))
    }

    fn beat(&self) -> Option<Beat> {
        self.beats.offer(self.ranks.can_send())
    }

    /// The clock edge. The datapath takes what is next, if `takes`, and the outcome of the last beat of a vector leaves
    /// it, if `has_outcome`.
    pub fn cycle(&mut self, inputs: &SearchInputs<'_>, is_ray_offered: bool, takes: bool, has_outcome: bool) {
        let is_beat = self.next_beat(is_ray_offered).is_some();
        if takes && (is_ray_offered || self.beat().is_some()) {
            self.before = if is_beat && is_ray_offered { self.before + 1 } else { 0 };
        }
        let leaves = is_beat && takes;
        // Each part reads what the others had in registers.
        let can_send = self.ranks.can_send();
        let has_failed = self.turns.running().is_some_and(|context| self.beats.has_failed(context));
        let takes_ranked = self.ranks.first().filter(|_| self.filter.can_take());
        let next = self.filter.next();
        let arrived_job = self.beats.job();
        let ListEdge { is_free, found, expands, limit } = self.list.edge(self.results.can_push());
        let loads = arrived_job.filter(|_| is_free);
        let taken = next.filter(|_| is_free && arrived_job.is_none());
        let (sent, ended) = self.beats.ends(leaves, loads.is_some(), can_send);
        let list_block = self.beats.list_block();
        let take = self.fetch.has_head() && (self.beats.is_free(ended)) && !self.beats.keeps_query();

        let release = self.results.edge(found, inputs.result_ready, &self.list);
        let burst = self.turns.edge(&turns::Events {
            enters: inputs.job,
            release,
            load: loads.map(|(context, words)| (context, *words)),
            list: list_block.map(|(context, index, words)| (context, index, *words)),
            expands,
            has_failed,
            burst_ready: self.fetch.is_ready(),
        });
        if let Some((context, words)) = loads {
            let words = *words;
            self.results.load(context, &words);
        }
        if let Some((id, ..)) = inputs.job.filter(|_| burst.entered.is_some()) {
            self.results.enter(burst.entered.unwrap_or_default(), id);
        }
        let norm = self.ranks.edge(sent, has_outcome, takes_ranked.is_some());
        if let Some((context, norm)) = norm {
            self.results.norm(context, norm);
        }
        self.filter.edge(takes_ranked, taken.is_some(), limit);
        if let Some((context, words)) = loads {
            let (context, words) = (context, *words);
            self.filter.limit(context, self.list.clear(context, &words));
        }
        if let Some(item) = taken {
            self.list.take(item);
        }
        let head = self.fetch.edge(burst.burst, inputs.request_ready, inputs.response.as_ref(), take);
        self.beats.edge(head, leaves, ended);
    }
}

/// A queue in a memory with a word at the output, as the module `raypath_queue`.
#[derive(Debug, Clone)]
struct Fifo<T> {
    memory: VecDeque<T>,
    output: Option<T>,
}

impl<T> Fifo<T> {
    fn new() -> Self {
        Self { memory: VecDeque::new(), output: None }
    }

    fn first(&self) -> Option<&T> {
        self.output.as_ref()
    }

    fn edge(&mut self, push: Option<T>, pop: bool) {
        if pop {
            self.output = None;
        }
        if self.output.is_none() {
            self.output = self.memory.pop_front();
        }
        self.memory.extend(push);
    }
}
