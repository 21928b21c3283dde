//! A combinational unit as one module, or as a chain of modules with registers to come between them.
//!
//! The unit is described once. It marks each point where it may be divided, with the values that cross this point.
//! Without a division there, the values continue unchanged, so the whole unit and its parts compute the same. A value
//! that is not passed on at a cut is not available after it: its use is an error when the part is finished.

use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// The parts of a unit under construction.
pub(crate) struct Parts<'m> {
    builders: &'m [Builder],
    /// The index of the part that is described now.
    current: usize,
    /// Values that pass through all later parts, besides those that a cut names.
    along: Vec<(&'static str, Wire<'m>)>,
}

impl<'m> Parts<'m> {
    /// Builds a unit, and returns its parts in order: the module `name` if `count` is 1, otherwise
    /// `<name>_part_1_of_<count>` and so on. `doc` is the first line of their head comments. It is an error if the
    /// description has no cuts for this count.
    pub fn build(
        name: &str,
        doc: &str,
        count: u32,
        describe: impl for<'b> FnOnce(&mut Parts<'b>),
    ) -> Result<Vec<Arc<Module>>, Error> {
        let builders: Vec<Builder> = (1..=count).map(|part| begin(name, doc, part, count)).collect();
        let undivided = || Error::Name {
            module: name.to_string(),
            name: part_name(1, count),
            problem: "does not exist: the unit has no such division".to_string(),
        };
        if builders.is_empty() {
            return Err(undivided());
        }
        let mut parts = Parts { builders: &builders, current: 0, along: Vec::new() };
        describe(&mut parts);
        if parts.current + 1 != builders.len() {
            return Err(undivided());
        }
        builders.into_iter().map(Builder::finish).collect()
    }

    /// The number of parts.
    pub fn count(&self) -> usize {
        self.builders.len()
    }

    /// The builder of the current part. It is another one after a cut.
    pub fn builder(&self) -> &'m Builder {
        &self.builders[self.current]
    }

    /// Passes a value through all cuts that follow.
    pub fn take_along(&mut self, stem: &'static str, wire: Wire<'m>) {
        self.along.push((stem, wire));
    }

    /// A value passed with [`take_along`](Self::take_along), in the current part.
    pub fn along(&self, stem: &str) -> Option<Wire<'m>> {
        self.along.iter().find(|(known, _)| *known == stem).map(|(_, wire)| *wire)
    }

    /// Ends what [`take_along`](Self::take_along) began: the value does not pass the next cut.
    pub fn leave_behind(&mut self, stem: &str) {
        self.along.retain(|(known, _)| *known != stem);
    }

    /// Ends the current part and begins the next one if `cuts`, pairs of a part and a number of parts, contain it. A
    /// value of stem `x` leaves the part by the port `x_o` and enters the next by `x_i`. Returns the values in the part
    /// that is current then. [`cut`] is the usual way to call it.
    pub fn cut<const N: usize>(&mut self, cuts: &[(usize, usize)], values: [(&str, Wire<'m>); N]) -> [Wire<'m>; N] {
        if !self.is_cut(cuts) {
            return values.map(|(_, wire)| wire);
        }
        self.current += 1;
        let values = values.map(|(stem, wire)| self.over(stem, wire));
        self.pass_along();
        values
    }

    fn is_cut(&self, cuts: &[(usize, usize)]) -> bool {
        let next = self.current + 1;
        next != self.count() && cuts.contains(&(next, self.count()))
    }

    /// Passes a value from the part before to the current one.
    fn over(&self, stem: &str, wire: Wire<'m>) -> Wire<'m> {
        self.builders[self.current - 1].output(&format!("{stem}_o"), wire);
        self.builders[self.current].input(&format!("{stem}_i"), wire.width())
    }

    fn pass_along(&mut self) {
        let along = std::mem::take(&mut self.along);
        self.along = along.into_iter().map(|(stem, wire)| (stem, self.over(stem, wire))).collect();
    }
}

/// Cuts a unit with [`Parts::cut`]: ports have the names of the variables, which hold the values of the current part
/// afterwards.
macro_rules! cut {
    ($parts:ident, $cuts:expr, $($value:ident),+) => {
        let [$($value),+] = $parts.cut(&$cuts, [$((stringify!($value), $value)),+]);
    };
}
pub(crate) use cut;

fn begin(name: &str, doc: &str, part: u32, count: u32) -> Builder {
    if count == 1 {
        let m = Builder::new(name);
        m.doc(doc);
        return m;
    }
    let m = Builder::new(&format!("{name}_{}", part_name(part, count)));
    m.doc(doc);
    m.doc(format!("Part {part} of {count}."));
    m
}

fn part_name(part: u32, count: u32) -> String {
    format!("part_{part}_of_{count}")
}
