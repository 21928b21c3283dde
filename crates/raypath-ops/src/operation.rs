use crate::{Bundle, Circuit, Kernels};

/// An operation of the datapath: the types of its jobs and results, and the function between them.
///
/// The ports follow from the structures: a field `ray: Ray<C>` with a field `origin: Vec3<C>` makes the ports
/// `ray_origin_x_i` and so on. Operations whose inputs have the same name share the port.
pub trait Operation {
    /// The operation's name in `snake_case`, as it appears in schedules, comments and on the command line.
    const NAME: &'static str;

    /// The values of a job.
    type Input<C: Circuit>: Bundle<C>;
    /// The values of a result.
    type Output<C: Circuit>: Bundle<C>;
    /// The values that a job leaves for the next of the same operation, zeros after a reset; `()` if there are none.
    type State<C: Circuit>: Bundle<C>;

    /// Whether this configuration of the operation has the input port `port`. An absent input must not be read.
    fn has_input(&self, _port: &str) -> bool {
        true
    }

    /// Whether this configuration of the operation has the output port `port`. Hardware does not compute absent ones.
    fn has_output(&self, _port: &str) -> bool {
        true
    }

    /// Computes one job, stage by stage. Returns the result and the state for the next job. The state must be read in
    /// the stage that computes its next value, and in no other.
    fn run<C: Circuit>(&self, c: C, input: Self::Input<C>, state: Self::State<C>) -> (Self::Output<C>, Self::State<C>);

    /// As [`run`](Self::run), with the inner parts computed by `kernels`, if the operation has such parts.
    #[inline(always)]
    fn run_with<C: Circuit, K: Kernels<C>>(
        &self,
        c: C,
        _kernels: K,
        input: Self::Input<C>,
        state: Self::State<C>,
    ) -> (Self::Output<C>, Self::State<C>) {
        self.run(c, input, state)
    }
}

/// Implements [`Operation::run`] by [`Operation::run_with`] and the portable kernels. Use it inside the `impl` block.
macro_rules! run_portable {
    () => {
        #[inline(always)]
        fn run<C: Circuit>(
            &self,
            c: C,
            input: Self::Input<C>,
            state: Self::State<C>,
        ) -> (Self::Output<C>, Self::State<C>) {
            self.run_with(c, $crate::Portable, input, state)
        }
    };
}
pub(crate) use run_portable;
