//! The two halves of a step: with any state, also with one that no ray reaches soon, such as counters at their limits.

use super::Bench;
use raypath_ops::{Binary32, Bundle, Port, Word, from_words, ports_of, to_words};
use raypath_traversal::state::{Answer, Group, RayState, Request};
use raypath_traversal::{HalfStep, StepParameters};

/// The cases of each half.
const CASES: usize = 40_000;

/// Compares the first half with the function.
pub fn prepare(bench: &mut Bench, parameters: StepParameters) -> Result<(), String> {
    let (state, answer) =
        (Ports::inputs::<RayState<Binary32>>(bench, "state"), Ports::inputs::<Answer<_>>(bench, "answer"));
    let half = Ports::outputs::<HalfStep<Binary32>>(bench, "half");
    let limit = bench.module.inputs().iter().position(|port| port.name == "node_limit_i");
    compare(bench, &mut |bench, words| {
        let limit = Word::truncate(limit.map_or(0, |place| words[place] as u32));
        half.check(bench, &raypath_traversal::prepare(Binary32, parameters, state.of(words), answer.of(words), limit))
    })
}

/// Compares the second half with the function.
pub fn finish(bench: &mut Bench, parameters: StepParameters) -> Result<(), String> {
    let (half, top) = (Ports::inputs::<HalfStep<Binary32>>(bench, "half"), Ports::inputs::<Group<_>>(bench, "top"));
    let next = Ports::outputs::<RayState<Binary32>>(bench, "next");
    let request = Ports::outputs::<Request<Binary32>>(bench, "request");
    compare(bench, &mut |bench, words| {
        let (state, asked) = raypath_traversal::finish(Binary32, parameters, half.of(words), top.of(words));
        next.check(bench, &state)?;
        request.check(bench, &asked)
    })
}

type Check<'a> = &'a mut dyn FnMut(&Bench, &[u64]) -> Result<(), String>;

/// Checks the outputs of a module without registers for random words at its inputs.
fn compare(bench: &mut Bench, check: Check<'_>) -> Result<(), String> {
    for case in 0..CASES {
        let words = bench.words();
        words.iter().enumerate().for_each(|(input, &word)| bench.set(input, word));
        bench.simulator.settle();
        check(bench, &words).map_err(|problem| format!("case {case}: {problem}"))?;
    }
    Ok(())
}

/// The places of a bundle's fields among the ports of a module, which may lack some.
struct Ports(Vec<(String, Option<usize>)>);

impl Ports {
    fn inputs<B: Bundle<Binary32>>(bench: &Bench, name: &str) -> Self {
        let place = |port: &str| bench.module.inputs().iter().position(|known| known.name == port);
        Self::new(ports_of::<B>(), |field| format!("{name}_{field}_i"), place)
    }

    fn outputs<B: Bundle<Binary32>>(bench: &Bench, name: &str) -> Self {
        let place = |port: &str| bench.module.outputs().iter().position(|known| known.name == port);
        Self::new(ports_of::<B>(), |field| format!("{name}_{field}_o"), place)
    }

    fn new(fields: Vec<Port>, name: impl Fn(&str) -> String, place: impl Fn(&str) -> Option<usize>) -> Self {
        let port = |field: Port| {
            let name = name(&field.name);
            let place = place(&name);
            (name, place)
        };
        Self(fields.into_iter().map(port).collect())
    }

    /// The bundle of inputs with these words; fields that the module lacks are 0.
    fn of<B: Bundle<Binary32>>(&self, words: &[u64]) -> B {
        let words: Vec<u64> = self.0.iter().map(|(_, place)| place.map_or(0, |place| words[place])).collect();
        from_words(Binary32, &words)
    }

    /// Compares the outputs with a bundle.
    fn check(&self, bench: &Bench, expected: &impl Bundle<Binary32>) -> Result<(), String> {
        let mut words = Vec::new();
        to_words(expected, &mut words);
        for ((port, place), expected) in self.0.iter().zip(words) {
            if let Some(found) = place.map(|place| bench.get(place)).filter(|found| *found != expected) {
                return Err(format!("{port} is {found:#x}, expected {expected:#x}"));
            }
        }
        Ok(())
    }
}
