use crate::bundle::Bundle;
use crate::circuit::Circuit;

/// An operation of the datapath: what it takes, what it answers, and one function between them.
///
/// Ports follow from the structures: a field `ray: Ray<C>` with a field `origin: Vec3<C>` is the ports
/// `ray_origin_x_i` and so on. Operations that name an input alike share the port.
pub trait Operation {
    /// Its name, `snake_case`, as it stands in schedules and comments.
    const NAME: &'static str;

    /// What a job brings.
    type Input<C: Circuit>: Bundle<C>;
    /// What it answers.
    type Output<C: Circuit>: Bundle<C>;
    /// What a job leaves for the next one of the same operation; all zeros at first and after a reset. `()` for none.
    type State<C: Circuit>: Bundle<C>;

    /// Whether an input port of this name is there in this configuration. What is not there must not be read.
    fn has_input(&self, _port: &str) -> bool {
        true
    }

    /// Whether an output port of this name is there in this configuration; what is not there is not made.
    fn has_output(&self, _port: &str) -> bool {
        true
    }

    /// One job, stage by stage. Gives the answer and the state for the next job. The state must be read in the stage
    /// that makes its next value, and in no other.
    fn run<C: Circuit>(&self, c: C, input: Self::Input<C>, state: Self::State<C>) -> (Self::Output<C>, Self::State<C>);
}
