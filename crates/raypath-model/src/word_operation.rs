use crate::dynamic::Dynamic;
use raypath_ops::{Binary32, Operation, Port, from_words, ports_of, to_canonical_words, to_words};

/// An operation as a function on the words at its ports. The trait is object-safe, and implemented for every
/// [`Operation`].
pub trait WordOperation: Send + Sync {
    /// [`Operation::NAME`].
    fn name(&self) -> &'static str;

    /// All input ports that the operation may have.
    fn inputs(&self) -> Vec<Port>;

    /// All output ports that the operation may have.
    fn outputs(&self) -> Vec<Port>;

    /// Whether the operation has an input port: [`Operation::has_input`].
    fn has_input(&self, port: &str) -> bool;

    /// Whether the operation has an output port: [`Operation::has_output`].
    fn has_output(&self, port: &str) -> bool;

    /// Computes one job over `circuit`. `job` has a word for each of [`inputs`](Self::inputs). `output` is replaced by
    /// a word for each of [`outputs`](Self::outputs). `state` has the words that the previous job left, initially none,
    /// and is replaced by those that this job leaves.
    fn run_words(&self, circuit: Dynamic<'_>, job: &[u64], state: &mut Vec<u64>, output: &mut Vec<u64>);
}

impl<O: Operation + Send + Sync> WordOperation for O {
    fn name(&self) -> &'static str {
        O::NAME
    }

    fn inputs(&self) -> Vec<Port> {
        ports_of::<O::Input<Binary32>>()
    }

    fn outputs(&self) -> Vec<Port> {
        ports_of::<O::Output<Binary32>>()
    }

    fn has_input(&self, port: &str) -> bool {
        Operation::has_input(self, port)
    }

    fn has_output(&self, port: &str) -> bool {
        Operation::has_output(self, port)
    }

    fn run_words(&self, circuit: Dynamic<'_>, job: &[u64], state: &mut Vec<u64>, output: &mut Vec<u64>) {
        let (result, next) = self.run(circuit, from_words(circuit, job), from_words(circuit, state));
        to_words(&next, state);
        to_canonical_words(&result, output);
    }
}
