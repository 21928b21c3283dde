use crate::dynamic::Dynamic;
use raypath_float::Format;
use raypath_ops::{Binary32, Operation, Port, from_words, ports_of, to_canonical_words, to_words};
use std::cell::Cell;

/// An operation as a function on the words at its ports. It is object-safe, so that a list can hold operations of any
/// type, and implemented for every [`Operation`].
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

    /// Computes one job in numbers of `format`. `job` has a word for each of [`inputs`](Self::inputs). `answer` is
    /// replaced by a word for each of [`outputs`](Self::outputs). `state` is what the previous job left (empty
    /// initially) and is replaced by what this job leaves. In binary32, `raised` collects the exceptions of additions
    /// and multiplications.
    fn answer(
        &self,
        format: Format,
        job: &[u64],
        state: &mut Vec<u64>,
        raised: Option<&Cell<u64>>,
        answer: &mut Vec<u64>,
    );
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

    fn answer(
        &self,
        format: Format,
        job: &[u64],
        state: &mut Vec<u64>,
        raised: Option<&Cell<u64>>,
        answer: &mut Vec<u64>,
    ) {
        let circuit = Dynamic::new(format, raised);
        let (output, next) = self.run(circuit, from_words(circuit, job), from_words(circuit, state));
        to_words(&next, state);
        to_canonical_words(&output, answer);
    }
}
