//! Shared code of tests with operations that are not in the paper.

pub mod drive;
pub mod driver;

/// Declares an operation with a name from the types `Input` and `Output` at its place of use; with a third parameter,
/// it also has a `State`.
macro_rules! operation {
    ($name:ident = $text:literal, |$c:ident, $input:ident| $body:expr) => {
        operation!($name = $text, Output<C>, (), |$c, $input, _state| ($body, ()));
    };
    ($name:ident = $text:literal, |$c:ident, $input:ident, $state:ident| $body:expr) => {
        operation!($name = $text, Output<C>, State<C>, |$c, $input, $state| $body);
    };
    ($name:ident = $text:literal, $output:ty, $state_type:ty, |$c:ident, $input:ident, $state:ident| $body:expr) => {
        struct $name;
        impl Operation for $name {
            const NAME: &'static str = $text;
            type Input<C: Circuit> = Input<C>;
            type Output<C: Circuit> = $output;
            type State<C: Circuit> = $state_type;
            fn run<C: Circuit>(&self, $c: C, $input: Input<C>, $state: $state_type) -> ($output, $state_type) {
                $body
            }
        }
    };
}
