//! The words of a job: whether one is outside its range, and what parts of the hardware need of them.

use super::super::connect::{Named, named};
use super::fetch::COUNT_BITS;
use super::list::place_bits;
use super::wiring::{BLOCK_BITS, BLOCK_SHIFT, key_of};
use crate::search::SearchParameters;
use raypath_hdl::{Builder, Wire};

/// What follows from the words of a job.
pub struct Settings<'m> {
    words: &'m [Wire<'m>],
    parameters: SearchParameters,
    refused: Wire<'m>,
    /// Blocks of a vector.
    blocks: Wire<'m>,
}

impl<'m> Settings<'m> {
    pub fn of(m: &'m Builder, parameters: SearchParameters, words: &'m [Wire<'m>]) -> Self {
        m.section("The job that was loaded: whether a word is outside its range");
        let (low, high) = (|k: usize| words[k].lower(16), |k: usize| words[k].upper(16));
        let most = |wire: Wire<'m>, most: u32| !m.constant(wire.width(), most.into()).less(wire);
        let place = words[0].lower(4);
        let [is_list, is_graph, is_tree] = [place.any(), place.is(2), place.upper(3).is(2)];
        let elements = words[0].bits(9, 8);
        let dimensions = low(1).lower(13);
        let blocks = |shift: u32| {
            let whole = dimensions.upper(13 - shift).extend(COUNT_BITS);
            whole + dimensions.lower(shift).any().extend(COUNT_BITS)
        };
        let blocks = elements.bit(1).mux(blocks(6), elements.bit(0).mux(blocks(5), blocks(4))).named("job_blocks");
        let is_aligned = |k: usize| !words[k].lower(BLOCK_SHIFT).any();
        let (k, candidates) = (high(0), high(1));
        let scale = words[12];
        let of_graph = is_aligned(8) & !high(7).any() & !candidates.less(k) & most(candidates, parameters.candidates);
        let holds = [
            if parameters.has_trees() { most(place, 2) | is_tree } else { most(place, 2) },
            most(words[0].bits(7, 4), 2),
            most(words[0].bits(11, 8), 2),
            !words[0].bits(15, 12).any(),
            k.any() & most(k, parameters.neighbours),
            low(1).any() & most(low(1), parameters.dimensions),
            is_aligned(2) & is_aligned(3) & is_aligned(4),
            !words[4].upper(BLOCK_BITS).less(blocks.extend(BLOCK_BITS)),
            !is_list | is_aligned(6),
            !is_graph | of_graph,
            !m.constant(31, 0x7f80_0000).less(words[11].lower(31)),
            !scale.top() & scale.any() & !scale.bits(30, 23).all(),
            !m.concat(&[words[13].any(), words[14].any(), words[15].any()]).any(),
        ];
        let mut holds = holds.to_vec();
        if parameters.has_trees() {
            let len_holds = place.bit(0).mux(!words[7].any(), !high(7).any());
            holds.push(!is_tree | (!elements.any() & most(low(1), 3) & len_holds));
        }
        Self { words, parameters, refused: (!m.concat(&holds).all()).named("is_refused"), blocks }
    }

    /// What turns need of it.
    pub fn kept(&self) -> Named<'m> {
        let Self { words, parameters, refused, blocks } = self;
        let block = |k: usize| words[k].upper(BLOCK_BITS);
        let named_words = [
            ("place", words[0].lower(2 + parameters.trees)),
            ("cosine", words[0].bit(5)),
            ("refused", *refused),
            ("blocks", *blocks),
            ("query", block(2)),
            ("vectors", block(3)),
            ("stride", block(4)),
            ("count", words[5]),
            ("list", block(6)),
            ("len", words[7]),
            ("entries", block(8)),
            ("entry_count", words[9]),
            ("expansions", words[10]),
        ];
        named_words.map(|(name, wire)| named(name, wire)).to_vec()
    }

    /// What the list of candidates and results need of it.
    pub fn outputs(&self, m: &'m Builder) {
        let Self { words, parameters, refused, .. } = self;
        let width = place_bits(*parameters);
        let last = |count: Wire<'m>| count.lower(width) - m.constant(width, 1);
        let neighbour = last(words[0].upper(16));
        let rest = words[11].lower(31);
        let bound = key_of(m.concat(&[words[11].top() & rest.any(), rest]));
        m.output("bound_o", bound);
        m.output("neighbour_o", neighbour);
        m.output("candidate_o", words[0].bit(1).mux(last(words[1].upper(16)), neighbour));
        m.output("refused_o", *refused);
        m.output("metric_o", words[0].bits(5, 4));
        m.output("scale_o", words[12]);
    }
}
