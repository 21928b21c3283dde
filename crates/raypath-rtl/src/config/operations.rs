//! The operations of a configuration, for hardware and models alike.

use super::declarations::{Features, Semantics};
use super::enumerations::{Accumulators, Lanes};
use raypath_ops::operations::quantised_box::QuantisedBox;
use raypath_ops::{
    Angular, AngularMany, Euclidean, EuclideanMany, JobKind, Operation, RayBox, RayTriangle, RayTriangleExtended,
    Rounding,
};

/// Receives the operations of a configuration, one after another.
pub trait OperationVisitor {
    /// The reason to stop.
    type Error;

    /// Receives an operation and its opcode.
    ///
    /// # Errors
    /// The visitor's own. After an error it receives no further operation.
    fn visit<O: Operation + Send + Sync + 'static>(&mut self, operation: O, opcode: u64) -> Result<(), Self::Error>;
}

impl Semantics {
    /// Shows the operations to a visitor, in the order of ports, tables and comments. The operations do not handle the
    /// tag or the exception flags, which are the same for any operation.
    ///
    /// # Errors
    /// Those of the visitor.
    pub fn operations<V: OperationVisitor>(self, visitor: &mut V) -> Result<(), V::Error> {
        let (rules, rounding, features) = (self.rules_in_full(), self.rounding, self.features);
        if features.quantised_boxes {
            visitor.visit(QuantisedBox, JobKind::Quadbox.opcode())?;
        } else {
            let boxes = RayBox { rules, is_conservative: features.conservative };
            visitor.visit(boxes, JobKind::Quadbox.opcode())?;
        }
        match self.extended_triangle() {
            Some(extended) => visitor.visit(extended, JobKind::Triangle.opcode())?,
            None => visitor.visit(RayTriangle { rules, rounding }, JobKind::Triangle.opcode())?,
        }
        match self.lanes {
            Lanes::None => Ok(()),
            Lanes::Two => distances::<2, 1, V>(self, visitor),
            Lanes::Four => distances::<4, 2, V>(self, visitor),
            Lanes::Eight => distances::<8, 4, V>(self, visitor),
            Lanes::Sixteen => distances::<16, 8, V>(self, visitor),
            Lanes::ThirtyTwo => distances::<32, 16, V>(self, visitor),
            Lanes::SixtyFour => distances::<64, 32, V>(self, visitor),
        }
    }

    /// The triangle test with the features that change it; `None` without such a feature.
    pub fn extended_triangle(self) -> Option<RayTriangleExtended> {
        let (rules, rounding) = (self.rules_in_full(), self.rounding);
        let Features { edges, culling, facing, barycentrics, range, .. } = self.features;
        let extended = RayTriangleExtended { rules, rounding, edges, culling, facing, barycentrics, range };
        self.features.extend_triangles().then_some(extended)
    }
}

/// The distance operations of `E` and `A` lanes.
fn distances<const E: usize, const A: usize, V: OperationVisitor>(
    semantics: Semantics,
    visitor: &mut V,
) -> Result<(), V::Error> {
    let Semantics { rounding, features, .. } = semantics;
    match features.accumulators {
        Accumulators::One => {
            visitor.visit(Euclidean::<E> { rounding }, JobKind::Euclidean.opcode())?;
            visitor.visit(Angular::<A> { rounding }, JobKind::Angular.opcode())
        }
        Accumulators::Two => several::<E, A, 2, 1, V>(rounding, visitor),
        Accumulators::Four => several::<E, A, 4, 2, V>(rounding, visitor),
        Accumulators::Eight => several::<E, A, 8, 3, V>(rounding, visitor),
        Accumulators::Sixteen => several::<E, A, 16, 4, V>(rounding, visitor),
    }
}

/// The distance operations with `K` accumulators each; a word of `W` bits selects one.
fn several<const E: usize, const A: usize, const K: usize, const W: u32, V: OperationVisitor>(
    rounding: Rounding,
    visitor: &mut V,
) -> Result<(), V::Error> {
    visitor.visit(EuclideanMany::<E, K, W> { rounding }, JobKind::Euclidean.opcode())?;
    visitor.visit(AngularMany::<A, K, W> { rounding }, JobKind::Angular.opcode())
}
