//! The control of a folded pipeline: the positions of the jobs.

use raypath_hdl::{Builder, Module, Wire};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The most bits of a word.
const WORD: u32 = 64;

/// The registers that have a bit for each position, the lowest first: names and bits.
pub fn words(positions: u32) -> Vec<(String, u32)> {
    if positions <= WORD {
        return vec![("at_q".to_string(), positions)];
    }
    let bits = |word: u32| (positions - word * WORD).min(WORD);
    (0..positions.div_ceil(WORD)).map(|word| (format!("at_{}_q", word * WORD), bits(word))).collect()
}

/// The control of a folded pipeline.
pub struct Rounds<'a> {
    /// The number of positions, at most 64 if jobs wait at some.
    pub positions: u32,
    /// The least number of positions between two jobs.
    pub interval: u32,
    /// The positions at which a job waits for the one before it; none if the exit has a place for every job. The last
    /// position is one of them, and they are an interval apart.
    pub stops: &'a BTreeSet<u32>,
}

impl Rounds<'_> {
    /// The module `raypath_rounds`. `at` and `moves` are the positions for which it has outputs.
    pub fn module(&self, at: &BTreeSet<u32>, moves: &BTreeSet<u32>) -> Result<Arc<Module>, raypath_hdl::Error> {
        let m = Builder::new("raypath_rounds");
        let Self { positions, interval, stops } = *self;
        m.doc(format!("The positions of the jobs, from 0 to {}. Jobs are {interval} or more apart.", positions - 1));
        let valid = m.input("valid_i", 1);
        let ready_after = (!stops.is_empty()).then(|| m.input("ready_i", 1));
        let words = words(positions);
        let states: Vec<_> = words.iter().map(|(name, bits)| m.register(name, *bits).reset_to(0)).collect();
        let state = states[0];
        let is_at = |position: u32| states[(position / WORD) as usize].wire().bit(position % WORD);

        if stops.is_empty() {
            m.section("Every job moves in every cycle");
            let mut enters = valid;
            for (state, (_, bits)) in states.iter().zip(&words) {
                let word = state.wire();
                state.next(if *bits > 1 { m.concat(&[word.lower(bits - 1), enters]) } else { enters });
                enters = word.top();
            }
        }
        let mut go: Vec<Option<Wire<'_>>> = vec![None; positions as usize];
        if let Some(ready_after) = ready_after {
            // Stops are an interval apart, so a job at one of them has no other job before the next.
            m.section("A job moves on from these positions if no job waits at the next of them");
            let mut next = ready_after;
            let mut last = positions - 1;
            for &stop in stops.iter().rev() {
                if stop != last {
                    next = !(is_at(last) & !next);
                    last = stop;
                }
                next = next.named(&format!("free_{stop}")).comment("the job here can move on");
                go[stop as usize] = Some(next);
            }
            let waits = |position: u32| go[position as usize].map(|go| is_at(position) & !go);
            m.section("A job enters if the job before it is far enough");
            let near = (0..interval - 1).filter(|&position| position < positions).map(is_at).reduce(|a, b| a | b);
            let far = waits((interval - 1).min(positions - 1)).filter(|_| interval <= positions);
            let blocked = match (near, far) {
                (Some(near), Some(far)) => near | far,
                (near, far) => near.or(far).unwrap_or(valid),
            };
            let ready = !blocked;
            let enters = (valid & ready).named("enters");
            let next = (0..positions).rev().map(|position| {
                let arrives = match position.checked_sub(1) {
                    None => enters,
                    Some(before) => go[before as usize].map_or(is_at(before), |go| is_at(before) & go),
                };
                waits(position).map_or(arrives, |waits| arrives | waits)
            });
            state.next(m.concat(&next.collect::<Vec<_>>()));
            m.output("ready_o", ready);
            m.output("enters_o", enters);
        }
        for &position in at {
            m.output(&format!("at_{position}_o"), is_at(position));
        }
        for &position in moves {
            let moves = go[position as usize].map_or(is_at(position), |go| is_at(position) & go);
            m.output(&format!("moves_{position}_o"), moves);
        }
        m.finish()
    }
}
