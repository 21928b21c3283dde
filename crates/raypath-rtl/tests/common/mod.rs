//! What tests of operations that are none of the paper's begin with.

pub mod drive;

/// An operation without state that is a function of `Input` to `Output`, whatever these are where it stands.
macro_rules! operation {
    ($name:ident, |$c:ident, $input:ident| $body:expr) => {
        struct $name;
        impl Operation for $name {
            const NAME: &'static str = stringify!($name);
            type Input<C: Circuit> = Input<C>;
            type Output<C: Circuit> = Output<C>;
            type State<C: Circuit> = ();
            fn run<C: Circuit>(&self, circuit: C, $input: Input<C>, _: ()) -> (Output<C>, ()) {
                let $c = circuit;
                ($body, ())
            }
        }
    };
}
