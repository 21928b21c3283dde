//! Shared code of tests with operations that are not in the paper.

pub mod drive;
pub mod driver;

/// Declares an operation with a name from the types `Input` and `Output` at its place of use, or from given ones; with a
/// third parameter, it also has a `State`.
macro_rules! operation {
    ($name:ident = $text:literal, |$c:ident, $input:ident| $body:expr) => {
        operation!($name = $text, Input<C> => Output<C>, |$c, $input| $body);
    };
    ($name:ident = $text:literal, $from:ty => $to:ty, |$c:ident, $input:ident| $body:expr) => {
        operation!($name = $text, $from => $to, (), |$c, $input, _state| ($body, ()));
    };
    ($name:ident = $text:literal, |$c:ident, $input:ident, $state:ident| $body:expr) => {
        operation!($name = $text, Input<C> => Output<C>, State<C>, |$c, $input, $state| $body);
    };
    ($name:ident = $text:literal, $from:ty => $to:ty, $kept:ty, |$c:ident, $input:ident, $state:ident| $body:expr) => {
        struct $name;
        impl Operation for $name {
            const NAME: &'static str = $text;
            type Input<C: Circuit> = $from;
            type Output<C: Circuit> = $to;
            type State<C: Circuit> = $kept;
            fn run<C: Circuit>(&self, $c: C, $input: $from, $state: $kept) -> ($to, $kept) {
                $body
            }
        }
    };
}
